//! What can be done by a key, in one table: the program acts on it, menus and buttons show it, and F1 lists it.

use eframe::egui::{Context, Key, KeyboardShortcut, Modifiers, Popup};

use crate::texts;

/// Something that a person can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Command {
    Open,
    OpenClip,
    Start,
    Save,
    SaveAs,
    Undo,
    Redo,
    Cancel,
    Help,
    Light,
    Play,
    NextFrame,
    PreviousFrame,
    NextKey,
    PreviousKey,
    FirstFrame,
    LastFrame,
    NextCorrection,
    Loop,
    NewLimb,
    NextLimb,
    RemoveStroke,
    Fit,
    ZoomIn,
    ZoomOut,
    Strokes,
    Tracks,
    Paths,
    Mask,
    NextStyle,
    AsFilmed,
    Make,
    Export,
    ExportAgain,
}

/// A line of the table.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shortcut {
    pub(crate) command: Command,
    pub(crate) keys: KeyboardShortcut,
    pub(crate) text: &'static str,
}

const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers::COMMAND.plus(Modifiers::SHIFT);

const fn on(command: Command, modifiers: Modifiers, key: Key, text: &'static str) -> Shortcut {
    Shortcut { command, keys: KeyboardShortcut::new(modifiers, key), text }
}

/// The table, in groups as they are listed.
pub(crate) const TABLE: [(&str, &[Shortcut]); 5] = [
    (
        texts::GROUP_SESSION,
        &[
            on(Command::OpenClip, CTRL, Key::N, texts::DO_OPEN_CLIP),
            on(Command::Open, CTRL, Key::O, texts::DO_OPEN),
            on(Command::Save, CTRL, Key::S, texts::DO_SAVE),
            on(Command::SaveAs, CTRL_SHIFT, Key::S, texts::DO_SAVE_AS),
            on(Command::Undo, CTRL, Key::Z, texts::DO_UNDO),
            on(Command::Redo, CTRL_SHIFT, Key::Z, texts::DO_REDO),
            on(Command::Cancel, Modifiers::NONE, Key::Escape, texts::DO_CANCEL),
            on(Command::Start, CTRL, Key::W, texts::DO_START),
        ],
    ),
    (
        texts::GROUP_DRAWING,
        &[
            on(Command::NewLimb, Modifiers::NONE, Key::N, texts::DO_NEW_LIMB),
            on(Command::NextLimb, Modifiers::NONE, Key::L, texts::DO_NEXT_LIMB),
            on(Command::RemoveStroke, Modifiers::NONE, Key::Delete, texts::DO_REMOVE_STROKE),
            on(Command::NextCorrection, Modifiers::NONE, Key::C, texts::DO_NEXT_CORRECTION),
            on(Command::Make, CTRL, Key::Enter, texts::DO_MAKE),
        ],
    ),
    (
        texts::GROUP_TIME,
        &[
            on(Command::Play, Modifiers::NONE, Key::Space, texts::DO_PLAY),
            on(Command::PreviousFrame, Modifiers::NONE, Key::Comma, texts::DO_PREVIOUS_FRAME),
            on(Command::NextFrame, Modifiers::NONE, Key::Period, texts::DO_NEXT_FRAME),
            on(Command::PreviousKey, CTRL, Key::Comma, texts::DO_PREVIOUS_KEY),
            on(Command::NextKey, CTRL, Key::Period, texts::DO_NEXT_KEY),
            on(Command::FirstFrame, Modifiers::NONE, Key::Home, texts::DO_FIRST_FRAME),
            on(Command::LastFrame, Modifiers::NONE, Key::End, texts::DO_LAST_FRAME),
            on(Command::Loop, Modifiers::NONE, Key::R, texts::DO_LOOP),
        ],
    ),
    (
        texts::GROUP_LOOKING,
        &[
            on(Command::Fit, CTRL, Key::Num0, texts::DO_FIT),
            on(Command::ZoomIn, CTRL, Key::Plus, texts::DO_ZOOM_IN),
            on(Command::ZoomOut, CTRL, Key::Minus, texts::DO_ZOOM_OUT),
            on(Command::Strokes, Modifiers::NONE, Key::Num1, texts::DO_STROKES),
            on(Command::Tracks, Modifiers::NONE, Key::Num2, texts::DO_TRACKS),
            on(Command::Paths, Modifiers::NONE, Key::Num3, texts::DO_PATHS),
            on(Command::Mask, Modifiers::NONE, Key::Num4, texts::DO_MASK),
            on(Command::NextStyle, Modifiers::NONE, Key::V, texts::DO_NEXT_STYLE),
            on(Command::AsFilmed, Modifiers::NONE, Key::F, texts::DO_AS_FILMED),
        ],
    ),
    (
        texts::GROUP_MORE,
        &[
            on(Command::Export, CTRL, Key::E, texts::DO_EXPORT),
            on(Command::ExportAgain, CTRL_SHIFT, Key::E, texts::DO_EXPORT_AGAIN),
            on(Command::Light, CTRL, Key::L, texts::DO_LIGHT),
            on(Command::Help, Modifiers::NONE, Key::F1, texts::DO_HELP),
        ],
    ),
];

/// The keys of a command.
pub(crate) fn keys(command: Command) -> Option<KeyboardShortcut> {
    all().find(|s| s.command == command).map(|s| s.keys)
}

/// A text for a tooltip: what it does, and by which key.
pub(crate) fn hint(ctx: &Context, text: &str, command: Command) -> String {
    keys(command).map_or_else(|| text.to_owned(), |keys| texts::with_key(text, &ctx.format_shortcut(&keys)))
}

fn all() -> impl Iterator<Item = &'static Shortcut> {
    TABLE.iter().flat_map(|(_, group)| *group)
}

/// The commands whose keys were pressed. Keys without Ctrl are left to a text that is being typed, and those that move
/// or press a widget that has the focus to the widget. [`Command::Play`] is not among them: its key pans too, see
/// [`play_released`].
pub(crate) fn pressed(ctx: &Context) -> Vec<Command> {
    if covered(ctx) {
        return Vec::new();
    }
    let typing = ctx.text_edit_focused();
    let mut order: Vec<&Shortcut> = all().filter(|s| s.command != Command::Play).collect();
    // egui takes Ctrl+Shift+Z for Ctrl+Z where it is asked for that first.
    order.sort_by_key(|s| !s.keys.modifiers.shift);
    let mut commands = Vec::new();
    ctx.input_mut(|input| {
        for shortcut in order {
            let plain = shortcut.keys.modifiers.is_none() && !matches!(shortcut.keys.logical_key, Key::F1);
            let edits_text = matches!(shortcut.command, Command::Undo | Command::Redo);
            if typing && (plain || edits_text) {
                continue;
            }
            if input.consume_shortcut(&shortcut.keys) {
                commands.push(shortcut.command);
            }
        }
        if !typing
            && input.consume_key(Modifiers::SHIFT, Key::Questionmark)
                | input.consume_key(Modifiers::NONE, Key::Questionmark)
        {
            commands.push(Command::Help);
        }
    });
    commands
}

/// Whether the key that plays was let go.
pub(crate) fn play_released(ctx: &Context) -> bool {
    !covered(ctx) && !ctx.text_edit_focused() && ctx.input(|i| i.key_released(Key::Space))
}

/// Whether a dialog or a list is open, whose the keys are.
fn covered(ctx: &Context) -> bool {
    Popup::is_any_open(ctx) || ctx.memory(|m| m.top_modal_layer().is_some())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_two_commands_share_a_key_and_none_is_listed_twice() {
        let all: Vec<&Shortcut> = all().collect();
        for (i, one) in all.iter().enumerate() {
            for other in &all[..i] {
                assert_ne!(one.keys, other.keys, "{:?} and {:?}", one.command, other.command);
                assert_ne!(one.command, other.command);
                assert_ne!(one.text, other.text);
            }
        }
    }
}
