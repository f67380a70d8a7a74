//! Controls for parameters, drawn from what they say of themselves.

use eframe::egui::{Checkbox, ComboBox, Grid, Response, Slider, TextEdit, Ui};
use marey_binding::{PluginParameter, PluginParameterKind};

use crate::plugins::Value;
use crate::widgets;

/// Shows those that are to be seen; gives what was changed: the parameter's name and its new value.
pub(crate) fn show(ui: &mut Ui, of: &str, parameters: &[(PluginParameter, Value)]) -> Option<(String, Value)> {
    let mut changed = None;
    let mut group = "";
    let seen: Vec<&(PluginParameter, Value)> = parameters.iter().filter(|(p, _)| is_shown(p, parameters)).collect();
    let mut rest = &seen[..];
    while let Some((first, _)) = rest.first() {
        let count = rest.iter().take_while(|(p, _)| p.group == first.group).count();
        let (now, later) = rest.split_at(count);
        rest = later;
        if first.group != group {
            group = &first.group;
            widgets::section(ui, group);
        }
        Grid::new((of, &first.id)).num_columns(2).spacing([12.0, 6.0]).show(ui, |ui| {
            for (parameter, value) in now {
                if let Some(value) = one(ui, of, parameter, value) {
                    changed = Some((parameter.id.clone(), value));
                }
                ui.end_row();
            }
        });
    }
    changed
}

/// Whether what it depends on has the value that it depends on.
fn is_shown(parameter: &PluginParameter, all: &[(PluginParameter, Value)]) -> bool {
    let met =
        |(name, wanted): &(String, f64)| all.iter().any(|(p, value)| p.id == *name && *value == Value::Number(*wanted));
    !parameter.hidden && parameter.visible_if.as_ref().is_none_or(met)
}

fn one(ui: &mut Ui, of: &str, parameter: &PluginParameter, value: &Value) -> Option<Value> {
    let label = ui.label(&parameter.label);
    let label = if parameter.about.is_empty() { label } else { label.on_hover_text(&parameter.about) };
    let named = |response: Response| {
        let response = response.labelled_by(label.id);
        if parameter.about.is_empty() { response } else { response.on_hover_text(&parameter.about) }
    };
    match (&parameter.kind, value) {
        (PluginParameterKind::Switch, Value::Number(number)) => {
            let mut on = *number != 0.0;
            let check = ui.add(Checkbox::without_text(&mut on));
            named(check).changed().then_some(Value::Number(f64::from(u8::from(on))))
        }
        (PluginParameterKind::Choice(names), Value::Number(number)) => {
            let mut now = *number as usize;
            let text = names.get(now).map_or("", |n| n);
            let list = ComboBox::from_id_salt((of, &parameter.id)).width(180.0).selected_text(text);
            let list = list.show_ui(ui, |ui| {
                for (i, name) in names.iter().enumerate() {
                    ui.selectable_value(&mut now, i, name);
                }
            });
            named(list.response);
            (now as f64 != *number).then_some(Value::Number(now as f64))
        }
        (PluginParameterKind::Number(low, high) | PluginParameterKind::Whole(low, high), Value::Number(number)) => {
            let mut moved = *number;
            let slider = Slider::new(&mut moved, *low..=*high);
            let slider = match parameter.kind {
                PluginParameterKind::Whole(..) => slider.integer(),
                _ => slider.step_by(parameter.step),
            };
            let unit = if parameter.unit.is_empty() { String::new() } else { format!(" {}", parameter.unit) };
            let moves = named(ui.add(slider.suffix(unit))).changed();
            (moves && moved != *number).then_some(Value::Number(moved))
        }
        (_, Value::Text(text)) => {
            let mut typed = text.clone();
            let edit = ui.add(TextEdit::singleline(&mut typed).desired_width(260.0));
            named(edit).changed().then_some(Value::Text(typed))
        }
        _ => None,
    }
}
