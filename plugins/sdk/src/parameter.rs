//! What a person can choose about a plugin. From it any host can draw a control.

/// What values a parameter takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Any number from `low` to `high`.
    Number {
        /// The least.
        low: f64,
        /// The greatest.
        high: f64,
        /// Where nothing else is chosen.
        default: f64,
    },
    /// A whole number from `low` to `high`.
    Whole {
        /// The least.
        low: i32,
        /// The greatest.
        high: i32,
        /// Where nothing else is chosen.
        default: i32,
    },
    /// On or off.
    Switch {
        /// Where nothing else is chosen.
        default: bool,
    },
    /// One of several.
    Choice {
        /// What a person reads for each.
        names: &'static [&'static str],
        /// The index where nothing else is chosen.
        default: u32,
    },
    /// A line of text.
    Text {
        /// Where nothing else is chosen.
        default: &'static str,
    },
    /// The path of a file; empty for none.
    File,
}

/// A parameter: its kind, and how to show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    pub(crate) id: &'static str,
    pub(crate) label: &'static str,
    pub(crate) kind: Kind,
    pub(crate) about: &'static str,
    pub(crate) group: &'static str,
    pub(crate) unit: &'static str,
    pub(crate) step: f64,
    pub(crate) flags: u32,
    pub(crate) visible_if: Option<(&'static str, f64)>,
}

impl Parameter {
    /// A parameter of any kind. `id` is its name for ever (a-z, 0-9, `_`, `-`, `.`); `label` is what a person reads.
    pub const fn new(id: &'static str, label: &'static str, kind: Kind) -> Self {
        Self { id, label, kind, about: "", group: "", unit: "", step: 0.0, flags: 0, visible_if: None }
    }

    /// Any number from `low` to `high`.
    pub const fn number(id: &'static str, label: &'static str, low: f64, high: f64, default: f64) -> Self {
        Self::new(id, label, Kind::Number { low, high, default })
    }

    /// A whole number from `low` to `high`.
    pub const fn whole(id: &'static str, label: &'static str, low: i32, high: i32, default: i32) -> Self {
        Self::new(id, label, Kind::Whole { low, high, default })
    }

    /// On or off.
    pub const fn switch(id: &'static str, label: &'static str, default: bool) -> Self {
        Self::new(id, label, Kind::Switch { default })
    }

    /// One of `names`.
    pub const fn choice(id: &'static str, label: &'static str, names: &'static [&'static str], default: u32) -> Self {
        Self::new(id, label, Kind::Choice { names, default })
    }

    /// A line of text.
    pub const fn text(id: &'static str, label: &'static str, default: &'static str) -> Self {
        Self::new(id, label, Kind::Text { default })
    }

    /// The path of a file, none at first.
    pub const fn file(id: &'static str, label: &'static str) -> Self {
        Self::new(id, label, Kind::File)
    }

    /// What it does, a sentence.
    #[must_use]
    pub const fn about(mut self, about: &'static str) -> Self {
        self.about = about;
        self
    }

    /// Where it stands among others, "Search/Fine".
    #[must_use]
    pub const fn group(mut self, group: &'static str) -> Self {
        self.group = group;
        self
    }

    /// "px", "frames", "degrees".
    #[must_use]
    pub const fn unit(mut self, unit: &'static str) -> Self {
        self.unit = unit;
        self
    }

    /// One step of a slider.
    #[must_use]
    pub const fn step(mut self, step: f64) -> Self {
        self.step = step;
        self
    }

    /// For those who know the method; a host may fold it away.
    #[must_use]
    pub const fn advanced(mut self) -> Self {
        self.flags |= crate::raw::ADVANCED;
        self
    }

    /// Not to be shown.
    #[must_use]
    pub const fn hidden(mut self) -> Self {
        self.flags |= crate::raw::HIDDEN;
        self
    }

    /// A slider does better with the logarithm.
    #[must_use]
    pub const fn logarithmic(mut self) -> Self {
        self.flags |= crate::raw::LOGARITHMIC;
        self
    }

    /// Shown only while the parameter `id` has this value (a switch 0 or 1, a choice its index).
    #[must_use]
    pub const fn visible_if(mut self, id: &'static str, value: f64) -> Self {
        self.visible_if = Some((id, value));
        self
    }
}
