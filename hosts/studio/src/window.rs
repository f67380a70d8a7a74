//! The window that the studio runs in.

use std::path::PathBuf;

use eframe::egui::ViewportBuilder;

use crate::{Places, Studio, texts};

struct Window(Studio);

impl eframe::App for Window {
    fn ui(&mut self, ui: &mut eframe::egui::Ui, _frame: &mut eframe::Frame) {
        self.0.ui(ui);
    }

    fn on_exit(&mut self) {
        self.0.close();
    }
}

/// Opens the window, and returns when it is closed. `file` is a clip or a session to begin with.
///
/// # Errors
/// There is no display, no way to draw on it, or no folder to keep things in; for a person.
pub fn run(file: Option<PathBuf>) -> Result<(), String> {
    let places = Places::of_user()?;
    let mut studio = Studio::new(places)?;
    if let Some(file) = file {
        studio.open_file(&file);
    }
    let viewport = ViewportBuilder::default()
        .with_title(texts::PROGRAM)
        .with_app_id("marey-studio")
        .with_inner_size([1360.0, 860.0])
        .with_min_inner_size([900.0, 600.0])
        .with_drag_and_drop(true);
    let options = eframe::NativeOptions { viewport, ..Default::default() };
    eframe::run_native("marey-studio", options, Box::new(|_| Ok(Box::new(Window(studio)))))
        .map_err(|e| texts::no_window(&e.to_string()))
}
