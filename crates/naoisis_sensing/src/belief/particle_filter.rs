//! The robot's own pose by a particle filter: many possible poses, weighed by what is seen.
//!
//! Augmented Monte Carlo localisation (Thrun, Burgard, Fox: Probabilistic Robotics, 2005, tables 8.2 and 8.3): particles
//! are carried along by odometry, each with an error of its own, weighed by how likely it makes what is seen, and drawn
//! again by their weights. When what is seen becomes less likely than it was in the long run, new particles are drawn from
//! what is seen alone: so a robot that was carried elsewhere finds itself.
//!
//! Against the [Kalman filter](super::pose_estimate) it can hold several hypotheses at a time, and costs some ten times as
//! much.

use bevy::math::ops;
use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::covariance::inverse;
use super::landmarks::{Landmarks, PitchObservation, seen_goal, sighting_of_mark, sighting_of_post};
use super::line_sighting::SeenLine;
use super::particle_set::{Particle, likeliest_hypothesis, normalise, resample, spread};
use super::pose_estimate::{PoseEstimate, StepError, pose_from_two};
use super::sighting::{Residual, Sighting};
use crate::sensing::vision::{GoalPostPercept, LandmarkKind};
use naoisis_core::geometry::{Pose, angle_of, unit, unrotate, wrap_angle};
use naoisis_core::pitch::{End, GoalColour};
use naoisis_core::random::RandomStream;
use naoisis_core::team::RobotId;

/// How many particles there are.
const COUNT: usize = 100;
/// Cycles between two updates by what is seen: thirty a second would tell hardly more, and weigh it too much.
const CYCLES_PER_UPDATE: usize = 3;
/// Marks on the ground that are used in an update.
const MARKS_PER_UPDATE: usize = 3;
/// Stretches of lines that are used in an update.
const LINES_PER_UPDATE: usize = 1;
/// Beyond this squared Mahalanobis distance, what is seen is taken for something else.
const OUTLIER: f32 = 12.0;
/// How fast the long and the short memory of the likelihood follow.
const MEMORY: [f32; 2] = [0.01, 0.15];
/// The greatest share of particles that are drawn anew in an update.
const MOST_NEW: f32 = 0.3;
/// Standard deviations of the pose of a robot that has lost its way, m and radians.
const LOST_SD: [f32; 2] = [0.5, 0.4];
/// How likely what is seen is for a robot that knows where it is, for a thing.
const LIKELY: f32 = 0.4;
/// After so many updates, with what is seen as likely as this, a robot has found its way.
const SURE_UPDATES: u32 = 8;
const SURE: f32 = 0.15;
/// An update that makes what is seen so likely on average for a thing confirms the pose.
const CONFIRMING: f32 = 0.1;

/// The robot's own pose as a set of particles.
#[derive(Clone, PartialEq, Debug, Reflect, Serialize, Deserialize)]
pub struct ParticleFilter {
    particles: Vec<Particle>,
    /// The long and the short memory of how likely what is seen is.
    likelihood: [f32; 2],
    /// The robot's dice.
    stream: RandomStream,
    /// Where it is, in one.
    estimate: PoseEstimate,
    age_s: f32,
    /// Updates since the particles were gathered.
    looks: u32,
    /// Where the robot would be by its steps alone, on a pitch that looks the same from both ends: of two poses that nothing seen
    /// can tell apart, it is the one nearer to this.
    reckoned: Option<Pose>,
}

impl ParticleFilter {
    /// All particles near a pose, with these deviations, m and radians.
    pub fn around(robot: RobotId, pose: Pose, place_sd: f32, heading_sd: f32) -> Self {
        let mut filter = Self {
            particles: Vec::new(),
            likelihood: [0.0; 2],
            stream: RandomStream::new(0, robot, "particles"),
            estimate: PoseEstimate::new(pose, place_sd, heading_sd),
            age_s: 0.0,
            looks: 0,
            reckoned: None,
        };
        filter.gather_around(pose, place_sd, heading_sd);
        filter
    }

    /// Moves all particles near a pose.
    pub fn gather_around(&mut self, pose: Pose, place_sd: f32, heading_sd: f32) {
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

    /// The particles of a robot that has lost its way: half of them near where it thought that it was, the others anywhere.
    pub fn search(robot: RobotId, pose: Pose, landmarks: &Landmarks) -> Self {
        let mut filter = Self::around(robot, pose, LOST_SD[0], LOST_SD[1]);
        for particle in filter.particles.iter_mut().skip(COUNT / 2) {
            let mut throw = |most: f32| most * (2.0 * filter.stream.uniform() - 1.0);
            let place = Vec2::new(throw(landmarks.carpet().x), throw(landmarks.carpet().y));
            particle.pose = Pose { position: place, heading: throw(core::f32::consts::PI) };
        }
        filter.reckoned = landmarks.are_symmetric().then_some(pose);
        // What it saw was likelier before.
        filter.likelihood = [LIKELY; 2];
        filter
    }

    /// Whether it has found one hypothesis that explains what is seen.
    pub fn is_sure(&self) -> bool {
        let covariance = &self.estimate.covariance;
        let [place, heading] = [covariance.x_axis.x + covariance.y_axis.y, covariance.z_axis.z];
        self.looks > SURE_UPDATES && self.likelihood[1] > SURE && place < 0.05 && heading < 0.02
    }

    /// Half a turn of the pitch away.
    pub fn change_ends(&mut self) {
        for particle in &mut self.particles {
            particle.pose = particle.pose.turned_half();
        }
        self.reckoned = self.reckoned.map(Pose::turned_half);
        self.estimate = self.estimate.turned_half();
    }

    /// Half of the particles at each of two poses.
    pub fn gather_around_either(&mut self, poses: [Pose; 2], place_sd: f32, heading_sd: f32) {
        self.gather_around(poses[0], place_sd, heading_sd);
        for particle in self.particles.iter_mut().skip(COUNT / 2) {
            particle.pose = spread(poses[1], place_sd, heading_sd, &mut self.stream);
        }
    }

    /// Whether every number in it is finite, and there are particles at all.
    pub(super) fn is_finite(&self) -> bool {
        let is_sound = |particle: &Particle| particle.pose.is_finite() && particle.weight.is_finite();
        self.estimate.is_finite() && !self.particles.is_empty() && self.particles.iter().all(is_sound)
    }

    /// Where the robot is, and how certain that is.
    pub fn estimate(&self) -> &PoseEstimate {
        &self.estimate
    }

    /// Since what was seen confirmed it, s.
    pub fn age_s(&self) -> f32 {
        self.age_s
    }

    /// A measured step (in the robot's frame before it) and `duration` seconds later.
    pub fn move_by(&mut self, step: Pose, duration: f32, error: &StepError) {
        self.age_s += duration;
        if step == Pose::default() {
            return;
        }
        self.reckoned = self.reckoned.map(|pose| pose.compose(step));
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

    /// Weighs the particles by what the robot sees of the pitch.
    pub fn correct(&mut self, observation: &PitchObservation) {
        let PitchObservation { percepts, landmarks, own_end, image, turn, model, .. } = *observation;
        if !turn.is_multiple_of(CYCLES_PER_UPDATE) {
            return;
        }
        let lines: Vec<SeenLine> = observation.lines(LINES_PER_UPDATE).filter(SeenLine::is_useful).collect();
        let seen = percepts.goal_posts.len() + observation.marks(MARKS_PER_UPDATE).count() + lines.len();
        if seen == 0 {
            return;
        }
        let posts: Vec<(GoalColour, Sighting)> =
            percepts.goal_posts.iter().map(|post| (post.colour, sighting_of_post(post, image, model))).collect();
        let marks: Vec<(LandmarkKind, Sighting)> =
            observation.marks(MARKS_PER_UPDATE).map(|mark| (mark.kind, sighting_of_mark(mark, model))).collect();
        if let Some(reckoned) = self.reckoned {
            for particle in &mut self.particles {
                particle.pose = nearer_half(particle.pose, reckoned);
            }
        }
        let mut sum = 0.0;
        for particle in &mut self.particles {
            let (position, forward) = (particle.pose.position, particle.pose.forward());
            let expected = |place: Vec2| unrotate(forward, place - position);
            let mut distance = 0.0;
            for (colour, sighting) in &posts {
                distance += nearest(sighting, landmarks.posts(*colour, own_end).map(expected));
            }
            for (kind, sighting) in &marks {
                distance += match *kind {
                    LandmarkKind::Junction { shape } => nearest(sighting, landmarks.junctions(shape).map(expected)),
                    LandmarkKind::PenaltyCross => nearest(sighting, landmarks.crosses().map(expected)),
                    LandmarkKind::CornerArc => nearest(sighting, landmarks.arcs().map(expected)),
                    LandmarkKind::CentreCircle => nearest(sighting, core::iter::once(expected(Vec2::ZERO))),
                    LandmarkKind::Line { .. } => 0.0,
                };
            }
            for line in &lines {
                let candidates = landmarks.lines().iter().filter(|other| line.can_be_of(other, position, forward));
                distance += least(candidates.map(|other| line.residual(other, position, forward)));
            }
            // Errors of neighbouring images have much in common, so that each counts for less.
            let likelihood = ops::exp(-0.25 * distance / (seen as f32).sqrt());
            particle.weight *= likelihood;
            sum += likelihood;
        }
        let mean = sum / self.particles.len() as f32;
        self.looks += 1;
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

    /// Draws particles by their weights where these differ much, and a share of them anew from the goal that is seen.
    fn draw_again(&mut self, new_share: f32, posts: &[GoalPostPercept], landmarks: &Landmarks, own_end: End) {
        let effective = normalise(&mut self.particles);
        let anew = (new_share * COUNT as f32) as usize;
        if effective > 0.5 * COUNT as f32 && anew == 0 {
            return;
        }
        resample(&mut self.particles, &mut self.stream);
        for slot in 0..anew {
            if let Some(pose) = pose_from_posts(posts, landmarks, own_end, &mut self.stream)
                && let Some(particle) = self.particles.get_mut(slot * COUNT / anew.max(1))
            {
                particle.pose = pose;
            }
        }
    }
}

/// A pose, or that turned by half a turn about the centre mark: whichever is nearer to another.
fn nearer_half(pose: Pose, to: Pose) -> Pose {
    /// So far away counts as much as a radian.
    const METRES_PER_RADIAN: f32 = 2.0;
    let off = |pose: Pose| {
        let turn = METRES_PER_RADIAN * wrap_angle(pose.heading - to.heading);
        pose.position.distance_squared(to.position) + turn * turn
    };
    let turned = pose.turned_half();
    if off(turned) < off(pose) { turned } else { pose }
}

/// The squared Mahalanobis distance of a sighting from the likeliest of some places, m, robot frame.
fn nearest(sighting: &Sighting, places: impl Iterator<Item = Vec2>) -> f32 {
    least(places.map(|place| sighting.residual(place)))
}

/// The least of some squared Mahalanobis distances.
fn least(residuals: impl Iterator<Item = Residual>) -> f32 {
    residuals
        .map(|Residual { difference, noise }| {
            // Particles are sparse: with nothing but the camera's error, the true pose would hardly ever be among them.
            let noise = noise + Mat2::from_diagonal(Vec2::splat(2e-3));
            difference.dot(inverse(noise) * difference)
        })
        .fold(OUTLIER, f32::min)
}

/// A pose from which the posts that are seen would be seen there: one pose for a goal, any around a single post.
fn pose_from_posts(
    seen: &[GoalPostPercept],
    landmarks: &Landmarks,
    own_end: End,
    stream: &mut RandomStream,
) -> Option<Pose> {
    let pose = match (seen_goal(seen), seen) {
        (Some([left, right]), _) => {
            let goals: Vec<_> = landmarks.goals(left.colour, own_end).collect();
            // Where both have this colour, it may be either.
            let index = if goals.len() > 1 { (stream.uniform() * goals.len() as f32) as usize } else { 0 };
            let goal = goals.get(index)?;
            let places = [goal.left_post, goal.right_post];
            spread(pose_from_two(places, [left.position_m, right.position_m]), 0.15, 0.06, stream)
        }
        (None, [post, ..]) => {
            let places: Vec<Vec2> = landmarks.posts(post.colour, own_end).collect();
            let place = *places.get((stream.uniform() * places.len() as f32) as usize)?;
            // Somewhere around it, towards the pitch.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::belief::landmarks::LandmarkModel;
    use crate::sensing::vision::Percepts;
    use approx::assert_abs_diff_eq;
    use naoisis_core::camera_model::CameraName;
    use naoisis_core::pitch::{GoalColour, Pitch};
    use naoisis_core::team::Team;

    const IMAGE: Vec2 = Vec2::new(320.0, 240.0);
    const ROBOT: RobotId = RobotId::new(Team::Blue, 2);

    /// The yellow goal, as seen from a pose.
    fn goal_from(pose: Pose) -> Percepts {
        let post = |y| GoalPostPercept {
            camera: CameraName::TOP,
            colour: GoalColour::Yellow,
            pixel: IMAGE / 2.0,
            position_m: pose.inverse_transform_point(Vec2::new(2.975, y)),
        };
        Percepts { goal_posts: vec![post(0.7), post(-0.7)], ..default() }
    }

    fn observe(filter: &mut ParticleFilter, percepts: &Percepts, cycles: usize) {
        let (landmarks, model) = (Landmarks::of(&Pitch::default()), LandmarkModel::default());
        for turn in 0..cycles {
            filter.move_by(Pose::default(), 1.0 / 30.0, &StepError::default());
            let own_end = End::NegativeX;
            filter.correct(&PitchObservation {
                percepts,
                landmarks: &landmarks,
                own_end,
                image: IMAGE,
                turn,
                model: &model,
                camera: None,
            });
        }
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
        let pitch = ron::from_str(include_str!("../../../../assets/fields/spl2025.ron")).unwrap();
        let landmarks = Landmarks::of(&pitch);
        let was = Pose::new(-2.5, 1.0, 2.9);
        let model = LandmarkModel::default();
        for number in 1..=8 {
            let truth = Pose::new(-2.9, 0.6, 2.6);
            let robot = RobotId::new(Team::Blue, number);
            let mut filter = ParticleFilter::search(robot, was, &landmarks);
            let (x, y) = (-pitch.goal_post_x(), pitch.goal.width_m / 2.0);
            let post = |place: Vec2| GoalPostPercept {
                camera: CameraName::TOP,
                colour: pitch.goal_colour(End::NegativeX),
                pixel: Vec2::splat(100.0),
                position_m: truth.inverse_transform_point(place),
            };
            let percepts = Percepts { goal_posts: vec![post(Vec2::new(x, y)), post(Vec2::new(x, -y))], ..default() };
            for turn in 0..90 {
                filter.correct(&PitchObservation {
                    percepts: &percepts,
                    landmarks: &landmarks,
                    own_end: End::NegativeX,
                    image: Vec2::new(320.0, 240.0),
                    turn,
                    model: &model,
                    camera: None,
                });
            }
            let pose = filter.estimate().pose;
            assert!(pose.position.distance(truth.position) < 0.4, "{number} {pose:?}");
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
        // After 1 m the place varies by 0.02 m², and by the heading's 0.005 rad² over the way.
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
