//! The referee's course through a cycle: what it sees, what it decides, what it does.
//!
//! [`decide`] is a plain function from a [`MatchSnapshot`] to [`Decisions`]; the systems only fetch and store.

use bevy::prelude::*;

use super::boundary::crossing;
use super::game::{Game, GameState, half_cycles};
use super::penalty::Penalty;
use super::placing::{Occupied, line_up};
use super::rules::{BallOutRestart, Rules};
use super::snapshot::{BallSnapshot, Disc, MatchSnapshot, RobotSnapshot};
use super::touch::{LastTouch, Touch, last_touch_of_cycle};
use super::{ball_out, goal};
use crate::ball::{Ball, BallPath, BallPhysics, BallVelocity};
use crate::collision::Contacts;
use crate::cycle::CycleClock;
use crate::events::{CycleEvents, MatchEvent};
use crate::geometry::Pose;
use crate::pitch::{Pitch, Post};
use crate::robot::body::BodyBounds;
use crate::robot::kick::{KickCommand, KickPhase};
use crate::robot::motion::WalkCommand;
use crate::robot::{PreviousPose, RobotId, Roster, Team, Velocity};

/// What the referee decided in a cycle.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Decisions {
    /// The state of the match from now on.
    pub game: Game,
    /// What is announced.
    pub events: Vec<MatchEvent>,
    /// Where the ball is put down to rest, m.
    pub ball: Option<Vec2>,
    /// Robots that are put down, by their index in the snapshot.
    pub robots: Vec<(usize, Pose)>,
}

impl Decisions {
    fn begin(&mut self, game: &Game) {
        self.game = game.clone();
        self.events.clear();
        self.ball = None;
        self.robots.clear();
    }

    /// Ball and robots are placed for a kick-off.
    fn kick_off(&mut self, snapshot: &MatchSnapshot, team: Team) {
        self.game.kick_off_team = team;
        self.game.restarts += 1;
        self.ball = Some(Vec2::ZERO);
        self.robots = line_up(&MatchSnapshot { game: &self.game, ..*snapshot }, team);
        self.events.push(MatchEvent::KickOff { team });
    }
}

/// Judges a cycle in which the ball was in play, into `decisions`.
pub fn decide(snapshot: &MatchSnapshot, decisions: &mut Decisions) {
    decisions.begin(snapshot.game);
    if snapshot.game.state != GameState::Playing {
        return;
    }
    let goal_restart = judge_ball(snapshot, decisions);
    let half_is_over = run_clock(decisions);
    if half_is_over {
        end_half(snapshot, decisions);
    } else if let Some(team) = goal_restart {
        decisions.kick_off(snapshot, team);
    }
}

/// Goals and outs. Returns the team that kicks off because of one.
fn judge_ball(snapshot: &MatchSnapshot, decisions: &mut Decisions) -> Option<Team> {
    let ball = snapshot.ball.as_ref()?;
    let crossing = crossing(ball, snapshot.pitch)?;
    if let Some(goal) = goal::judge(snapshot, &crossing) {
        *decisions.game.score.of_mut(goal.team) += 1;
        decisions.events.push(MatchEvent::Goal { team: goal.team, scorer: goal.scorer, own_goal: goal.is_own_goal() });
        return Some(goal.team.opponent());
    }
    let out = ball_out::judge(snapshot, &crossing)?;
    decisions.events.push(MatchEvent::BallOut { line: out.line, position_m: out.position, last_touch: out.last_touch });
    match snapshot.rules.ball_out_restart {
        BallOutRestart::KickOff => Some(out.restart_team),
        BallOutRestart::ThrowIn => {
            let mut occupied = Occupied::by_posts(snapshot.posts, None);
            for robot in snapshot.robots.iter().filter(|robot| !robot.penalised) {
                occupied.add_robot(robot.pose, &robot.bounds);
            }
            let place = occupied.free_ball_place(ball_out::throw_in_place(snapshot, &out), ball.radius);
            decisions.ball = Some(place);
            decisions.events.push(MatchEvent::ThrowIn { team: out.restart_team, position_m: place });
            None
        }
    }
}

/// Counts the cycle. Returns whether the half is over.
fn run_clock(decisions: &mut Decisions) -> bool {
    let Some(cycles_left) = &mut decisions.game.cycles_left else { return false };
    *cycles_left = cycles_left.saturating_sub(1);
    *cycles_left == 0
}

/// Changes sides for the next half, or ends the match.
fn end_half(snapshot: &MatchSnapshot, decisions: &mut Decisions) {
    let game = &mut decisions.game;
    if game.half >= snapshot.rules.halves {
        game.state = GameState::Finished;
        decisions.events.push(MatchEvent::FinalWhistle);
        return;
    }
    game.half += 1;
    game.blue_end = game.blue_end.opposite();
    game.cycles_left = Some(half_cycles(snapshot.rules, &snapshot.clock));
    let half = game.half;
    decisions.events.push(MatchEvent::HalfBegins { half });
    decisions.kick_off(snapshot, Game::first_kick_off_of_half(half));
}

/// The first whistle: in the first cycle the ball comes into play before anybody senses or acts.
pub(super) fn begin_match(mut game: ResMut<Game>, mut events: ResMut<CycleEvents>) {
    if game.state == GameState::Initial {
        game.state = GameState::Playing;
        events.push(MatchEvent::HalfBegins { half: game.half });
    }
}

/// What [`officiate`] works with, kept between cycles so that a steady match allocates nothing.
#[derive(Default)]
pub(super) struct Scratch {
    entities: Vec<Entity>,
    robots: Vec<RobotSnapshot>,
    posts: Vec<Disc>,
    decisions: Decisions,
}

pub(super) fn officiate(
    mut scratch: Local<Scratch>,
    clock: Res<CycleClock>,
    rules: Res<Rules>,
    pitch: Res<Pitch>,
    roster: Res<Roster>,
    contacts: Res<Contacts>,
    mut events: ResMut<CycleEvents>,
    mut game: ResMut<Game>,
    mut last_touch: ResMut<LastTouch>,
    posts: Query<(&Pose, &Post), (Without<RobotId>, Without<Ball>)>,
    mut robots: Query<
        (
            &mut Pose,
            &mut PreviousPose,
            &mut Velocity,
            &BodyBounds,
            &Penalty,
            &mut WalkCommand,
            &mut KickCommand,
            &mut KickPhase,
        ),
        With<RobotId>,
    >,
    mut balls: Query<
        (&mut Pose, &mut PreviousPose, &mut BallVelocity, &BallPhysics, &BallPath),
        (With<Ball>, Without<RobotId>),
    >,
) {
    let Scratch { entities, robots: seen, posts: discs, decisions } = &mut *scratch;
    entities.clear();
    seen.clear();
    for (id, entity) in roster.iter() {
        let Ok((pose, _, velocity, bounds, penalty, ..)) = robots.get(entity) else { continue };
        entities.push(entity);
        seen.push(RobotSnapshot {
            id,
            pose: *pose,
            velocity: *velocity,
            bounds: *bounds,
            penalised: penalty.is_active(),
        });
    }
    discs.clear();
    discs.extend(posts.iter().map(|(pose, post)| Disc { centre: pose.position, radius: post.radius }));

    if let Some((robot, kick)) = last_touch_of_cycle(&events, contacts.robots_at_ball()) {
        let robot_position = seen.iter().find(|seen| seen.id == robot).map(|seen| seen.pose.position);
        last_touch.0 = robot_position.map(|robot_position| Touch { robot, cycle: clock.cycle, robot_position, kick });
    }
    let mut balls = balls.iter_mut();
    let mut ball = balls.next();
    decide(
        &MatchSnapshot {
            clock: *clock,
            pitch: &pitch,
            rules: &rules,
            game: &game,
            ball: ball.as_ref().map(|(pose, _, velocity, physics, path)| BallSnapshot {
                path: &path.corners,
                position: pose.position,
                velocity: velocity.0,
                radius: physics.radius_m,
            }),
            robots: seen,
            posts: discs,
            last_touch: last_touch.0,
        },
        decisions,
    );

    game.set_if_neq(decisions.game.clone());
    events.append(&mut decisions.events);
    if let (Some(place), Some((pose, previous, velocity, ..))) = (decisions.ball, &mut ball) {
        pose.position = place;
        previous.0 = **pose;
        velocity.0 = Vec2::ZERO;
        last_touch.0 = None;
    }
    for (index, place) in decisions.robots.drain(..) {
        let Ok((mut pose, mut previous, mut velocity, _, _, mut walk, mut kick, mut phase)) =
            robots.get_mut(entities[index])
        else {
            continue;
        };
        *pose = place;
        previous.0 = place;
        *velocity = Velocity::default();
        *walk = WalkCommand::default();
        *kick = KickCommand::default();
        *phase = KickPhase::default();
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::Situation;
    use super::*;
    use crate::events::BoundaryLine;
    use approx::assert_abs_diff_eq;

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const PINK2: RobotId = RobotId::new(Team::Pink, 2);

    #[test]
    fn a_goal_counts_and_the_other_team_kicks_off() {
        let decided = Situation::three_a_side().touched_by(BLUE2).ball_rolled([2.9, 0.2], [3.2, 0.2]).decide();
        assert_eq!(decided.game.score.blue, 1);
        assert_eq!(
            decided.events,
            [
                MatchEvent::Goal { team: Team::Blue, scorer: Some(BLUE2), own_goal: false },
                MatchEvent::KickOff { team: Team::Pink },
            ]
        );
        assert_eq!((decided.ball, decided.robots.len(), decided.game.restarts), (Some(Vec2::ZERO), 6, 1));
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
        situation.last_touch.0.as_mut().unwrap().robot_position.x = robot_x;
        let decided = situation.decide();
        assert!(decided.robots.is_empty() && decided.game.restarts == 0);
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
        situation.last_touch.0.as_mut().unwrap().robot_position.x = 1.0;
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
        assert!(decided.robots[0].1.position.x > 2.0);
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
        assert_eq!((decided.events.len(), decided.ball, decided.robots.len()), (0, None, 0));
    }
}
