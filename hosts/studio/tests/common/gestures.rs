//! What a person might do next, at random but the same for the same seed.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use egui_kittest::Harness;
use egui_kittest::kittest::NodeT as _;
use marey_studio::Studio;
use marey_studio::egui::accesskit::Role;
use marey_studio::egui::{
    Event, Key, Modifiers, MouseWheelSource, MouseWheelUnit, PointerButton, Pos2, TouchPhase, pos2, vec2,
};

use super::Dropped;

/// SplitMix64.
pub struct Chance(u64);

impl Chance {
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    pub fn below(&mut self, count: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) % count.max(1) as u64) as usize
    }

    pub fn share(&mut self) -> f32 {
        self.below(1 << 20) as f32 / (1 << 20) as f32
    }
}

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

const KEYS: [(Modifiers, Key); 43] = [
    (CTRL, Key::Z),
    (CTRL, Key::Z),
    (CTRL, Key::Z),
    (CTRL_SHIFT, Key::Z),
    (CTRL_SHIFT, Key::Z),
    (CTRL, Key::S),
    (CTRL, Key::E),
    (CTRL, Key::L),
    (CTRL, Key::N),
    (CTRL, Key::O),
    (CTRL, Key::W),
    (CTRL, Key::Enter),
    (CTRL, Key::Comma),
    (CTRL, Key::Period),
    (CTRL, Key::Num0),
    (CTRL, Key::Plus),
    (CTRL, Key::Minus),
    (Modifiers::NONE, Key::Escape),
    (Modifiers::NONE, Key::Escape),
    (Modifiers::NONE, Key::Escape),
    (Modifiers::NONE, Key::N),
    (Modifiers::NONE, Key::L),
    (Modifiers::NONE, Key::Delete),
    (Modifiers::NONE, Key::C),
    (Modifiers::NONE, Key::Space),
    (Modifiers::NONE, Key::Comma),
    (Modifiers::NONE, Key::Period),
    (Modifiers::NONE, Key::Home),
    (Modifiers::NONE, Key::End),
    (Modifiers::NONE, Key::R),
    (Modifiers::NONE, Key::V),
    (Modifiers::NONE, Key::F),
    (Modifiers::NONE, Key::F1),
    (Modifiers::NONE, Key::Tab),
    (Modifiers::SHIFT, Key::Tab),
    (Modifiers::NONE, Key::Enter),
    (Modifiers::NONE, Key::ArrowRight),
    (Modifiers::NONE, Key::ArrowLeft),
    (Modifiers::NONE, Key::Num3),
    (Modifiers::NONE, Key::Num4),
    (Modifiers::NONE, Key::Num5),
    (Modifiers::NONE, Key::I),
    (Modifiers::NONE, Key::G),
];

/// One gesture; gives its name.
pub fn gesture(harness: &mut Harness<'static, Studio>, chance: &mut Chance, clip: &Path) -> &'static str {
    let open = harness.state().open().is_some();
    let kind = chance.below(if open { 100 } else { 30 });
    let name = match kind {
        0..14 => named(harness, chance),
        14..16 if !open => opened(harness, clip),
        14..16 => scrolled(harness, chance),
        16..22 => clicked(harness, chance),
        22..24 => resized(harness, chance),
        24..30 if !open => opened(harness, clip),
        24..45 => key(harness, chance),
        45..52 => dragged(harness, chance),
        52..57 => typed(harness, chance),
        57..62 => scrolled(harness, chance),
        62..63 => opened(harness, clip),
        _ => drew(harness, chance),
    };
    harness.step();
    harness.step();
    name
}

/// Drops a file over the window.
pub fn drop_file(harness: &mut Harness<'static, Studio>, path: PathBuf) {
    harness.input_mut().dropped_files.push(Arc::new(Dropped(path)));
    harness.step();
}

/// A stroke over the clip, with a limb chosen or not.
pub fn drew(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    let count = 2 + chance.below(3);
    let places: Vec<Pos2> = {
        let Some(open) = harness.state().open() else { return "nothing" };
        let mut at = || open.on_screen((96.0 * chance.share(), 64.0 * chance.share()));
        (0..count).map(|_| at()).collect()
    };
    drag(harness, &places, PointerButton::Primary);
    "drew"
}

fn drag(harness: &mut Harness<'static, Studio>, places: &[Pos2], button: PointerButton) {
    harness.hover_at(places[0]);
    press(harness, places[0], button, true);
    for pair in places.windows(2) {
        for step in 1..=3 {
            harness.event(Event::PointerMoved(pair[0].lerp(pair[1], step as f32 / 3.0)));
        }
        harness.step();
    }
    press(harness, places[places.len() - 1], button, false);
}

fn press(harness: &Harness<'static, Studio>, pos: Pos2, button: PointerButton, pressed: bool) {
    harness.event(Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE });
}

fn anywhere(harness: &Harness<'static, Studio>, chance: &mut Chance) -> Pos2 {
    let size = harness.ctx.content_rect().size();
    pos2(size.x * chance.share(), size.y * chance.share())
}

fn button(chance: &mut Chance) -> PointerButton {
    [PointerButton::Primary, PointerButton::Primary, PointerButton::Middle, PointerButton::Secondary][chance.below(4)]
}

fn clicked(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    let (at, button) = (anywhere(harness, chance), button(chance));
    for _ in 0..=chance.below(2) {
        harness.hover_at(at);
        press(harness, at, button, true);
        press(harness, at, button, false);
    }
    "clicked"
}

fn dragged(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    let (from, to) = (anywhere(harness, chance), anywhere(harness, chance));
    drag(harness, &[from, to], button(chance));
    "dragged"
}

fn scrolled(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    harness.hover_at(anywhere(harness, chance));
    if chance.below(3) == 0 {
        harness.event(Event::Zoom(0.5 + chance.share()));
    } else {
        let delta = vec2(0.0, 300.0 * (chance.share() - 0.5));
        let (unit, phase, source) = (MouseWheelUnit::Point, TouchPhase::Move, MouseWheelSource::Unknown);
        harness.event(Event::MouseWheel { unit, delta, phase, source, modifiers: Modifiers::NONE });
    }
    "scrolled"
}

fn resized(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    harness.set_size(vec2(900.0 + 900.0 * chance.share(), 600.0 + 600.0 * chance.share()));
    "resized"
}

fn key(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    let (modifiers, key) = KEYS[chance.below(KEYS.len())];
    harness.key_press_modifiers(modifiers, key);
    "pressed a key"
}

fn typed(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    let text: String = (0..=chance.below(6)).map(|_| ['a', 'ø', '3', ' ', '.', '中'][chance.below(6)]).collect();
    harness.event(Event::Text(text));
    "typed"
}

fn opened(harness: &mut Harness<'static, Studio>, clip: &Path) -> &'static str {
    drop_file(harness, clip.to_owned());
    "opened"
}

/// A click on a widget that has a name.
fn named(harness: &mut Harness<'static, Studio>, chance: &mut Chance) -> &'static str {
    let widgets: Vec<Pos2> = {
        let root = harness.root();
        let all = root.children_recursive().filter(|node| {
            let node = node.accesskit_node();
            !matches!(node.role(), Role::Label | Role::Canvas | Role::Window | Role::GenericContainer)
                && node.label().is_some()
                && !node.is_disabled()
        });
        all.map(|node| node.rect().center()).collect()
    };
    if widgets.is_empty() {
        return "nothing";
    }
    let at = widgets[chance.below(widgets.len())];
    harness.hover_at(at);
    press(harness, at, PointerButton::Primary, true);
    press(harness, at, PointerButton::Primary, false);
    "clicked on a widget"
}
