//! What can be done by a key, in one table: the program acts on it, menus and buttons show it, and F1 lists it. A person may
//! choose other keys.

use std::collections::BTreeMap;
use std::sync::Arc;

use eframe::egui::{Context, Id, Key, KeyboardShortcut, Modifiers, Popup};

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
    Onion,
    NewLimb,
    NextLimb,
    RemoveStroke,
    Facing,
    Order,
    ToolLimbs,
    ToolCreature,
    ToolBeside,
    Narrower,
    Wider,
    Fit,
    ZoomIn,
    ZoomOut,
    Strokes,
    Tracks,
    Paths,
    Mask,
    Overlaps,
    Clip,
    NextStyle,
    AsFilmed,
    Make,
    Export,
    ExportAgain,
    Plugins,
    Methods,
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
            on(Command::Facing, Modifiers::NONE, Key::T, texts::DO_FACING),
            on(Command::Order, Modifiers::NONE, Key::I, texts::DO_ORDER),
            on(Command::ToolLimbs, Modifiers::NONE, Key::D, texts::DO_TOOL_LIMBS),
            on(Command::ToolCreature, Modifiers::NONE, Key::B, texts::DO_TOOL_CREATURE),
            on(Command::ToolBeside, Modifiers::NONE, Key::X, texts::DO_TOOL_BESIDE),
            on(Command::Narrower, Modifiers::NONE, Key::OpenBracket, texts::DO_NARROWER),
            on(Command::Wider, Modifiers::NONE, Key::CloseBracket, texts::DO_WIDER),
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
            on(Command::Onion, Modifiers::NONE, Key::O, texts::DO_ONION),
            on(Command::Fit, CTRL, Key::Num0, texts::DO_FIT),
            on(Command::ZoomIn, CTRL, Key::Plus, texts::DO_ZOOM_IN),
            on(Command::ZoomOut, CTRL, Key::Minus, texts::DO_ZOOM_OUT),
            on(Command::Strokes, Modifiers::NONE, Key::Num1, texts::DO_STROKES),
            on(Command::Tracks, Modifiers::NONE, Key::Num2, texts::DO_TRACKS),
            on(Command::Paths, Modifiers::NONE, Key::Num3, texts::DO_PATHS),
            on(Command::Mask, Modifiers::NONE, Key::Num4, texts::DO_MASK),
            on(Command::Overlaps, Modifiers::NONE, Key::Num5, texts::DO_OVERLAPS),
            on(Command::Clip, Modifiers::NONE, Key::G, texts::DO_CLIP),
            on(Command::NextStyle, Modifiers::NONE, Key::V, texts::DO_NEXT_STYLE),
            on(Command::AsFilmed, Modifiers::NONE, Key::F, texts::DO_AS_FILMED),
        ],
    ),
    (
        texts::GROUP_MORE,
        &[
            on(Command::Export, CTRL, Key::E, texts::DO_EXPORT),
            on(Command::ExportAgain, CTRL_SHIFT, Key::E, texts::DO_EXPORT_AGAIN),
            on(Command::Methods, CTRL, Key::M, texts::DO_METHODS),
            on(Command::Plugins, CTRL_SHIFT, Key::P, texts::DO_PLUGINS),
            on(Command::Light, CTRL, Key::L, texts::DO_LIGHT),
            on(Command::Help, Modifiers::NONE, Key::F1, texts::DO_HELP),
        ],
    ),
];

/// Keys that a person chose instead of those of the table: by the command's name, as text; empty for none.
pub(crate) type Chosen = BTreeMap<String, String>;

/// What each command has now, in the order of the table.
type Keymap = Arc<Vec<(Command, Option<KeyboardShortcut>)>>;

fn id() -> Id {
    Id::unique("keymap")
}

/// Lets `chosen` be so from now on.
pub(crate) fn choose(ctx: &Context, chosen: &Chosen) {
    let of = |s: &Shortcut| match chosen.get(&name(s.command)) {
        Some(text) if text.is_empty() => None,
        // What cannot be read is as good as not chosen.
        Some(text) => Some(parse(text).unwrap_or(s.keys)),
        None => Some(s.keys),
    };
    let map: Keymap = Arc::new(all().map(|s| (s.command, of(s))).collect());
    ctx.data_mut(|data| data.insert_temp(id(), map));
}

fn keymap(ctx: &Context) -> Keymap {
    ctx.data(|data| data.get_temp::<Keymap>(id()))
        .unwrap_or_else(|| Arc::new(all().map(|s| (s.command, Some(s.keys))).collect()))
}

/// What a command is remembered by.
pub(crate) fn name(command: Command) -> String {
    format!("{command:?}")
}

/// The keys of a command.
pub(crate) fn keys(ctx: &Context, command: Command) -> Option<KeyboardShortcut> {
    keymap(ctx).iter().find(|(c, _)| *c == command).and_then(|(_, keys)| *keys)
}

/// The other command that has these keys, and what it does.
pub(crate) fn taken(ctx: &Context, keys: KeyboardShortcut, by_other_than: Command) -> Option<(Command, &'static str)> {
    let map = keymap(ctx);
    let other = map.iter().find(|(c, k)| *c != by_other_than && *k == Some(keys))?.0;
    all().find(|s| s.command == other).map(|s| (other, s.text))
}

/// As they are remembered: "Ctrl+Shift+E"; Ctrl is Command on a Mac.
pub(crate) fn text(keys: KeyboardShortcut) -> String {
    let KeyboardShortcut { modifiers: m, logical_key } = keys;
    let held = [(m.command || m.ctrl, "Ctrl+"), (m.shift, "Shift+"), (m.alt, "Alt+")];
    // A comma alone is easily overlooked; a bracket is what is on the key.
    let name = match logical_key {
        Key::OpenBracket => "[",
        Key::CloseBracket => "]",
        key => key.name(),
    };
    held.iter().filter(|(on, _)| *on).map(|(_, word)| *word).chain([name]).collect()
}

fn parse(text: &str) -> Option<KeyboardShortcut> {
    let (mut modifiers, mut rest) = (Modifiers::NONE, text);
    for (word, modifier) in [("Ctrl+", CTRL), ("Shift+", Modifiers::SHIFT), ("Alt+", Modifiers::ALT)] {
        if let Some(behind) = rest.strip_prefix(word) {
            (modifiers, rest) = (modifiers.plus(modifier), behind);
        }
    }
    Key::from_name(rest).map(|key| KeyboardShortcut::new(modifiers, key))
}

/// A key with what is held, as a person pressed it, to be a command's; an error where it has another use in any window.
pub(crate) fn offered(modifiers: Modifiers, key: Key) -> Result<KeyboardShortcut, &'static str> {
    let mut held = if modifiers.command || modifiers.ctrl { CTRL } else { Modifiers::NONE };
    (held.shift, held.alt) = (modifiers.shift, modifiers.alt);
    let moves = [Key::Tab, Key::Enter, Key::ArrowLeft, Key::ArrowRight, Key::ArrowUp, Key::ArrowDown, Key::Escape];
    let edits = [Key::A, Key::C, Key::V, Key::X];
    if moves.contains(&key) && !held.command && !held.alt {
        return Err(texts::KEY_MOVES);
    }
    if held == CTRL && edits.contains(&key) {
        return Err(texts::KEY_EDITS);
    }
    Ok(KeyboardShortcut::new(held, key))
}

/// Keys as a person reads them on their keyboard.
pub(crate) fn shown(ctx: &Context, keys: &KeyboardShortcut) -> String {
    let text = ctx.format_shortcut(keys);
    let brackets = [(Key::OpenBracket, "["), (Key::CloseBracket, "]")];
    let bracket = brackets.iter().find(|(key, _)| *key == keys.logical_key);
    let head = bracket.and_then(|(key, sign)| Some((text.strip_suffix(key.name())?, sign)));
    head.map(|(head, sign)| format!("{head}{sign}")).unwrap_or(text)
}

/// A text for a tooltip: what it does, and by which key.
pub(crate) fn hint(ctx: &Context, text: &str, command: Command) -> String {
    keys(ctx, command).map_or_else(|| text.to_owned(), |keys| texts::with_key(text, &shown(ctx, &keys)))
}

fn all() -> impl Iterator<Item = &'static Shortcut> {
    TABLE.iter().flat_map(|(_, group)| *group)
}

/// Its key pans too, while it is held: it plays when it is let go.
const PLAYS: KeyboardShortcut = KeyboardShortcut::new(Modifiers::NONE, Key::Space);

/// The commands whose keys were pressed. Keys without Ctrl are left to a text that is being typed, and those that move
/// or press a widget that has the focus to the widget. The space bar is not among them, see [`space_released`].
pub(crate) fn pressed(ctx: &Context) -> Vec<Command> {
    if covered(ctx) {
        return Vec::new();
    }
    let typing = ctx.text_edit_focused();
    let map = keymap(ctx);
    let mut order: Vec<(Command, KeyboardShortcut)> = map.iter().filter_map(|(c, keys)| Some((*c, (*keys)?))).collect();
    order.retain(|(_, keys)| *keys != PLAYS);
    // egui takes Ctrl+Shift+Z for Ctrl+Z where it is asked for that first.
    order.sort_by_key(|(_, keys)| (!keys.modifiers.shift, !keys.modifiers.alt));
    let mut commands = Vec::new();
    ctx.input_mut(|input| {
        for (command, keys) in order {
            let plain = !(keys.modifiers.command || keys.modifiers.alt || is_function(keys.logical_key));
            let edits_text = matches!(command, Command::Undo | Command::Redo);
            if typing && (plain || edits_text) {
                continue;
            }
            if input.consume_shortcut(&keys) {
                commands.push(command);
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

/// F1 and its like write nothing.
fn is_function(key: Key) -> bool {
    key.name().strip_prefix('F').is_some_and(|number| number.parse::<u8>().is_ok())
}

/// The command of the space bar, where it was let go.
pub(crate) fn space_released(ctx: &Context) -> Option<Command> {
    let released = !covered(ctx) && !ctx.text_edit_focused() && ctx.input(|i| i.key_released(Key::Space));
    let command = keymap(ctx).iter().find(|(_, keys)| *keys == Some(PLAYS)).map(|(command, _)| *command);
    command.filter(|_| released)
}

/// Whether a dialog or a list is open, whose the keys are.
fn covered(ctx: &Context) -> bool {
    Popup::is_any_open(ctx) || ctx.memory(|m| m.top_modal_layer().is_some())
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test that cannot go on has failed")]
mod tests {
    use super::*;

    #[test]
    fn keys_are_remembered_as_text_and_damage_costs_one_of_them() {
        for shortcut in all() {
            assert_eq!(parse(&text(shortcut.keys)), Some(shortcut.keys), "{:?}", shortcut.command);
        }
        let ctx = Context::default();
        let chosen = [("Save", "Ctrl+Alt+K"), ("Undo", "Ctrl+Nonsense"), ("Redo", ""), ("Gone", "Ctrl+G")];
        choose(&ctx, &chosen.map(|(name, keys)| (name.to_owned(), keys.to_owned())).into());
        let of = |command| keys(&ctx, command).map(text);
        assert_eq!(of(Command::Save).as_deref(), Some("Ctrl+Alt+K"));
        assert_eq!((of(Command::Undo).as_deref(), of(Command::Redo)), (Some("Ctrl+Z"), None));
        assert_eq!(taken(&ctx, parse("Ctrl+Z").unwrap(), Command::Save), Some((Command::Undo, texts::DO_UNDO)));
        assert_eq!(taken(&ctx, parse("Ctrl+Z").unwrap(), Command::Undo), None);
    }

    #[test]
    fn keys_that_every_window_needs_are_not_given_away() {
        for (modifiers, key) in [(Modifiers::NONE, Key::Tab), (Modifiers::SHIFT, Key::Tab), (CTRL, Key::C)] {
            assert!(offered(modifiers, key).is_err(), "{key:?}");
        }
        assert_eq!(offered(CTRL_SHIFT, Key::E).map(text), Ok("Ctrl+Shift+E".into()));
        assert_eq!(offered(CTRL, Key::Enter).map(text), Ok("Ctrl+Enter".into()));
    }

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
