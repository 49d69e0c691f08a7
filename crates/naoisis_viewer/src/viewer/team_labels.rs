//! The names of the teams, cut to the room that there is.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{Color32, FontId, Painter};

use naoisis_core::behaviour::BehaviourRegistry;
use naoisis_core::team::{PerTeam, Team};
use naoisis_record::record::team_names::team_names;
use naoisis_sim::scenario::Scenario;

/// The number of letters that a name has at least, however little room there is.
const LEAST: usize = 6;

/// The names of the teams.
#[derive(SystemParam)]
pub(super) struct TeamNames<'w> {
    scenario: Option<Res<'w, Scenario>>,
    registry: Res<'w, BehaviourRegistry>,
}

impl TeamNames<'_> {
    /// Returns the names of blue and pink.
    pub fn both(&self) -> [String; 2] {
        match &self.scenario {
            Some(scenario) => {
                let PerTeam { blue, pink } = team_names(scenario, &self.registry);
                [blue, pink]
            }
            None => Team::BOTH.map(|team| team.name().to_owned()),
        }
    }

    /// Returns the names, cut as far as they do not fit into this width together; `width_of` measures a name.
    pub fn within(&self, room: f32, width_of: impl Fn(&str) -> f32) -> [String; 2] {
        cut(self.both(), room, width_of)
    }
}

/// Returns the width of a text in letters of this size, logical pixels.
pub(super) fn width_of(painter: &Painter, text: &str, size: f32) -> f32 {
    painter.layout_no_wrap(text.to_owned(), FontId::proportional(size), Color32::WHITE).size().x
}

/// The names, of which the wider one loses letters until both fit into a width.
fn cut(names: [String; 2], room: f32, width_of: impl Fn(&str) -> f32) -> [String; 2] {
    let with_letters = |index: usize, letters: usize| {
        let name: &String = &names[index];
        match letters < name.chars().count() {
            true => name.chars().take(letters.saturating_sub(1)).chain(['…']).collect(),
            false => name.clone(),
        }
    };
    let mut letters = [0, 1].map(|index| names[index].chars().count());
    loop {
        let shown = [0, 1].map(|index| with_letters(index, letters[index]));
        let widths = [0, 1].map(|index| width_of(&shown[index]));
        let wider = usize::from(widths[1] > widths[0]);
        let Some(cut) = [wider, 1 - wider].into_iter().find(|index| letters[*index] > LEAST) else { return shown };
        if widths[0] + widths[1] <= room {
            return shown;
        }
        letters[cut] -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::simulation::{self, NaoisisPlugins};

    #[test]
    fn names_are_cut_only_where_they_do_not_fit() {
        let names =
            |room: f32| cut(["roles".into(), "the fast strikers".into()], room, |name| name.chars().count() as f32);
        assert_eq!(names(22.0), ["roles", "the fast strikers"]);
        assert_eq!(names(21.0), ["roles", "the fast strike…"]);
        assert_eq!(names(0.0), ["roles", "the f…"], "a name has some letters in any case");
    }

    #[test]
    fn teams_have_the_names_of_the_scenario() {
        let scenario = Scenario::from_json(r#"{ "teams": { "blue": "roles", "pink": "chasers" } }"#).unwrap();
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        let pink = |scenario: &Scenario| team_names(scenario, app.world().resource()).pink;
        assert_eq!(pink(&scenario), "chasers");
        // A trace lists robots, not teams.
        let listed = simulation::resolved(app.world(), &scenario);
        assert_eq!(listed.teams, None);
        assert_eq!(pink(&listed), "chasers");
        let scripted = Scenario::from_json(r#"{ "robots": [{ "team": "pink", "number": 1 }] }"#).unwrap();
        assert_eq!(pink(&scripted), "pink");
    }
}
