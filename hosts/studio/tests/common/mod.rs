//! The studio as tests use it: by what its widgets are called, by mouse and keyboard, without a window.
#![allow(dead_code, unreachable_pub, reason = "each test file uses its share")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

pub mod gestures;
pub mod screens;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use egui_kittest::kittest::Queryable as _;
use egui_kittest::{Harness, HarnessBuilder, TestRenderer};
use marey_studio::egui::{Context, FullOutput, Key, Modifiers, Pos2, TexturesDelta, Theme, vec2};
use marey_studio::{Open, Places, Studio};

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// Of the window, in points, and of the frame that the harness lays around it.
pub const SIZE: (u32, u32) = (1360, 860);
pub const EDGE: u32 = 8;

/// A person at the studio, with folders of their own.
pub struct Desk {
    pub harness: Harness<'static, Studio>,
    pub folder: Arc<tempfile::TempDir>,
}

impl Desk {
    pub fn new() -> Self {
        Self::in_folder(Arc::new(tempfile::tempdir().unwrap()), Theme::Dark)
    }

    /// The same, with a program that tries plugins.
    pub fn with_probe(program: &Path) -> Self {
        let folder = Arc::new(tempfile::tempdir().unwrap());
        let places = places(folder.path()).with_probe(program);
        Self { harness: start(builder(), places), folder }
    }

    /// The studio started once more.
    pub fn again(self) -> Self {
        let folder = self.folder.clone();
        drop(self);
        Self::in_folder(folder, Theme::Dark)
    }

    pub fn in_folder(folder: Arc<tempfile::TempDir>, theme: Theme) -> Self {
        let builder = builder().with_theme(theme);
        let harness = start(builder, places(folder.path()));
        Self { harness, folder }
    }

    pub fn home(&self) -> PathBuf {
        self.folder.path().join("home")
    }

    /// Lets time pass until something is so.
    pub fn wait(&mut self, what: &str, so: impl Fn(&Studio) -> bool) {
        let began = Instant::now();
        loop {
            self.harness.step();
            if so(self.harness.state()) {
                break;
            }
            assert!(began.elapsed() < PATIENCE, "waited for: {what}; said: {:?}", self.harness.state().notices());
            std::thread::sleep(Duration::from_millis(4));
        }
        self.harness.step();
        self.harness.check_accessibility();
    }

    pub fn wait_open(&mut self) {
        self.wait("the clip to open", |studio| studio.open().is_some());
        self.harness.run_steps(3);
    }

    /// Lets go of files over the window.
    pub fn drop_file(&mut self, path: &Path) {
        self.harness.input_mut().dropped_files.push(Arc::new(Dropped(path.to_owned())));
        self.harness.step();
    }

    pub fn click(&mut self, label: &str) {
        self.harness.get_by_label(label).click();
        self.harness.run_steps(3);
    }

    pub fn keys(&mut self, modifiers: Modifiers, key: Key) {
        self.harness.key_press_modifiers(modifiers, key);
        self.harness.run_steps(3);
    }

    pub fn click_at(&mut self, at: Pos2) {
        self.harness.hover_at(at);
        self.harness.drag_at(at);
        self.harness.drop_at(at);
        self.harness.run_steps(3);
    }

    /// Types a path where one is asked for.
    pub fn type_path(&mut self, path: &str) {
        self.harness.key_press_modifiers(Modifiers::COMMAND, Key::A);
        self.harness.step();
        self.harness.get_by_label("Path").type_text(path);
        self.harness.run_steps(2);
        self.harness.key_press(Key::Enter);
        self.harness.run_steps(3);
    }

    pub fn drag(&mut self, from: Pos2, to: Pos2) {
        self.press_from(&[from, to]);
        self.harness.drop_at(to);
        self.harness.run_steps(3);
    }

    /// What is open.
    pub fn open(&self) -> Open<'_> {
        self.harness.state().open().unwrap()
    }

    /// Lets so many milliseconds pass.
    pub fn rest(&mut self, milliseconds: u64) {
        let until = Instant::now() + Duration::from_millis(milliseconds);
        while Instant::now() < until {
            self.harness.step();
            std::thread::sleep(Duration::from_millis(16));
        }
    }

    /// Draws along places of the clip.
    pub fn draw(&mut self, points: &[(f32, f32)]) {
        let last = self.press_along(points);
        self.harness.drop_at(last);
        self.harness.step();
        self.harness.run_steps(2);
    }

    /// The same, with the button still held; gives where.
    pub fn press_along(&mut self, points: &[(f32, f32)]) -> Pos2 {
        let at: Vec<Pos2> = points.iter().map(|p| self.open().on_screen(*p)).collect();
        self.press_from(&at);
        *at.last().unwrap()
    }

    fn press_from(&mut self, at: &[Pos2]) {
        self.harness.hover_at(at[0]);
        self.harness.drag_at(at[0]);
        for pair in at.windows(2) {
            for step in 1..=8 {
                self.harness.hover_at(pair[0].lerp(pair[1], step as f32 / 8.0));
            }
        }
    }

    pub fn limbs(&self) -> Vec<String> {
        self.open().limbs()
    }
}

fn builder() -> HarnessBuilder<Studio> {
    let (width, height) = (SIZE.0 + 2 * EDGE, SIZE.1 + 2 * EDGE);
    let builder = Harness::builder().with_size(vec2(width as f32, height as f32));
    // A name may be in any script.
    builder.with_step_dt(1.0 / 60.0).with_render_cursor(false).allow_missing_glyphs()
}

fn places(folder: &Path) -> Places {
    std::fs::create_dir_all(folder.join("home")).unwrap();
    Places::in_folder(&folder.join("data"), &folder.join("home")).unwrap()
}

fn start(builder: HarnessBuilder<Studio>, places: Places) -> Harness<'static, Studio> {
    let mut studio = Studio::new(places).unwrap();
    studio.ask_for_paths();
    builder.build_ui_state(|ui, studio: &mut Studio| studio.ui(ui), studio)
}

/// The studio alone, with another renderer.
pub fn harness(folder: &Path, renderer: impl TestRenderer + 'static) -> Harness<'static, Studio> {
    start(builder().renderer(renderer), places(folder))
}

/// Draws nothing, and forgets textures where the harness's own would keep them until it draws.
pub struct Nothing;

impl TestRenderer for Nothing {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        delta.clear();
    }

    fn render(&mut self, _: &Context, _: &FullOutput) -> Result<image::RgbaImage, String> {
        Err("it draws nothing".into())
    }
}

#[derive(Debug)]
pub struct Dropped(pub PathBuf);

impl marey_studio::egui::DroppedFile for Dropped {
    fn path(&self) -> &Path {
        &self.0
    }

    fn bytes(&self) -> Result<Vec<u8>, String> {
        std::fs::read(&self.0).map_err(|e| e.to_string())
    }
}

/// Pictures of a thing with a body and two legs that cross, at (48, 38) in frame 0; it wanders a pixel a frame.
pub fn legs(folder: &Path) -> PathBuf {
    let clip = folder.join("legs");
    std::fs::create_dir(&clip).unwrap();
    let far = |p: (f32, f32), a: (f32, f32), b: (f32, f32)| {
        let (u, v) = ((b.0 - a.0, b.1 - a.1), (p.0 - a.0, p.1 - a.1));
        let t = ((u.0 * v.0 + u.1 * v.1) / (u.0 * u.0 + u.1 * u.1)).clamp(0.0, 1.0);
        ((v.0 - t * u.0).powi(2) + (v.1 - t * u.1).powi(2)).sqrt()
    };
    for frame in 0..BAR_FRAMES {
        let image = image::RgbImage::from_fn(96, 64, |x, y| {
            let at = (x as f32 - frame as f32, y as f32);
            let grain = (((x + 96 - frame) * 37 + y * 91) % 17) as u8;
            if far(at, LEGS[1][0], LEGS[1][1]) < 3.5 {
                image::Rgb([150, 60 + grain, 40])
            } else if far(at, LEGS[2][0], LEGS[2][1]) < 3.5 {
                image::Rgb([40, 60, 150 - grain])
            } else if far(at, LEGS[0][0], LEGS[0][1]) < 7.0 {
                image::Rgb([60 + grain, 40, 30])
            } else {
                image::Rgb([190, 200 - grain, 180 + grain])
            }
        });
        image.save(clip.join(format!("{frame:05}.png"))).unwrap();
    }
    clip
}

/// The body and the legs of [`legs`] in frame 0.
pub const LEGS: [[(f32, f32); 2]; 3] =
    [[(16.0, 18.0), (76.0, 18.0)], [(30.0, 18.0), (66.0, 58.0)], [(66.0, 18.0), (30.0, 58.0)]];

pub const BAR_FRAMES: u32 = 8;

/// Pictures of a dark bar that wanders over light ground; in frame 0 it lies from (30, 32) to (60, 32).
pub fn bar(folder: &Path) -> PathBuf {
    let clip = folder.join("bar");
    std::fs::create_dir(&clip).unwrap();
    for frame in 0..BAR_FRAMES {
        let at = 30 + 2 * frame;
        let image = image::RgbImage::from_fn(96, 64, |x, y| {
            let bar = x >= at && x < at + 30 && (26..38).contains(&y);
            let grain = ((x * 37 + y * 91) % 17) as u8;
            if bar { image::Rgb([60 + grain, 40, 30]) } else { image::Rgb([190, 200 - grain, 180 + grain]) }
        });
        image.save(clip.join(format!("{frame:05}.png"))).unwrap();
    }
    clip
}
