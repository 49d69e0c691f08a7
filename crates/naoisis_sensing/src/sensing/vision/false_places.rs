//! Places that look like something else: a crossing of lines like a ball, something beside the pitch like a robot.
//!
//! To each robot its own appear and vanish at random ([`FalsePlaces`]). While they last they stand on the pitch as things do:
//! the robot sees them wherever they are in view and not hidden, with the noise of what they look like.

use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::Percepts;
use super::geometric::Observer;
use super::noise::{FalsePlaces, VisionNoise};
use crate::appearance::scene::{Scene, SceneBall};
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::RandomStream;
use naoisis_core::team::Team;

/// More than this many at a time are no mistakes any more.
const MOST_PLACES: usize = 100;

/// What a place looks like.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Reflect, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Semblance {
    Ball,
    Robot(Team),
}

/// A place that looks like something else for a while.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
struct Mistaken {
    semblance: Semblance,
    /// On the ground, m, pitch frame.
    position: Vec2,
    /// How long it goes on, s.
    left_s: f32,
}

/// The places that a robot takes for something else.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct MistakenPlaces {
    places: Vec<Mistaken>,
    /// Until the next one appears, s: one like a ball, one like a robot.
    until_next_s: [Option<f32>; 2],
}

impl MistakenPlaces {
    /// After `period` seconds: some are gone, and others there.
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
            let FalsePlaces { per_minute, life_s } = class;
            let gap_s = |stream: &mut RandomStream| exponential(60.0 / per_minute, stream);
            let mut until_next_s = match self.until_next_s[index] {
                Some(left_s) => (left_s - period).max(-period),
                None => gap_s(stream),
            };
            while until_next_s <= 0.0 && self.places.len() < MOST_PLACES {
                let found = if index == 0 { like_a_ball(scene, stream) } else { like_a_robot(scene, stream) };
                let left_s = exponential(life_s, stream);
                self.places.extend(found.map(|(semblance, position)| Mistaken { semblance, position, left_s }));
                until_next_s += gap_s(stream);
            }
            self.until_next_s[index] = Some(until_next_s);
        }
    }

    /// Adds to what a robot sees what it takes for something. Of a ball that is seen, nothing else is taken for one.
    pub(super) fn see(&self, observer: &mut Observer, percepts: &mut Percepts, scene: &Scene) {
        if observer.actual.is_empty() {
            return;
        }
        let radius = scene.ball.map_or(0.0, |ball| ball.radius);
        for place in &self.places {
            match place.semblance {
                Semblance::Ball if percepts.ball.is_none() => {
                    percepts.ball = observer.see_ball(SceneBall { position: place.position, radius });
                }
                Semblance::Ball => {}
                Semblance::Robot(team) => {
                    // As one of them is built, or whoever is there where they have none.
                    let of_team =
                        scene.robots.iter().filter(|robot| robot.id.team == team).min_by_key(|robot| robot.id);
                    if let Some(robot) = of_team.or(scene.robots.first()) {
                        percepts.robots.extend(observer.see_like_robot(place.position, team, &robot.body.waistband));
                    }
                }
            }
        }
    }
}

/// A crossing of lines or a penalty cross.
fn like_a_ball(scene: &Scene, stream: &mut RandomStream) -> Option<(Semblance, Vec2)> {
    let markings = &scene.markings;
    let junctions = markings.junctions.iter().map(|junction| junction.position);
    let count = markings.junctions.len() + markings.penalty_crosses.len();
    let index = (stream.uniform() * count as f32) as usize;
    let position = junctions.chain(markings.penalty_crosses).nth(index)?;
    Some((Semblance::Ball, position))
}

/// A place on the carpet.
fn like_a_robot(scene: &Scene, stream: &mut RandomStream) -> Option<(Semblance, Vec2)> {
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
        let often = FalsePlaces { per_minute: 30.0, life_s: 2.0 };
        let noise = VisionNoise { false_balls: often, false_robots: often, ..VisionNoise::none() };
        let scene = Scene::default();
        for cycles_per_second in [10, 60] {
            let period = 1.0 / cycles_per_second as f32;
            let mut stream = RandomStream::for_match(6, "places");
            let mut mistaken = MistakenPlaces::default();
            let mut balls = 0.0;
            let cycles = 4000 * cycles_per_second;
            for _ in 0..cycles {
                mistaken.advance(&noise, &scene, period, &mut stream);
                let is_ball = |place: &&Mistaken| place.semblance == Semblance::Ball;
                balls += mistaken.places.iter().filter(is_ball).count() as f32 / cycles as f32;
                assert!(mistaken.places.iter().all(|place| place.position.abs().cmple(Vec2::new(3.7, 2.7)).all()));
            }
            // One in two seconds, for two: one at a time on average, with a variance of one that is forgotten after 2 s, so
            // in 4000 s known to sqrt(2 * 2 / 4000) = 0.032; four of them. A cycle counts as a whole.
            assert!((balls - 1.0).abs() < 0.13 + period / 4.0, "{balls}");
        }
    }

    #[test]
    fn without_figures_nothing_is_drawn_and_nothing_left() {
        let noise = VisionNoise { false_balls: FalsePlaces { per_minute: 600.0, life_s: 10.0 }, ..VisionNoise::none() };
        let mut stream = RandomStream::for_match(6, "places");
        let mut mistaken = MistakenPlaces::default();
        for _ in 0..100 {
            mistaken.advance(&noise, &Scene::default(), 0.1, &mut stream);
        }
        assert!(!mistaken.places.is_empty() && mistaken.places.len() <= MOST_PLACES);
        let before = stream.clone();
        mistaken.advance(&VisionNoise::default(), &Scene::default(), 0.1, &mut stream);
        assert_eq!((mistaken, stream), (MistakenPlaces::default(), before));
    }
}
