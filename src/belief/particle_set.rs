//! The particles of a particle filter: spread, resampled by their weights, and the hypothesis that most of them support.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::pose_estimate::PoseEstimate;
use crate::geometry::{Pose, wrap_angle};
use crate::random::RandomStream;

/// Particles within this of the best one, m and radians, support the same hypothesis.
const SAME_HYPOTHESIS: (f32, f32) = (0.5, 0.5);

/// A possible pose, team frame, and its weight.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(super) struct Particle {
    pub(super) pose: Pose,
    pub(super) weight: f32,
}

/// A pose with an error.
pub(super) fn spread(pose: Pose, place_sd: f32, heading_sd: f32, stream: &mut RandomStream) -> Pose {
    Pose {
        position: pose.position + Vec2::new(stream.gaussian(place_sd), stream.gaussian(place_sd)),
        heading: wrap_angle(pose.heading + stream.gaussian(heading_sd)),
    }
}

/// Makes the weights add up to 1; all the same where there is nothing of them. Returns how many particles of one weight
/// would tell as much.
pub(super) fn normalise(particles: &mut [Particle]) -> f32 {
    let total: f32 = particles.iter().map(|particle| particle.weight).sum();
    if total <= f32::MIN_POSITIVE {
        let weight = 1.0 / particles.len() as f32;
        particles.iter_mut().for_each(|particle| particle.weight = weight);
    } else {
        particles.iter_mut().for_each(|particle| particle.weight /= total);
    }
    1.0 / particles.iter().map(|particle| particle.weight * particle.weight).sum::<f32>()
}

/// Draws as many particles again by their weights, which add up to 1: systematic resampling, with one random number for all.
pub(super) fn resample(particles: &mut Vec<Particle>, stream: &mut RandomStream) {
    let old = core::mem::take(particles);
    let weight = 1.0 / old.len() as f32;
    let mut at = stream.uniform() / old.len() as f32;
    let mut index = 0;
    let Some(mut reached) = old.first().map(|first| first.weight) else { return };
    for _ in 0..old.len() {
        while reached < at && index + 1 < old.len() {
            index += 1;
            reached += old[index].weight;
        }
        particles.push(Particle { weight, ..old[index] });
        at += weight;
    }
}

/// The hypothesis with the greatest weight: mean and covariance of the particles that support it.
pub(super) fn likeliest_hypothesis(particles: &[Particle]) -> Option<PoseEstimate> {
    let near = |one: &Pose, other: &Pose| {
        one.position.distance_squared(other.position) < SAME_HYPOTHESIS.0 * SAME_HYPOTHESIS.0
            && wrap_angle(one.heading - other.heading).abs() < SAME_HYPOTHESIS.1
    };
    // Candidates are a few particles, evenly taken from the list, in which neighbours are often alike.
    let weight_around =
        |pose: &Pose| particles.iter().filter(|other| near(&other.pose, pose)).map(|other| other.weight).sum::<f32>();
    let candidates = particles.iter().step_by(5).map(|particle| particle.pose);
    let best = candidates.map(|pose| (weight_around(&pose), pose)).max_by(|(a, _), (b, _)| a.total_cmp(b));
    let (weight, centre) = best?;
    let (mut place, mut heading) = (Vec2::ZERO, 0.0);
    let members = || particles.iter().filter(|particle| near(&particle.pose, &centre));
    for particle in members() {
        place += particle.weight * (particle.pose.position - centre.position);
        heading += particle.weight * wrap_angle(particle.pose.heading - centre.heading);
    }
    let pose =
        Pose { position: centre.position + place / weight, heading: wrap_angle(centre.heading + heading / weight) };
    let mut covariance = Mat3::from_diagonal(Vec3::new(1e-4, 1e-4, 1e-5));
    for particle in members() {
        let turned = wrap_angle(particle.pose.heading - pose.heading);
        let difference = (particle.pose.position - pose.position).extend(turned);
        let share = particle.weight / weight;
        covariance += Mat3::from_cols(
            difference * (difference.x * share),
            difference * (difference.y * share),
            difference * (difference.z * share),
        );
    }
    // What supports others makes this one less certain.
    let others = (1.0 - weight).max(0.0);
    let elsewhere = Mat3::from_diagonal(Vec3::new(others, others, 0.3 * others));
    Some(PoseEstimate { pose, covariance: covariance + elsewhere })
}
