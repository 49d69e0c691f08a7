//! Substitutions (2025 rule book, section 3.12; HSL 2026, 3.4). In a time-out and at half time the substitute takes the player's place at once.
//! In other stoppages it enters where penalised robots return; by the rules of 2025 it waits there as a robot that is picked up does. The
//! penalty of the player and its cautions pass to the substitute, and so does the task of the goalkeeper.

use super::decide::Referee;
use super::formation;
use super::placing::Occupied;
use super::removal::waiting_pose;
use crate::events::MatchEvent;
use crate::game::{ActivePenalty, GameState, Penalty, PenaltyReason, SubstitutionProcedure};
use crate::team::RobotId;

impl Referee<'_, '_> {
    /// Records that `robot` is to be replaced by the substitute `by`.
    ///
    /// # Errors
    /// The reason why this is not possible.
    pub(super) fn ask_for_substitution(&mut self, robot: RobotId, by: RobotId) -> Result<(), String> {
        self.require_own_referee()?;
        self.require_no_shoot_out()?;
        if self.decisions.game.state == GameState::Finished {
            return Err("the match is over".to_owned());
        }
        self.check_substitution([robot, by])?;
        let requests = &mut self.memory.substitution_requests;
        match requests.iter().find(|request| request[0] == robot || request[1] == by) {
            Some(request) if *request == [robot, by] => {}
            Some([out, on]) => return Err(format!("{on} is to replace {out} already")),
            None => requests.push([robot, by]),
        }
        Ok(())
    }

    /// The indices of a player and its substitute.
    fn check_substitution(&self, [robot, by]: [RobotId; 2]) -> Result<[usize; 2], String> {
        let indices = [self.find(robot)?, self.find(by)?];
        let reason = |index: usize| self.decisions.robots[index].penalty.0.map(|penalty| penalty.reason);
        if robot.team != by.team {
            return Err(format!("{by} is of the other team"));
        }
        if reason(indices[1]) != Some(PenaltyReason::Substitute) {
            return Err(format!("{by} is no substitute"));
        }
        match reason(indices[0]) {
            Some(PenaltyReason::Substitute) => Err(format!("{robot} is a substitute itself")),
            Some(PenaltyReason::SentOff) => Err(format!("{robot} is sent off")),
            _ => Ok(indices),
        }
    }

    /// Makes the requested substitutions, if the rules allow them now.
    pub(super) fn make_substitutions(&mut self) {
        if self.memory.substitution_requests.is_empty() {
            return;
        }
        let game = &self.decisions.game;
        let at_half_time = game.half != self.seen.game.half;
        let is_break = game.state == GameState::Timeout || at_half_time;
        let is_now = match self.seen.rules.substitution {
            SubstitutionProcedure::InTimeouts => is_break,
            SubstitutionProcedure::InStoppages => self.is_stoppage(),
            SubstitutionProcedure::AsPickUp => game.stop.is_none(),
        };
        if !is_now || game.shoot_out.is_some() {
            return;
        }
        for request in core::mem::take(&mut self.memory.substitution_requests) {
            // A substitution that has become impossible meanwhile is dropped.
            if let Ok(indices) = self.check_substitution(request) {
                self.substitute(indices, is_break);
            }
        }
    }

    fn substitute(&mut self, [out, on]: [usize; 2], is_break: bool) {
        let snapshot = self.now();
        let (rules, pitch) = (snapshot.rules, snapshot.pitch);
        let [player, substitute] = [snapshot.robots[out], snapshot.robots[on]];
        let own_end = snapshot.game.own_end(player.id.team);
        let is_keeper = snapshot.game.is_goalkeeper(player.id);
        let waiting = Occupied::by_waiting(&snapshot);
        let beside = waiting_pose(pitch, rules.return_place, own_end, player.pose.position, &player.bounds, &waiting);
        let picked_up = |cycles_left| Penalty(Some(ActivePenalty { reason: PenaltyReason::PickUp, cycles_left }));
        let (pose, penalty) = match (player.is_present(), rules.substitution) {
            (false, _) => (player.pose, player.penalty),
            (true, _) if is_break => {
                let kicks_off = snapshot.game.has_kick_off(player.id.team);
                let number = if is_keeper { RobotId::GOALKEEPER } else { snapshot.game.role_number(substitute.id) };
                let place = formation(pitch, rules.team_size, number, own_end, kicks_off);
                (Occupied::by_others(&snapshot, Some(out)).free_pose(place, &substitute.bounds), Penalty(None))
            }
            // It waits where it stands beside the pitch, if that is not away from there.
            (true, SubstitutionProcedure::AsPickUp) => (beside, picked_up(snapshot.cycles(rules.penalty_s).max(1))),
            (true, _) => (beside, picked_up(1)),
        };
        // The player goes to the position at which the substitute has waited.
        let (robots, records) = (&mut self.decisions.robots, &mut self.memory.robots);
        (robots[out].pose, robots[out].penalty) = (substitute.pose, Penalty::SUBSTITUTE);
        (robots[on].pose, robots[on].penalty) = (pose, penalty);
        if is_keeper {
            let number = substitute.id.number;
            self.decisions.game.goalkeepers[player.id.team] = (!substitute.id.is_goalkeeper()).then_some(number);
        }
        let cautions = [records[out].cautions, records[on].cautions];
        [records[on].cautions, records[out].cautions] = cautions;
        records[out].forgive();
        records[on].forgive();
        records[on].restarts = records[on].restarts.saturating_add(u32::from(penalty.0.is_none()));
        self.decisions.events.push(MatchEvent::Substitution { robot: substitute.id, replaced: player.id });
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::Intervention;
    use crate::geometry::Pose;
    use crate::team::Team;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
    const REPLACE: Intervention = Intervention::Substitute { robot: BLUE2, by: BLUE3 };

    /// A match in play in which blue 3 is a substitute.
    fn with_substitute(substitution: SubstitutionProcedure) -> MatchFixture {
        let mut situation = MatchFixture::three_a_side().robot_at(BLUE3, Pose::new(-2.0, 2.4, 0.0));
        situation.robot_mut(BLUE3).penalty = Penalty::SUBSTITUTE;
        situation.rules.substitution = substitution;
        situation.rules.penalty_s = 1.0;
        situation.rules.kick_off = crate::game::KickOffProcedure::ReadyAndSet;
        situation.rules.penalties_run_in_ready = true;
        situation
    }

    /// Whether blue 2 and blue 3 are on the pitch.
    fn present(situation: &MatchFixture) -> [bool; 2] {
        [1, 2].map(|index| situation.robots[index].is_present())
    }

    #[test]
    fn by_the_rules_of_2025_the_substitute_waits_like_a_robot_that_is_picked_up() {
        let mut situation = with_substitute(SubstitutionProcedure::AsPickUp);
        situation.interventions = vec![REPLACE];
        let decided = situation.pass();
        assert!(decided.events.contains(&MatchEvent::Substitution { robot: BLUE3, replaced: BLUE2 }));
        let waits =
            (0..100).take_while(|_| present(&situation) == [false, false] && situation.pass().events.is_empty());
        // 1 s of 1/30 s.
        assert_eq!(waits.count(), 29);
        assert_eq!(present(&situation), [false, true]);
    }

    #[test]
    fn in_the_humanoid_league_it_enters_in_a_stoppage() {
        let mut situation = with_substitute(SubstitutionProcedure::InStoppages);
        situation.interventions = vec![REPLACE];
        situation.pass();
        assert_eq!(present(&situation), [true, false]);
        situation.interventions = vec![Intervention::KickOff { team: Team::Blue }];
        situation.pass();
        assert_eq!(present(&situation), [false, false]);
        situation.pass();
        assert_eq!(present(&situation), [false, true]);
        // From the side line, where robots return by these rules.
        let place = situation.robots[2].pose.position;
        assert!(place.y.abs() >= situation.pitch.half_width(), "{place}");
    }

    #[test]
    fn in_a_time_out_it_takes_a_place_on_the_pitch() {
        let mut situation = with_substitute(SubstitutionProcedure::InTimeouts);
        situation.interventions = vec![REPLACE, Intervention::KickOff { team: Team::Blue }];
        situation.pass();
        assert_eq!(present(&situation), [true, false]);
        situation.interventions = vec![Intervention::Timeout { team: None, duration_s: Some(1.0) }];
        situation.pass();
        assert_eq!(present(&situation), [false, true]);
        assert!(situation.robots[2].pose.position.y.abs() < situation.pitch.half_width());
        (0..100).for_each(|_| _ = situation.pass());
        assert_eq!(present(&situation), [false, true]);
    }

    #[test]
    fn the_substitute_inherits_penalty_and_cautions() {
        let mut situation = with_substitute(SubstitutionProcedure::AsPickUp);
        let (reason, cycles_left) = (PenaltyReason::Pushing, 50);
        situation.robot_mut(BLUE2).penalty = Penalty(Some(ActivePenalty { reason, cycles_left }));
        situation.memory.match_robots(&situation.robots);
        situation.memory.robots[1].cautions = 1;
        situation.interventions = vec![REPLACE];
        situation.pass();
        let penalty = Penalty(Some(ActivePenalty { reason, cycles_left: cycles_left - 1 }));
        assert_eq!([1, 2].map(|index| situation.robots[index].penalty), [Penalty::SUBSTITUTE, penalty]);
        assert_eq!([1, 2].map(|index| situation.memory.robots[index].cautions), [0, 1]);
    }

    #[test]
    fn who_replaces_the_goalkeeper_is_the_goalkeeper_until_it_is_replaced() {
        let mut situation = with_substitute(SubstitutionProcedure::InTimeouts);
        let blue1 = RobotId::new(Team::Blue, 1);
        let timeout = Intervention::Timeout { team: None, duration_s: Some(1.0) };
        let resume = Intervention::Resume;
        let keepers = |situation: &MatchFixture| [blue1, BLUE2, BLUE3].map(|id| situation.game.is_goalkeeper(id));
        let replace = |situation: &mut MatchFixture, robot, by| {
            situation.interventions = vec![Intervention::Substitute { robot, by }, timeout];
            (0..2).for_each(|_| _ = situation.pass());
        };
        assert_eq!(keepers(&situation), [true, false, false]);
        replace(&mut situation, blue1, BLUE3);
        assert_eq!(keepers(&situation), [false, false, true]);
        // It stands where the goalkeeper does.
        let goal_line = situation.game.own_end(Team::Blue).sign() * situation.pitch.half_length();
        assert!((situation.robots[2].pose.position.x - goal_line).abs() < 0.5, "{}", situation.robots[2].pose.position);
        assert_eq!([blue1, BLUE2, BLUE3].map(|id| situation.game.role_number(id)), [3, 2, 1]);
        situation.interventions = vec![resume];
        situation.pass();
        replace(&mut situation, BLUE2, blue1);
        assert_eq!(keepers(&situation), [false, false, true]);
        situation.interventions = vec![resume];
        situation.pass();
        replace(&mut situation, BLUE3, BLUE2);
        assert_eq!(keepers(&situation), [false, true, false]);
        situation.interventions = vec![resume];
        situation.pass();
        replace(&mut situation, blue1, BLUE3);
        replace(&mut situation, BLUE2, blue1);
        assert_eq!((keepers(&situation), situation.game.goalkeepers[Team::Blue]), ([true, false, false], None));
    }

    #[test]
    fn who_cannot_be_replaced_is_refused() {
        let refused = |robot, by, change: fn(&mut MatchFixture)| {
            let mut situation = with_substitute(SubstitutionProcedure::AsPickUp);
            change(&mut situation);
            situation.interventions = vec![Intervention::Substitute { robot, by }];
            let events = situation.pass().events;
            events.into_iter().find_map(|event| match event {
                MatchEvent::InterventionRefused { message, .. } => Some(message),
                _ => None,
            })
        };
        let [blue1, pink2] = [RobotId::new(Team::Blue, 1), RobotId::new(Team::Pink, 2)];
        let words = |robot, by| refused(robot, by, |_| {}).unwrap_or_default();
        assert_eq!(words(pink2, BLUE3), "blue3 is of the other team");
        assert_eq!(words(BLUE2, blue1), "blue1 is no substitute");
        let sent_off = |situation: &mut MatchFixture| {
            let reason = PenaltyReason::SentOff;
            situation.robot_mut(BLUE2).penalty = Penalty(Some(ActivePenalty { reason, cycles_left: 9 }));
        };
        assert_eq!(refused(BLUE2, BLUE3, sent_off).as_deref(), Some("blue2 is sent off"));
        assert_eq!(refused(BLUE2, BLUE3, |_| {}), None);
        let waits = |situation: &mut MatchFixture| {
            situation.rules.substitution = SubstitutionProcedure::InTimeouts;
            situation.interventions = vec![REPLACE];
            situation.pass();
        };
        assert_eq!(refused(blue1, BLUE3, waits).as_deref(), Some("blue3 is to replace blue2 already"));
        assert_eq!(refused(BLUE2, BLUE3, waits), None);
    }
}
