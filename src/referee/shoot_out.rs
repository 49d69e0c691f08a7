//! The penalty shoot-out that decides a drawn match (2010 rule book, section 3.8.1): alternate shots from the penalty
//! mark, one attacker against one keeper, all at the goal at -x; then sudden death.

use core::f32::consts::PI;

use bevy::prelude::*;

use super::boundary::{Boundary, crossing};
use super::decide::Referee;
use super::placing::Occupied;
use super::removal::waiting_pose;
use super::snapshot::MatchSnapshot;
use crate::events::MatchEvent;
use crate::game::{ActivePenalty, Evidence, GameState, Penalty, PenaltyReason, ShootOut, Shot, Standing};
use crate::geometry::Pose;
use crate::pitch::End;
use crate::team::Team;

/// The goal that all shots are at.
const GOAL: End = End::NegativeX;
/// What has become of a shot in a cycle: scored or failed and why; none while it goes on.
pub fn judge_shot(snapshot: &MatchSnapshot, shoot_out: &ShootOut) -> Option<(bool, Evidence)> {
    let ball = snapshot.ball.as_ref()?;
    let case = |scored: bool, rule: &'static str| Some((scored, snapshot.evidence(rule, ball.position)));
    for (robot, _) in snapshot.touches {
        let shoots = robot.team == shoot_out.team;
        if !shoots && is_outside_area(snapshot, ball.position, ball.radius) {
            return case(true, "The keeper may not touch a ball that is wholly outside the penalty area.");
        }
        if shoots && is_inside_area(snapshot, ball.path.first().copied().unwrap_or(ball.position), ball.radius) {
            return case(false, "The attacker may not touch a ball that is wholly inside the penalty area.");
        }
    }
    if let Some(crossing) = crossing(ball, snapshot.pitch) {
        return match crossing.boundary {
            Boundary::Goal(GOAL) => case(true, "The shot scores when the ball is in the goal in time."),
            _ => case(false, "The shot is over when the ball leaves the pitch."),
        };
    }
    if shoot_out.shot.cycles >= snapshot.cycles(snapshot.rules.shoot_out_s) {
        return case(false, "The shot is over when its time is.");
    }
    None
}

fn is_inside_area(snapshot: &MatchSnapshot, ball: Vec2, radius: f32) -> bool {
    let (depth, across) = place_in_area(snapshot, ball);
    depth >= radius && across >= radius
}

fn is_outside_area(snapshot: &MatchSnapshot, ball: Vec2, radius: f32) -> bool {
    let (depth, across) = place_in_area(snapshot, ball);
    depth <= -radius || across <= -radius
}

/// How far a place is inside the penalty area, its lines included, from its front and from its nearer side, m.
fn place_in_area(snapshot: &MatchSnapshot, place: Vec2) -> (f32, f32) {
    let (pitch, area) = (snapshot.pitch, snapshot.pitch.penalty_area);
    let half_line = pitch.line_width_m / 2.0;
    let front = pitch.half_length() - area.depth_m - half_line;
    (GOAL.sign() * place.x - front, area.width_m / 2.0 + half_line - place.y.abs())
}

impl Referee<'_, '_> {
    /// A drawn match goes on with a shoot-out.
    pub(super) fn begin_shoot_out(&mut self) {
        self.end_penalties();
        self.decisions.game.shoot_out = Some(ShootOut::default());
        self.decisions.events.push(MatchEvent::ShootOutBegins);
        self.prepare_shot();
    }

    /// The attacker is put behind the ball on the penalty mark, in the centre of the pitch, the keeper on its goal
    /// line; all others wait beside the pitch.
    fn prepare_shot(&mut self) {
        let Some(shoot_out) = &mut self.decisions.game.shoot_out else { return };
        shoot_out.shot = Shot::default();
        let team = shoot_out.team;
        let game = &mut self.decisions.game;
        game.kick_off_team = team;
        game.drop_ball = false;
        game.set_play = None;
        game.blue_end = if team == Team::Blue { GOAL.opposite() } else { GOAL };
        let attacker = self.first_of(team, 2);
        let keeper = self.first_of(team.opponent(), 1);
        let pitch = self.seen.pitch;
        let mark = GOAL.sign() * (pitch.half_length() - pitch.penalty_mark_distance_m);
        let poses = [Pose::new(0.0, 0.0, PI), Pose::new(GOAL.sign() * pitch.half_length(), 0.0, 0.0)];
        for robot in &mut self.decisions.robots {
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
        for record in &mut self.memory.robots {
            record.forgive();
        }
        self.put_ball(Vec2::new(mark, 0.0));
        self.enter(GameState::Set);
    }

    /// The robot of a team with the least number from `number` on, or else with the least number.
    fn first_of(&self, team: Team, number: u8) -> Option<usize> {
        let numbers = || self.seen.robots.iter().enumerate().filter(|(_, robot)| robot.id.team == team);
        let first = numbers().find(|(_, robot)| robot.id.number >= number).or_else(|| numbers().next());
        first.map(|(index, _)| index)
    }

    fn wait_beside(&mut self, index: usize) {
        let mut snapshot = self.now();
        let robots: Vec<_> = snapshot.robots[..index].to_vec();
        snapshot.robots = &robots;
        let waiting = Occupied::by_waiting(&snapshot);
        let robot = &self.decisions.robots[index];
        let own_end = self.decisions.game.own_end(robot.id.team);
        let pose = waiting_pose(self.seen, own_end, robot.pose.position, &robot.bounds, &waiting);
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
        self.decisions.game.shoot_out = Some(shoot_out);
        if let Some((scored, evidence)) = judge_shot(self.seen, &shoot_out) {
            self.end_shot(shoot_out, scored, evidence);
        }
    }

    fn end_shot(&mut self, mut shoot_out: ShootOut, scored: bool, evidence: Evidence) {
        let team = shoot_out.team;
        shoot_out.shot.scored = scored;
        shoot_out.last[team as usize] = shoot_out.shot;
        shoot_out.taken[team] += 1;
        shoot_out.goals[team] += u32::from(scored);
        shoot_out.team = team.opponent();
        self.whistle();
        self.decisions.events.push(MatchEvent::Shot { team, scored, goals: shoot_out.goals, evidence });
        self.decisions.game.shoot_out = Some(shoot_out);
        let winner = match shoot_out.standing(self.seen.rules.shoot_out_shots, self.seen.clock.period_s) {
            Standing::Open => return self.prepare_shot(),
            Standing::Won(winner) => winner,
            Standing::Coin => {
                let heads = self.memory.coin.as_mut().is_some_and(|coin| coin.chance(0.5));
                if heads { Team::Blue } else { Team::Pink }
            }
        };
        self.decisions.events.push(MatchEvent::ShootOutWon { team: winner });
        self.finish();
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::MatchFixture;
    use super::*;
    use crate::team::RobotId;

    /// A drawn match that has just become a shoot-out.
    fn drawn() -> MatchFixture {
        let mut situation = MatchFixture::three_a_side();
        situation.rules.shoot_out = true;
        situation.game.half = 2;
        situation.game.cycles_left = Some(1);
        situation.pass();
        situation
    }

    /// Lets the `set` before a shot pass.
    fn whistled(mut situation: MatchFixture) -> MatchFixture {
        while situation.game.state == GameState::Set {
            situation.pass();
        }
        situation
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
}
