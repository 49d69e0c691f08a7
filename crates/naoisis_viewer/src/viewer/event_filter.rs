//! The filter of the list of events: by kind, team and robot. Hidden events are counted.

use bevy::prelude::*;
use bevy_egui::egui::containers::menu::{MenuButton, MenuConfig};
use bevy_egui::egui::{self, PopupCloseBehavior, RichText, WidgetInfo, WidgetType};
use std::collections::{BTreeMap, BTreeSet};

use super::commands::FindEvent;
use super::event_log::{EventLog, LogEntry, LogKind};
use super::theme::{dim, team_colour, text_size};
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};

/// The longest time from a mistake to a goal for the other team that the mistake may have cost, s.
pub const COSTLY_S: f64 = 10.0;

/// Keeps the [`ListedEvents`].
pub struct EventFilterPlugin;

impl Plugin for EventFilterPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<EventFilter>()
            .init_resource::<FoundMistakes>()
            .init_resource::<ListedEvents>()
            .add_systems(PreUpdate, list_events);
    }
}

/// Which events are listed.
#[derive(Resource, Clone, PartialEq, Eq, Debug)]
pub struct EventFilter {
    /// Hidden kinds.
    pub hidden: BTreeSet<LogKind>,
    /// Only events of this team.
    pub team: Option<Team>,
    /// Only events of this robot.
    pub robot: Option<RobotId>,
    /// Of mistakes, only those shortly before a goal for the other team.
    pub only_costly: bool,
}

impl Default for EventFilter {
    fn default() -> Self {
        // Mistakes are only found by reading the whole match, so they are hidden until the user wants them.
        Self { hidden: [LogKind::Mistake].into(), ..Self::everything() }
    }
}

impl EventFilter {
    /// Returns whether an event passes the filter.
    pub fn has(&self, entry: &LogEntry) -> bool {
        let team = entry.robot.map(|robot| robot.team).or(entry.team);
        !self.hidden.contains(&entry.kind)
            && self.team.is_none_or(|wanted| team == Some(wanted))
            && self.robot.is_none_or(|wanted| entry.robot == Some(wanted))
            && (entry.kind != LogKind::Mistake || entry.important || !self.only_costly)
    }

    /// Returns whether the filter shows mistakes.
    pub fn has_mistakes(&self) -> bool {
        !self.hidden.contains(&LogKind::Mistake)
    }
}

/// The mistakes of robots as entries of the list, once they have been searched for.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct FoundMistakes(pub Vec<LogEntry>);

/// The listed events, oldest first, and the number of hidden ones.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct ListedEvents {
    /// The listed events.
    pub entries: Vec<LogEntry>,
    /// The number of events of each kind, listed or not; mistakes only once they have been searched for.
    pub counts: BTreeMap<LogKind, usize>,
    /// The number of hidden events.
    pub hidden: usize,
    /// The inputs from which the list was made, to detect changes.
    of: Option<(EventFilter, usize, Option<LogEntry>, usize)>,
}

impl ListedEvents {
    /// Filters the log and the mistakes.
    fn of(filter: &EventFilter, log: &[LogEntry], mistakes: &[LogEntry]) -> Self {
        let mut listed = Self::default();
        for entry in log.iter().chain(mistakes).cloned() {
            *listed.counts.entry(entry.kind).or_default() += 1;
            if filter.has(&entry) {
                listed.entries.push(entry);
            } else {
                listed.hidden += 1;
            }
        }
        // What is done by hand comes before what the referee makes of it.
        let is_effect = |entry: &LogEntry| entry.kind != LogKind::Hand;
        listed
            .entries
            .sort_by(|one, other| one.time_s.total_cmp(&other.time_s).then(is_effect(one).cmp(&is_effect(other))));
        listed
    }
}

/// Updates the list if an input has changed.
fn list_events(
    filter: Res<EventFilter>,
    log: Res<EventLog>,
    found: Res<FoundMistakes>,
    mut listed: ResMut<ListedEvents>,
) {
    let mistakes = if filter.has_mistakes() { &found.0[..] } else { &[] };
    let log = log.until(f64::INFINITY);
    let is_same = listed.of.as_ref().is_some_and(|(of, count, last, wrong)| {
        *of == *filter && *count == log.len() && last.as_ref() == log.last() && *wrong == found.0.len()
    });
    if !is_same {
        let of = Some((filter.clone(), log.len(), log.last().cloned(), found.0.len()));
        *listed = ListedEvents { of, ..ListedEvents::of(&filter, log, mistakes) };
        if !found.0.is_empty() {
            listed.counts.insert(LogKind::Mistake, found.0.len());
        }
    }
}

/// Shows the buttons to the next and previous listed event, and the filter. Returns whether the filter was changed.
pub(super) fn show(
    ui: &mut egui::Ui,
    filter: &mut EventFilter,
    listed: &ListedEvents,
    roster: &Roster,
    events: &mut MessageWriter<FindEvent>,
) -> bool {
    let mut is_used = false;
    ui.horizontal_wrapped(|ui| {
        let steps = [
            ("<", "Previous listed event", "Previous event (,)", FindEvent::Previous),
            (">", "Next listed event", "Next event (.)", FindEvent::Next),
        ];
        for (text, name, hint, event) in steps {
            let button = ui.small_button(text);
            button.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
            if button.on_hover_text(hint).clicked() {
                is_used = true;
                events.write(event);
            }
        }
        let only_goals = filter.kinds() == [LogKind::Goal];
        let goals = ui.selectable_label(only_goals, RichText::new("Goals").size(text_size::SMALL));
        goals.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, only_goals, "Only goals"));
        if goals.on_hover_text("Only goals; again: all events").clicked() {
            is_used = true;
            filter.hidden = if only_goals { EventFilter::default().hidden } else { only(LogKind::Goal) };
        }
        if filter.has_mistakes() {
            let costly = ui.selectable_label(filter.only_costly, RichText::new("Costly").size(text_size::SMALL));
            let name = "Only costly mistakes";
            let hint = format!("Of mistakes, only those in the {COSTLY_S:.0} s before a goal for the other team");
            costly.widget_info(|| WidgetInfo::selected(WidgetType::Button, true, filter.only_costly, name));
            if costly.on_hover_text(hint).clicked() {
                is_used = true;
                filter.only_costly = !filter.only_costly;
            }
        }
        let stays = MenuConfig::new().close_behavior(PopupCloseBehavior::CloseOnClickOutside);
        let before = filter.clone();
        let words = RichText::new("Filter").size(text_size::SMALL);
        let (button, _) = MenuButton::new(words).config(stays).ui(ui, |ui| choose(ui, filter, listed, roster));
        button.on_hover_text("Which events are listed; , and . jump between them");
        is_used |= *filter != before;
        if listed.hidden > 0 {
            let count = format!("{} hidden", listed.hidden);
            let all = ui.small_button(RichText::new(&count).size(text_size::SMALL));
            all.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, "Hidden events"));
            if all.on_hover_text("Click: list all events").clicked() {
                *filter = EventFilter { hidden: filter.hidden_mistakes(), ..EventFilter::everything() };
            }
        }
    });
    is_used
}

/// Every kind but this one.
fn only(kind: LogKind) -> BTreeSet<LogKind> {
    LogKind::ALL.into_iter().map(|(other, _)| other).filter(|other| *other != kind).collect()
}

impl EventFilter {
    /// Lists only this kind.
    pub(super) fn list_only(&mut self, kind: LogKind) {
        self.hidden = only(kind);
    }

    /// The kinds that are listed.
    fn kinds(&self) -> Vec<LogKind> {
        LogKind::ALL.into_iter().map(|(kind, _)| kind).filter(|kind| !self.hidden.contains(kind)).collect()
    }

    fn everything() -> Self {
        Self { hidden: BTreeSet::new(), team: None, robot: None, only_costly: false }
    }

    /// The default: mistakes are hidden, because finding them takes time.
    fn hidden_mistakes(&self) -> BTreeSet<LogKind> {
        self.hidden.iter().copied().filter(|kind| *kind == LogKind::Mistake).collect()
    }
}

fn choose(ui: &mut egui::Ui, filter: &mut EventFilter, listed: &ListedEvents, roster: &Roster) {
    for (kind, name) in LogKind::ALL {
        let mut is_on = !filter.hidden.contains(&kind);
        let is_unknown = kind == LogKind::Mistake && !is_on && !listed.counts.contains_key(&kind);
        let count = listed.counts.get(&kind).copied().unwrap_or_default();
        let words = if is_unknown { name.to_owned() } else { format!("{name} ({count})") };
        let (shown, alone) = ui
            .horizontal(|ui| {
                let shown = ui.checkbox(&mut is_on, words);
                (shown, ui.small_button(RichText::new("only").size(text_size::SMALL)))
            })
            .inner;
        shown.widget_info(|| WidgetInfo::selected(WidgetType::Checkbox, true, is_on, format!("List {name}")));
        alone.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, format!("Only {name}")));
        if alone.clicked() {
            filter.list_only(kind);
        }
        if shown.clicked() {
            if is_on {
                filter.hidden.remove(&kind);
            } else {
                filter.hidden.insert(kind);
            }
        }
    }
    ui.separator();
    ui.horizontal(|ui| {
        ui.label(dim("of"));
        ui.selectable_value(&mut filter.team, None, "both teams");
        for team in Team::BOTH {
            let name = RichText::new(team.name()).color(team_colour(ui, team));
            if ui.selectable_label(filter.team == Some(team), name).clicked() {
                filter.team = Some(team);
                filter.robot = filter.robot.filter(|robot| robot.team == team);
            }
        }
    });
    let chosen = filter.robot.map_or("any robot".to_owned(), |robot| robot.to_string());
    egui::ComboBox::from_id_salt("robot of events").selected_text(chosen).show_ui(ui, |ui| {
        ui.selectable_value(&mut filter.robot, None, "any robot");
        let ids = roster.iter().map(|(id, _)| id);
        for id in ids.filter(|id| filter.team.is_none_or(|team| id.team == team)).collect::<Vec<_>>() {
            ui.selectable_value(&mut filter.robot, Some(id), id.to_string());
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);
    const PINK: RobotId = RobotId::new(Team::Pink, 1);

    fn log() -> Vec<LogEntry> {
        let entry = |second: u32, kind, robot: Option<RobotId>| LogEntry {
            time_s: f64::from(second),
            kind,
            robot,
            team: robot.map(|robot| robot.team),
            ..default()
        };
        vec![
            entry(1, LogKind::Referee, None),
            entry(2, LogKind::Kick, Some(BLUE)),
            entry(3, LogKind::Kick, Some(PINK)),
            entry(4, LogKind::Goal, Some(PINK)),
        ]
    }

    fn times(filter: &EventFilter, mistakes: &[LogEntry]) -> (Vec<f64>, usize) {
        let listed = ListedEvents::of(filter, &log(), mistakes);
        (listed.entries.iter().map(|entry| entry.time_s).collect(), listed.hidden)
    }

    #[test]
    fn what_is_left_out_is_counted() {
        let all = EventFilter::default();
        assert_eq!(times(&all, &[]), (vec![1.0, 2.0, 3.0, 4.0], 0));
        let no_kicks = EventFilter { hidden: [LogKind::Kick].into(), ..all.clone() };
        assert_eq!(times(&no_kicks, &[]), (vec![1.0, 4.0], 2));
        assert_eq!(times(&EventFilter { team: Some(Team::Pink), ..all.clone() }, &[]), (vec![3.0, 4.0], 2));
        assert_eq!(times(&EventFilter { robot: Some(BLUE), ..all }, &[]), (vec![2.0], 3));
    }

    #[test]
    fn one_kind_alone_is_all_that_is_listed() {
        for (kind, _) in LogKind::ALL {
            assert_eq!(EventFilter { hidden: only(kind), ..EventFilter::everything() }.kinds(), [kind]);
        }
    }

    #[test]
    fn costly_mistakes_are_found_among_the_others() {
        let mistake = |time_s, important| LogEntry { time_s, important, kind: LogKind::Mistake, ..default() };
        let filter = EventFilter { only_costly: true, hidden: only(LogKind::Mistake), ..EventFilter::everything() };
        assert_eq!(times(&filter, &[mistake(2.5, false), mistake(3.5, true)]).0, [3.5]);
    }

    #[test]
    fn mistakes_stand_among_the_events_of_their_time() {
        let mistake = LogEntry { time_s: 2.5, kind: LogKind::Mistake, ..default() };
        let (times, hidden) = times(&EventFilter::everything(), &[mistake]);
        assert_eq!((times, hidden), (vec![1.0, 2.0, 2.5, 3.0, 4.0], 0));
    }
}
