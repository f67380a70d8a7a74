//! How a scene is looked at.

use glam::{Mat4, Vec3, Vec4, vec3};
use marey::job::Progress;
use marey::{Error, Result};

use crate::{Camera, Extent, Scene, Style};

/// Pictures have at most so many pixels on a side; adapters may take fewer.
pub const MAX_SIDE: u32 = 16384;
/// Where shadows fall, a unit of height below: to the right and back, so that they lie beside what stands there.
const FALL: Vec3 = vec3(0.30, -1.0, -0.45);

/// How a scene is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// From where.
    pub camera: Camera,
    /// What of it.
    pub style: Style,
    /// What lies behind: straight alpha; nothing by default.
    pub background: [u8; 4],
    /// Edges are smoothed by 4 samples a pixel; without, a pixel belongs to what covers its centre.
    pub smooth: bool,
    /// How dark the shadow on the floor is, 0..=1; 0 for none. The floor is where the lowest frame of the scene ends.
    pub shadow: f32,
}

impl Picture {
    /// A smooth picture of the textures on nothing.
    pub fn new(size: (u32, u32), camera: Camera) -> Self {
        Self { size, camera, style: Style::Textured, background: [0; 4], smooth: true, shadow: 0.0 }
    }

    /// What both paths draw by.
    ///
    /// # Errors
    /// A size, camera, shadow, frame or scene that cannot be drawn.
    pub(crate) fn view(&self, scene: &Scene, frame: usize) -> Result<View> {
        let (w, h) = self.size;
        if w == 0 || h == 0 || w > MAX_SIDE || h > MAX_SIDE {
            let remedy = format!("give 1 to {MAX_SIDE} pixels on each side");
            return Err(Error::invalid("the picture", format!("is {w}x{h} pixels"), remedy));
        }
        if !(0.0..=1.0).contains(&self.shadow) {
            return Err(Error::invalid("the shadow", format!("is {}", self.shadow), "give 0 (none) to 1 (black)"));
        }
        self.camera.validate()?;
        scene.validate(frame)?;
        let extent = scene.extent(Progress::new().whole())?;
        let floor = extent.bounds().0.y;
        let data = matches!(self.style, Style::Depth | Style::Normals);
        let shadow = (self.shadow > 0.0 && !data && self.camera.is_above(floor)).then(|| flat(floor));
        let tones = self.camera.depths(&extent);
        let reach = match &shadow {
            Some(flat) => Extent::join([&extent, &extent.moved(flat)]),
            None => extent,
        };
        let clear = Vec4::from_array(self.background.map(|c| f32::from(c) / 255.0));
        let clear = (clear.truncate() * clear.w).extend(clear.w);
        Ok(View {
            projection: self.camera.projection(self.size, self.camera.depths(&reach)),
            turn: self.camera.turn(),
            tones,
            clear,
            shadow,
            shadow_color: clear * (1.0 - self.shadow) + Vec4::W * self.shadow,
        })
    }
}

/// What both paths draw by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct View {
    /// World to clip coordinates.
    pub(crate) projection: Mat4,
    /// World to view.
    pub(crate) turn: Mat4,
    /// View z that the depth style shows white and black.
    pub(crate) tones: (f32, f32),
    /// What lies behind, premultiplied.
    pub(crate) clear: Vec4,
    /// World to the floor along the light, where there is a shadow.
    pub(crate) shadow: Option<Mat4>,
    /// What the shadow on the background is like, premultiplied: one colour, so that where shadows overlap it is no darker.
    pub(crate) shadow_color: Vec4,
}

/// Takes everything along the light onto a floor.
fn flat(floor: f32) -> Mat4 {
    let mut flat = Mat4::IDENTITY;
    flat.y_axis = vec3(-FALL.x / FALL.y, 0.0, -FALL.z / FALL.y).extend(0.0);
    let down = vec3(floor * FALL.x / FALL.y, floor, floor * FALL.z / FALL.y);
    flat.w_axis = down.extend(1.0);
    flat
}
