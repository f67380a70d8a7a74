//! What the program keeps around every screen.

use marey_binding::Context;

use crate::Places;
use crate::notices::Notices;
use crate::picker::Picker;
use crate::preferences::Preferences;

pub(crate) struct Around {
    pub(crate) context: Context,
    pub(crate) places: Places,
    pub(crate) preferences: Preferences,
    pub(crate) notices: Notices,
    pub(crate) picker: Picker,
}
