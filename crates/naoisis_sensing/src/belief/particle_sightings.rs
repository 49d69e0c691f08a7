//! The information of sightings about the pose of a particle: their likelihood from a pose, and the poses from which they could be seen.

use bevy::math::ops;
use bevy::prelude::*;

use super::covariance::inverse;
use super::landmarks::{Landmarks, PitchObservation, seen_goal, sighting_of_mark, sighting_of_post};
use super::line_sighting::SeenLine;
use super::particle_set::spread;
use super::pose_estimate::pose_from_two;
use super::sighting::{Residual, Sighting};
use crate::sensing::vision::{GoalPostPercept, LandmarkKind};
use naoisis_core::geometry::{Pose, angle_of, unit, unrotate, wrap_angle};
use naoisis_core::pitch::{End, GoalColour};
use naoisis_core::random::RandomStream;

/// The greatest number of marks that are used in an update.
const MARKS_PER_UPDATE: usize = 3;
/// The greatest number of line segments that are used in an update.
const LINES_PER_UPDATE: usize = 1;
/// The squared Mahalanobis distance beyond which a sighting counts as an outlier.
const OUTLIER: f32 = 12.0;

/// The sightings of a cycle that are used in an update.
pub(super) struct Sightings<'a> {
    landmarks: &'a Landmarks,
    own_end: End,
    posts: Vec<(GoalColour, Sighting)>,
    marks: Vec<(LandmarkKind, Sighting)>,
    lines: Vec<SeenLine>,
}

impl<'a> Sightings<'a> {
    /// The sightings of an observation; `None` if there are none.
    pub(super) fn of(observation: &PitchObservation<'a>) -> Option<Self> {
        let PitchObservation { percepts, landmarks, own_end, image, model, .. } = *observation;
        let posts =
            percepts.goal_posts.iter().map(|post| (post.colour, sighting_of_post(post, image, model))).collect();
        let marks =
            observation.marks(MARKS_PER_UPDATE).map(|mark| (mark.kind, sighting_of_mark(mark, model))).collect();
        let lines = observation.lines(LINES_PER_UPDATE).filter(SeenLine::is_useful).collect();
        let sightings = Self { landmarks, own_end, posts, marks, lines };
        (sightings.count() > 0).then_some(sightings)
    }

    fn count(&self) -> usize {
        self.posts.len() + self.marks.len() + self.lines.len()
    }

    /// The likelihood of the sightings from `pose`, team frame.
    pub(super) fn likelihood_at(&self, pose: Pose) -> f32 {
        let Self { landmarks, own_end, .. } = *self;
        let (position, forward) = (pose.position, pose.forward());
        let expected = |place: Vec2| unrotate(forward, place - position);
        let mut distance = 0.0;
        for (colour, sighting) in &self.posts {
            distance += nearest(sighting, landmarks.posts(*colour, own_end).map(expected));
        }
        for (kind, sighting) in &self.marks {
            distance += match *kind {
                LandmarkKind::Junction { shape } => nearest(sighting, landmarks.junctions(shape).map(expected)),
                LandmarkKind::PenaltyCross => nearest(sighting, landmarks.crosses().map(expected)),
                LandmarkKind::CornerArc => nearest(sighting, landmarks.arcs().map(expected)),
                LandmarkKind::CentreCircle => nearest(sighting, core::iter::once(expected(Vec2::ZERO))),
                LandmarkKind::Line { .. } => 0.0,
            };
        }
        for line in &self.lines {
            let candidates = landmarks.lines().iter().filter(|other| line.can_be_of(other, position, forward));
            distance += least(candidates.map(|other| line.residual(other, position, forward)));
        }
        // The errors of successive images are correlated, so each sighting counts for less.
        ops::exp(-0.25 * distance / (self.count() as f32).sqrt())
    }
}

/// The squared Mahalanobis distance of a sighting from the likeliest of these positions, m, robot frame.
fn nearest(sighting: &Sighting, places: impl Iterator<Item = Vec2>) -> f32 {
    least(places.map(|place| sighting.residual(place)))
}

/// The least squared Mahalanobis distance of these residuals, at most [`OUTLIER`].
fn least(residuals: impl Iterator<Item = Residual>) -> f32 {
    residuals
        .map(|Residual { difference, noise }| {
            // Particles are sparse: with the camera's error alone, hardly any of them would match the true pose.
            let noise = noise + Mat2::from_diagonal(Vec2::splat(2e-3));
            difference.dot(inverse(noise) * difference)
        })
        .fold(OUTLIER, f32::min)
}

/// Draws a random pose from which the posts in view would be seen at their positions: near one pose for a goal, anywhere around a single
/// post.
pub(super) fn pose_from_posts(
    seen: &[GoalPostPercept],
    landmarks: &Landmarks,
    own_end: End,
    stream: &mut RandomStream,
) -> Option<Pose> {
    let pose = match (seen_goal(seen), seen) {
        (Some([left, right]), _) => {
            let goals: Vec<_> = landmarks.goals(left.colour, own_end).collect();
            // If both goals have this colour, it may be either.
            let index = if goals.len() > 1 { (stream.uniform() * goals.len() as f32) as usize } else { 0 };
            let goal = goals.get(index)?;
            let places = [goal.left_post, goal.right_post];
            spread(pose_from_two(places, [left.position_m, right.position_m]), 0.15, 0.06, stream)
        }
        (None, [post, ..]) => {
            let places: Vec<Vec2> = landmarks.posts(post.colour, own_end).collect();
            let place = *places.get((stream.uniform() * places.len() as f32) as usize)?;
            // Anywhere around the post, looking towards the pitch.
            let inwards = angle_of(-place) + (stream.uniform() - 0.5) * core::f32::consts::PI;
            let distance = post.position_m.length() * (1.0 + stream.gaussian(0.1));
            let position = place + unit(inwards) * distance;
            let heading = wrap_angle(angle_of(place - position) - angle_of(post.position_m));
            Pose { position, heading }
        }
        (None, []) => return None,
    };
    landmarks.is_on_carpet(pose.position).then_some(pose)
}
