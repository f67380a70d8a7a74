//! Parts of a document that are files of their own: what is marked, drawn and bound for characters and sketches.
//!
//! A part is held as the bytes of its file, and is sound when it can be read as one. An edit replaces a part whole:
//! the files are small, and the large ones, a picture and a motion, are set once.

use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD as BASE64;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{Error, Result};
use crate::motion::Motion;
use crate::motion::retarget::RetargetMap;
use crate::rig::{JointMarks, PointMarks};
use crate::shape::character::Character;
use crate::shape::sketch::{Binding, Drawing};

/// Bytes of a part: more than any picture of a character has, and little enough to write with every save.
pub const LARGEST_PART: usize = 64 << 20;

/// What a part is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum PartKind {
    /// Control points, a points.json.
    Points,
    /// Joints marked in the clip, a joints.json.
    Joints,
    /// A vector drawing, an SVG.
    Drawing,
    /// How the points hold the drawing, a bind.json.
    Binding,
    /// The picture of a character: PNG, JPEG, WebP or GIF.
    Picture,
    /// The character's mesh and skeleton, a rig.json.
    Skeleton,
    /// The motion that moves the character, a motion.json.
    Motion,
    /// Which joint follows what, a map.json.
    Map,
    /// Text of the host's own.
    Notes,
}

impl PartKind {
    /// All, in the order of their numbers.
    pub const ALL: [Self; 9] = [
        Self::Points,
        Self::Joints,
        Self::Drawing,
        Self::Binding,
        Self::Picture,
        Self::Skeleton,
        Self::Motion,
        Self::Map,
        Self::Notes,
    ];

    /// Its name in the session file.
    pub fn name(self) -> &'static str {
        match self {
            Self::Points => "points",
            Self::Joints => "joints",
            Self::Drawing => "drawing",
            Self::Binding => "binding",
            Self::Picture => "picture",
            Self::Skeleton => "skeleton",
            Self::Motion => "motion",
            Self::Map => "map",
            Self::Notes => "notes",
        }
    }
}

/// A part. Clones share its bytes.
#[derive(Clone, PartialEq)]
pub struct Part {
    kind: PartKind,
    bytes: Arc<[u8]>,
}

impl std::fmt::Debug for Part {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{} of {} bytes", self.kind.name(), self.bytes.len())
    }
}

impl Part {
    /// The part that these bytes of a file make.
    ///
    /// # Errors
    /// They are not the file that they should be, or too many.
    pub fn new(kind: PartKind, bytes: &[u8]) -> Result<Self> {
        if bytes.len() > LARGEST_PART {
            let (value, max) = (bytes.len() as u64, LARGEST_PART as u64);
            let what = format!("bytes of the {}", kind.name());
            return Err(Error::Limit { what, value, max, remedy: "give a smaller one".into() });
        }
        let text = || {
            std::str::from_utf8(bytes).map_err(|e| {
                let problem = format!("is not UTF-8 from byte {}", e.valid_up_to());
                Error::invalid(kind.name(), problem, "save it as UTF-8")
            })
        };
        match kind {
            PartKind::Points => PointMarks::from_json(text()?).map(drop),
            PartKind::Joints => JointMarks::from_json(text()?).map(drop),
            PartKind::Drawing => Drawing::from_svg(text()?).map(drop),
            PartKind::Binding => Binding::from_json(text()?).map(drop),
            PartKind::Skeleton => Character::from_json(text()?).map(drop),
            PartKind::Motion => Motion::from_json(text()?).map(drop),
            PartKind::Map => RetargetMap::from_json(text()?).map(drop),
            PartKind::Notes => text().map(drop),
            PartKind::Picture => image::guess_format(bytes).map(drop).map_err(|e| {
                let problem = format!("is no picture: {e}");
                Error::invalid("picture", problem, "expected a PNG, JPEG, WebP or GIF")
            }),
        }?;
        Ok(Self { kind, bytes: bytes.into() })
    }

    /// What it is.
    pub fn kind(&self) -> PartKind {
        self.kind
    }

    /// The bytes of its file.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }
}

/// How a part is written: pictures in base64, all else as the text that it is.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written<'a> {
    kind: PartKind,
    #[serde(borrow)]
    content: std::borrow::Cow<'a, str>,
}

impl Serialize for Part {
    fn serialize<S: Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
        let content = match self.kind {
            PartKind::Picture => BASE64.encode(&self.bytes).into(),
            // It was found to be UTF-8.
            _ => String::from_utf8_lossy(&self.bytes),
        };
        Written { kind: self.kind, content }.serialize(to)
    }
}

impl<'de> Deserialize<'de> for Part {
    fn deserialize<D: Deserializer<'de>>(from: D) -> std::result::Result<Self, D::Error> {
        let Written { kind, content } = Written::deserialize(from)?;
        let bytes = match kind {
            PartKind::Picture => BASE64.decode(content.as_bytes()).map_err(D::Error::custom)?,
            _ => content.into_owned().into_bytes(),
        };
        Self::new(kind, &bytes).map_err(D::Error::custom)
    }
}
