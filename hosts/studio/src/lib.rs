//! Marey Studio: the reference host with windows.
//!
//! It uses the C ABI only, through `marey-binding`: what it does, a C program can do. A [`Studio`] is the whole program but
//! for its window; [`run`] gives it one, and the tests drive it without.
//!
//! Who knows what: the [session](marey_binding::Session) is the document, and every edit goes through it (`document`).
//! What is looked at and selected is the door's (`creature_door`, `character_door`, `drawing_door`; the latter two share a
//! `workshop`, steps that fill themselves in, `filling`, and the clip with its points, `clip_points`), and so is what runs
//! (`running`). Panels draw what they are given and answer with what the person asked for; the door does it. Decoding,
//! drawing in 3D, opening and file dialogs have threads of their own, so that no frame of the window waits for any of them.

/// Threads that decode, draw and answer come and go, and the C library's allocator keeps an arena of what each has used:
/// a desk of random gestures grew by 100 MB in ten minutes, none of which was in use.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

mod app;
mod around;
mod background;
mod brush;
mod canvas;
mod capture;
mod character_canvas;
mod character_door;
mod character_steps;
mod clip_points;
mod creature_door;
mod document;
mod drawing_door;
mod drawing_sheet;
mod drawing_steps;
mod export;
mod filling;
mod frames;
mod handles;
mod held;
mod help;
mod icons;
mod keeping;
mod limbs_panel;
mod looking;
mod marks;
mod methods;
mod moving;
mod needles;
mod notes;
mod notices;
mod onion;
mod opening;
mod overlaps;
mod overlay;
mod parameters;
mod path_field;
mod picker;
mod places;
mod playback;
mod plugins;
mod plugins_panel;
mod preferences;
mod running;
mod sample;
mod shortcuts;
mod solved;
mod start;
mod texts;
mod theme;
mod timeline;
mod timing;
mod view;
mod view3d;
mod widgets;
mod window;
mod workshop;

pub use app::{Open, Studio};
pub use places::Places;
pub use plugins::probe;
pub use window::run;

/// What the studio is drawn with.
pub use eframe::egui;
