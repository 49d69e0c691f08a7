//! The menu of the calls that a human referee makes: stops, time-outs, kick-offs, pick-ups and substitutions.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::egui::{self, Button};

use naoisis_core::game::{Game, Intervention, Penalty, PenaltyReason};
use naoisis_core::robot::Roster;
use naoisis_core::team::{PerTeam, RobotId, Team};

/// A call, with its text and hint; `None` if it is not possible now.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct Call {
    pub(super) text: String,
    hint: &'static str,
    pub(super) intervention: Option<Intervention>,
}

/// What the referee's calls depend on.
#[derive(SystemParam)]
pub(super) struct RefereeMenu<'w, 's> {
    game: Res<'w, Game>,
    roster: Res<'w, Roster>,
    penalties: Query<'w, 's, (&'static RobotId, &'static Penalty)>,
}

impl RefereeMenu<'_, '_> {
    /// Shows the menu. Returns the call that was clicked.
    pub(super) fn show(&self, ui: &mut egui::Ui, selected: Option<RobotId>) -> Option<Intervention> {
        let selected = selected.filter(|robot| self.roster.get(*robot).is_some());
        let mut clicked = None;
        let menu = ui.menu_button("Referee", |ui| {
            for call in calls(&self.game, selected, &self.substitutes()) {
                let button = Button::new(call.text);
                if ui.add_enabled(call.intervention.is_some(), button).on_hover_text(call.hint).clicked() {
                    clicked = call.intervention;
                    ui.close();
                }
            }
        });
        menu.response.on_hover_text("Stops, time-outs, kick-offs; pick-ups and substitutions of the selected robot");
        clicked
    }

    /// The substitutes of each team, by number.
    fn substitutes(&self) -> PerTeam<Vec<RobotId>> {
        let mut substitutes = PerTeam::<Vec<RobotId>>::default();
        for (robot, penalty) in &self.penalties {
            if penalty.0.is_some_and(|penalty| penalty.reason == PenaltyReason::Substitute) {
                substitutes[robot.team].push(*robot);
            }
        }
        for team in Team::BOTH {
            substitutes[team].sort_unstable();
        }
        substitutes
    }
}

/// Returns the calls in the state of `game`; those of one robot are of `selected`.
pub(super) fn calls(game: &Game, selected: Option<RobotId>, substitutes: &PerTeam<Vec<RobotId>>) -> Vec<Call> {
    let always = |text: String, hint, intervention| Call { text, hint, intervention: Some(intervention) };
    let is_stopped = game.stop.is_some() || game.timeout.is_some();
    let mut calls = vec![if is_stopped {
        always("Resume".to_owned(), "Ends the stop or time-out", Intervention::Resume)
    } else {
        always("Stop briefly".to_owned(), "Nobody moves, no clock runs", Intervention::Stop)
    }];
    let timeout = Intervention::Timeout { team: None, duration_s: None };
    calls.push(always("Time-out of the referee".to_owned(), "At once", timeout));
    for team in Team::BOTH {
        let left = game.timeouts_left[team];
        calls.push(Call {
            text: format!("Time-out of {team}: {left} left"),
            hint: "In the next stoppage of play",
            intervention: (left > 0).then_some(Intervention::Timeout { team: Some(team), duration_s: None }),
        });
    }
    for team in Team::BOTH {
        calls.push(always(format!("Kick-off of {team}"), "Stops play for it", Intervention::KickOff { team }));
    }
    let Some(robot) = selected else { return calls };
    if substitutes[robot.team].contains(&robot) {
        return calls;
    }
    calls.push(always(format!("Pick up {robot}"), "As its team asks", Intervention::PickUp { robot }));
    calls.extend(substitutes[robot.team].iter().map(|&by| {
        let hint = "As soon as the rules allow it";
        always(format!("Replace {robot} by {by}"), hint, Intervention::Substitute { robot, by })
    }));
    calls
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_outs_are_offered_while_a_team_has_some_and_substitutes_of_the_own_team_only() {
        let [blue2, blue6, pink1] =
            [(Team::Blue, 2), (Team::Blue, 6), (Team::Pink, 1)].map(|(team, number)| RobotId { team, number });
        let game = Game { timeouts_left: PerTeam { blue: 1, pink: 0 }, ..Game::default() };
        let substitutes = PerTeam { blue: vec![blue6], pink: Vec::new() };
        let possible = |selected| -> Vec<String> {
            let calls = calls(&game, selected, &substitutes).into_iter();
            calls.filter(|call| call.intervention.is_some()).map(|call| call.text).collect()
        };
        let of_match = [
            "Stop briefly", "Time-out of the referee", "Time-out of blue: 1 left", "Kick-off of blue",
            "Kick-off of pink",
        ];
        assert_eq!(possible(None), of_match);
        assert_eq!(possible(Some(blue2))[5..], ["Pick up blue2", "Replace blue2 by blue6"]);
        assert_eq!(possible(Some(pink1))[5..], ["Pick up pink1"]);
        assert_eq!(possible(Some(blue6)), of_match);
    }
}
