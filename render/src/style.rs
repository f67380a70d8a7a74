//! What of a model a picture shows.

use marey::{Error, Result};

/// What of a model a picture shows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Style {
    /// The texture's colours as they are.
    #[default]
    Textured,
    /// The texture under a lamp.
    Shaded,
    /// The edges of the triangles on a surface of clay.
    Wireframe,
    /// How far the surface is from the bones that move it: dark is thin, bright is thick.
    Radius,
    /// Which bones move the surface, a colour a limb, and the bones themselves.
    Bones,
    /// How near it is: white is nearest, black farthest of the whole animation.
    Depth,
    /// Where the surface faces, as the viewer sees it: red to the right, green up, blue to the viewer.
    Normals,
}

impl Style {
    /// All of them with their names.
    pub const ALL: [(Self, &'static str); 7] = [
        (Self::Textured, "textured"),
        (Self::Shaded, "shaded"),
        (Self::Wireframe, "wireframe"),
        (Self::Radius, "radius"),
        (Self::Bones, "bones"),
        (Self::Depth, "depth"),
        (Self::Normals, "normals"),
    ];

    /// The style called `name`.
    ///
    /// # Errors
    /// A name that is not known.
    pub fn named(name: &str) -> Result<Self> {
        Self::ALL.iter().find(|s| s.1 == name).map(|s| s.0).ok_or_else(|| {
            let names = Self::ALL.map(|s| s.1).join(", ");
            Error::invalid("style", format!("`{name}` is not known"), format!("choose one of {names}"))
        })
    }

    /// Whether it shows the texture.
    pub(crate) fn is_textured(self) -> bool {
        matches!(self, Self::Textured | Self::Shaded)
    }
}
