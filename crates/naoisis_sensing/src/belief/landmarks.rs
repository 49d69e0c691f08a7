//! The landmarks of a pitch: goal posts, junctions, penalty crosses and lines, and their sightings.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::camera_error::CameraMotion;
use super::line_sighting::{PitchLine, SeenLine};
use super::point_team_from_pitch;
use super::sighting::{LENS_HEIGHT_M, Sighting};
use crate::sensing::vision::{GoalPostPercept, LandmarkKind, LandmarkPercept, Percepts};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::{End, GoalColour, JunctionShape, Pitch};

/// The distance of a waiting robot from the side line, m (2025 rule book).
const WAITING_DISTANCE_M: f32 = 0.5;
/// The factor on the error of the distance of a post whose foot is not in the image.
const HIDDEN_FOOT_FACTOR: f32 = 4.0;

/// The measurement model of landmarks.
#[derive(Clone, Copy, PartialEq, Debug, Reflect, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LandmarkModel {
    /// Standard deviation of the angles to a goal post's foot, or to the centre of the centre circle, radians. 3 pixels at a focal length of
    /// 361 pixels are 0.0083.
    pub goal_post_angle_sd: f32,
    /// Standard deviation of the angles to junctions and crosses, radians.
    pub mark_angle_sd: f32,
    /// Standard deviation of the angles to the ends of lines, radians.
    pub line_angle_sd: f32,
    /// The gate: a sighting further from the expectation than this is rejected. Squared Mahalanobis distance.
    pub gate: f32,
    /// The height of the robot's cameras, m. Set from its model.
    #[serde(skip)]
    pub lens_height_m: f32,
    /// The excess of landmarks out of place over those in place from which the pose counts as wrong.
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

/// The factor on the errors of landmarks for cameras with a lasting error: the part that its estimate does not explain is correlated
/// between images, which the filter neglects. With this factor the truth is within the 95 % ellipse in 90 to 94 % of the cycles of
/// realistic matches.
const ROCKING_FACTOR: f32 = 1.7;

impl LandmarkModel {
    /// The model for cameras with a lasting error.
    pub(super) fn of_rocking_cameras(&self) -> Self {
        Self {
            goal_post_angle_sd: self.goal_post_angle_sd * ROCKING_FACTOR,
            mark_angle_sd: self.mark_angle_sd * ROCKING_FACTOR,
            line_angle_sd: self.line_angle_sd * ROCKING_FACTOR,
            ..*self
        }
    }

    /// The model for cameras whose error is not estimated: it is added to the errors of all landmarks.
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

/// A goal, as seen from inside the pitch.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct GoalLandmark {
    pub(super) colour: GoalColour,
    pub(super) left_post: Vec2,
    pub(super) right_post: Vec2,
}

impl GoalLandmark {
    /// The goal as seen from `place` (m, team frame): left and right are exchanged if it is seen from behind.
    pub(super) fn seen_from(self, place: Vec2) -> Self {
        let is_behind = (place.x - self.left_post.x) * self.left_post.x > 0.0;
        if is_behind { Self { left_post: self.right_post, right_post: self.left_post, ..self } } else { self }
    }
}

/// The positions of all landmarks, in the frame of the team that defends -x. Marks on the ground have the same positions for the other
/// team, as the pitch is symmetric.
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
    /// The landmarks of `pitch`.
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

    /// Whether the pitch looks the same from both ends, because both goals have the same colour.
    pub(super) fn are_symmetric(&self) -> bool {
        self.goals[0].colour == self.goals[1].colour
    }

    /// The positions of the posts of this colour, in the frame of the team that defends `own_end`, m.
    pub(super) fn posts(&self, colour: GoalColour, own_end: End) -> impl Iterator<Item = Vec2> {
        self.goals(colour, own_end).flat_map(|goal| [goal.left_post, goal.right_post])
    }

    /// The positions of the junctions of this shape, m.
    pub(super) fn junctions(&self, shape: JunctionShape) -> impl Iterator<Item = Vec2> {
        self.junctions.iter().filter(move |(other, _)| *other == shape).map(|(_, place)| *place)
    }

    /// The positions of the penalty crosses, m.
    pub(super) fn crosses(&self) -> impl Iterator<Item = Vec2> {
        self.crosses.into_iter()
    }

    /// The positions of the corners with arcs, m.
    pub(super) fn arcs(&self) -> impl Iterator<Item = Vec2> {
        self.arcs.iter().copied()
    }

    /// The straight lines of the pitch, m, team frame.
    pub(super) fn lines(&self) -> &[PitchLine] {
        &self.lines
    }

    /// Half the length and width of the carpet, m.
    pub(super) fn carpet(&self) -> Vec2 {
        self.carpet_half_extents
    }

    /// Whether `place` is on the carpet, m.
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

/// The sightings of a cycle, and the model with which they are used.
#[derive(Clone, Copy, Debug)]
pub struct PitchObservation<'a> {
    /// The percepts of the robot.
    pub percepts: &'a Percepts,
    /// The landmarks of the pitch.
    pub landmarks: &'a Landmarks,
    /// The end that the robot's team defends.
    pub own_end: End,
    /// The size of the cameras' images, pixels.
    pub image: Vec2,
    /// The number of the cycle, which selects the landmarks in turn.
    pub turn: usize,
    /// The measurement model.
    pub model: &'a LandmarkModel,
    /// The motion of cameras with a lasting error; `None` if they have none.
    pub camera: Option<CameraMotion>,
}

impl<'a> PitchObservation<'a> {
    /// Up to `most` of the junctions, crosses and circles in view.
    pub(super) fn marks(&self, most: usize) -> impl Iterator<Item = &'a LandmarkPercept> {
        self.in_turn(most, |mark| !matches!(mark.kind, LandmarkKind::Line { .. }))
    }

    /// Up to `most` of the line segments in view.
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

/// The pose of a robot that returns from a penalty at the halfway line: at the end away from the ball (m, team frame).
pub(super) fn halfway_pose(landmarks: &Landmarks, ball: Option<Vec2>) -> Pose {
    let side = if ball.is_some_and(|ball| ball.y > 0.0) { -1.0 } else { 1.0 };
    Pose::new(0.0, side * landmarks.half_width, -side * core::f32::consts::FRAC_PI_2)
}

/// The poses of a robot that was removed at about `y` and waits beyond a side line, level with its own penalty mark, facing the pitch (2025
/// rule book): beyond the nearer side line, and beyond the other.
pub(super) fn waiting_poses(landmarks: &Landmarks, y: f32) -> [Pose; 2] {
    let nearer = if y < 0.0 { -1.0 } else { 1.0 };
    let x = -landmarks.crosses[1].x.abs();
    let beyond = WAITING_DISTANCE_M.min(landmarks.carpet_half_extents.y - landmarks.half_width);
    [nearer, -nearer]
        .map(|side| Pose::new(x, side * (landmarks.half_width + beyond), -side * core::f32::consts::FRAC_PI_2))
}

/// The sighting of a goal post.
pub(super) fn sighting_of_post(post: &GoalPostPercept, image: Vec2, model: &LandmarkModel) -> Sighting {
    let foot_in_image = post.pixel.cmpge(Vec2::ZERO).all() && post.pixel.cmple(image).all();
    let distance_factor = if foot_in_image { 1.0 } else { HIDDEN_FOOT_FACTOR };
    Sighting {
        distance_factor,
        lens_height_m: model.lens_height_m,
        ..Sighting::new(post.position_m, model.goal_post_angle_sd)
    }
}

/// The sighting of a junction, a cross, a corner arc or the centre circle.
pub(super) fn sighting_of_mark(mark: &LandmarkPercept, model: &LandmarkModel) -> Sighting {
    let is_circle = mark.kind == LandmarkKind::CentreCircle;
    let angle_sd = if is_circle { model.goal_post_angle_sd } else { model.mark_angle_sd };
    Sighting::new(mark.position_m, angle_sd).from_height(model.lens_height_m)
}

/// The left and the right post of a goal, if exactly two posts are in view and have the same colour.
pub(super) fn seen_goal(posts: &[GoalPostPercept]) -> Option<[&GoalPostPercept; 2]> {
    let [first, second] = posts else { return None };
    let is_first_left = first.position_m.perp_dot(second.position_m) < 0.0;
    let goal = if is_first_left { [first, second] } else { [second, first] };
    (first.colour == second.colour).then_some(goal)
}
