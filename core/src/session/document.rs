//! The document: all that a session's user made, and what was tracked from it.

use std::collections::BTreeMap;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::clip_reference::ClipReference;
use super::parameters::Settings;
use super::part::{Part, PartKind};
use crate::error::{Error, Result};
use crate::motion::Motion;
use crate::rig::Rig;

/// What a job works from. Clones are cheap and stay as they are while the session is edited.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Inputs {
    /// The clip, where one is chosen.
    pub clip: Option<Arc<ClipReference>>,
    /// What was drawn; well-formed, and possibly unfinished ([`Rig::validate_draft`]).
    pub rig: Arc<Rig>,
    /// What was chosen otherwise than by default.
    pub settings: Settings,
}

impl Default for Inputs {
    fn default() -> Self {
        let rig = Rig { size: (0, 0), limbs: Vec::new(), keyframes: Vec::new() };
        Self { clip: None, rig: Arc::new(rig), settings: Settings::default() }
    }
}

/// The limbs over time, and what they were tracked from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tracked {
    /// One track a limb of `inputs`, in its order.
    pub motion: Arc<Motion>,
    /// What it was made of.
    pub inputs: Inputs,
}

impl Tracked {
    /// Checks that the motion is sound and of its inputs.
    pub(super) fn check(&self) -> Result<()> {
        self.motion.validate()?;
        let labels = self.inputs.rig.limbs.iter().map(|l| &l.label);
        if self.motion.tracks.iter().map(|t| &t.name).eq(labels) && self.motion.size == self.inputs.rig.size {
            return Ok(());
        }
        Err(Error::invalid("motion", "is not of this rig: its size or its track names are others", "track this rig"))
    }
}

/// All that undo and redo move between, and that a session file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// What the user made.
    pub inputs: Inputs,
    /// What was tracked last, from these inputs or from earlier ones.
    pub tracked: Option<Tracked>,
    /// What is held for characters and sketches.
    pub parts: BTreeMap<PartKind, Part>,
}
