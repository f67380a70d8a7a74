//! The creature from any side. The library draws it on a thread of its own; the latest picture is shown, and of pictures
//! that were asked for meanwhile only the last one is drawn.

use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::{Duration, Instant};

use eframe::egui::{
    Align, Color32, ColorImage, ComboBox, Context, CursorIcon, Layout, PointerButton, Rect, Role, Sense, TextureHandle,
    TextureOptions, Ui, WidgetInfo, pos2, vec2,
};
use marey_binding::{Camera, Creature, RenderOptions, Style};

use crate::icons::Icon;
use crate::shortcuts::Command;
use crate::theme::Palette;
use crate::{shortcuts, texts, widgets};

/// Degrees between bottom and top.
const FOV: f32 = 24.0;
/// Degrees a point of dragging.
const TURN: f32 = 0.4;
/// Where a picture takes longer, it is drawn at half the size and with hard edges while things move.
const SLOW: Duration = Duration::from_millis(28);
/// How long after a move the whole size comes back.
const REST: Duration = Duration::from_millis(180);
/// As large as a GPU of any age draws.
const MOST: f32 = 4096.0;

pub(crate) const STYLES: [(Style, &str); 7] = [
    (Style::Textured, texts::STYLE_TEXTURED),
    (Style::Shaded, texts::STYLE_SHADED),
    (Style::Wireframe, texts::STYLE_WIREFRAME),
    (Style::Radius, texts::STYLE_RADIUS),
    (Style::Bones, texts::STYLE_BONES),
    (Style::Depth, texts::STYLE_DEPTH),
    (Style::Normals, texts::STYLE_NORMALS),
];

/// From where it is looked at.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orbit {
    pub(crate) yaw: f32,
    pub(crate) pitch: f32,
    /// How many times nearer than where all of the animation fits in.
    pub(crate) zoom: f32,
}

const FILMED: Orbit = Orbit { yaw: 0.0, pitch: 0.0, zoom: 1.0 };
/// From a little to the side and above, where one sees at once that it is solid.
const FIRST: Orbit = Orbit { yaw: -32.0, pitch: 14.0, zoom: 1.0 };

/// What is to be drawn.
#[derive(Clone, Debug)]
struct Request {
    creature: Arc<Creature>,
    options: RenderOptions,
}

type Drawn = (RenderOptions, Duration, Result<ColorImage, String>);

#[derive(Debug, Default)]
struct Wanted {
    request: Option<Request>,
    closed: bool,
}

pub(crate) struct View3d {
    pub(crate) orbit: Orbit,
    pub(crate) style: Style,
    shared: Arc<(Mutex<Wanted>, Condvar)>,
    drawn: Receiver<Drawn>,
    asked: Option<RenderOptions>,
    /// How long a picture of the whole size takes.
    took: Duration,
    /// When something last moved.
    moved: Instant,
    shown: Option<TextureHandle>,
    /// How many pictures were shown.
    pub(crate) pictures: u64,
    failed: Option<String>,
}

impl View3d {
    pub(crate) fn new(ui: &Context) -> Self {
        let shared = Arc::new((Mutex::new(Wanted::default()), Condvar::new()));
        let (send, drawn) = channel();
        let (worker, ui) = (shared.clone(), ui.clone());
        std::thread::spawn(move || draw(&worker, &send, &ui));
        Self {
            orbit: FIRST,
            style: Style::Textured,
            shared,
            drawn,
            asked: None,
            took: Duration::ZERO,
            moved: Instant::now(),
            shown: None,
            pictures: 0,
            failed: None,
        }
    }

    /// Another creature: what is shown is not it.
    pub(crate) fn renew(&mut self) {
        self.asked = None;
    }

    /// The camera of the orbit. `bounds` are those of the motion in a clip of that height.
    pub(crate) fn camera(&self, bounds: [f32; 4], height: f32) -> Camera {
        camera(self.orbit, bounds, height)
    }

    /// `bounds` are those of the motion in a clip of that height.
    pub(crate) fn show(&mut self, ui: &mut Ui, creature: &Arc<Creature>, frame: u64, bounds: [f32; 4], height: f32) {
        self.head(ui);
        let palette = Palette::of(ui);
        let (response, painter) = ui.allocate_painter(ui.available_size(), Sense::click_and_drag());
        let panel = response.rect;
        response.widget_info(|| WidgetInfo::labeled(Role::Image, true, texts::VIEW3D_NAME));
        painter.rect_filled(panel, 0.0, palette.canvas);

        let before = (self.orbit, self.style);
        if response.dragged_by(PointerButton::Primary) || response.dragged_by(PointerButton::Middle) {
            let by = response.drag_delta() * TURN;
            self.orbit.yaw = (self.orbit.yaw - by.x + 180.0).rem_euclid(360.0) - 180.0;
            self.orbit.pitch = (self.orbit.pitch + by.y).clamp(-89.0, 89.0);
            ui.ctx().set_cursor_icon(CursorIcon::Grabbing);
        }
        if response.hovered() {
            let (zoom, scroll) = ui.input(|i| (i.zoom_delta(), i.smooth_scroll_delta().y));
            self.orbit.zoom = (self.orbit.zoom * zoom * (scroll / 240.0).exp2()).clamp(0.3, 12.0);
        }
        if response.double_clicked() {
            self.orbit = FIRST;
        }
        for (options, took, picture) in self.drawn.try_iter() {
            match picture {
                Ok(picture) => {
                    match &mut self.shown {
                        Some(texture) => texture.set(picture, TextureOptions::LINEAR),
                        None => self.shown = Some(ui.ctx().load_texture("creature", picture, TextureOptions::LINEAR)),
                    }
                    self.pictures += 1;
                    self.failed = None;
                    // Half the size is a quarter of the pixels.
                    let whole = options.size.1 as f32 > 0.75 * panel.height() * ui.pixels_per_point();
                    self.took = if whole { took } else { self.took.max(took) };
                }
                Err(message) => self.failed = Some(message),
            }
        }
        let moves = before != (self.orbit, self.style) || self.asked.is_some_and(|a| a.frame != frame);
        if moves {
            self.moved = Instant::now();
        }
        let resting = self.moved.elapsed() > REST;
        let coarse = self.took > SLOW && !resting;
        if coarse {
            ui.ctx().request_repaint_after(REST);
        }
        let pixels = panel.size() * ui.pixels_per_point() * if coarse { 0.5 } else { 1.0 };
        let side = |v: f32| v.round().clamp(1.0, MOST) as u32;
        let options = RenderOptions {
            size: (side(pixels.x), side(pixels.y)),
            style: self.style,
            hard_edges: coarse,
            shadow: 0.35,
            frame,
            camera: self.camera(bounds, height),
            ..RenderOptions::default()
        };
        if self.asked != Some(options) {
            self.asked = Some(options);
            let mut wanted = self.shared.0.lock().unwrap_or_else(PoisonError::into_inner);
            wanted.request = Some(Request { creature: creature.clone(), options });
            self.shared.1.notify_one();
        }
        if let Some(texture) = &self.shown {
            painter.image(texture.id(), panel, Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0)), Color32::WHITE);
        }
        if let Some(failed) = &self.failed {
            let font = eframe::egui::FontId::proportional(14.0);
            let galley = painter.layout(failed.clone(), font, palette.bad, panel.width() - 40.0);
            painter.galley(panel.min + vec2(20.0, 20.0), galley, palette.bad);
        }
    }

    fn head(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            let name = STYLES.iter().find(|(s, _)| *s == self.style).map_or("", |(_, name)| name);
            let list = ComboBox::from_id_salt("style").width(110.0).selected_text(name);
            let list = list.show_ui(ui, |ui| {
                for (style, name) in STYLES {
                    ui.selectable_value(&mut self.style, style, name);
                }
            });
            let hint = shortcuts::hint(ui.ctx(), texts::STYLE, Command::NextStyle);
            list.response.accessible_name(texts::STYLE).on_hover_text(hint);
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if widgets::command_button(ui, Icon::Filmed, texts::AS_FILMED, Command::AsFilmed) {
                    self.orbit = FILMED;
                }
                widgets::remark(ui, texts::ORBIT_HINT);
            });
        });
    }

    /// Does what a key asked for; false for what is not this view's.
    pub(crate) fn command(&mut self, command: Command) -> bool {
        match command {
            Command::NextStyle => {
                let now = STYLES.iter().position(|(s, _)| *s == self.style).unwrap_or(0);
                self.style = STYLES[(now + 1) % STYLES.len()].0;
            }
            Command::AsFilmed => self.orbit = FILMED,
            _ => return false,
        }
        true
    }
}

impl Drop for View3d {
    fn drop(&mut self) {
        self.shared.0.lock().unwrap_or_else(PoisonError::into_inner).closed = true;
        self.shared.1.notify_one();
    }
}

/// Stands where the motion fits in from every side, with a third of air.
pub(crate) fn camera(orbit: Orbit, [left, top, right, bottom]: [f32; 4], height: f32) -> Camera {
    let (wide, high) = ((right - left).max(1.0), (bottom - top).max(1.0));
    let reach = wide.hypot(high) * 1.15 / orbit.zoom;
    Camera::Placed {
        yaw: orbit.yaw,
        pitch: orbit.pitch,
        fov: FOV,
        reach: reach / 2.0 / (FOV / 2.0).to_radians().tan(),
        // The world's y goes up from the clip's lower edge.
        target: [(left + right) / 2.0, height - (top + bottom) / 2.0, 0.0],
    }
}

/// A picture of a creature, ready to be a texture.
pub(crate) fn picture(creature: &Creature, options: &RenderOptions) -> Result<ColorImage, String> {
    let rgba = creature.render(options).map_err(|e| e.to_string())?;
    Ok(ColorImage::from_rgba_unmultiplied([options.size.0 as usize, options.size.1 as usize], &rgba))
}

fn draw(shared: &(Mutex<Wanted>, Condvar), send: &Sender<Drawn>, ui: &Context) {
    loop {
        let request = {
            let mut wanted = shared.0.lock().unwrap_or_else(PoisonError::into_inner);
            loop {
                if wanted.closed {
                    return;
                }
                match wanted.request.take() {
                    Some(request) => break request,
                    None => wanted = shared.1.wait(wanted).unwrap_or_else(PoisonError::into_inner),
                }
            }
        };
        let began = Instant::now();
        let picture = picture(&request.creature, &request.options);
        if send.send((request.options, began.elapsed(), picture)).is_err() {
            return;
        }
        ui.request_repaint();
    }
}
