//! What the program keeps around every screen.

use marey_binding::Context;

use crate::Places;
use crate::notices::Notices;
use crate::picker::Picker;
use crate::plugins::Plugins;
use crate::preferences::Preferences;

pub(crate) struct Around {
    pub(crate) context: Context,
    pub(crate) places: Places,
    pub(crate) preferences: Preferences,
    pub(crate) notices: Notices,
    pub(crate) picker: Picker,
    /// None before there is a window to tell.
    pub(crate) plugins: Option<Plugins>,
}
