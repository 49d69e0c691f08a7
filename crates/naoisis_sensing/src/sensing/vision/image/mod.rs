//! The image vision: detects objects in RGB images alone, with the methods of 2011.
//!
//! Each pixel's colour is looked up in a table of classes; connected pixels of one class form a blob; and blobs are classified by shape,
//! size and distance, with the [`ObjectModel`]:
//!
//! | class | cue | located by |
//! |---|---|---|
//! | ball | orange disc, or white disc with dark patches, of the size of a ball at that place | its centre, a ball's radius above the ground |
//! | goal post | upright strip of a goal's colour | its foot if green is below; otherwise its width |
//! | robot | waistband or jersey in the team's colour, of the size of one of the team's robots at that place | the band's lower edge; the upper one if that is cut off |
//! | robot in black, white, grey or brown | a body on the field: trunk in that colour, other colours about it, legs that end on the carpet | where the body fits best |
//! | line | white between green, about as wide as a line | segments of at least 20 cm; junctions where they meet at right angles; the centre circle by its curvature |
//! | edge of the carpet | the highest green of a column of the image | itself |
//! | penalty cross | white spot on green, as large and as broad in all directions as a cross at that place | its centre |
//!
//! An object that two cameras see is one percept: by its foot or its lower edge if one of them sees that. Objects in the lower camera are
//! nearer, and so measured more exactly.
//!
//! If an image shows one side of a near post and neither its foot nor its top, the distance is estimated between bounds.
//!
//! White goals have no colour of their own: their posts are detected by their height, if they are not hidden.

pub mod accuracy;
mod ball;
mod blobs;
mod bodies;
mod border;
mod colour;
mod crosses;
mod football;
mod junctions;
mod line_point;
mod lines;
mod pieces;
mod posts;
mod robots;
pub(super) mod seeing;
mod strips;

use bevy::math::Vec2;

use super::{BallPercept, GoalPostPercept, GroundPoint, LandmarkPercept, RobotPercept};
use crate::sensing::camera::image::Image;
use blobs::Segmentation;
use colour::ColourClass;
use naoisis_core::ball::BallLook;
use naoisis_core::camera_model::{CameraName, CameraView};
use naoisis_core::pitch::{End, GoalColour, Pitch};
use naoisis_core::robot::body::{Body, Waistband};
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::{PerTeam, Team};

/// The least height of a lens, m.
const LOWEST_LENS_M: f32 = 0.1;

/// The sizes and colours of the objects that the image vision detects.
#[derive(Clone, PartialEq, Debug)]
pub struct ObjectModel {
    /// The ball's radius, m.
    pub ball_radius: f32,
    /// The ball's colours.
    pub ball_look: BallLook,
    /// The goal posts' radius, m.
    pub post_radius: f32,
    /// The goal posts' height, m.
    pub post_height: f32,
    /// The waistbands of each team's robots, or the areas of their jerseys, each kind once. In a team of different robots, a blob counts as
    /// the band whose size fits best.
    pub waistbands: PerTeam<Vec<Waistband>>,
    /// The jerseys of the teams. Robots in green are not detected.
    pub jerseys: PerTeam<Option<Jersey>>,
    /// The colours of the two goals.
    pub goal_colours: [GoalColour; 2],
    /// Width of the lines, m.
    pub line_width: f32,
    /// Length of the bars of the penalty crosses, m.
    pub penalty_mark_size: f32,
    /// Radius of the centre circle, m.
    pub circle_radius: f32,
    /// Radius of the corner arcs, m; zero without.
    pub arc_radius: f32,
    /// The greatest reach of a robot's body from its middle, m.
    pub robot_reach: f32,
    /// The greatest distance of an object, m: from corner to corner of the carpet.
    pub farthest: f32,
}

impl ObjectModel {
    /// The model of a `pitch` with an orange ball of this radius, m, and NAOs.
    pub fn new(pitch: &Pitch, ball_radius: f32) -> Self {
        Self {
            ball_radius,
            ball_look: BallLook::Orange,
            post_radius: pitch.goal.post_diameter_m / 2.0,
            post_height: pitch.goal.height_m,
            waistbands: PerTeam::new(|_| vec![Waistband::default()]),
            jerseys: PerTeam::default(),
            goal_colours: End::BOTH.map(|end| pitch.goal_colour(end)),
            line_width: pitch.line_width_m,
            penalty_mark_size: pitch.penalty_mark_size_m,
            circle_radius: pitch.centre_circle_diameter_m / 2.0,
            arc_radius: pitch.corner_arc_radius_m,
            robot_reach: reach_of(&Body::default()),
            farthest: 2.0 * pitch.carpet_half_extents().length(),
        }
    }

    /// The model with robots with these bodies; NAOs for a team without any.
    pub fn with_robots<'a>(self, bodies: impl IntoIterator<Item = (Team, &'a Body)>) -> Self {
        let mut waistbands = PerTeam::<Vec<Waistband>>::default();
        let mut jerseys = self.jerseys;
        let mut robot_reach = 0.0_f32;
        for (team, body) in bodies {
            robot_reach = robot_reach.max(reach_of(body));
            jerseys[team] = jerseys[team].or(body.jersey);
            let mark = body.team_mark();
            if !waistbands[team].contains(&mark) {
                waistbands[team].push(mark);
            }
        }
        for team in Team::BOTH {
            if waistbands[team].is_empty() {
                robot_reach = robot_reach.max(reach_of(&Body::default()));
                waistbands[team].push(Waistband::default());
            }
        }
        Self { waistbands, jerseys, robot_reach, ..self }
    }

    /// The radii of the centre circle and of corner arcs, m; zero if there are none.
    fn radii(&self) -> [f32; 2] {
        [self.circle_radius, self.arc_radius]
    }
}

/// The reach of a body from the robot's middle, m.
fn reach_of(body: &Body) -> f32 {
    body.torso.reach().max(body.base.reach())
}

/// The detections in one image.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct ImageDetections {
    /// The most likely ball, and its number of pixels.
    pub ball: Option<(u32, BallPercept)>,
    /// Goal posts, and whether their feet are in the image.
    pub goal_posts: Vec<(bool, GoalPostPercept)>,
    /// Robots, and whether the lower edges of their waistbands are in the image.
    pub robots: Vec<(bool, RobotPercept)>,
    /// Lines, junctions and marks.
    pub landmarks: Vec<LandmarkPercept>,
    /// Points along lines.
    pub line_points: Vec<GroundPoint>,
    /// Points along the edge of the carpet.
    pub border_points: Vec<GroundPoint>,
}

impl ImageDetections {
    fn clear(&mut self) {
        let ImageDetections { ball, goal_posts, robots, landmarks, line_points, border_points } = self;
        *ball = None;
        goal_posts.clear();
        robots.clear();
        landmarks.clear();
        line_points.clear();
        border_points.clear();
    }
}

/// The image vision. Keep it, as it reuses its memory from image to image.
#[derive(Default)]
pub struct ImageVision {
    segmentation: Segmentation,
    contour: Vec<Vec2>,
    football: football::Football,
    edges: Vec<[u16; 2]>,
    bodies: bodies::Bodies,
    strips: strips::Strips,
    lines: lines::Lines,
}

/// One image with its view.
struct Look<'a> {
    camera: CameraName,
    view: &'a CameraView,
    model: &'a ObjectModel,
    segmentation: &'a Segmentation,
}

impl ImageVision {
    /// Detects all objects in an image that was taken by `camera` with this `view`.
    pub fn recognise(
        &mut self,
        image: &Image,
        camera: CameraName,
        view: &CameraView,
        model: &ObjectModel,
        detections: &mut ImageDetections,
    ) {
        detections.clear();
        if image.is_empty() {
            return;
        }
        self.segmentation.segment(image);
        let look = Look { camera, view, model, segmentation: &self.segmentation };
        look.find_posts(&mut self.strips, &mut detections.goal_posts);
        look.find_robots(&mut self.edges, &mut detections.robots);
        look.find_bodies(&detections.goal_posts, &mut self.bodies, &mut detections.robots);
        detections.ball = match model.ball_look {
            BallLook::Pentagons => look.find_football(&detections.robots, &mut self.football),
            _ => look.find_ball(&mut self.contour),
        };
        let ImageDetections { goal_posts, robots, landmarks, line_points, border_points, .. } = detections;
        look.find_lines(&mut self.lines, robots, goal_posts, landmarks, line_points);
        look.find_border(robots, border_points);
    }
}

impl Look<'_> {
    fn width(&self) -> usize {
        self.segmentation.width
    }

    fn height(&self) -> usize {
        self.segmentation.height
    }

    fn class(&self, u: usize, v: usize) -> ColourClass {
        self.segmentation.classes[v * self.segmentation.width + u]
    }

    /// The depth of a point along the axis of the camera, m.
    fn depth(&self, place: Vec2, height: f32) -> f32 {
        self.view.camera_from_robot(place.extend(height)).z
    }

    /// The place at this height that a pixel shows, robot frame, m, if it may be on the pitch.
    fn place(&self, pixel: Vec2, height: f32) -> Option<Vec2> {
        let place = self.view.point_at_height(pixel, height)?;
        (place.length_squared() < self.model.farthest * self.model.farthest).then_some(place)
    }

    /// The length of ground along the line of sight that a pixel covers at `place`, m.
    fn pixel_on_ground(&self, place: Vec2) -> f32 {
        place.length_squared() / (self.view.intrinsics.focal.x * self.view.lens.z.max(LOWEST_LENS_M))
    }
}

#[cfg(test)]
mod tests;
