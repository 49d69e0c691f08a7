//! What is known of a pitch and can be seen of it: goal posts, junctions, crosses, lines.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::camera_error::CameraMotion;
use super::line_sighting::{PitchLine, SeenLine};
use super::point_team_from_pitch;
use super::sighting::{LENS_HEIGHT_M, Sighting};
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, LandmarkPercept, Percepts};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::{End, GoalColour, JunctionShape, Pitch};

/// Distance of a waiting robot from the side line, m (2025 rule book).
const WAITING_DISTANCE_M: f32 = 0.5;
/// A post whose foot is not in the image is measured by its top or its width, so much worse.
const HIDDEN_FOOT_FACTOR: f32 = 4.0;

/// How landmarks are used.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkModel {
    /// Expected error of the angles at which a goal post's foot, or the centre circle's middle, is seen: standard
    /// deviation, radians. 3 pixels at 361 pixels of focal length are 0.0083.
    pub goal_post_angle_sd: f32,
    /// The same for junctions and crosses, radians.
    pub mark_angle_sd: f32,
    /// The same for the ends of lines, radians.
    pub line_angle_sd: f32,
    /// What is seen further from the expectation than this is not the landmark that it is taken for: squared
    /// Mahalanobis distance.
    pub gate: f32,
    /// How high the robot's cameras are, m. Read of its model.
    #[serde(skip)]
    pub lens_height_m: f32,
    /// After so many landmarks more out of place than in place, the robot takes its pose for wrong.
    pub contradictions: u32,
}

impl Default for LandmarkModel {
    fn default() -> Self {
        Self {
            goal_post_angle_sd: 0.01,
            mark_angle_sd: 0.005,
            line_angle_sd: 0.008,
            gate: 12.0,
            lens_height_m: LENS_HEIGHT_M,
            contradictions: 6,
        }
    }
}

/// How much worse landmarks are where cameras err than each of them alone: what the estimate of that error does not explain is alike
/// in several images, and counts as if it were not. By this factor the truth is within ellipses of 95 % about as often as it should
/// be: in 90 to 94 % of the cycles of realistic matches.
const ROCKING_FACTOR: f32 = 1.7;

impl LandmarkModel {
    /// The same where cameras rock with the walk.
    pub(super) fn of_rocking_cameras(&self) -> Self {
        Self {
            goal_post_angle_sd: self.goal_post_angle_sd * ROCKING_FACTOR,
            mark_angle_sd: self.mark_angle_sd * ROCKING_FACTOR,
            line_angle_sd: self.line_angle_sd * ROCKING_FACTOR,
            ..*self
        }
    }

    /// The same for cameras whose error is not estimated: everything seen is so much less certain.
    pub(super) fn with_camera_error(&self, camera: &CameraMotion) -> Self {
        let error = camera.total_sd();
        let wider = |sd: f32| (sd * sd + error * error).sqrt();
        Self {
            goal_post_angle_sd: wider(self.goal_post_angle_sd),
            mark_angle_sd: wider(self.mark_angle_sd),
            line_angle_sd: wider(self.line_angle_sd),
            ..*self
        }
    }
}

/// A goal, seen from inside the pitch.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct GoalLandmark {
    pub(super) colour: GoalColour,
    pub(super) left_post: Vec2,
    pub(super) right_post: Vec2,
}

impl GoalLandmark {
    /// The same for a robot at `place` (m, team frame): who is behind the goal sees its posts the other way round.
    pub(super) fn seen_from(self, place: Vec2) -> Self {
        let is_behind = (place.x - self.left_post.x) * self.left_post.x > 0.0;
        if is_behind { Self { left_post: self.right_post, right_post: self.left_post, ..self } } else { self }
    }
}

/// The places of all landmarks, in the frame of the team that defends -x. Marks on the ground have the same places for
/// the other team, as the pitch looks the same from both ends.
#[derive(Clone, PartialEq, Debug)]
pub struct Landmarks {
    junctions: Vec<(JunctionShape, Vec2)>,
    crosses: [Vec2; 2],
    arcs: Vec<Vec2>,
    lines: Vec<PitchLine>,
    goals: [GoalLandmark; 2],
    carpet_half_extents: Vec2,
    half_width: f32,
}

impl Landmarks {
    /// Those of a pitch.
    pub fn of(pitch: &Pitch) -> Self {
        let [negative_cross, positive_cross, _] = pitch.marks();
        let goal = |end: End| {
            let [x, y] = [end.sign() * pitch.goal_post_x(), end.sign() * pitch.goal.width_m / 2.0];
            GoalLandmark { colour: pitch.goal_colour(end), left_post: Vec2::new(x, y), right_post: Vec2::new(x, -y) }
        };
        Self {
            junctions: pitch.line_junctions().iter().map(|junction| (junction.shape, junction.position)).collect(),
            crosses: [negative_cross, positive_cross],
            arcs: pitch.corner_arcs().iter().map(|arc| arc.corner).collect(),
            lines: pitch.line_segments().into_iter().map(PitchLine::from).collect(),
            goals: End::BOTH.map(goal),
            carpet_half_extents: pitch.carpet_half_extents(),
            half_width: pitch.half_width(),
        }
    }

    /// Whether the pitch looks the same from both ends: both goals have one colour.
    pub(super) fn are_symmetric(&self) -> bool {
        self.goals[0].colour == self.goals[1].colour
    }

    /// The posts of this colour, in the frame of the team that defends `own_end`, m.
    pub(super) fn posts(&self, colour: GoalColour, own_end: End) -> impl Iterator<Item = Vec2> {
        self.goals(colour, own_end).flat_map(|goal| [goal.left_post, goal.right_post])
    }

    /// The junctions of this shape, m.
    pub(super) fn junctions(&self, shape: JunctionShape) -> impl Iterator<Item = Vec2> {
        self.junctions.iter().filter(move |(other, _)| *other == shape).map(|(_, place)| *place)
    }

    /// The penalty crosses, m.
    pub(super) fn crosses(&self) -> impl Iterator<Item = Vec2> {
        self.crosses.into_iter()
    }

    /// The corners about which arcs are painted, m.
    pub(super) fn arcs(&self) -> impl Iterator<Item = Vec2> {
        self.arcs.iter().copied()
    }

    /// The lines of the pitch, straight ones only, m, team frame.
    pub(super) fn lines(&self) -> &[PitchLine] {
        &self.lines
    }

    /// Half the carpet's length and width, m.
    pub(super) fn carpet(&self) -> Vec2 {
        self.carpet_half_extents
    }

    /// Whether a robot could stand at a place, m.
    pub(super) fn is_on_carpet(&self, place: Vec2) -> bool {
        place.abs().cmplt(self.carpet_half_extents).all()
    }

    /// The goals of this colour, in the frame of the team that defends `own_end`.
    pub(super) fn goals(&self, colour: GoalColour, own_end: End) -> impl Iterator<Item = GoalLandmark> {
        let in_team = move |place| point_team_from_pitch(place, own_end);
        self.goals.into_iter().filter(move |goal| goal.colour == colour).map(move |goal| GoalLandmark {
            left_post: in_team(goal.left_post),
            right_post: in_team(goal.right_post),
            ..goal
        })
    }
}

/// What a robot sees of the pitch in a cycle, and how that is to be used.
#[derive(Clone, Copy, Debug)]
pub struct PitchObservation<'a> {
    /// What its cameras recognised.
    pub percepts: &'a Percepts,
    /// What there is to be seen.
    pub landmarks: &'a Landmarks,
    /// Which end the robot's team defends.
    pub own_end: End,
    /// The size of the cameras' images, pixels.
    pub image: Vec2,
    /// Counts the cycles, so that everything that is seen gets its turn.
    pub turn: usize,
    /// How landmarks are used.
    pub model: &'a LandmarkModel,
    /// How the cameras err for longer than an image; none if they do not.
    pub camera: Option<CameraMotion>,
}

impl<'a> PitchObservation<'a> {
    /// Up to `most` of the junctions, crosses and circles that are seen.
    pub(super) fn marks(&self, most: usize) -> impl Iterator<Item = &'a LandmarkPercept> {
        self.in_turn(most, |mark| !matches!(mark.kind, LandmarkKind::Line { .. }))
    }

    /// Up to `most` of the stretches of lines that are seen.
    pub(super) fn lines(&self, most: usize) -> impl Iterator<Item = SeenLine> {
        let LandmarkModel { line_angle_sd: angle_sd, lens_height_m, .. } = *self.model;
        self.in_turn(most, |mark| matches!(mark.kind, LandmarkKind::Line { .. })).filter_map(move |mark| {
            let LandmarkKind::Line { end_position_m, .. } = mark.kind else { return None };
            Some(SeenLine::new([mark.position_m, end_position_m], angle_sd, lens_height_m))
        })
    }

    fn in_turn(
        &self,
        most: usize,
        wanted: impl Fn(&LandmarkPercept) -> bool + Copy,
    ) -> impl Iterator<Item = &'a LandmarkPercept> {
        let all = self.percepts.landmarks.iter();
        let count = all.clone().filter(|mark| wanted(mark)).count();
        all.filter(move |mark| wanted(mark)).cycle().skip(self.turn % count.max(1)).take(count.min(most))
    }
}

/// Where a penalised robot comes back on the halfway line: at the end away from the ball (m, team frame).
pub(super) fn halfway_pose(landmarks: &Landmarks, ball: Option<Vec2>) -> Pose {
    let side = if ball.is_some_and(|ball| ball.y > 0.0) { -1.0 } else { 1.0 };
    Pose::new(0.0, side * landmarks.half_width, -side * core::f32::consts::FRAC_PI_2)
}

/// Where a robot that was removed from `y` waits, beyond the side line.
pub(super) fn waiting_pose(landmarks: &Landmarks, y: f32) -> Pose {
    let side = if y < 0.0 { -1.0 } else { 1.0 };
    let x = -landmarks.crosses[1].x.abs();
    let beyond = WAITING_DISTANCE_M.min(landmarks.carpet_half_extents.y - landmarks.half_width);
    Pose::new(x, side * (landmarks.half_width + beyond), -side * core::f32::consts::FRAC_PI_2)
}

/// What the measured place of a post is worth.
pub(super) fn sighting_of_post(post: &GoalPostPercept, image: Vec2, model: &LandmarkModel) -> Sighting {
    let foot_in_image = post.pixel.cmpge(Vec2::ZERO).all() && post.pixel.cmple(image).all();
    let distance_factor = if foot_in_image { 1.0 } else { HIDDEN_FOOT_FACTOR };
    Sighting {
        distance_factor,
        lens_height_m: model.lens_height_m,
        ..Sighting::new(post.position_m, model.goal_post_angle_sd)
    }
}

/// What the measured place of a junction, a cross, a corner with its arc or the centre circle is worth.
pub(super) fn sighting_of_mark(mark: &LandmarkPercept, model: &LandmarkModel) -> Sighting {
    let is_circle = mark.kind == LandmarkKind::CentreCircle;
    let angle_sd = if is_circle { model.goal_post_angle_sd } else { model.mark_angle_sd };
    Sighting::new(mark.position_m, angle_sd).from_height(model.lens_height_m)
}

/// The left and the right post of a goal, if no others are seen: of two of one colour, it is beyond doubt which is which.
pub(super) fn seen_goal(posts: &[GoalPostPercept]) -> Option<[&GoalPostPercept; 2]> {
    let [first, second] = posts else { return None };
    let is_first_left = first.position_m.perp_dot(second.position_m) < 0.0;
    let goal = if is_first_left { [first, second] } else { [second, first] };
    (first.colour == second.colour).then_some(goal)
}
