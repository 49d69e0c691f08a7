//! Operations on particles: spreading, resampling, and the likeliest hypothesis.

use bevy::prelude::*;
use core::f32::consts::TAU;
use serde::{Deserialize, Serialize};

use super::pose_estimate::PoseEstimate;
use naoisis_core::geometry::{Pose, wrap_angle};
use naoisis_core::random::RandomStream;

/// Particles within this distance of each other, m and radians, support the same hypothesis.
const SAME_HYPOTHESIS: (f32, f32) = (0.5, 0.5);
/// The number of particles that are tried as the centre of the likeliest hypothesis.
const CANDIDATES: usize = 20;

/// A possible pose, team frame, with its weight.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(super) struct Particle {
    pub(super) pose: Pose,
    pub(super) weight: f32,
}

/// A pose with a random error.
pub(super) fn spread(pose: Pose, place_sd: f32, heading_sd: f32, stream: &mut RandomStream) -> Pose {
    Pose {
        position: pose.position + Vec2::new(stream.gaussian(place_sd), stream.gaussian(place_sd)),
        heading: wrap_angle(pose.heading + stream.gaussian(heading_sd)),
    }
}

/// Normalises the weights to a sum of 1; equal weights if all are zero. Returns the effective number of particles.
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

/// Resamples the particles by their weights, whose sum is 1: systematic resampling, with one random number for all.
pub(super) fn resample(particles: &mut Vec<Particle>, stream: &mut RandomStream) {
    let old = core::mem::replace(particles, Vec::with_capacity(particles.len()));
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

/// Whether two poses support the same hypothesis. Headings are in (-π, π].
#[inline]
fn are_near(one: &Pose, other: &Pose) -> bool {
    let turned = (one.heading - other.heading).abs();
    let is_near = one.position.distance_squared(other.position) < SAME_HYPOTHESIS.0 * SAME_HYPOTHESIS.0;
    is_near & (turned.min((TAU - turned).abs()) < SAME_HYPOTHESIS.1)
}

/// The hypothesis with the greatest weight: mean and covariance of the particles that support it.
pub(super) fn likeliest_hypothesis(particles: &[Particle]) -> Option<PoseEstimate> {
    // Candidates are taken evenly from the list, in which neighbours are often alike.
    let step = particles.len().div_ceil(CANDIDATES).max(1);
    let candidates = || particles.iter().step_by(step).map(|particle| particle.pose);
    // Written without branches, so that several candidates are compared at a time.
    let [mut x, mut y, mut heading, mut weights] = [[0.0; CANDIDATES]; 4];
    for (index, pose) in candidates().enumerate() {
        [x[index], y[index], heading[index]] = [pose.position.x, pose.position.y, pose.heading];
    }
    for Particle { pose, weight } in particles {
        for (sum, ((x, y), heading)) in weights.iter_mut().zip(x.iter().zip(&y).zip(&heading)) {
            *sum += if are_near(pose, &Pose::new(*x, *y, *heading)) { *weight } else { 0.0 };
        }
    }
    let (weight, centre) = weights.into_iter().zip(candidates()).max_by(|(a, _), (b, _)| a.total_cmp(b))?;
    let (mut place, mut heading) = (Vec2::ZERO, 0.0);
    let members = || particles.iter().filter(|particle| are_near(&particle.pose, &centre));
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
    // The weight of other hypotheses makes this one less certain.
    let others = (1.0 - weight).max(0.0);
    let elsewhere = Mat3::from_diagonal(Vec3::new(others, others, 0.3 * others));
    Some(PoseEstimate { pose, covariance: covariance + elsewhere })
}
