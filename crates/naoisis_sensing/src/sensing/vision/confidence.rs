//! How sure a vision is of its percepts.
//!
//! The confidence of a true detection lies between the probability with which such an object is detected at its distance and 1, and that of
//! a false detection between 0 and that probability. So it tells true detections from false ones well at short distances and badly at long
//! ones, as the scores of learned detectors do. That it is uniform in these ranges is a guess.

use super::noise::{ClassNoise, VisionNoise};
use super::{LandmarkKind, Percepts};
use naoisis_core::random::RandomStream;

/// The number of percepts of each class.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct Counts {
    has_ball: bool,
    goal_posts: usize,
    robots: usize,
}

impl Counts {
    /// The numbers in `percepts`.
    pub(super) fn of(percepts: &Percepts) -> Self {
        let Percepts { ball, goal_posts, robots, .. } = percepts;
        Self { has_ball: ball.is_some(), goal_posts: goal_posts.len(), robots: robots.len() }
    }
}

/// Sets the confidence of all percepts. The first ones, as many as `true_ones`, are true detections, and so are all landmarks.
pub(super) fn rate(percepts: &mut Percepts, true_ones: Counts, noise: &VisionNoise, stream: &mut RandomStream) {
    let mut draw = |class: &ClassNoise, distance_m: f32, is_true: bool| {
        Some(confidence(class.detection_probability(distance_m), is_true, stream.uniform()))
    };
    let Percepts { ball, balls, goal_posts, robots, landmarks, .. } = percepts;
    let several = balls.len();
    for ball in balls.iter_mut().chain(ball.iter_mut().filter(|_| several == 0)) {
        ball.confidence = draw(&noise.ball, ball.position_m.length(), true_ones.has_ball);
    }
    if let Some(nearest) = balls.first() {
        *ball = Some(*nearest);
    }
    for (index, post) in goal_posts.iter_mut().enumerate() {
        post.confidence = draw(&noise.goal_posts, post.position_m.length(), index < true_ones.goal_posts);
    }
    for (index, robot) in robots.iter_mut().enumerate() {
        robot.confidence = draw(&noise.robots, robot.position_m.length(), index < true_ones.robots);
    }
    for landmark in landmarks {
        let class = match landmark.kind {
            LandmarkKind::Line { .. } => &noise.lines,
            LandmarkKind::Junction { .. } | LandmarkKind::CornerArc => &noise.junctions,
            LandmarkKind::PenaltyCross => &noise.penalty_crosses,
            LandmarkKind::CentreCircle => &noise.centre_circle,
        };
        landmark.confidence = draw(class, landmark.position_m.length(), true);
    }
}

/// The confidence of a detection with this probability, by a number from 0 to 1.
fn confidence(probability: f32, is_true: bool, uniform: f32) -> f32 {
    if is_true { probability + (1.0 - probability) * uniform } else { probability * uniform }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn true_detections_are_surer_than_false_ones() {
        for probability in [0.0, 0.3, 0.9, 1.0] {
            for uniform in [0.0, 0.5, 0.99] {
                let [sure, unsure] = [true, false].map(|is_true| confidence(probability, is_true, uniform));
                assert!((probability..=1.0).contains(&sure) && (0.0..=probability).contains(&unsure));
            }
        }
    }
}
