//! The list of commands, in which one is found by typing a part of its name.

use bevy::prelude::*;
use bevy_egui::egui::{self, Align2, Key, Margin, Order, TextEdit, WidgetInfo, WidgetType};
use bevy_egui::{EguiContexts, EguiPrimaryContextPass};

use super::commands::{Action, FindEvent, SelectionCommand, TeachAction, ViewerCommand};
use super::display_settings::{DisplaySettings, Switch, Workspace};
use super::key_bindings::first_bindings;
use super::keys::TypedAhead;
use super::layout::{LARGE_SCORE, LayoutSystems, shown_at};
use super::speed::Speed;
use super::theme::{MARGIN, bright, card, dim, panel};
use naoisis_core::robot::Roster;
use naoisis_sim::scenario::LIBRARY;

/// The width of the list, its distance from the upper edge, and its greatest height, logical pixels.
const WIDTH: f32 = 480.0;
/// Its least width, also in a smaller window, logical pixels.
const LEAST_WIDTH: f32 = 100.0;
const BELOW_SCORE: f32 = 70.0;
const HEIGHT: f32 = 380.0;
/// The height of everything around the list, and its least height, logical pixels.
const AROUND: f32 = 80.0;
const LEAST_HEIGHT: f32 = 60.0;

/// Other words for commands, by which they are found, too.
const SYNONYMS: &[(Action, &str)] = &[
    (Action::Toggle(Switch::Summary), "summary passes shots possession table"),
    (Action::Toggle(Switch::Decided), "swings chances why lost goal reasons"),
    (Action::Toggle(Switch::Events), "goals penalties fouls mistakes list"),
    (Action::Toggle(Switch::Lanes), "mistakes goals decisions whole"),
    (Action::Toggle(Switch::Overlays), "beliefs percepts fields of view trails"),
    (Action::Toggle(Switch::Plots), "graph curve belief error chart"),
    (Action::Toggle(Switch::Cameras), "images"),
    (Action::Toggle(Switch::ManyTimes), "repeat what if simulate"),
    (Action::Toggle(Switch::Game), "teams league realism options preferences"),
    (Action::Find(FindEvent::Next), "goal mistake penalty"),
    (Action::Find(FindEvent::Previous), "goal mistake penalty"),
    (Action::Teach(TeachAction::RobotsWorld), "belief believes"),
    (Action::Command(ViewerCommand::MatchBefore), "back undo"),
];

/// Shows the list of commands.
pub struct CommandListPlugin;

impl Plugin for CommandListPlugin {
    fn build(&self, app: &mut App) {
        let is_shown = |display: Res<DisplaySettings>| display.commands;
        app.add_systems(EguiPrimaryContextPass, show.run_if(is_shown).in_set(LayoutSystems::Floating));
    }
}

/// A command of the list.
#[derive(Clone, PartialEq, Debug)]
struct Entry {
    group: &'static str,
    name: String,
    key: &'static str,
    action: Action,
}

/// All commands: those of keys, and choices that have no key.
fn entries(roster: &Roster) -> Vec<Entry> {
    let of_keys = first_bindings()
        .filter(|(_, binding)| binding.action != Action::Toggle(Switch::Commands))
        .map(|(group, binding)| (group, binding.description.to_owned(), binding.name, binding.action));
    let uses = Workspace::ALL.map(|usage| ("Panels", usage.name().to_owned(), "", Action::Workspace(usage)));
    let speeds =
        Speed::ALL.map(|speed| ("Time", format!("Speed {speed}"), "", Action::Command(ViewerCommand::SetSpeed(speed))));
    let robots = roster
        .iter()
        .map(|(robot, _)| ("Robots", format!("Select {robot}"), "", Action::Select(SelectionCommand::Robot(robot))));
    let scenarios = LIBRARY.iter().map(|entry| {
        ("Scenarios", format!("Play {}", entry.name), "", Action::Command(ViewerCommand::Load(entry.name)))
    });
    let all = of_keys.chain(uses).chain(speeds).chain(robots).chain(scenarios);
    all.map(|(group, name, key, action)| Entry { group, name, key, action }).collect()
}

/// The commands in whose group, name or key all words of `typed` occur. The one whose key it is comes first, then those whose name ends
/// with these words, begins with them, has them where a word begins, and has them anywhere.
fn found<'a>(entries: &'a [Entry], typed: &str) -> Vec<&'a Entry> {
    let typed = typed.trim().to_lowercase();
    let is_meant = |entry: &&Entry| {
        let others = SYNONYMS.iter().find(|(action, _)| *action == entry.action).map_or("", |(_, words)| words);
        let text = format!("{} {} {} {others}", entry.group, entry.name, entry.key).to_lowercase();
        typed.split_whitespace().all(|word| text.contains(word))
    };
    let mut found: Vec<&Entry> = entries.iter().filter(is_meant).collect();
    if typed.is_empty() {
        return found;
    }
    // Names of scenarios have underscores between their words.
    let spaced = |text: &str| text.to_lowercase().replace('_', " ");
    let words = format!(" {}", spaced(&typed));
    found.sort_by_key(|entry| {
        let name = spaced(&entry.name);
        let [ends, begins, has] = [name.ends_with(&words), name.starts_with(words.trim_start()), name.contains(&words)];
        (entry.key.to_lowercase() != typed, !ends, !begins, !has, !name.contains(words.trim_start()))
    });
    found
}

/// What was typed, and the index of the marked command.
#[derive(Default)]
struct Typed {
    text: String,
    marked: usize,
}

fn show(
    mut contexts: EguiContexts,
    mut typed: Local<Typed>,
    (mut display, mut ahead): (ResMut<DisplaySettings>, ResMut<TypedAhead>),
    roster: Res<Roster>,
    mut actions: MessageWriter<Action>,
) -> Result {
    let context = contexts.ctx_mut()?;
    typed.text.push_str(&ahead.0);
    ahead.0.clear();
    let entries = entries(&roster);
    let mut chosen = None;
    let keys = [Key::Escape, Key::Enter, Key::ArrowUp, Key::ArrowDown];
    let [closes, enters, up, down] = keys.map(|key| context.input(|input| input.key_pressed(key)));
    // The large score of the use for watching is higher than the bar.
    let top = shown_at(context, LARGE_SCORE).map_or(BELOW_SCORE, |score| BELOW_SCORE.max(score.bottom() + MARGIN));
    // Above the start page.
    let area = panel("commands", Align2::CENTER_TOP, [0.0, top]).order(Order::Foreground);
    area.show(context, |ui| {
        card(ui).fill(ui.visuals().panel_fill).inner_margin(Margin::same(12)).show(ui, |ui| {
            ui.set_width(WIDTH.min(ui.ctx().content_rect().width() - 60.0).max(LEAST_WIDTH));
            let text = TextEdit::singleline(&mut typed.text).hint_text("Find a command").desired_width(f32::INFINITY);
            let text = ui.add(text);
            text.widget_info(|| WidgetInfo::labeled(WidgetType::TextEdit, true, "Find a command"));
            if text.changed() {
                typed.marked = 0;
            }
            text.request_focus();
            let found = found(&entries, &typed.text);
            if up || down {
                let last = found.len().saturating_sub(1);
                typed.marked = if up { typed.marked.saturating_sub(1) } else { (typed.marked + 1).min(last) };
            }
            if found.is_empty() {
                ui.label(dim("No command has a name with these words."));
            }
            // egui would keep the height of the shortest list so far.
            let height = HEIGHT.min(ui.ctx().content_rect().height() - top - AROUND).max(LEAST_HEIGHT);
            let list = egui::ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            list.auto_shrink([false, true]).show(ui, |ui| {
                for (index, entry) in found.iter().enumerate() {
                    let is_marked = index == typed.marked;
                    let row = show_entry(ui, entry, is_marked);
                    if is_marked && (up || down) {
                        row.scroll_to_me(None);
                    }
                    if row.clicked() || (is_marked && enters) {
                        chosen = Some(entry.action);
                    }
                }
            });
        });
    });
    if closes || chosen.is_some() {
        *typed = Typed::default();
        display.commands = false;
        // The text field is gone, so that keys are commands again.
        context.memory_mut(|memory| memory.focused().inspect(|id| memory.surrender_focus(*id)));
    }
    actions.write_batch(chosen);
    Ok(())
}

/// Shows a command with its key at the right.
fn show_entry(ui: &mut egui::Ui, entry: &Entry, is_marked: bool) -> egui::Response {
    let words = bright(format!("{}: {}", entry.group, entry.name));
    let button = egui::Button::selectable(is_marked, words)
        .shortcut_text(if is_marked { bright(entry.key) } else { dim(entry.key) })
        .min_size([ui.available_width(), 0.0].into());
    ui.add(button)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::viewer::key_bindings::BINDINGS;

    #[test]
    fn a_command_is_found_by_parts_of_its_words_in_any_order() {
        let entries = entries(&Roster::default());
        let names = |typed: &str| found(&entries, typed).iter().map(|entry| entry.name.clone()).collect::<Vec<_>>();
        assert_eq!(names("BEFORE match"), ["The match before this one"]);
        assert_eq!(names("ctrl s")[0], "Save the match and its trace");
        assert_eq!(names("play match3v3")[0], "Play match3v3");
        assert_eq!(names("collision post")[0], "Play collision_post");
        assert_eq!(names("k1")[0], "Play k1_against_nao");
        assert_eq!(names("speed 4"), ["Speed 4×"]);
        assert_eq!(names("summary"), ["Statistics of the match"]);
        assert!(names("goal").contains(&"To the next listed event".to_owned()));
        assert!(names("no such thing").is_empty());
        assert_eq!(names("").len(), entries.len());
    }

    #[test]
    fn every_key_has_its_command_and_every_scenario_one() {
        let entries = entries(&Roster::default());
        for binding in BINDINGS.iter().filter(|binding| binding.action != Action::Toggle(Switch::Commands)) {
            assert!(entries.iter().any(|entry| entry.action == binding.action), "{}", binding.name);
        }
        for scenario in LIBRARY {
            assert!(entries.iter().any(|entry| entry.name == format!("Play {}", scenario.name)));
        }
    }
}
