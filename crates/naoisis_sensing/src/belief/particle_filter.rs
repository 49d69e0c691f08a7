//! Localisation by a particle filter: many possible poses, weighted by the sightings.
//!
//! The method is augmented Monte Carlo localisation (Thrun, Burgard, Fox: Probabilistic Robotics, 2005, tables 8.2 and 8.3): particles move
//! with the odometry, each with an error of its own, are weighted by the likelihood of the sightings, and resampled. When the likelihood
//! falls below its long-term mean, new particles are drawn from the sightings alone, so that a robot that was carried away finds its pose.
//!
//! Unlike the [Kalman filter](super::pose_estimate), the filter represents several hypotheses at a time; it is about ten times as costly.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::kalman_localiser::RETURNED_SD;
use super::landmarks::{Landmarks, PitchObservation};
use super::particle_set::{Particle, likeliest_hypothesis, normalise, resample, spread};
use super::particle_sightings::{Sightings, pose_from_posts};
use super::pose_estimate::{PoseEstimate, StepError};
use crate::sensing::vision::GoalPostPercept;
use naoisis_core::geometry::{Pose, wrap_angle};
use naoisis_core::pitch::End;
use naoisis_core::random::RandomStream;
use naoisis_core::team::RobotId;

/// The number of particles.
const COUNT: usize = 100;
/// Number of cycles between two updates by sightings: the errors of successive images are correlated.
const CYCLES_PER_UPDATE: usize = 3;
/// The rates of the long-term and the short-term mean of the likelihood.
const MEMORY: [f32; 2] = [0.01, 0.15];
/// The greatest share of new particles in an update.
const MOST_NEW: f32 = 0.3;
/// Standard deviations of the pose of a lost robot, m and radians.
const LOST_SD: [f32; 2] = [0.5, 0.4];
/// The likelihood per sighting for a robot with a known pose.
const LIKELY: f32 = 0.4;
/// Number of particles near the first of two poses, of which the first is likelier: the robot may have been removed near the middle of the
/// pitch, or it may not have known its position.
pub(super) const LIKELIER: usize = COUNT * 2 / 3;
/// Number of particles near the first of two poses that are equally likely.
pub(super) const EQUALLY_LIKELY: usize = COUNT / 2;
/// The number of updates after which a lost robot may have found its pose.
const SURE_UPDATES: u32 = 8;
/// The likelihood per sighting above which a lost robot has found its pose.
const SURE: f32 = 0.15;
/// The mean likelihood per sighting above which an update confirms the pose.
const CONFIRMING: f32 = 0.1;

/// The distribution of the robot's own pose as a set of particles.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub(crate) struct ParticleFilter {
    particles: Vec<Particle>,
    /// The long-term and the short-term mean of the likelihood.
    likelihood: [f32; 2],
    /// The random numbers of the filter.
    stream: RandomStream,
    /// The likeliest hypothesis.
    estimate: PoseEstimate,
    age_s: f32,
    /// Number of updates since the particles were gathered.
    looks: u32,
    /// The possible poses by odometry alone, on a symmetric pitch. Of two poses that sightings cannot distinguish, the one nearer to one of
    /// these poses is chosen.
    reckoned: Vec<Pose>,
}

impl ParticleFilter {
    /// A filter with all particles near `pose`, with these standard deviations, m and radians.
    pub(crate) fn around(robot: RobotId, pose: Pose, place_sd: f32, heading_sd: f32) -> Self {
        let mut filter = Self {
            particles: Vec::new(),
            likelihood: [0.0; 2],
            stream: RandomStream::new(0, robot, "particles"),
            estimate: PoseEstimate::new(pose, place_sd, heading_sd),
            age_s: 0.0,
            looks: 0,
            reckoned: Vec::new(),
        };
        filter.gather_around(pose, place_sd, heading_sd);
        filter
    }

    /// Moves all particles near `pose`.
    pub(crate) fn gather_around(&mut self, pose: Pose, place_sd: f32, heading_sd: f32) {
        self.particles.clear();
        for _ in 0..COUNT {
            let pose = spread(pose, place_sd, heading_sd, &mut self.stream);
            self.particles.push(Particle { pose, weight: 1.0 / COUNT as f32 });
        }
        self.likelihood = [0.0; 2];
        self.estimate = PoseEstimate::new(pose, place_sd, heading_sd);
        self.age_s = 0.0;
        self.looks = 0;
    }

    /// A filter for a lost robot: half of the particles near its last `pose`, the others anywhere.
    pub(crate) fn search(robot: RobotId, pose: Pose, landmarks: &Landmarks) -> Self {
        let mut filter = Self::around(robot, pose, LOST_SD[0], LOST_SD[1]);
        for particle in filter.particles.iter_mut().skip(COUNT / 2) {
            let mut throw = |most: f32| most * (2.0 * filter.stream.uniform() - 1.0);
            let place = Vec2::new(throw(landmarks.carpet().x), throw(landmarks.carpet().y));
            particle.pose = Pose { position: place, heading: throw(core::f32::consts::PI) };
        }
        if landmarks.are_symmetric() {
            filter.reckoned.push(pose);
        }
        // The likelihood before the robot was lost.
        filter.likelihood = [LIKELY; 2];
        filter
    }

    /// A filter for a robot that returns from a penalty at one of two poses, of which the first is likelier.
    pub(crate) fn returned(robot: RobotId, poses: [Pose; 2], landmarks: &Landmarks) -> Self {
        let mut filter = Self::around(robot, poses[0], RETURNED_SD[0], RETURNED_SD[1]);
        filter.gather_around_either(poses, LIKELIER, RETURNED_SD);
        // Unlikely sightings make it look elsewhere, too.
        filter.likelihood = [LIKELY; 2];
        if landmarks.are_symmetric() {
            filter.reckoned.extend(poses);
        }
        filter
    }

    /// Whether one hypothesis explains the sightings.
    pub(crate) fn is_sure(&self) -> bool {
        let covariance = &self.estimate.covariance;
        let [place, heading] = [covariance.x_axis.x + covariance.y_axis.y, covariance.z_axis.z];
        self.looks > SURE_UPDATES && self.likelihood[1] > SURE && place < 0.05 && heading < 0.02
    }

    /// Rotates all poses by half a turn about the centre mark.
    pub(crate) fn change_ends(&mut self) {
        for particle in &mut self.particles {
            particle.pose = particle.pose.turned_half();
        }
        for pose in &mut self.reckoned {
            *pose = pose.turned_half();
        }
        self.estimate = self.estimate.turned_half();
    }

    /// Moves all particles near one of two poses, `near_first` of them near the first one.
    pub(crate) fn gather_around_either(
        &mut self,
        poses: [Pose; 2],
        near_first: usize,
        [place_sd, heading_sd]: [f32; 2],
    ) {
        self.gather_around(poses[0], place_sd, heading_sd);
        for particle in self.particles.iter_mut().skip(near_first) {
            particle.pose = spread(poses[1], place_sd, heading_sd, &mut self.stream);
        }
    }

    /// Whether there are particles, and every number in the filter is finite.
    pub(super) fn is_finite(&self) -> bool {
        let is_sound = |particle: &Particle| particle.pose.is_finite() && particle.weight.is_finite();
        self.estimate.is_finite() && !self.particles.is_empty() && self.particles.iter().all(is_sound)
    }

    /// The estimate of the pose.
    pub(crate) fn estimate(&self) -> &PoseEstimate {
        &self.estimate
    }

    /// The time since a sighting confirmed the pose, s.
    pub(crate) fn age_s(&self) -> f32 {
        self.age_s
    }

    /// Moves the particles by a measured `step` (in the robot frame before it), `duration` seconds later.
    pub(crate) fn move_by(&mut self, step: Pose, duration: f32, error: &StepError) {
        self.age_s += duration;
        if step == Pose::default() {
            return;
        }
        for pose in &mut self.reckoned {
            *pose = pose.compose(step);
        }
        let length = step.position.length();
        let place_sd = (error.place_per_metre * length).sqrt();
        let heading_variance = error.heading_per_metre * length + error.heading_per_radian * step.heading.abs();
        let heading_sd = heading_variance.sqrt();
        for particle in &mut self.particles {
            let moved = particle.pose.compose(step);
            particle.pose = spread(moved, place_sd, heading_sd, &mut self.stream);
        }
        self.estimate = self.estimate.moved_by(step, error);
    }

    /// Weights the particles by the sightings of a cycle, and resamples them.
    pub(crate) fn correct(&mut self, observation: &PitchObservation) {
        let PitchObservation { percepts, landmarks, own_end, turn, .. } = *observation;
        if !turn.is_multiple_of(CYCLES_PER_UPDATE) {
            return;
        }
        let Some(sightings) = Sightings::of(observation) else { return };
        if !self.reckoned.is_empty() {
            for particle in &mut self.particles {
                particle.pose = nearer_half(particle.pose, &self.reckoned);
            }
        }
        let mut sum = 0.0;
        for particle in &mut self.particles {
            let likelihood = sightings.likelihood_at(particle.pose);
            particle.weight *= likelihood;
            sum += likelihood;
        }
        let mean = sum / self.particles.len() as f32;
        self.looks = self.looks.wrapping_add(1);
        if mean > CONFIRMING {
            self.age_s = 0.0;
        }
        let [long, short] = &mut self.likelihood;
        *long = if *long == 0.0 { mean } else { *long + MEMORY[0] * (mean - *long) };
        *short = if *short == 0.0 { mean } else { *short + MEMORY[1] * (mean - *short) };
        let lost = (1.0 - *short / long.max(1e-6)).clamp(0.0, MOST_NEW);
        self.draw_again(lost, &percepts.goal_posts, landmarks, own_end);
        if let Some(estimate) = likeliest_hypothesis(&self.particles) {
            self.estimate = estimate;
        }
    }

    /// Resamples the particles if their weights differ much, and replaces the share `new_share` of them by poses that follow from the goal
    /// in view.
    fn draw_again(&mut self, new_share: f32, posts: &[GoalPostPercept], landmarks: &Landmarks, own_end: End) {
        let effective = normalise(&mut self.particles);
        let count_new = (new_share * COUNT as f32) as usize;
        if effective > 0.5 * COUNT as f32 && count_new == 0 {
            return;
        }
        resample(&mut self.particles, &mut self.stream);
        for slot in 0..count_new {
            if let Some(pose) = pose_from_posts(posts, landmarks, own_end, &mut self.stream)
                && let Some(particle) = self.particles.get_mut(slot * COUNT / count_new.max(1))
            {
                particle.pose = pose;
            }
        }
    }
}

/// Returns `pose`, or `pose` rotated by half a turn about the centre mark, the one that is nearer to a pose of `reckoned`.
fn nearer_half(pose: Pose, reckoned: &[Pose]) -> Pose {
    /// The distance that is equivalent to a radian, m.
    const METRES_PER_RADIAN: f32 = 2.0;
    let off = |pose: Pose| {
        let from = |to: &Pose| {
            let turn = METRES_PER_RADIAN * wrap_angle(pose.heading - to.heading);
            pose.position.distance_squared(to.position) + turn * turn
        };
        reckoned.iter().map(from).fold(f32::INFINITY, f32::min)
    };
    let turned = pose.turned_half();
    if off(turned) < off(pose) { turned } else { pose }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::landmarks::{LandmarkModel, waiting_poses};
    use crate::belief::localisation_method::LocalisationMethod;
    use crate::belief::localiser::Localiser;
    use crate::sensing::vision::Percepts;
    use approx::assert_abs_diff_eq;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::geometry::unit;
    use naoisis_core::pitch::{GoalColour, Pitch};
    use naoisis_core::team::Team;

    const IMAGE: Vec2 = Vec2::new(320.0, 240.0);
    const ROBOT: RobotId = RobotId::new(Team::Blue, 2);

    /// The yellow goal, as seen from a pose.
    fn goal_from(pose: Pose) -> Percepts {
        let post = |y| {
            let position_m = pose.inverse_transform_point(Vec2::new(2.975, y));
            GoalPostPercept::new(CameraName::TOP, GoalColour::Yellow, IMAGE / 2.0, position_m)
        };
        Percepts { goal_posts: vec![post(0.7), post(-0.7)], ..default() }
    }

    /// A pitch whose ends look the same.
    fn spl2025() -> Pitch {
        ron::Options::default()
            .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
            .from_str(include_str!("../../../../assets/fields/spl2025.ron"))
            .unwrap()
    }

    /// The own goal, as seen from a pose.
    fn own_goal_from(pose: Pose, pitch: &Pitch) -> Percepts {
        let (x, y) = (-pitch.goal_post_x(), pitch.goal.width_m / 2.0);
        let post = |place: Vec2| {
            let (colour, position_m) = (pitch.goal_colour(End::NegativeX), pose.inverse_transform_point(place));
            GoalPostPercept::new(CameraName::TOP, colour, Vec2::splat(100.0), position_m)
        };
        Percepts { goal_posts: vec![post(Vec2::new(x, y)), post(Vec2::new(x, -y))], ..default() }
    }

    /// Calls `correct` with the same observation in each of these cycles.
    fn observe_with(
        percepts: &Percepts,
        landmarks: &Landmarks,
        cycles: usize,
        mut correct: impl FnMut(&PitchObservation),
    ) {
        let model = LandmarkModel::default();
        let own_end = End::NegativeX;
        for turn in 0..cycles {
            correct(&PitchObservation {
                percepts,
                landmarks,
                own_end,
                image: IMAGE,
                turn,
                model: &model,
                camera: None,
            });
        }
    }

    fn observe(filter: &mut ParticleFilter, percepts: &Percepts, cycles: usize) {
        observe_with(percepts, &Landmarks::of(&Pitch::default()), cycles, |observation| {
            filter.move_by(Pose::default(), 1.0 / 30.0, &StepError::default());
            filter.correct(observation);
        });
    }

    #[test]
    fn a_goal_tells_a_robot_that_hardly_knows_where_it_is() {
        let truth = Pose::new(0.5, 0.4, -0.1);
        let mut filter = ParticleFilter::around(ROBOT, Pose::new(0.3, 0.0, 0.1), 0.4, 0.3);
        observe(&mut filter, &goal_from(truth), 60);
        assert_abs_diff_eq!(filter.estimate().pose.position, truth.position, epsilon = 0.2);
        assert_abs_diff_eq!(filter.estimate().pose.heading, truth.heading, epsilon = 0.06);
        assert_eq!(filter.age_s(), 2.0 / 30.0);
    }

    #[test]
    fn where_both_ends_look_the_same_a_lost_robot_is_at_the_one_where_it_was() {
        let pitch = spl2025();
        let landmarks = Landmarks::of(&pitch);
        let was = Pose::new(-2.5, 1.0, 2.9);
        for number in 1..=8 {
            let truth = Pose::new(-2.9, 0.6, 2.6);
            let robot = RobotId::new(Team::Blue, number);
            let mut filter = ParticleFilter::search(robot, was, &landmarks);
            let percepts = own_goal_from(truth, &pitch);
            observe_with(&percepts, &landmarks, 90, |observation| filter.correct(observation));
            let pose = filter.estimate().pose;
            assert!(pose.position.distance(truth.position) < 0.4, "{number} {pose:?}");
        }
    }

    #[test]
    fn a_robot_that_returns_at_either_side_sees_which_one_it_is() {
        let pitch = spl2025();
        let landmarks = Landmarks::of(&pitch);
        for number in 1..=8 {
            for (believed_y, side) in [(0.3, 0), (0.3, 1), (-2.5, 0), (-2.5, 1)] {
                let truth = waiting_poses(&landmarks, believed_y)[side].compose(Pose::new(0.2, -0.3, 0.1));
                let robot = RobotId::new(Team::Blue, number);
                let mut own = Localiser::placed(LocalisationMethod::Unscented, robot, Pose::new(-1.0, believed_y, 0.0));
                own.come_back_where_it_waited(robot, &landmarks);
                let percepts = own_goal_from(truth, &pitch);
                observe_with(&percepts, &landmarks, 120, |observation| own.correct(robot, observation));
                let pose = own.estimate().pose;
                let is_found = matches!(own, Localiser::Kalman(_)) && pose.position.distance(truth.position) < 0.2;
                assert!(is_found, "robot {number} at side {side} of {believed_y}: {pose:?}");
            }
        }
    }

    #[test]
    fn a_robot_that_was_carried_elsewhere_finds_itself() {
        let mut filter = ParticleFilter::around(ROBOT, Pose::new(-1.0, 0.5, 0.0), 0.05, 0.03);
        observe(&mut filter, &goal_from(Pose::new(-1.0, 0.5, 0.0)), 60);
        let truth = Pose::new(1.2, -1.0, 0.5);
        observe(&mut filter, &goal_from(truth), 240);
        assert_abs_diff_eq!(filter.estimate().pose.position, truth.position, epsilon = 0.2);
        assert_abs_diff_eq!(filter.estimate().pose.heading, truth.heading, epsilon = 0.08);
    }

    #[test]
    fn steps_move_all_particles_and_uncertainty_grows_with_the_way() {
        let mut filter = ParticleFilter::around(ROBOT, Pose::new(0.0, 0.0, 0.3), 0.0, 0.0);
        for _ in 0..100 {
            filter.move_by(Pose::new(0.01, 0.0, 0.0), 1.0 / 30.0, &StepError::default());
        }
        let estimate = likeliest_hypothesis(&filter.particles).unwrap();
        assert_abs_diff_eq!(estimate.pose.position, unit(0.3), epsilon = 0.06);
        // After 1 m the position varies by 0.02 m², and by the heading's 0.005 rad² over the path.
        assert!((0.008..0.05).contains(&estimate.covariance.x_axis.x), "{:?}", estimate.covariance);
    }

    #[test]
    fn the_dice_are_the_robots_own_and_fall_the_same_again() {
        let run = |robot| {
            let mut filter = ParticleFilter::around(robot, Pose::default(), 0.3, 0.2);
            observe(&mut filter, &goal_from(Pose::new(0.2, 0.1, 0.0)), 30);
            filter.estimate().pose
        };
        assert_eq!(run(ROBOT), run(ROBOT));
        assert_ne!(run(ROBOT), run(RobotId::new(Team::Blue, 3)));
    }
}
