//! Decisions after the ball has crossed a line: goals and outs.

use super::decide::{Referee, Stoppage};
use super::set_play;
use super::{ball_out, boundary, goal, indirect_goal, kick_off_shot};
use crate::events::{DisallowedGoal, MatchEvent};
use crate::game::{BallOutRestart, SetPlayKind};
use crate::team::Team;

impl Referee<'_, '_> {
    /// Returns whether the ball goes into a goal or out in this cycle, which comes before offences away from it.
    pub(super) fn ball_leaves_play(&self) -> bool {
        let crossing = self.seen.ball.as_ref().and_then(|ball| boundary::crossing(ball, self.seen.pitch));
        crossing.is_some_and(|crossing| {
            goal::judge(self.seen, None, &crossing).is_some() || ball_out::judge(self.seen, &crossing).is_some()
        })
    }

    /// Judges goals and outs, unless the ball has just been placed.
    pub(super) fn judge_ball(&mut self) -> Option<Stoppage> {
        let ball = self.seen.ball.as_ref().filter(|_| self.decisions.ball.is_none())?;
        let crossing = boundary::crossing(ball, self.seen.pitch)?;
        if let Some(goal) = goal::judge(self.seen, self.memory.plays.shot, &crossing) {
            return self.award_goal(&goal, &crossing);
        }
        let out = ball_out::judge(self.seen, &crossing)?;
        self.decisions.events.push(MatchEvent::BallOut {
            line: out.line,
            position_m: out.position,
            last_touch: out.last_touch,
            evidence: ball_out::evidence(self.seen, &out),
        });
        match self.seen.rules.ball_out_restart {
            BallOutRestart::KickOff => Some(Stoppage::KickOff(Some(out.restart_team))),
            BallOutRestart::ThrowIn => {
                let place = self.put_ball(ball_out::throw_in_place(self.seen, &out));
                self.decisions.events.push(MatchEvent::ThrowIn { team: out.restart_team, position_m: place });
                None
            }
            BallOutRestart::FreeKick => {
                let (kind, place) = set_play::for_ball_out(self.seen, &out);
                self.begin_free_kick(kind, out.restart_team, place);
                None
            }
        }
    }

    /// Awards a goal, unless it is disallowed.
    fn award_goal(&mut self, goal: &goal::ScoredGoal, crossing: &boundary::Crossing) -> Option<Stoppage> {
        let opponent = goal.team.opponent();
        if let Some(evidence) = kick_off_shot::judge(self.seen, self.memory.kick_off.as_ref(), goal.team, crossing) {
            let reason = DisallowedGoal::KickOffShot;
            self.decisions.events.push(MatchEvent::GoalDisallowed { team: goal.team, reason, evidence });
            return Some(Stoppage::KickOff(Some(opponent)));
        }
        if let Some(evidence) = indirect_goal::judge_own(self.seen, &self.memory.plays, goal.team, crossing) {
            let reason = DisallowedGoal::OwnSetPlay;
            self.decisions.events.push(MatchEvent::GoalDisallowed { team: goal.team, reason, evidence });
            let place = set_play::corner(self.seen, self.seen.game.own_end(opponent), crossing.position.y);
            self.begin_free_kick(SetPlayKind::CornerKick, goal.team, place);
            return None;
        }
        let (plays, kick_off) = (&self.memory.plays, self.memory.kick_off.as_ref());
        if let Some(evidence) = indirect_goal::judge(self.seen, plays, kick_off, goal.team, crossing) {
            let reason = DisallowedGoal::NotIndirect;
            self.decisions.events.push(MatchEvent::GoalDisallowed { team: goal.team, reason, evidence });
            let place = set_play::goal_kick_place(self.seen, opponent, crossing.position.y);
            self.begin_free_kick(SetPlayKind::GoalKick, opponent, place);
            return None;
        }
        if self.decisions.game.goals_void[goal.team] {
            let (reason, evidence) = (DisallowedGoal::TooManyMessages, goal::evidence(self.seen, goal, crossing));
            self.decisions.events.push(MatchEvent::GoalDisallowed { team: goal.team, reason, evidence });
            return Some(Stoppage::KickOff(Some(opponent)));
        }
        self.decisions.events.push(MatchEvent::Goal {
            team: goal.team,
            scorer: goal.scorer,
            own_goal: goal.is_own_goal(),
            evidence: goal::evidence(self.seen, goal, crossing),
        });
        Some(self.count_goal(goal.team))
    }

    /// Counts a goal of `team`. Returns how play continues.
    pub(super) fn count_goal(&mut self, team: Team) -> Stoppage {
        let score = &mut self.decisions.game.score;
        score[team] = score[team].saturating_add(1);
        let decided = self.seen.rules.mercy_goals.is_some_and(|most| score.blue.abs_diff(score.pink) >= most);
        if decided { Stoppage::Mercy } else { Stoppage::KickOff(Some(team.opponent())) }
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::events::BoundaryLine;
    use crate::geometry::Pose;
    use crate::robot::posture::{LyingOn, Posture};
    use crate::team::RobotId;
    use approx::assert_abs_diff_eq;
    use bevy::prelude::*;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const PINK1: RobotId = RobotId::new(Team::Pink, 1);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    #[test]
    fn a_goal_counts_and_the_other_team_kicks_off() {
        let decided = MatchFixture::three_a_side().touched_by(BLUE2).ball_rolled([2.9, 0.2], [3.2, 0.2]).decide();
        assert_eq!(decided.game.score.blue, 1);
        assert!(matches!(
            decided.events[..],
            [
                MatchEvent::Goal { team: Team::Blue, scorer: Some(BLUE2), own_goal: false, .. },
                MatchEvent::KickOff { team: Team::Pink },
            ]
        ));
        assert_eq!((decided.ball, decided.game.restarts), (Some(Vec2::ZERO), 1));
    }

    #[test]
    fn an_own_goal_counts_for_the_other_team_and_after_the_change_of_sides_the_goals_are_the_other_ones() {
        let own = MatchFixture::three_a_side().touched_by(PINK2).ball_rolled([2.9, 0.2], [3.2, 0.2]).decide();
        assert!(matches!(own.events[0], MatchEvent::Goal { team: Team::Blue, own_goal: true, .. }));
        let mut second_half = MatchFixture::three_a_side().touched_by(PINK2).ball_rolled([2.9, 0.2], [3.2, 0.2]);
        second_half.game.blue_end = second_half.game.blue_end.opposite();
        assert_eq!(second_half.decide().game.score.pink, 1);
    }

    #[test]
    fn a_kick_that_an_opponent_deflects_into_its_goal_is_the_kickers_goal() {
        for (kicker, scorer, is_own) in [(BLUE2, BLUE2, false), (PINK1, PINK2, true)] {
            let mut shot = MatchFixture::three_a_side().touched_by(PINK2).ball_rolled([2.9, 0.2], [3.2, 0.2]);
            shot.memory.plays.shot = Some(kicker);
            let events = shot.decide().events;
            assert!(
                matches!(&events[0], MatchEvent::Goal { team: Team::Blue, scorer: Some(by), own_goal, .. }
                    if *by == scorer && *own_goal == is_own),
                "{events:?}"
            );
        }
    }

    #[test]
    fn no_goal_and_no_out_before_the_whole_ball_is_past_the_line() {
        assert!(MatchFixture::three_a_side().ball_rolled([2.9, 0.2], [3.054, 0.2]).decide().events.is_empty());
        assert!(MatchFixture::three_a_side().ball_rolled([2.0, 1.9], [2.1, 2.054]).decide().events.is_empty());
    }

    #[test]
    fn after_an_out_the_team_that_did_not_touch_the_ball_kicks_off() {
        let decided = MatchFixture::three_a_side().touched_by(BLUE2).ball_rolled([1.0, 1.9], [1.0, 2.1]).decide();
        assert!(matches!(decided.events[0], MatchEvent::BallOut { line: BoundaryLine::Side, .. }));
        assert_eq!(decided.events[1], MatchEvent::KickOff { team: Team::Pink });
        // No robot touched the ball: the team in whose half it went out counts.
        let unknown = MatchFixture::three_a_side().ball_rolled([-1.0, 1.9], [-1.0, 2.1]).decide();
        assert_eq!(unknown.events[1], MatchEvent::KickOff { team: Team::Blue });
    }

    /// The position of the throw-in if blue's number 2, at x = `robot_x`, touched the ball last.
    fn thrown_in(robot_x: f32, from: [f32; 2], to: [f32; 2]) -> Vec2 {
        let mut situation = MatchFixture::three_a_side().touched_by(BLUE2).ball_rolled(from, to);
        situation.rules.ball_out_restart = BallOutRestart::ThrowIn;
        situation.memory.last_touch.as_mut().unwrap().robot_position.x = robot_x;
        let decided = situation.decide();
        assert_eq!((&decided.robots, decided.game.restarts), (&situation.robots, 0));
        decided.ball.unwrap()
    }

    #[test]
    fn over_the_side_line_the_ball_is_thrown_in_a_metre_back_from_the_out_or_the_robot() {
        // Back is -x for blue. Out at x = 1: 1 - 1 = 0; robot at 0.5: 0.5 - 1 = -0.5 is farther back.
        assert_abs_diff_eq!(thrown_in(0.9, [1.0, 1.9], [1.0, 2.1]), Vec2::new(-0.1, 1.6), epsilon = 1e-5);
        assert_abs_diff_eq!(thrown_in(1.5, [1.0, -1.9], [1.0, -2.1]), Vec2::new(0.0, -1.6), epsilon = 1e-5);
        // Not beyond the end of the throw-in line, 2 m from the halfway line.
        assert_abs_diff_eq!(thrown_in(-2.0, [-1.5, 1.9], [-1.5, 2.1]), Vec2::new(-2.0, 1.6), epsilon = 1e-5);
    }

    #[test]
    fn over_the_goal_lines_the_ball_is_thrown_in_at_the_end_of_the_line_or_at_the_halfway_line() {
        assert_abs_diff_eq!(thrown_in(-2.5, [-2.9, 1.0], [-3.1, 1.0]), Vec2::new(-2.0, 1.6), epsilon = 1e-5);
        assert_abs_diff_eq!(thrown_in(2.0, [2.9, -1.0], [3.1, -1.0]), Vec2::new(0.0, -1.6), epsilon = 1e-5);
        assert_abs_diff_eq!(thrown_in(0.4, [2.9, 1.0], [3.1, 1.0]), Vec2::new(-0.6, 1.6), epsilon = 1e-5);
    }

    #[test]
    fn a_robot_makes_way_for_the_thrown_in_ball_and_stays_as_it_is() {
        let mut situation = MatchFixture::three_a_side().touched_by(BLUE2).ball_rolled([1.0, 1.9], [1.0, 2.1]);
        situation.rules.ball_out_restart = BallOutRestart::ThrowIn;
        situation.robots[1].pose = Pose::new(-0.05, 1.6, 0.0);
        situation.memory.last_touch.as_mut().unwrap().robot_position.x = 1.0;
        situation.robots[1].posture = Posture::Fallen { cycles: 1, on: LyingOn::Front };
        let decided = situation.decide();
        assert_abs_diff_eq!(decided.ball.unwrap(), Vec2::new(0.0, 1.6), epsilon = 1e-5);
        let robot = decided.robots[1];
        assert!(robot.bounds.base.footprint(robot.pose).signed_distance(decided.ball.unwrap()).0 > 0.03);
        assert!(robot.pose.position.distance(situation.robots[1].pose.position) < 0.5);
        assert_eq!((decided.moved_aside, robot.posture), (vec![BLUE2], situation.robots[1].posture));
    }
}
