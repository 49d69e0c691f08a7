//! False positives: detections of balls, goal posts and robots where there are none.
//!
//! Some occur in a single image ([`ClassNoise::false_positive_probability`]). Others last ([`FalsePositives`]): a line crossing looks like
//! a ball, or an object beside the pitch like a robot. Each robot has its own; they appear and vanish at random. While they last, the robot
//! detects them whenever they are in view and not hidden, with the noise of the class that they look like.

use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::measuring::on_pitch;
use super::noise::{ClassNoise, FalsePositives, VisionNoise};
use super::observer::Observer;
use super::{BallPercept, GoalPostPercept, Percepts, RobotPercept, jersey_colours};
use crate::appearance::scene::{Scene, SceneBall};
use naoisis_core::camera_model::CameraName;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::RandomStream;
use naoisis_core::team::Team;

/// The greatest number of draws of a false detection until it has a position on the ground.
const ATTEMPTS: usize = 8;

/// The greatest number of lasting false positives at a time.
const MOST_PLACES: usize = 100;

impl Observer<'_> {
    /// Adds detections where there are no objects, for this image.
    pub(super) fn add_false_positives(&mut self, percepts: &mut Percepts, scene: &Scene) {
        if self.actual.is_empty() {
            return;
        }
        let VisionNoise { ball, goal_posts, robots, .. } = self.noise;
        if percepts.ball.is_none() && self.stream.chance(ball.false_positive_probability) {
            let radius = scene.ball.map_or(0.0, |ball| ball.radius);
            let place = self.random_place(ball, radius);
            percepts.ball = place.map(|(camera, pixel, place)| BallPercept::new(camera, pixel, place));
        }
        if self.stream.chance(goal_posts.false_positive_probability) {
            let [one, other] = scene.markings.goal_colours;
            let colour = if self.stream.chance(0.5) { one } else { other };
            let place = self.random_place(goal_posts, 0.0);
            let post = place.map(|(camera, pixel, place)| GoalPostPercept::new(camera, colour, pixel, place));
            percepts.goal_posts.extend(post);
        }
        if self.stream.chance(robots.false_positive_probability) {
            let team = if self.stream.chance(0.5) { Team::Blue } else { Team::Pink };
            let place = self.random_place(robots, 0.0);
            let colour = jersey_colours::of_team(scene, team).filter(|_| self.noise.jerseys.colour_m > 0.0);
            let robot = place
                .map(|(camera, pixel, place)| RobotPercept { colour, ..RobotPercept::new(camera, team, pixel, place) });
            percepts.robots.extend(robot);
        }
    }

    /// Draws a random pixel of the images that shows a point at a height, m, within the greatest distance of a class. Returns its camera,
    /// the pixel, and the point, m, robot frame.
    fn random_place(&mut self, class: &ClassNoise, height: f32) -> Option<(CameraName, Vec2, Vec2)> {
        (0..ATTEMPTS).find_map(|_| {
            let count = self.believed.len();
            let camera = count - 1 - ((self.stream.uniform() * count as f32) as usize).min(count - 1);
            let view = &self.believed[camera];
            let pixel = view.intrinsics.size * Vec2::new(self.stream.uniform(), self.stream.uniform());
            let place = on_pitch(view.point_at_height(pixel, height)).filter(|&place| !class.is_too_far(place))?;
            Some((self.names[camera], pixel, place))
        })
    }
}

/// The class of object that a false positive looks like.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Semblance {
    Ball,
    Robot(Team),
}

/// A lasting false positive.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
struct Mistaken {
    semblance: Semblance,
    /// Position on the ground, m, pitch frame.
    position: Vec2,
    /// The time that it still lasts, s.
    left_s: f32,
}

/// The lasting false positives of a robot.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub(crate) struct ActiveFalsePositives {
    places: Vec<Mistaken>,
    /// The time until the next false ball and the next false robot appear, s.
    until_next_s: [Option<f32>; 2],
}

impl ActiveFalsePositives {
    /// Removes the false positives that have ended after `period` seconds, and adds new ones.
    pub(super) fn advance(&mut self, noise: &VisionNoise, scene: &Scene, period: f32, stream: &mut RandomStream) {
        for place in &mut self.places {
            place.left_s -= period;
        }
        self.places.retain(|place| {
            let still = match place.semblance {
                Semblance::Ball => noise.false_balls,
                Semblance::Robot(_) => noise.false_robots,
            };
            place.left_s > 0.0 && still.per_minute > 0.0
        });
        for (index, class) in [noise.false_balls, noise.false_robots].into_iter().enumerate() {
            if class.per_minute <= 0.0 || class.life_s <= 0.0 {
                self.until_next_s[index] = None;
                continue;
            }
            let FalsePositives { per_minute, life_s } = class;
            let gap_s = |stream: &mut RandomStream| exponential(60.0 / per_minute, stream);
            let mut until_next_s = match self.until_next_s[index] {
                Some(left_s) => (left_s - period).max(-period),
                None => gap_s(stream),
            };
            while until_next_s <= 0.0 && self.places.len() < MOST_PLACES {
                let found = if index == 0 { false_ball(scene, stream) } else { false_robot(scene, stream) };
                let left_s = exponential(life_s, stream);
                self.places.extend(found.map(|(semblance, position)| Mistaken { semblance, position, left_s }));
                until_next_s += gap_s(stream);
            }
            self.until_next_s[index] = Some(until_next_s);
        }
    }

    /// Adds the false positives in view to the percepts. If the ball is detected already, no false one is added.
    pub(super) fn see(&self, observer: &mut Observer, percepts: &mut Percepts, scene: &Scene) {
        if observer.actual.is_empty() {
            return;
        }
        let radius = scene.ball.map_or(0.0, |ball| ball.radius);
        for place in &self.places {
            match place.semblance {
                Semblance::Ball if percepts.ball.is_none() => {
                    percepts.ball = observer.see_ball(SceneBall::on_ground(place.position, radius)).ok();
                }
                Semblance::Ball => {}
                Semblance::Robot(team) => {
                    // The body is that of a robot of that team, or of any robot if the team has none.
                    let of_team =
                        scene.robots.iter().filter(|robot| robot.id.team == team).min_by_key(|robot| robot.id);
                    if let Some(robot) = of_team.or(scene.robots.first()) {
                        percepts.robots.extend(observer.see_false_robot(place.position, team, &robot.body));
                    }
                }
            }
        }
    }
}

/// A false ball at a line junction or a penalty cross.
fn false_ball(scene: &Scene, stream: &mut RandomStream) -> Option<(Semblance, Vec2)> {
    let markings = &scene.markings;
    let junctions = markings.junctions.iter().map(|junction| junction.position);
    let count = markings.junctions.len() + markings.penalty_crosses.len();
    let index = (stream.uniform() * count as f32) as usize;
    let position = junctions.chain(markings.penalty_crosses).nth(index)?;
    Some((Semblance::Ball, position))
}

/// A false robot anywhere on the carpet.
fn false_robot(scene: &Scene, stream: &mut RandomStream) -> Option<(Semblance, Vec2)> {
    let pitch = &scene.pitch;
    let carpet = Vec2::new(pitch.length_m, pitch.width_m) + Vec2::splat(2.0 * pitch.border_m);
    let position = carpet * (Vec2::new(stream.uniform(), stream.uniform()) - Vec2::splat(0.5));
    let team = if stream.chance(0.5) { Team::Blue } else { Team::Pink };
    Some((Semblance::Robot(team), position))
}

/// A draw from the exponential distribution with this mean.
fn exponential(mean: f32, stream: &mut RandomStream) -> f32 {
    -mean * ops::ln(1.0 - stream.uniform())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_come_and_go_at_their_rate_whatever_the_cycles_are() {
        let often = FalsePositives { per_minute: 30.0, life_s: 2.0 };
        let noise = VisionNoise { false_balls: often, false_robots: often, ..VisionNoise::none() };
        let scene = Scene::default();
        for cycles_per_second in [10, 60] {
            let period = 1.0 / cycles_per_second as f32;
            let mut stream = RandomStream::for_match(6, "places");
            let mut mistaken = ActiveFalsePositives::default();
            let mut balls = 0.0;
            let cycles = 4000 * cycles_per_second;
            for _ in 0..cycles {
                mistaken.advance(&noise, &scene, period, &mut stream);
                let is_ball = |place: &&Mistaken| place.semblance == Semblance::Ball;
                balls += mistaken.places.iter().filter(is_ball).count() as f32 / cycles as f32;
                assert!(mistaken.places.iter().all(|place| place.position.abs().cmple(Vec2::new(3.7, 2.7)).all()));
            }
            // One appears in two seconds and lasts for two: one at a time on average, with a variance of one that is forgotten after 2 s,
            // so in 4000 s the mean is known to sqrt(2 * 2 / 4000) = 0.032; four of them. A cycle counts as a whole.
            assert!((balls - 1.0).abs() < 0.13 + period / 4.0, "{balls}");
        }
    }

    #[test]
    fn without_figures_nothing_is_drawn_and_nothing_left() {
        let noise =
            VisionNoise { false_balls: FalsePositives { per_minute: 600.0, life_s: 10.0 }, ..VisionNoise::none() };
        let mut stream = RandomStream::for_match(6, "places");
        let mut mistaken = ActiveFalsePositives::default();
        for _ in 0..100 {
            mistaken.advance(&noise, &Scene::default(), 0.1, &mut stream);
        }
        assert!(!mistaken.places.is_empty() && mistaken.places.len() <= MOST_PLACES);
        let before = stream.clone();
        mistaken.advance(&VisionNoise::default(), &Scene::default(), 0.1, &mut stream);
        assert_eq!((mistaken, stream), (ActiveFalsePositives::default(), before));
    }
}
