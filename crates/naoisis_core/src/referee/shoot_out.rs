//! The penalty shoot-out that decides a drawn match (2010 rule book, sections 3.7 and 3.8; 2025 rule book, section 3.19):
//! alternate shots from the penalty mark, one attacker against one keeper, all at the goal at -x; then sudden death.

use core::f32::consts::PI;

use bevy::prelude::*;

use super::areas::{penalty_mark, touches_goal_line};
use super::boundary::{Boundary, crossing};
use super::decide::Referee;
use super::placing::Occupied;
use super::removal::waiting_pose;
use super::set_play::MOVED_CLEARLY_M;
use super::snapshot::{BallSnapshot, MatchSnapshot, RobotSnapshot};
use crate::events::MatchEvent;
use crate::game::{
    ActivePenalty, Evidence, Game, GameState, Penalty, PenaltyReason, ShootOut, ShootOutProcedure, Shot, ShotRank,
    Standing,
};
use crate::geometry::Pose;
use crate::pitch::{End, Pitch};
use crate::team::{RobotId, Team};

/// The end of the goal for all shots.
const GOAL: End = End::NegativeX;
/// Distance behind the ball at which an attacker begins if the penalty area does not reach beyond the ball, m.
const BEHIND_BALL_M: f32 = 0.35;
/// Speed below which the ball has stopped, m/s.
const STOPPED_MPS: f32 = 0.05;
/// Greatest distance from a post's surface at which a turn of the ball counts as hitting the post, m.
const AT_POST_M: f32 = 0.01;

/// The result of a shot after a cycle: scored or failed, and why; `None` while it continues.
fn judge_shot(snapshot: &MatchSnapshot, shoot_out: &ShootOut) -> Option<(bool, Evidence)> {
    let ball = snapshot.ball.as_ref()?;
    let case = |scored: bool, rule: &'static str| Some((scored, snapshot.evidence(rule, ball.position)));
    let fault = match snapshot.rules.shoot_out_procedure {
        ShootOutProcedure::Spl2010 => fault_of_2010(snapshot, shoot_out, ball),
        ShootOutProcedure::Spl2025 => fault_of_2025(snapshot, shoot_out, ball),
    };
    if let Some((scored, rule)) = fault {
        return case(scored, rule);
    }
    if let Some(crossing) = crossing(ball, snapshot.pitch) {
        return match crossing.boundary {
            Boundary::Goal(GOAL) => case(true, "The shot scores when the ball is in the goal in time."),
            _ => case(false, "The shot is over when the ball leaves the pitch."),
        };
    }
    if shoot_out.shot.cycles >= snapshot.cycles(shoot_out.shot_s(snapshot.rules)) {
        return case(false, "The shot is over when its time is.");
    }
    let over_at_rest = snapshot.rules.shoot_out_procedure == ShootOutProcedure::Spl2025
        && shoot_out.shot.rank > ShotRank::NoKick
        && snapshot.touches.is_empty()
        && ball.velocity.length() < STOPPED_MPS;
    if over_at_rest {
        return case(false, "The shot is over when the ball has come to a stop after the attacker has played it.");
    }
    None
}

/// A foul of the attacker or the goalkeeper: whether the shot counts as scored, and the rule.
fn fault_of_2010(snapshot: &MatchSnapshot, shoot_out: &ShootOut, ball: &BallSnapshot) -> Option<(bool, &'static str)> {
    snapshot.touches.iter().find_map(|(robot, _)| {
        let shoots = robot.team == shoot_out.team;
        if !shoots && is_outside_area(snapshot, ball.position, ball.radius) {
            return Some((true, "The keeper may not touch a ball that is wholly outside the penalty area."));
        }
        let start = ball.path.first().copied().unwrap_or(ball.position);
        (shoots && is_inside_area(snapshot, start, ball.radius))
            .then_some((false, "The attacker may not touch a ball that is wholly inside the penalty area."))
    })
}

/// A foul by the rules of 2025.
fn fault_of_2025(snapshot: &MatchSnapshot, shoot_out: &ShootOut, ball: &BallSnapshot) -> Option<(bool, &'static str)> {
    let start = ball.path.first().copied().unwrap_or(ball.position);
    let plays = snapshot.touches.iter().any(|(robot, _)| robot.team == shoot_out.team);
    if plays && start.distance(penalty_mark(snapshot.pitch, GOAL)) > MOVED_CLEARLY_M {
        return Some((false, "The attacker may not play the ball a second time after it has moved clearly."));
    }
    let keeper = snapshot.robots.iter().find(|robot| robot.is_present() && robot.id.team != shoot_out.team)?;
    (shoot_out.shot.rank == ShotRank::NoKick
        && !(keeper.posture.is_upright() && touches_goal_line(snapshot.pitch, GOAL, keeper)))
    .then_some((
        true,
        "Until the attacker has touched the ball, the keeper stays on its feet and in contact with the goal line.",
    ))
}

/// The rank of a shot so far, including this cycle.
fn rank(snapshot: &MatchSnapshot, shoot_out: &ShootOut) -> ShotRank {
    let before = shoot_out.shot.rank;
    let Some(ball) = &snapshot.ball else { return before };
    let touched =
        |by_attacker: bool| snapshot.touches.iter().any(|(robot, _)| (robot.team == shoot_out.team) == by_attacker);
    if before == ShotRank::NoKick && !touched(true) {
        return before;
    }
    let turns = ball.path.get(1..ball.path.len().saturating_sub(1)).unwrap_or(&[]);
    let hits = |turn: &Vec2| {
        snapshot.posts.iter().any(|post| post.centre.distance(*turn) <= post.radius + ball.radius + AT_POST_M)
    };
    let beside = crossing(ball, snapshot.pitch).is_some_and(|crossing| crossing.boundary == Boundary::GoalLine(GOAL));
    let now = if touched(false) {
        ShotRank::Blocked
    } else if turns.iter().any(hits) {
        ShotRank::Post
    } else if beside {
        ShotRank::BesideGoal
    } else {
        ShotRank::Kick
    };
    before.max(now)
}

fn is_inside_area(snapshot: &MatchSnapshot, ball: Vec2, radius: f32) -> bool {
    let (depth, across) = place_in_area(snapshot, ball);
    depth >= radius && across >= radius
}

fn is_outside_area(snapshot: &MatchSnapshot, ball: Vec2, radius: f32) -> bool {
    let (depth, across) = place_in_area(snapshot, ball);
    depth <= -radius || across <= -radius
}

/// The distances of a point inside the penalty area, including its lines, from its front and from its nearer side, m.
fn place_in_area(snapshot: &MatchSnapshot, place: Vec2) -> (f32, f32) {
    let (pitch, area) = (snapshot.pitch, snapshot.pitch.penalty_area);
    let half_line = pitch.line_width_m / 2.0;
    let front = pitch.half_length() - area.depth_m - half_line;
    (GOAL.sign() * place.x - front, area.width_m / 2.0 + half_line - place.y.abs())
}

/// The poses for a shot, team frame: the shooter behind the ball, or in 2010 at the centre, and the goalkeeper on its goal line.
pub fn places_for_shot(pitch: &Pitch, procedure: ShootOutProcedure, shoots: bool) -> (Pose, Vec2) {
    if !shoots {
        return (Pose::new(-pitch.half_length(), 0.0, 0.0), penalty_mark(pitch, End::NegativeX));
    }
    let x = match procedure {
        ShootOutProcedure::Spl2010 => 0.0,
        ShootOutProcedure::Spl2025 => {
            let from_goal = pitch.penalty_area.depth_m.max(pitch.penalty_mark_distance_m + BEHIND_BALL_M);
            pitch.half_length() - from_goal
        }
    };
    (Pose::new(x, 0.0, 0.0), penalty_mark(pitch, End::PositiveX))
}

impl Referee<'_, '_> {
    /// Begins a shoot-out after a drawn match.
    pub(super) fn begin_shoot_out(&mut self) {
        self.end_penalties();
        self.decisions.game.stop = None;
        self.decisions.game.shoot_out = Some(ShootOut { team: self.seen.rules.first_kick_off, ..default() });
        self.decisions.events.push(MatchEvent::ShootOutBegins);
        self.prepare_shot();
    }

    /// Places the ball on the penalty mark, the attacker behind it, the goalkeeper on its goal line, and all others beside the
    /// pitch.
    fn prepare_shot(&mut self) {
        let Some(shoot_out) = &mut self.decisions.game.shoot_out else { return };
        shoot_out.shot = Shot::default();
        let team = shoot_out.team;
        let game = &mut self.decisions.game;
        game.kick_off_team = team;
        game.drop_ball = false;
        game.set_play = None;
        game.blue_end = if team == Team::Blue { GOAL.opposite() } else { GOAL };
        let attacker = self.first_of(team, |game, id| !game.is_goalkeeper(id));
        let keeper = self.first_of(team.opponent(), Game::is_goalkeeper);
        let pitch = self.seen.pitch;
        let (behind_ball, _) = places_for_shot(pitch, self.seen.rules.shoot_out_procedure, true);
        let attacker_x = GOAL.sign() * behind_ball.position.x;
        let poses = [Pose::new(attacker_x, 0.0, PI), Pose::new(GOAL.sign() * pitch.half_length(), 0.0, 0.0)];
        for robot in self.decisions.robots.iter_mut().filter(|robot| !robot.is_out()) {
            let penalty = ActivePenalty { reason: PenaltyReason::ShootOut, cycles_left: u64::from(u32::MAX) };
            robot.penalty = Penalty(Some(penalty));
        }
        let mut occupied = Occupied::by_posts(pitch, self.seen.posts, None);
        for index in 0..self.decisions.robots.len() {
            if let Some(pose) = [attacker, keeper].iter().position(|who| *who == Some(index)) {
                let robot = &mut self.decisions.robots[index];
                robot.penalty = Penalty(None);
                robot.pose = occupied.free_pose(poses[pose], &robot.bounds);
                occupied.add_robot(robot.pose, &robot.bounds);
            } else {
                self.wait_beside(index);
            }
        }
        for (index, record) in self.memory.robots.iter_mut().enumerate() {
            record.forgive();
            if [attacker, keeper].contains(&Some(index)) {
                record.hand_placements = record.hand_placements.saturating_add(1);
            }
        }
        self.put_ball(penalty_mark(self.seen.pitch, GOAL));
        self.enter(GameState::Set);
    }

    /// The index of the first robot of a team that may play and that is `preferred`, or else of the first that may play.
    fn first_of(&self, team: Team, preferred: impl Fn(&Game, RobotId) -> bool) -> Option<usize> {
        let may_play = |(_, robot): &(usize, &RobotSnapshot)| robot.id.team == team && !robot.is_out();
        let mut robots = self.seen.robots.iter().enumerate().filter(may_play);
        let first =
            robots.clone().find(|(_, robot)| preferred(&self.decisions.game, robot.id)).or_else(|| robots.next());
        first.map(|(index, _)| index)
    }

    fn wait_beside(&mut self, index: usize) {
        let mut snapshot = self.now();
        let robots: Vec<_> = snapshot.robots[..index].to_vec();
        snapshot.robots = &robots;
        let waiting = Occupied::by_waiting(&snapshot);
        let robot = &self.decisions.robots[index];
        let own_end = self.decisions.game.own_end(robot.id.team);
        let (pitch, place) = (self.seen.pitch, self.seen.rules.return_place);
        let pose = waiting_pose(pitch, place, own_end, robot.pose.position, &robot.bounds, &waiting);
        self.decisions.robots[index].pose = pose;
    }

    /// A cycle of a shot.
    pub(super) fn follow_shot(&mut self, mut shoot_out: ShootOut) {
        shoot_out.shot.cycles += 1;
        if let Some(ball) = self.seen.ball {
            let post = self.seen.pitch.goal.width_m / 2.0;
            let line = Vec2::new(GOAL.sign() * self.seen.pitch.half_length(), ball.position.y.clamp(-post, post));
            shoot_out.shot.nearest_m = shoot_out.shot.nearest_m.min(ball.position.distance(line));
        }
        let verdict = judge_shot(self.seen, &shoot_out);
        shoot_out.shot.rank = rank(self.seen, &shoot_out);
        self.decisions.game.shoot_out = Some(shoot_out);
        if let Some((scored, evidence)) = verdict {
            self.end_shot(shoot_out, scored, evidence);
        }
    }

    fn end_shot(&mut self, mut shoot_out: ShootOut, scored: bool, evidence: Evidence) {
        let team = shoot_out.team;
        shoot_out.shot.scored = scored;
        if scored {
            shoot_out.shot.rank = ShotRank::Goal;
        }
        shoot_out.last[team as usize] = shoot_out.shot;
        shoot_out.taken[team] = shoot_out.taken[team].saturating_add(1);
        shoot_out.goals[team] = shoot_out.goals[team].saturating_add(u32::from(scored));
        shoot_out.team = team.opponent();
        self.whistle();
        self.decisions.events.push(MatchEvent::Shot { team, scored, goals: shoot_out.goals, evidence });
        self.decisions.game.shoot_out = Some(shoot_out);
        let standing = shoot_out.standing(self.seen.rules, self.seen.clock.period_s);
        let winner = match standing {
            Standing::Open => return self.prepare_shot(),
            Standing::Won(winner) => winner,
            Standing::Coin => {
                let heads = self.memory.coin.as_mut().is_some_and(|coin| coin.chance(0.5));
                if heads { Team::Blue } else { Team::Pink }
            }
        };
        (shoot_out.winner, shoot_out.coin) = (Some(winner), standing == Standing::Coin);
        self.decisions.game.shoot_out = Some(shoot_out);
        self.decisions.events.push(MatchEvent::ShootOutWon { team: winner });
        self.finish();
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;

    /// A drawn match that has just become a shoot-out.
    fn drawn() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.shoot_out = true;
        situation.game.half = 2;
        situation.game.cycles_left = Some(1);
        situation.pass();
        situation
    }

    /// Lets the `set` before a shot pass, up to the whistle.
    fn whistled(mut situation: MatchFixture) -> MatchFixture {
        while situation.game.state == GameState::Set {
            situation.pass();
        }
        situation
    }

    #[test]
    fn the_robot_that_replaced_the_goalkeeper_keeps_the_goal() {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.shoot_out = true;
        (situation.game.half, situation.game.cycles_left) = (2, Some(1));
        situation.game.goalkeepers.pink = Some(3);
        situation.pass();
        let present = situation.robots.iter().filter(|robot| robot.is_present()).map(|robot| robot.id.to_string());
        assert_eq!(present.collect::<Vec<_>>(), ["blue2", "pink3"]);
    }

    #[test]
    fn one_attacker_faces_one_keeper() {
        let situation = drawn();
        let present: Vec<String> =
            situation.robots.iter().filter(|robot| robot.is_present()).map(|robot| robot.id.to_string()).collect();
        assert_eq!(present, ["blue2", "pink1"]);
        assert_eq!(situation.game.own_end(Team::Pink), GOAL);
        // The penalty mark: 3 - 1.8 = 1.2 m from the halfway line.
        assert!(situation.path[0].distance(Vec2::new(-1.2, 0.0)) < 1e-5);
    }

    #[test]
    fn a_shot_scores_or_fails_and_the_teams_take_turns() {
        let mut situation = whistled(drawn()).ball_rolled([-2.9, 0.0], [-3.2, 0.0]);
        let decided = situation.pass();
        assert!(matches!(decided.events[0], MatchEvent::Shot { team: Team::Blue, scored: true, .. }));
        assert_eq!((situation.game.score.blue, situation.game.shoot_out.unwrap().goals.blue), (0, 1));
        let mut situation = whistled(situation).ball_rolled([-2.9, 1.0], [-3.2, 1.0]);
        let decided = situation.pass();
        assert!(matches!(decided.events[0], MatchEvent::Shot { team: Team::Pink, scored: false, .. }));
    }

    #[test]
    fn a_shot_that_takes_too_long_fails() {
        let mut situation = whistled(drawn());
        let cycles = (1..10_000).find(|_| {
            situation.pass().events.iter().any(|event| matches!(event, MatchEvent::Shot { scored: false, .. }))
        });
        // 60 s of 1/30 s.
        assert_eq!(cycles, Some(1800));
    }

    #[test]
    fn neither_may_play_the_ball_where_it_is_the_others() {
        let shot = |place: [f32; 2], robot: RobotId| {
            let mut situation = whistled(drawn()).ball_rolled(place, place);
            situation.touches = vec![(robot, false)];
            let events = situation.decide().events;
            events
                .iter()
                .find_map(|event| if let MatchEvent::Shot { scored, .. } = event { Some(*scored) } else { None })
        };
        let (attacker, keeper) = (RobotId::new(Team::Blue, 2), RobotId::new(Team::Pink, 1));
        // The area's front edge is at -2.4 + 0.025 m; the ball's radius 0.03 m.
        assert_eq!(shot([-2.4, 0.0], attacker), None);
        assert_eq!(shot([-2.41, 0.0], attacker), Some(false));
        assert_eq!(shot([-2.35, 0.0], keeper), None);
        assert_eq!(shot([-2.34, 0.0], keeper), Some(true));
    }

    /// A shot under way by the rules of 2025.
    fn drawn_2025() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.shoot_out = true;
        situation.rules.shoot_out_procedure = ShootOutProcedure::Spl2025;
        situation.game.half = 2;
        situation.game.cycles_left = Some(1);
        situation.pass();
        whistled(situation)
    }

    fn shot(situation: &mut MatchFixture) -> Option<(bool, ShotRank)> {
        let events = situation.pass().events;
        let scored = events
            .iter()
            .find_map(|event| if let MatchEvent::Shot { scored, .. } = event { Some(*scored) } else { None })?;
        Some((scored, situation.game.shoot_out.unwrap().last[0].rank))
    }

    #[test]
    fn by_the_rules_of_2025_the_attacker_plays_the_ball_once_and_the_shot_ends_when_it_stops() {
        let attacker = RobotId::new(Team::Blue, 2);
        let touched = |situation: MatchFixture, from: f32, to: f32| {
            let mut situation = situation.ball_rolled([from, 0.0], [to, 0.0]);
            situation.touches = vec![(attacker, true)];
            situation
        };
        // The mark is at x = -1.2; from there the ball rolls, and stops.
        let mut kicked = touched(drawn_2025(), -1.2, -1.25);
        assert_eq!(shot(&mut kicked), None);
        assert_eq!(shot(&mut kicked.clone().ball_rolled([-1.25, 0.0], [-1.25, 0.0])), Some((false, ShotRank::Kick)));
        let mut rolls = kicked.clone().ball_rolled([-1.25, 0.0], [-1.3, 0.0]);
        assert_eq!(shot(&mut rolls), None);
        assert_eq!(shot(&mut touched(rolls, -1.26, -1.3)), Some((false, ShotRank::Kick)));
        assert_eq!(
            shot(&mut kicked.clone().ball_rolled([-2.9, 1.0], [-3.2, 1.0])),
            Some((false, ShotRank::BesideGoal))
        );
        assert_eq!(shot(&mut kicked.clone().ball_rolled([-2.9, 0.0], [-3.2, 0.0])), Some((true, ShotRank::Goal)));
        let mut blocked = kicked.ball_rolled([-2.8, 0.0], [-2.8, 0.0]);
        blocked.touches = vec![(RobotId::new(Team::Pink, 1), false)];
        assert_eq!(shot(&mut blocked), None);
        assert_eq!(shot(&mut blocked), Some((false, ShotRank::Blocked)));
    }

    #[test]
    fn by_the_rules_of_2025_the_attacker_begins_behind_the_ball() {
        let situation = drawn_2025();
        let attacker = situation.robots[1].pose;
        assert!(attacker.position.distance(Vec2::new(-1.2 + BEHIND_BALL_M, 0.0)) < 1e-5, "{attacker:?}");
    }
}
