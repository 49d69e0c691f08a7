//! Forbidden motion: robots that begin to walk in `set` or `standby` (2025 rule book, section 4.5). Robots that walked before have
//! a moment to stop. Heads may move, and fallen robots may get up.

use bevy::prelude::*;

use super::decide::Referee;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use crate::game::{BriefStop, Evidence, GameState, PenaltyReason};
use crate::robot::posture::Posture;

/// The time of standing after which a walking robot counts as beginning to walk, s.
const STOOD_S: f32 = 0.3;
/// The time after which a robot that still walks is not just finishing a step, s.
const FINISHED_S: f32 = 2.0;

/// Whether the robot moves although it may not: it walks or turns, or gets up in a brief stop.
fn walks(robot: &RobotSnapshot, in_stop: bool) -> bool {
    let gets_up = in_stop && matches!(robot.posture, Posture::GettingUp { .. });
    gets_up
        || robot.posture.is_upright()
            && (robot.wanted_velocity != Vec2::ZERO || robot.pose.heading != robot.previous.heading)
}

/// The number of cycles for which the robot has stood in `set`, `standby` or a brief stop, including this one.
pub fn advance(cycles: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> u64 {
    if walks(robot, snapshot.game.stop.is_some()) { 0 } else { cycles + 1 }
}

/// The evidence against a robot that walks after it has `stood` for a number of cycles.
pub fn judge(stood: u64, snapshot: &MatchSnapshot, robot: &RobotSnapshot) -> Option<Evidence> {
    let stop = snapshot.game.stop;
    let since = stop.map_or(snapshot.game.state_cycles, |stop| stop.cycles);
    // A robot that was getting up when the stop began cannot break off.
    let goes_on_getting_up = matches!(robot.posture, Posture::GettingUp { .. });
    let (what, cycles, limit_s) = if stood >= snapshot.cycles(STOOD_S) {
        ("s of standing before", stood, STOOD_S)
    } else if since > snapshot.cycles(FINISHED_S) && !goes_on_getting_up {
        ("s of walking on", since, FINISHED_S)
    } else {
        return None;
    };
    walks(robot, stop.is_some()).then(|| {
        let rule = match snapshot.game.state {
            _ if stop.is_some() => "In a brief stop no robot may move, unless it is getting up already.",
            GameState::Standby => "In `standby` nobody may walk before the referee raises its arms.",
            _ => "In `set` nobody may walk before the whistle.",
        };
        snapshot
            .evidence_against(rule, robot)
            .with_measurement(what, snapshot.seconds(cycles), limit_s)
            .otherwise("It had to stand, and to wait.")
    })
}

impl Referee<'_, '_> {
    /// Penalises robots that begin to walk, in place; in `standby` their whole team, until the robots know of `ready`.
    pub(super) fn judge_motion(&mut self) {
        let (rules, in_stop) = (self.seen.rules, self.seen.game.stop.is_some());
        let seconds = if in_stop { rules.motion_in_stop.then_some(rules.penalty_s) } else { rules.motion_in_set_s };
        let Some(seconds) = seconds.filter(|_| self.seen.game.shoot_out.is_none()) else { return };
        for (index, robot) in self.seen.robots.iter().enumerate() {
            let stood = self.memory.robots[index].cycles_standing;
            self.memory.robots[index].cycles_standing = advance(stood, self.seen, robot);
            if !self.decisions.robots[index].is_present() {
                continue;
            }
            let Some(evidence) = judge(stood, self.seen, robot) else { continue };
            if in_stop {
                self.penalise(index, PenaltyReason::MotionInStop, evidence);
                continue;
            }
            if self.seen.game.state == GameState::Set {
                let cycles = self.lengthened_cycles(seconds, robot.id.team, false);
                self.remove(index, PenaltyReason::MotionInSet, cycles, evidence);
                continue;
            }
            let cycles = self.seen.cycles(self.seen.rules.ready_delay_s);
            for other in 0..self.seen.robots.len() {
                if self.seen.robots[other].id.team == robot.id.team && self.decisions.robots[other].is_present() {
                    self.remove(other, PenaltyReason::MotionInStandby, cycles, evidence.clone());
                }
            }
        }
    }

    /// Stops the match briefly, for `duration_cycles` or until somebody continues it.
    pub(super) fn stop(&mut self, duration_cycles: Option<u64>) {
        let ball_m = self.seen.ball.map(|ball| self.decisions.ball.unwrap_or(ball.position));
        self.decisions.game.stop = Some(BriefStop { ball_m, cycles: 0, duration_cycles });
        for record in &mut self.memory.robots {
            record.cycles_standing = 0;
        }
    }

    /// Continues the match after a brief stop, with the ball at its position before the stop.
    pub(super) fn resume(&mut self, stop: BriefStop) {
        if let Some(ball_m) = stop.ball_m {
            let last_touch = self.memory.last_touch;
            self.put_ball(ball_m);
            self.memory.last_touch = last_touch;
        }
    }

    /// Ends the penalties for motion in `standby`.
    pub(super) fn forgive_standby(&mut self) {
        for index in 0..self.decisions.robots.len() {
            let penalty = self.decisions.robots[index].penalty.0;
            if penalty.is_some_and(|penalty| penalty.reason == PenaltyReason::MotionInStandby) {
                self.bring_back(index);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::game::Intervention;
    use crate::robot::posture::LyingOn;
    use crate::team::{RobotId, Team};

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

    /// A match in `state`, with rules that penalise robots that walk in `set`.
    fn in_state(state: GameState) -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.motion_in_set_s = Some(15.0);
        situation.rules.ready_delay_s = 45.0;
        situation.memory.standby_cycles = 1000;
        situation.game.state = state;
        situation
    }

    /// The penalised robots after the robot has stood for `stands` cycles and then walked for `walks` cycles.
    fn penalised(situation: &mut MatchFixture, stands: usize, walks: usize) -> Vec<String> {
        for cycle in 0..stands + walks {
            situation.robot_mut(BLUE2).wanted_velocity = Vec2::new(if cycle < stands { 0.0 } else { 0.1 }, 0.0);
            situation.pass();
        }
        let away = situation.robots.iter().filter(|robot| robot.penalty.is_active());
        away.map(|robot| robot.id.to_string()).collect()
    }

    #[test]
    fn who_begins_to_walk_in_set_is_penalised_and_who_finishes_its_steps_is_not() {
        assert_eq!(penalised(&mut in_state(GameState::Set), 0, 61), [""; 0]);
        assert_eq!(penalised(&mut in_state(GameState::Set), 8, 1), [""; 0]);
        assert_eq!(penalised(&mut in_state(GameState::Set), 9, 1), ["blue2"]);
        assert_eq!(penalised(&mut in_state(GameState::Set), 0, 62), ["blue2"]);
    }

    #[test]
    fn it_stays_where_it_is_until_it_may_go_on() {
        let mut situation = in_state(GameState::Set);
        let before = situation.robots[1].pose;
        penalised(&mut situation, 9, 1);
        assert_eq!((situation.robots[1].pose, situation.robots[1].penalty.is_off_pitch()), (before, false));
        situation.game.state = GameState::Playing;
        for _ in 0..450 {
            assert!(situation.robots[1].penalty.is_active());
            situation.pass();
        }
        assert_eq!((situation.robots[1].pose, situation.robots[1].penalty.is_active()), (before, false));
        // The penalty does not make later penalties longer.
        assert_eq!(situation.memory.infractions[Team::Blue], 0);
    }

    #[test]
    fn in_standby_it_is_the_whole_team_until_set() {
        let mut situation = in_state(GameState::Standby);
        assert_eq!(penalised(&mut situation, 9, 1), ["blue1", "blue2", "blue3"]);
        situation.robot_mut(BLUE2).wanted_velocity = Vec2::ZERO;
        situation.game.state = GameState::Ready;
        situation.game.state_cycles = 44 * 30;
        situation.rules.penalties_run_in_ready = true;
        assert!(situation.pass().robots[1].penalty.is_active());
        situation.game.state_cycles = 45 * 30;
        assert!(!situation.pass().robots[1].penalty.is_active());
        assert_eq!(situation.game.state, GameState::Set);
    }

    #[test]
    fn in_a_brief_stop_it_may_not_begin_to_get_up_but_go_on_with_it() {
        let after = |lies: usize| {
            let mut situation = in_state(GameState::Playing);
            situation.rules.motion_in_stop = true;
            let (on, ball_m) = (LyingOn::Front, None);
            situation.game.stop = Some(BriefStop { ball_m, cycles: 0, duration_cycles: None });
            for cycle in 0..100 {
                situation.robot_mut(BLUE2).posture = match cycle {
                    cycle if cycle < lies => Posture::Fallen { on, cycles: 50 },
                    _ => Posture::GettingUp { on, cycles: 50, cycles_left: 50 },
                };
                situation.pass();
            }
            situation.robots[1].penalty.is_active()
        };
        assert_eq!([0, 8, 20].map(after), [false, false, true]);
    }

    #[test]
    fn a_ball_that_is_placed_in_a_brief_stop_stays_there() {
        let mut situation = in_state(GameState::Playing);
        situation.game.stop = Some(BriefStop { ball_m: Some(Vec2::ZERO), cycles: 0, duration_cycles: None });
        let place = Vec2::new(1.0, 0.5);
        situation.interventions = vec![Intervention::PlaceBall { position_m: place, velocity_mps: Vec2::ZERO }];
        assert_eq!(situation.pass().ball, Some(place));
        situation.interventions = vec![Intervention::Resume];
        let decided = situation.pass();
        assert!(decided.game.stop.is_none() && decided.ball.is_none_or(|ball| ball == place), "{:?}", decided.ball);
    }

    #[test]
    fn where_the_rules_forbid_nothing_nothing_is_judged() {
        let mut situation = in_state(GameState::Set);
        situation.rules.motion_in_set_s = None;
        assert_eq!(penalised(&mut situation, 9, 10), [""; 0]);
    }
}
