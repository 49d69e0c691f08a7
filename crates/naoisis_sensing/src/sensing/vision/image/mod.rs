//! The image vision: from an RGB image alone to what is seen in it, as robots in 2011 did it.
//!
//! Each pixel's colour is looked up in a table of classes ([`colour`]); pixels of one class that touch each other are a
//! blob; and blobs are judged by shape, size and distance, with what is [`Known`] of the things on the pitch:
//!
//! | class | cue | located by |
//! |---|---|---|
//! | ball | orange disc of the size that a ball has there | its centre, a ball's radius above the ground |
//! | goal post | upright strip of a goal's colour | its foot where green is below; else its width |
//! | robot | waistband in the team's colour, of the size that one of the team's kinds of robots has there | the band's lower edge; the upper where that is cut off |
//! | line | white between green, about as wide as a line | stretches of at least 20 cm; where they meet at right angles, junctions; the centre circle by its curvature |
//! | penalty cross | white spot on green, as large and as broad in all directions as a cross there | its centre |
//!
//! A thing that both cameras see is one percept: by its foot or its lower edge where one of them sees that. What the lower
//! camera sees is nearer, and so better known.
//!
//! Of a near post of which the image shows one side and neither foot nor top, the distance is a guess between bounds.
//!
//! Goals that are white have no colour of their own: their posts are found by their height, if nothing hides them.

pub mod accuracy;
mod ball;
mod blobs;
pub mod colour;
mod crosses;
mod junctions;
mod line_point;
mod lines;
mod pieces;
mod posts;
mod robots;
pub(super) mod seeing;
mod strips;

use bevy::math::Vec2;

use super::{BallPercept, GoalPostPercept, LandmarkPercept, RobotPercept};
use crate::sensing::camera::image::Image;
use blobs::Segmentation;
use colour::ColourClass;
use naoisis_core::camera_model::{CameraName, CameraView};
use naoisis_core::pitch::{End, GoalColour, Pitch};
use naoisis_core::robot::body::{Body, Waistband};
use naoisis_core::team::{PerTeam, Team};

/// No lens is nearer to the ground, m.
const LOWEST_LENS_M: f32 = 0.1;

/// What a robot knows of the things that it looks for.
#[derive(Clone, PartialEq, Debug)]
pub struct Known {
    /// The ball's radius, m.
    pub ball_radius: f32,
    /// The goal posts' radius, m.
    pub post_radius: f32,
    /// Their height, m.
    pub post_height: f32,
    /// The waistbands of the teams' robots, each kind once: of those of a team whose robots differ, a band is taken for that whose size
    /// fits best.
    pub waistbands: PerTeam<Vec<Waistband>>,
    /// The colours of the two goals.
    pub goal_colours: [GoalColour; 2],
    /// Width of the lines, m.
    pub line_width: f32,
    /// Length of the bars of the penalty crosses, m.
    pub penalty_mark_size: f32,
    /// Radius of the centre circle, m.
    pub circle_radius: f32,
    /// Radius of the arcs at the corners, m; nought without.
    pub arc_radius: f32,
    /// How far a robot's body reaches from its middle, m.
    pub robot_reach: f32,
    /// What seems further away than this is not on the pitch, m: from corner to corner of the carpet.
    pub farthest: f32,
}

impl Known {
    /// By the rule book's pitch, with a ball of this radius, and NAOs.
    pub fn new(pitch: &Pitch, ball_radius: f32) -> Self {
        Self {
            ball_radius,
            post_radius: pitch.goal.post_diameter_m / 2.0,
            post_height: pitch.goal.height_m,
            waistbands: PerTeam::new(|_| vec![Waistband::default()]),
            goal_colours: End::BOTH.map(|end| pitch.goal_colour(end)),
            line_width: pitch.line_width_m,
            penalty_mark_size: pitch.penalty_mark_size_m,
            circle_radius: pitch.centre_circle_diameter_m / 2.0,
            arc_radius: pitch.corner_arc_radius_m,
            robot_reach: reach_of(&Body::default()),
            farthest: 2.0 * pitch.carpet_half_extents().length(),
        }
    }

    /// The same, with robots that have these bodies; of a team of which there are none, NAOs.
    pub fn with_robots<'a>(self, bodies: impl IntoIterator<Item = (Team, &'a Body)>) -> Self {
        let mut waistbands = PerTeam::<Vec<Waistband>>::default();
        let mut robot_reach = 0.0_f32;
        for (team, body) in bodies {
            robot_reach = robot_reach.max(reach_of(body));
            if !waistbands[team].contains(&body.waistband) {
                waistbands[team].push(body.waistband);
            }
        }
        for team in Team::BOTH {
            if waistbands[team].is_empty() {
                robot_reach = robot_reach.max(reach_of(&Body::default()));
                waistbands[team].push(Waistband::default());
            }
        }
        Self { waistbands, robot_reach, ..self }
    }

    /// The radii of what is painted round, m; nought of what there is not.
    fn radii(&self) -> [f32; 2] {
        [self.circle_radius, self.arc_radius]
    }
}

/// How far a body reaches from the robot's middle, m.
fn reach_of(body: &Body) -> f32 {
    body.torso.reach().max(body.base.reach())
}

/// What is found in one image.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Findings {
    /// The most likely ball, and how many of its pixels are seen.
    pub ball: Option<(u32, BallPercept)>,
    /// Goal posts, and whether their feet are seen.
    pub goal_posts: Vec<(bool, GoalPostPercept)>,
    /// Robots, and whether the lower edges of their waistbands are seen.
    pub robots: Vec<(bool, RobotPercept)>,
    /// Lines and where they meet.
    pub landmarks: Vec<LandmarkPercept>,
}

impl Findings {
    fn clear(&mut self) {
        let Findings { ball, goal_posts, robots, landmarks } = self;
        *ball = None;
        goal_posts.clear();
        robots.clear();
        landmarks.clear();
    }
}

/// Looks at images. It keeps its memory from one to the next.
#[derive(Default)]
pub struct ImageVision {
    segmentation: Segmentation,
    contour: Vec<Vec2>,
    edges: Vec<[u16; 2]>,
    strips: strips::Strips,
    lines: lines::Lines,
}

/// One image, and from where it was taken.
struct Look<'a> {
    side: CameraName,
    view: &'a CameraView,
    known: &'a Known,
    segmentation: &'a Segmentation,
}

impl ImageVision {
    /// Looks for everything in an image, which was taken by this camera with this view.
    pub fn recognise(
        &mut self,
        image: &Image,
        side: CameraName,
        view: &CameraView,
        known: &Known,
        findings: &mut Findings,
    ) {
        findings.clear();
        if image.is_empty() {
            return;
        }
        self.segmentation.segment(image);
        let look = Look { side, view, known, segmentation: &self.segmentation };
        findings.ball = look.find_ball(&mut self.contour);
        look.find_posts(&mut self.strips, &mut findings.goal_posts);
        look.find_robots(&mut self.edges, &mut findings.robots);
        let Findings { goal_posts, robots, landmarks, .. } = findings;
        look.find_lines(&mut self.lines, robots, goal_posts, landmarks);
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

    /// The distance of a point ahead of the lens, m.
    fn depth(&self, place: Vec2, height: f32) -> f32 {
        self.view.camera_from_robot(place.extend(height)).z
    }

    /// Where a pixel looks at this height, robot frame, m, if that may be on a pitch.
    fn place(&self, pixel: Vec2, height: f32) -> Option<Vec2> {
        let place = self.view.point_at_height(pixel, height)?;
        (place.length_squared() < self.known.farthest * self.known.farthest).then_some(place)
    }

    /// How much of the ground a pixel covers along the line of sight at a place, m.
    fn pixel_on_ground(&self, place: Vec2) -> f32 {
        place.length_squared() / (self.view.intrinsics.focal_length * self.view.lens.z.max(LOWEST_LENS_M))
    }
}

#[cfg(test)]
mod tests;
