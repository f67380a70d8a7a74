//! The program in a window of its own, on an X server without a screen, used by mouse and keyboard.
//!
//! Beside it a [`Desk`] does the same in a window of the same size, without showing it. It knows where widgets are and what
//! they look like, so that a test waits until the real window shows the same there, and only then clicks.
#![allow(unreachable_pub, reason = "each test file uses its share")]
#![allow(clippy::print_stdout, reason = "a test says why it was skipped")]
#![allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]

use std::io::{BufRead as _, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use egui_kittest::kittest::Queryable as _;
use image::RgbImage;
use marey_studio::egui::{Key, Modifiers, Pos2, Rect, vec2};

use crate::common::{Desk, EDGE, SIZE};

/// Longer than anything here takes on a slow machine.
const PATIENCE: Duration = Duration::from_secs(240);
/// So much may the mean of a channel differ, of 255: two drivers draw the edges of letters a little otherwise.
const ALIKE: f64 = 5.0;

pub struct Screen {
    /// None only while it is started anew.
    desk: Option<Desk>,
    server: Child,
    display: String,
    studio: Option<Child>,
    folder: PathBuf,
}

/// A widget as the desk shows it.
pub struct Look {
    label: String,
    pub rect: Rect,
    picture: RgbImage,
}

impl Screen {
    /// An X server and a desk; none, with the reason printed, where there is no software for it.
    pub fn new() -> Option<Self> {
        let on_path = |name: &str| {
            let path = std::env::var_os("PATH").unwrap_or_default();
            std::env::split_paths(&path).any(|folder| folder.join(name).is_file())
        };
        if let Some(missing) = ["Xvfb", "xdotool"].iter().find(|name| !on_path(name)) {
            println!("skipped: {missing} is not there; cargo xtask test installs it");
            return None;
        }
        if let Err(e) = marey_binding::Context::new(1).unwrap().renderer(marey_binding::Adapter::Gpu) {
            println!("skipped: {e}");
            return None;
        }
        let desk = Desk::new();
        let folder = desk.folder.path().join("screen");
        std::fs::create_dir_all(folder.join("home")).unwrap();
        let screen = format!("{}x{}x24", SIZE.0, SIZE.1);
        let mut server = Command::new("Xvfb");
        server.args(["-displayfd", "1", "-screen", "0", &screen, "-nolisten", "tcp", "-fbdir"]).arg(&folder);
        let mut server = server.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().unwrap();
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        Some(Self { desk: Some(desk), server, display: format!(":{}", number.trim()), studio: None, folder })
    }

    pub fn desk(&mut self) -> &mut Desk {
        self.desk.as_mut().unwrap()
    }

    pub fn home(&self) -> PathBuf {
        self.folder.join("home")
    }

    /// Starts the program.
    pub fn start(&mut self) {
        let home = self.home();
        let mut studio = Command::new(env!("CARGO_BIN_EXE_marey-studio"));
        studio.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env_remove("WAYLAND_SOCKET");
        // It has no desktop beside it: no portal, no screen reader, and no zenity that would wait for somebody.
        studio.env_remove("DBUS_SESSION_BUS_ADDRESS").env("XDG_RUNTIME_DIR", &self.folder).env("PATH", "");
        studio.env("HOME", &home).env("XDG_DATA_HOME", home.join("data")).env("XDG_CACHE_HOME", home.join("cache"));
        let log = std::fs::File::create(self.folder.join("studio.log")).unwrap();
        self.studio = Some(studio.stderr(log).spawn().unwrap());
        // No window manager gives it the keyboard.
        let name = ["search", "--sync", "--onlyvisible", "--name", "Marey Studio", "windowfocus", "--sync"];
        self.xdotool(&name.map(str::to_owned));
    }

    /// kill -9.
    pub fn kill(&mut self) {
        let mut studio = self.studio.take().unwrap();
        studio.kill().unwrap();
        studio.wait().unwrap();
    }

    /// Starts it and the desk again, as they were left.
    pub fn start_again(&mut self) {
        self.desk = self.desk.take().map(Desk::again);
        self.desk().rest(600);
        self.start();
    }

    fn xdotool(&self, words: &[String]) {
        let status = Command::new("xdotool").env("DISPLAY", &self.display).args(words).status().unwrap();
        assert!(status.success(), "xdotool {words:?}: {status}; {}", self.log());
    }

    fn log(&self) -> String {
        std::fs::read_to_string(self.folder.join("studio.log")).unwrap_or_default()
    }

    /// Seconds that the program has worked for, all its threads together; none where the system does not say.
    pub fn worked(&self) -> Option<f64> {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.studio.as_ref()?.id())).ok()?;
        // Behind its name in brackets; in hundredths.
        let fields: Vec<f64> = stat.rsplit(')').next()?.split_whitespace().map(|f| f.parse().unwrap_or(0.0)).collect();
        Some((fields.get(11)? + fields.get(12)?) / 100.0)
    }

    /// What the window shows. The server keeps it in a file, an XWD: a header of big-endian words, colours, rows of BGRX.
    pub fn picture(&self) -> RgbImage {
        let file = std::fs::read(self.folder.join("Xvfb_screen0")).unwrap();
        let word = |i: usize| u32::from_be_bytes(file[4 * i..4 * i + 4].try_into().unwrap());
        let (width, height, row, pixels) = (word(4), word(5), word(12) as usize, (word(0) + 12 * word(19)) as usize);
        RgbImage::from_fn(width, height, |x, y| {
            let at = pixels + y as usize * row + 4 * x as usize;
            image::Rgb([file[at + 2], file[at + 1], file[at]])
        })
    }

    pub fn save(&self, path: &Path) {
        self.picture().save(path).unwrap();
    }

    /// What the desk shows.
    fn reference(&mut self) -> RgbImage {
        let picture = self.desk().harness.render().unwrap();
        let cut = image::imageops::crop_imm(&picture, EDGE, EDGE, SIZE.0, SIZE.1).to_image();
        image::DynamicImage::from(cut).to_rgb8()
    }

    /// How a widget looks at the desk, and where it is in the window.
    pub fn look(&mut self, label: &str) -> Look {
        let rect = self.desk().harness.get_by_label(label).rect().translate(-vec2(EDGE as f32, EDGE as f32));
        Look { label: label.to_owned(), rect, picture: self.reference() }
    }

    /// Whether the window shows a widget so, there.
    pub fn shows(&self, look: &Look) -> bool {
        alike(&self.picture(), &look.picture, look.rect)
    }

    /// Waits until it does.
    pub fn see_as(&mut self, look: &Look) {
        let began = Instant::now();
        while !self.shows(look) {
            if began.elapsed() > PATIENCE {
                look.picture.save(std::env::temp_dir().join("marey-studio-desk.png")).unwrap();
            }
            self.go_on(began, &format!("`{}` in the window", look.label));
        }
    }

    /// Waits until the window shows a widget where the desk does, and as the desk does.
    pub fn see(&mut self, label: &str) -> Rect {
        let look = self.look(label);
        self.see_as(&look);
        look.rect
    }

    /// Lets time pass until something is so.
    pub fn wait(&mut self, what: &str, so: impl Fn(&Self) -> bool) {
        let began = Instant::now();
        while !so(self) {
            self.go_on(began, what);
        }
    }

    /// Lets a moment pass; fails when it was enough of them.
    fn go_on(&mut self, began: Instant, what: &str) {
        let ended = self.studio.as_mut().and_then(|studio| studio.try_wait().unwrap());
        if ended.is_some() || began.elapsed() > PATIENCE {
            let picture = std::env::temp_dir().join("marey-studio-window.png");
            self.save(&picture);
            panic!("waited for {what}; {ended:?}; {}; {}", picture.display(), self.log());
        }
        std::thread::sleep(Duration::from_millis(30));
    }

    /// Clicks on a widget, in the window and at the desk.
    pub fn click(&mut self, label: &str) {
        let at = self.see(label).center();
        self.click_at(at);
        self.desk().click(label);
    }

    pub fn click_at(&self, at: Pos2) {
        let mut words = place(at);
        words.extend(["sleep", "0.05", "mousedown", "1", "sleep", "0.03", "mouseup", "1"].map(str::to_owned));
        self.xdotool(&words);
    }

    /// Draws along places of the clip, in the window and at the desk.
    pub fn draw(&mut self, points: &[(f32, f32)]) {
        let edge = vec2(EDGE as f32, EDGE as f32);
        let at: Vec<Pos2> =
            points.iter().map(|p| self.desk().harness.state().open().unwrap().on_screen(*p) - edge).collect();
        let mut words = place(at[0]);
        words.extend(["sleep", "0.05", "mousedown", "1"].map(str::to_owned));
        for pair in at.windows(2) {
            for step in 1..=8 {
                words.extend(place(pair[0].lerp(pair[1], step as f32 / 8.0)));
                words.extend(["sleep", "0.01"].map(str::to_owned));
            }
        }
        words.extend(["mouseup", "1"].map(str::to_owned));
        self.xdotool(&words);
        self.desk().draw(points);
    }

    /// Presses keys, in the window and at the desk; `name` is what xdotool calls them.
    pub fn key(&mut self, name: &str, modifiers: Modifiers, key: Key) {
        self.xdotool(&["key".into(), name.into()]);
        self.desk().harness.key_press_modifiers(modifiers, key);
        self.desk().harness.run_steps(3);
    }

    /// Types into the field `label`, which has the keyboard, instead of what stands there.
    pub fn type_into(&mut self, label: &str, text: &str) {
        self.key("ctrl+a", Modifiers::COMMAND, Key::A);
        self.xdotool(&["type".into(), "--delay".into(), "4".into(), text.into()]);
        self.desk().harness.get_by_label(label).type_text(text);
        self.desk().harness.run_steps(3);
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        for child in self.studio.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

fn place(at: Pos2) -> Vec<String> {
    vec!["mousemove".into(), at.x.round().to_string(), at.y.round().to_string()]
}

fn alike(one: &RgbImage, other: &RgbImage, rect: Rect) -> bool {
    let (left, top) = (rect.left().max(0.0) as u32, rect.top().max(0.0) as u32);
    let (right, bottom) = ((rect.right() as u32).min(SIZE.0), (rect.bottom() as u32).min(SIZE.1));
    let places = (top..bottom).flat_map(|y| (left..right).map(move |x| (x, y)));
    let (sum, count) = places.fold((0.0, 0), |(sum, count), (x, y)| {
        let (a, b) = (one.get_pixel(x, y).0, other.get_pixel(x, y).0);
        (sum + (0..3).map(|c| f64::from(a[c].abs_diff(b[c]))).sum::<f64>(), count + 3)
    });
    count > 0 && sum / f64::from(count) < ALIKE
}
