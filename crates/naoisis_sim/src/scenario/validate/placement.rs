//! Checks that robots, ball and posts of a scenario are on the carpet and do not overlap, at the start and at every kick-off.

use bevy::prelude::*;

use super::{Checks, ScenarioFault};
use crate::scenario::BallSpec;
use crate::scenario::field_path::FieldPath;
use crate::scenario::robot_spec::RobotSpec;
use crate::scenario::types::Scenario;
use naoisis_core::game::Game;
use naoisis_core::pitch::End;
use naoisis_core::referee::placing::LineUp;
use naoisis_core::referee::snapshot::Disc;
use naoisis_core::robot::body::Footprint;
use naoisis_core::team::{RobotId, Team};

/// Overlap that is due to rounding, m. Touching is no overlap.
const TOLERANCE_M: f32 = 1e-4;

impl Checks {
    pub(super) fn placement(&mut self, scenario: &Scenario) {
        let root = FieldPath::default();
        let carpet = scenario.field.carpet_half_extents();
        let on_carpet = format!("a place on the carpet: x within ±{} m and y within ±{} m", carpet.x, carpet.y);
        let outside = |position: Vec2| position.abs().cmpgt(carpet).any();

        let robots = &scenario.robots;
        let pose_path = |index: usize| root.field("robots").index(index).field("pose");
        let players = || robots.iter().enumerate().filter(|(_, robot)| !robot.substitute);
        for (index, robot) in players() {
            let fault = |message: String, expected: &str| ScenarioFault::new(pose_path(index), message, expected);
            if outside(robot.pose.position) {
                let message = format!("{} at {} is outside the carpet", robot.id(), words(robot.pose.position));
                self.push(fault(message, &on_carpet));
            }
            for (other_index, other) in players().take_while(|(other, _)| *other < index) {
                if torsos_overlap(scenario, robot, other) {
                    let message = format!("{} and {} stand in one place", other.id(), robot.id());
                    let other = pose_path(other_index);
                    let fault = fault(message, "a place where the two have room");
                    self.push(fault.related_to(other.clone()));
                }
            }
            for post in scenario.field.goal_posts() {
                if torso_reaches(scenario, robot, post.position, post.radius) {
                    let message = format!("{} stands in the goal post at {}", robot.id(), words(post.position));
                    self.push(fault(message, "a place clear of posts"));
                }
            }
        }
        for (index, post) in scenario.posts.iter().enumerate() {
            let path = root.field("posts").index(index);
            let place = path.field("position_m");
            if outside(post.position_m) {
                let message = format!("the post at {} is outside the carpet", words(post.position_m));
                self.fault(place.clone(), message, on_carpet.as_str());
            }
            for (robot_index, robot) in players() {
                if torso_reaches(scenario, robot, post.position_m, post.radius_m) {
                    let message = format!("{} stands in the post at {}", robot.id(), words(post.position_m));
                    let fault = ScenarioFault::new(pose_path(robot_index), message, "a place clear of posts");
                    self.push(fault.related_to(place.clone()));
                }
            }
        }
        let balls: Vec<BallSpec> = scenario.balls().collect();
        for (index, ball) in balls.iter().enumerate() {
            let path = scenario.path_of_ball(index).field("position_m");
            let place_m = ball.place_m();
            let fault = |message: String, expected: &str| ScenarioFault::new(path.clone(), message, expected);
            if outside(place_m) {
                self.push(fault(format!("the ball at {} is outside the carpet", words(place_m)), &on_carpet));
            }
            for (index, robot) in players() {
                if holds_ball(scenario, robot, ball) {
                    let message = format!("the ball at {} is inside {}", words(place_m), robot.id());
                    let expected = "a place clear of the robots' torsos; a ball to kick lies 0.10 m to 0.22 m in front";
                    self.push(fault(message, expected).related_to(pose_path(index)));
                }
            }
            for (position, post_radius) in posts(scenario) {
                if position.distance(place_m) < post_radius + ball.radius_m - TOLERANCE_M {
                    let message = format!("the ball at {} is inside the post at {}", words(place_m), words(position));
                    self.push(fault(message, "a place clear of posts"));
                }
            }
            for other in &balls[..index] {
                let centres = [ball, other].map(place_m_of_centre);
                if centres[0].distance(centres[1]) < 2.0 * ball.radius_m - TOLERANCE_M {
                    let message = format!("two balls lie at {}", words(place_m));
                    self.push(fault(message, "a place clear of other balls"));
                }
            }
        }
    }

    /// That only what has no referee of a ball has several balls.
    pub(super) fn one_ball(&mut self, scenario: &Scenario) {
        let count = scenario.balls().count();
        let rules = &scenario.rules;
        let judged = [
            ("clock", rules.clock),
            ("goals", rules.goals),
            ("ball_out", rules.ball_out),
            ("stalling", rules.stalling),
            ("ball_holding", rules.ball_holding),
            ("obstruction", rules.obstruction),
            ("game_stuck", rules.game_stuck),
        ];
        if let (2.., Some((rule, _))) = (count, judged.iter().find(|(_, is_judged)| *is_judged)) {
            let message =
                format!("there are {count} balls, and the rules `{}` (`{rule}`) need exactly one", rules.name);
            self.fault(FieldPath::from("balls"), message, "the rules `free`, for training, or one ball");
        }
    }
}

impl Scenario {
    /// The path of a ball in a file.
    pub(super) fn path_of_ball(&self, index: usize) -> FieldPath {
        let root = FieldPath::default();
        if self.more_balls.is_empty() { root.field("ball") } else { root.field("balls").index(index) }
    }
}

/// The centre of a ball, m.
fn place_m_of_centre(ball: &BallSpec) -> Vec3 {
    ball.position_m.with_z(ball.start_flight().height_m)
}

impl Checks {
    /// Checks that there is room on the carpet for all robots at a kick-off of either team, at either end.
    pub(super) fn room_at_kick_offs(&mut self, scenario: &Scenario) {
        let carpet = scenario.field.carpet_half_extents();
        let is_outside = |place: Vec2| place.abs().cmpgt(carpet).any();
        let players = scenario.robots.iter().filter(|robot| !robot.substitute);
        let mut robots: Vec<RobotId> = players.map(RobotSpec::id).collect();
        let mut balls = vec![Vec2::ZERO];
        if scenario.teams.is_some() {
            let numbers = 1..=scenario.rules.team_size;
            robots = Team::BOTH
                .into_iter()
                .flat_map(|team| numbers.clone().map(move |number| RobotId::new(team, number)))
                .collect();
            // Robots that are lined up at the start avoid the ball, wherever it is.
            balls.extend(scenario.ball.map(|ball| ball.place_m()));
        }
        robots.sort();
        let kick_offs =
            End::BOTH.into_iter().flat_map(|end| [Some(Team::Blue), Some(Team::Pink), None].map(|team| (end, team)));
        for (blue_end, kick_off_team) in kick_offs {
            let game = Game { blue_end, ..Game::default() };
            for &ball in &balls {
                let mut line_up = scenario.line_up(&game, kick_off_team, scenario.ball.map(|_| ball));
                let crowded_out = robots.iter().find(|id| {
                    let body = scenario.body_of(&scenario.robot(**id));
                    is_outside(line_up.put_down(**id, &body).position)
                });
                let without_room = match (crowded_out, &scenario.ball) {
                    (Some(id), _) => Some((id.to_string(), line_up.place_of(*id).position)),
                    (None, Some(ball)) => {
                        is_outside(line_up.ball_place(ball.radius_m)).then(|| ("the ball".to_owned(), Vec2::ZERO))
                    }
                    (None, None) => None,
                };
                let Some((who, place)) = without_room else { continue };
                let root = FieldPath::default();
                let path = if scenario.posts.is_empty() {
                    root.field("rules").field("team_size")
                } else {
                    root.field("posts")
                };
                let message = format!("at a kick-off there is no room on the carpet for {who} around {}", words(place));
                self.fault(path, message, "fewer or thinner posts, smaller teams, or a larger pitch");
                return;
            }
        }
    }
}

impl Scenario {
    /// Returns the line-up for a kick-off of this scenario, with the ball at `ball` (m) and without robots so far.
    pub fn line_up<'a>(&'a self, game: &'a Game, kick_off_team: Option<Team>, ball: Option<Vec2>) -> LineUp<'a> {
        let posts: Vec<Disc> = posts(self).map(|(centre, radius)| Disc { centre, radius }).collect();
        let ball = ball.zip(self.ball).map(|(centre, ball)| Disc { centre, radius: ball.radius_m });
        LineUp::new(&self.field, &posts, ball, game, &self.rules, kick_off_team)
    }
}

/// Formats a position, to the millimetre.
fn words(position: Vec2) -> String {
    let millimetres = |metres: f32| f64::from((metres * 1000.0).round()) / 1000.0;
    format!("({}, {})", millimetres(position.x), millimetres(position.y))
}

/// Moves a ball that is at its default position, the centre mark, to the nearest place that is free of robots and posts. A robot may stand
/// on the mark if the ball does not matter.
pub fn place_ball_beside_robots(scenario: &mut Scenario) {
    const STEP_M: f32 = 0.05;
    const EIGHT_DIRECTIONS: [Vec2; 8] = [
        Vec2::new(0.0, 1.0),
        Vec2::new(0.0, -1.0),
        Vec2::new(1.0, 0.0),
        Vec2::new(-1.0, 0.0),
        Vec2::new(1.0, 1.0),
        Vec2::new(-1.0, -1.0),
        Vec2::new(1.0, -1.0),
        Vec2::new(-1.0, 1.0),
    ];
    let Some(ball) = scenario.ball else { return };
    let carpet = scenario.field.carpet_half_extents();
    let is_free = |place: Vec2| {
        let clear_of_robots = scenario.robots.iter().all(|robot| {
            let base = scenario.body_of(robot).base;
            !torso_reaches(scenario, robot, place, ball.radius_m)
                && !reaches(base.footprint(robot.pose), place, ball.radius_m)
        });
        clear_of_robots && posts(scenario).all(|(post, radius)| post.distance(place) >= radius + ball.radius_m)
    };
    let rings = (1..200).flat_map(|ring| EIGHT_DIRECTIONS.map(|direction| direction * (ring as f32 * STEP_M)));
    let mut places = core::iter::once(Vec2::ZERO).chain(rings).filter(|place| place.abs().cmple(carpet).all());
    if let Some(place) = places.find(|&place| is_free(place))
        && let Some(ball) = &mut scenario.ball
    {
        ball.position_m = place.extend(ball.position_m.z);
    }
}

/// Returns all posts of a scenario: positions (m) and radii (m).
fn posts(scenario: &Scenario) -> impl Iterator<Item = (Vec2, f32)> {
    let goals = scenario.field.goal_posts().map(|post| (post.position, post.radius));
    goals.into_iter().chain(scenario.posts.iter().map(|post| (post.position_m, post.radius_m)))
}

fn torsos_overlap(scenario: &Scenario, one: &RobotSpec, other: &RobotSpec) -> bool {
    let [one, other] = [one, other].map(|robot| scenario.body_of(robot).torso.footprint(robot.pose));
    let overlap = one.overlap(&other);
    overlap.is_some_and(|overlap| overlap.depth > TOLERANCE_M)
}

fn torso_reaches(scenario: &Scenario, robot: &RobotSpec, centre: Vec2, radius: f32) -> bool {
    reaches(scenario.body_of(robot).torso.footprint(robot.pose), centre, radius)
}

/// Returns whether a ball overlaps a robot's place. Beside the feet, there is room for a ball below the arms.
fn holds_ball(scenario: &Scenario, robot: &RobotSpec, ball: &BallSpec) -> bool {
    let base = scenario.body_of(robot).base.footprint(robot.pose);
    torso_reaches(scenario, robot, ball.place_m(), ball.radius_m) && reaches(base, ball.place_m(), ball.radius_m)
}

fn reaches(footprint: Footprint, centre: Vec2, radius: f32) -> bool {
    footprint.overlap_disc(centre, radius).is_some_and(|overlap| overlap.depth > TOLERANCE_M)
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::f32::consts::FRAC_PI_2;
    use naoisis_core::geometry::Pose;

    #[test]
    fn a_ball_lies_below_an_arm_and_not_in_a_foot() {
        let holds = |x: f32, y: f32| {
            let ball = BallSpec { position_m: Vec3::new(x, y, 0.0), ..BallSpec::default() };
            holds_ball(&Scenario::default(), &RobotSpec::default(), &ball)
        };
        // The feet are 20 cm wide, and the arms 30 cm apart; the ball's radius is 3 cm.
        assert!(holds(0.0, 0.0) && holds(0.0, 0.12) && !holds(0.0, 0.14));
    }

    #[test]
    fn torsos_that_touch_do_not_overlap() {
        // The torso is 8 cm deep and 30 cm wide.
        let here = Pose::default();
        for (pose, overlaps) in [
            (Pose::new(0.08, 0.0, 0.0), false),
            (Pose::new(0.0795, 0.0, 0.0), true),
            (Pose::new(0.0, 0.30, 0.0), false),
            (Pose::new(0.0, -0.2995, 0.0), true),
            // Turned to the left: its torso is from -3 cm to 5 cm along y, and the other one ends at 15 cm.
            (Pose::new(0.0, 0.181, FRAC_PI_2), false),
            (Pose::new(0.0, 0.179, FRAC_PI_2), true),
        ] {
            let scenario = Scenario::default();
            let [one, other] = [here, pose].map(|pose| RobotSpec { pose, ..default() });
            assert_eq!(torsos_overlap(&scenario, &one, &other), overlaps, "{pose:?}");
            assert_eq!(torsos_overlap(&scenario, &other, &one), overlaps, "{pose:?}");
        }
    }

    #[test]
    fn the_default_ball_makes_way_for_a_robot_on_the_mark() {
        let mut scenario = Scenario { robots: vec![RobotSpec { number: 1, ..default() }], ..default() };
        assert!(scenario.validate().is_err());
        place_ball_beside_robots(&mut scenario);
        assert_eq!(scenario.validate(), Ok(()));
        assert_ne!(scenario.ball.unwrap_or_default(), BallSpec::default());
    }
}
