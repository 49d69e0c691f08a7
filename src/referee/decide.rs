//! The referee's course through a cycle, as a plain function from a [`MatchSnapshot`] to [`Decisions`].

use bevy::prelude::*;

use super::evidence::Evidence;
use super::game::{Game, GameState, half_cycles};
use super::memory::{RefereeMemory, RobotRecord};
use super::penalty::{ActivePenalty, Penalty, PenaltyReason};
use super::placing::{Occupied, line_up};
use super::removal::{return_pose, waiting_pose};
use super::rules::BallOutRestart;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use super::{ball_out, boundary, collision, goal, stalling};
use crate::events::MatchEvent;
use crate::robot::Team;

/// What the referee decided in a cycle.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Decisions {
    /// The state of the match from now on.
    pub game: Game,
    /// What is announced.
    pub events: Vec<MatchEvent>,
    /// Where the ball is put down to rest, m.
    pub ball: Option<Vec2>,
    /// All robots, as in the snapshot but for the poses of those that are put down, and penalties.
    pub robots: Vec<RobotSnapshot>,
}

/// Judges a cycle. `memory` is carried from cycle to cycle; `decisions` is only room to write in.
pub fn decide(snapshot: &MatchSnapshot, memory: &mut RefereeMemory, decisions: &mut Decisions) {
    memory.match_robots(snapshot.robots);
    decisions.game.clone_from(snapshot.game);
    decisions.robots.clear();
    decisions.robots.extend_from_slice(snapshot.robots);
    decisions.events.clear();
    decisions.ball = None;
    let mut referee = Referee { seen: snapshot, memory, decisions };
    if snapshot.game.state == GameState::Playing {
        referee.judge_play();
    }
}

/// The referee at work in one cycle.
struct Referee<'a, 'b> {
    /// What was seen at the end of the cycle.
    seen: &'a MatchSnapshot<'a>,
    memory: &'b mut RefereeMemory,
    decisions: &'b mut Decisions,
}

impl Referee<'_, '_> {
    /// The snapshot with what was decided so far in this cycle.
    fn now(&self) -> MatchSnapshot<'_> {
        MatchSnapshot { game: &self.decisions.game, robots: &self.decisions.robots, ..*self.seen }
    }

    fn judge_play(&mut self) {
        self.count_penalties();
        self.judge_collisions();
        self.judge_robots();
        let kick_off = self.judge_ball();
        if self.run_clock() {
            self.end_half();
        } else if let Some(team) = kick_off {
            self.kick_off(team);
        }
    }

    /// Penalties run, and robots that have served theirs come back.
    fn count_penalties(&mut self) {
        for index in 0..self.decisions.robots.len() {
            let Some(penalty) = &mut self.decisions.robots[index].penalty.0 else { continue };
            penalty.cycles_left = penalty.cycles_left.saturating_sub(1);
            if penalty.cycles_left == 0 {
                self.bring_back(index);
            }
        }
    }

    fn judge_collisions(&mut self) {
        if !self.seen.rules.collisions {
            return;
        }
        for &pair in self.seen.contacts {
            let [first, second] = collision::responsible(self.seen, pair);
            if first {
                self.penalise_push(pair[0], pair[1]);
            }
            if second {
                self.penalise_push(pair[1], pair[0]);
            }
        }
    }

    /// Penalises the robot that is responsible for a collision: for the rest of the half, if its team has pushed
    /// too often.
    fn penalise_push(&mut self, robot: usize, other: usize) {
        if !self.decisions.robots[robot].is_present() {
            return;
        }
        let pushes = self.memory.pushes.of_mut(self.seen.robots[robot].id.team);
        *pushes += 1;
        let for_the_half = self.seen.rules.pushing_limit.is_some_and(|limit| *pushes >= limit);
        let rest_of_half = self.seen.game.cycles_left.filter(|_| for_the_half);
        let cycles = rest_of_half.unwrap_or(self.seen.cycles(self.seen.rules.penalty_s));
        self.penalise(robot, PenaltyReason::Pushing, cycles, collision::evidence(self.seen, robot, other));
    }

    /// The rules about single robots.
    fn judge_robots(&mut self) {
        for index in 0..self.decisions.robots.len() {
            if !self.decisions.robots[index].is_present() || !self.seen.robots[index].is_present() {
                continue;
            }
            if let Some((reason, evidence)) = self.judge_robot(index) {
                self.penalise(index, reason, self.seen.cycles(self.seen.rules.penalty_s), evidence);
            }
        }
    }

    fn judge_robot(&mut self, index: usize) -> Option<(PenaltyReason, Evidence)> {
        let (rules, robot) = (self.seen.rules, &self.seen.robots[index]);
        let record = &mut self.memory.robots[index];
        if rules.stalling {
            record.stall = stalling::advance(record.stall, self.seen, robot);
            if let Some(evidence) = record.stall.and_then(|stall| stalling::judge(&stall, self.seen, robot)) {
                return Some((PenaltyReason::Stalling, evidence));
            }
        }
        None
    }

    /// Goals and outs. Returns the team that kicks off because of one.
    fn judge_ball(&mut self) -> Option<Team> {
        let ball = self.seen.ball.as_ref()?;
        let crossing = boundary::crossing(ball, self.seen.pitch)?;
        if let Some(goal) = goal::judge(self.seen, &crossing) {
            *self.decisions.game.score.of_mut(goal.team) += 1;
            self.decisions.events.push(MatchEvent::Goal {
                team: goal.team,
                scorer: goal.scorer,
                own_goal: goal.is_own_goal(),
                evidence: goal::evidence(self.seen, &goal, &crossing),
            });
            return Some(goal.team.opponent());
        }
        let out = ball_out::judge(self.seen, &crossing)?;
        self.decisions.events.push(MatchEvent::BallOut {
            line: out.line,
            position_m: out.position,
            last_touch: out.last_touch,
            evidence: ball_out::evidence(self.seen, &out),
        });
        match self.seen.rules.ball_out_restart {
            BallOutRestart::KickOff => Some(out.restart_team),
            BallOutRestart::ThrowIn => {
                let occupied = Occupied::by_others(&self.now(), None);
                let place = occupied.free_ball_place(ball_out::throw_in_place(self.seen, &out), ball.radius);
                self.put_ball(place);
                self.decisions.events.push(MatchEvent::ThrowIn { team: out.restart_team, position_m: place });
                None
            }
        }
    }

    /// Counts the cycle. Returns whether the half is over.
    fn run_clock(&mut self) -> bool {
        let Some(cycles_left) = &mut self.decisions.game.cycles_left else { return false };
        *cycles_left = cycles_left.saturating_sub(1);
        *cycles_left == 0
    }

    /// Changes sides for the next half, or ends the match.
    fn end_half(&mut self) {
        let game = &mut self.decisions.game;
        if game.half >= self.seen.rules.halves {
            game.state = GameState::Finished;
            self.decisions.events.push(MatchEvent::FinalWhistle);
            return;
        }
        game.half += 1;
        game.blue_end = game.blue_end.opposite();
        game.cycles_left = Some(half_cycles(self.seen.rules, &self.seen.clock));
        let half = game.half;
        self.memory.pushes = default();
        self.decisions.events.push(MatchEvent::HalfBegins { half });
        self.end_penalties();
        self.kick_off(Game::first_kick_off_of_half(half));
    }

    /// Ball and robots are placed for a kick-off.
    fn kick_off(&mut self, team: Team) {
        if self.seen.rules.penalties_end_at_kick_off {
            self.end_penalties();
        }
        self.decisions.game.kick_off_team = team;
        self.decisions.game.restarts += 1;
        self.put_ball(Vec2::ZERO);
        let poses: Vec<_> = line_up(&self.now(), team).collect();
        for (robot, pose) in self.decisions.robots.iter_mut().zip(poses) {
            robot.pose = pose.unwrap_or(robot.pose);
        }
        self.memory.forget_robots();
        self.decisions.events.push(MatchEvent::KickOff { team });
    }

    fn put_ball(&mut self, place: Vec2) {
        self.decisions.ball = Some(place);
        self.memory.last_touch = None;
    }

    /// Removes a robot from the pitch for so many cycles of play.
    fn penalise(&mut self, index: usize, reason: PenaltyReason, cycles: u64, evidence: Evidence) {
        let snapshot = self.now();
        let RobotSnapshot { id, bounds, pose, .. } = snapshot.robots[index];
        let waiting = Occupied::by_waiting(&snapshot);
        let pose = waiting_pose(&snapshot, snapshot.game.own_end(id.team), pose.position, &bounds, &waiting);
        let until_s = (self.seen.clock.end_time_s() + cycles as f64 * self.seen.clock.period_s) as f32;
        let robot = &mut self.decisions.robots[index];
        robot.pose = pose;
        robot.penalty = Penalty(Some(ActivePenalty { reason, cycles_left: cycles.max(1) }));
        self.memory.robots[index] = RobotRecord::clean(id);
        self.decisions.events.push(MatchEvent::Penalty { robot: id, reason, until_s, evidence });
    }

    /// Lets a penalised robot come back.
    fn bring_back(&mut self, index: usize) {
        let snapshot = self.now();
        let RobotSnapshot { id, bounds, pose, .. } = snapshot.robots[index];
        let occupied = Occupied::by_others(&snapshot, Some(index));
        let pose = return_pose(&snapshot, snapshot.game.own_end(id.team), pose, &bounds, &occupied);
        let robot = &mut self.decisions.robots[index];
        robot.pose = pose;
        robot.penalty = Penalty(None);
        self.decisions.events.push(MatchEvent::PenaltyOver { robot: id, position_m: pose.position });
    }

    /// All penalties are over; the robots are about to be placed.
    fn end_penalties(&mut self) {
        for index in 0..self.decisions.robots.len() {
            let robot = &mut self.decisions.robots[index];
            if robot.penalty.is_active() {
                robot.penalty = Penalty(None);
                let (robot, position_m) = (robot.id, robot.pose.position);
                self.decisions.events.push(MatchEvent::PenaltyOver { robot, position_m });
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::rules::Rules;
    use super::super::testing::Situation;
    use super::*;
    use crate::events::BoundaryLine;
    use crate::geometry::Pose;
    use crate::robot::RobotId;
    use approx::assert_abs_diff_eq;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    #[test]
    fn a_goal_counts_and_the_other_team_kicks_off() {
        let decided = Situation::three_a_side().touched_by(BLUE2).ball_rolled([2.9, 0.2], [3.2, 0.2]).decide();
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
        let own = Situation::three_a_side().touched_by(PINK2).ball_rolled([2.9, 0.2], [3.2, 0.2]).decide();
        assert!(matches!(own.events[0], MatchEvent::Goal { team: Team::Blue, own_goal: true, .. }));
        let mut second_half = Situation::three_a_side().touched_by(PINK2).ball_rolled([2.9, 0.2], [3.2, 0.2]);
        second_half.game.blue_end = second_half.game.blue_end.opposite();
        assert_eq!(second_half.decide().game.score.pink, 1);
    }

    #[test]
    fn no_goal_and_no_out_before_the_whole_ball_is_past_the_line() {
        assert!(Situation::three_a_side().ball_rolled([2.9, 0.2], [3.054, 0.2]).decide().events.is_empty());
        assert!(Situation::three_a_side().ball_rolled([2.0, 1.9], [2.1, 2.054]).decide().events.is_empty());
    }

    #[test]
    fn after_an_out_the_team_that_did_not_touch_the_ball_kicks_off() {
        let decided = Situation::three_a_side().touched_by(BLUE2).ball_rolled([1.0, 1.9], [1.0, 2.1]).decide();
        assert!(matches!(decided.events[0], MatchEvent::BallOut { line: BoundaryLine::Side, .. }));
        assert_eq!(decided.events[1], MatchEvent::KickOff { team: Team::Pink });
        // Nobody touched it: the team in whose half it went out.
        let unknown = Situation::three_a_side().ball_rolled([-1.0, 1.9], [-1.0, 2.1]).decide();
        assert_eq!(unknown.events[1], MatchEvent::KickOff { team: Team::Blue });
    }

    /// Where the ball is thrown in when blue's number 2, at x = `robot_x`, touched it last.
    fn thrown_in(robot_x: f32, from: [f32; 2], to: [f32; 2]) -> Vec2 {
        let mut situation = Situation::three_a_side().touched_by(BLUE2).ball_rolled(from, to);
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
    fn the_thrown_in_ball_does_not_land_in_a_robot() {
        let mut situation = Situation::three_a_side().touched_by(BLUE2).ball_rolled([1.0, 1.9], [1.0, 2.1]);
        situation.rules.ball_out_restart = BallOutRestart::ThrowIn;
        situation.robots[1].pose = Pose::new(-0.2, 1.6, 0.0);
        situation.memory.last_touch.as_mut().unwrap().robot_position.x = 1.0;
        let place = situation.decide().ball.unwrap();
        assert!(place.distance(Vec2::new(0.0, 1.6)) < 0.5);
        let base = situation.robots[1].bounds.base.footprint(situation.robots[1].pose);
        assert!(base.signed_distance(place).0 > 0.03);
    }

    #[test]
    fn sides_change_at_half_time_and_the_match_ends_after_the_last_half() {
        let mut situation = Situation::three_a_side();
        situation.game.cycles_left = Some(1);
        let decided = situation.decide();
        assert_eq!(decided.events, [MatchEvent::HalfBegins { half: 2 }, MatchEvent::KickOff { team: Team::Pink }]);
        // 600 s of 1/30 s.
        assert_eq!(decided.game.cycles_left, Some(18_000));
        assert_eq!(decided.game.own_end(Team::Blue), crate::pitch::End::PositiveX);
        // Blue's keeper is now at +x.
        assert!(decided.robots[0].pose.position.x > 2.0);
        situation.game = decided.game;
        situation.game.cycles_left = Some(1);
        let decided = situation.decide();
        assert_eq!(
            (decided.events.as_slice(), decided.game.state),
            (&[MatchEvent::FinalWhistle][..], GameState::Finished)
        );
        situation.game = decided.game;
        assert_eq!(situation.touched_by(BLUE2).ball_rolled([2.9, 0.0], [3.2, 0.0]).decide().events, []);
    }

    #[test]
    fn a_goal_in_the_last_cycle_counts() {
        let mut situation = Situation::three_a_side().touched_by(PINK2).ball_rolled([-2.9, 0.0], [-3.2, 0.0]);
        situation.game.half = 2;
        situation.game.cycles_left = Some(1);
        let decided = situation.decide();
        assert_eq!((decided.game.score.pink, decided.game.state), (1, GameState::Finished));
        assert_eq!(decided.ball, None);
    }

    #[test]
    fn without_a_referee_nothing_is_repositioned() {
        let mut situation = Situation::three_a_side().ball_rolled([2.9, 0.0], [3.2, 0.0]);
        situation.rules = Rules { goals: false, ball_out: false, clock: false, ..Rules::default() };
        situation.game = Game::at_start(&situation.rules, &situation.clock);
        assert_eq!((situation.game.state, situation.game.cycles_left), (GameState::Playing, None));
        let decided = situation.decide();
        assert_eq!((decided.events.len(), decided.ball, &decided.robots), (0, None, &situation.robots));
    }
}
