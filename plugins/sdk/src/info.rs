//! What a plugin is called.

/// What a plugin is, for lists and menus.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Info {
    pub(crate) id: &'static str,
    pub(crate) name: &'static str,
    pub(crate) version: &'static str,
    pub(crate) vendor: &'static str,
    pub(crate) about: &'static str,
}

impl Info {
    /// `id` is its name for ever, in reverse DNS: "org.example.nearest" (a-z, 0-9, `.`, `-`, `_`). `name` is what a
    /// person reads, `version` such as `env!("CARGO_PKG_VERSION")`.
    pub const fn new(id: &'static str, name: &'static str, version: &'static str) -> Self {
        Self { id, name, version, vendor: "", about: "" }
    }

    /// Who made it.
    #[must_use]
    pub const fn vendor(mut self, vendor: &'static str) -> Self {
        self.vendor = vendor;
        self
    }

    /// What it is good at, a sentence or two.
    #[must_use]
    pub const fn about(mut self, about: &'static str) -> Self {
        self.about = about;
        self
    }
}
