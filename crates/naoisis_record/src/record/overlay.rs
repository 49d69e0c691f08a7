//! Overlays on pictures of the field: what robots sense, what they believe, and what their behaviours draw.
//!
//! Colours are those of the window: a robot's own believed pose is purple, the ball orange, other robots have their team's colour.
//! Ellipses are those of 95 % confidence.

use bevy::prelude::*;
use core::fmt;
use core::str::FromStr;

use super::canvas::{Anchor, Canvas, PAPER, ellipse};
use super::marks::{arc, bright_arrow, bright_line, bright_words, confidence_ellipse, sector};
use naoisis_core::behaviour::drawings::{DrawColour, Drawing, Drawings, DrawnShape, Frame};
use naoisis_core::game::{Game, Penalty};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::{End, GoalColour};
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::belief::{Belief, RobotBelief, pitch_from_team, point_pitch_from_team};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sensing::sensing::vision::{LandmarkKind, Percepts};

/// Fields of view are drawn so far from the robot, m.
const FURTHEST_M: f32 = 4.0;
/// A line in a picture of a thousand pixels from side to side is so wide, pixels.
const LINE: f32 = 1.6;
/// Radius at which a believed robot and a seen one are drawn, m.
const ROBOT_RADIUS_M: f32 = 0.14;
/// Radius at which a ball is drawn that is believed or seen, m.
const BALL_RADIUS_M: f32 = 0.07;
/// The time for which the way of a believed ball is drawn, s.
const ROLLS_FOR_S: f32 = 1.0;

/// Something that can be drawn over pictures of the field.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum FilmOverlay {
    /// Fields of view, percepts, and sonar readings.
    Senses,
    /// Believed poses of robots and ball, with their uncertainty.
    Beliefs,
    /// The [drawings](Drawings) of behaviours.
    Drawings,
}

impl FilmOverlay {
    /// All of them, the one that is drawn first before others.
    pub const ALL: [FilmOverlay; 3] = [FilmOverlay::Senses, FilmOverlay::Beliefs, FilmOverlay::Drawings];
}

impl fmt::Display for FilmOverlay {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str(match self {
            FilmOverlay::Senses => "senses",
            FilmOverlay::Beliefs => "beliefs",
            FilmOverlay::Drawings => "drawings",
        })
    }
}

/// Why a word is nothing that can be drawn.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "`{0}` cannot be drawn: expected `beliefs`, `senses` or `drawings`, or those of one robot, such as `blue2.beliefs`"
)]
pub struct NoOverlay(String);

naoisis_core::debug_as_displayed!(NoOverlay);

impl FromStr for FilmOverlay {
    type Err = NoOverlay;

    fn from_str(word: &str) -> Result<Self, Self::Err> {
        let found = FilmOverlay::ALL.into_iter().find(|overlay| overlay.to_string() == word);
        found.ok_or_else(|| NoOverlay(word.to_owned()))
    }
}

/// An overlay and its robot: in words, `beliefs` or `blue2.beliefs`.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct OverlayOf {
    /// The overlay.
    pub overlay: FilmOverlay,
    /// The robot. `None` for all.
    pub robot: Option<RobotId>,
}

impl FromStr for OverlayOf {
    type Err = NoOverlay;

    fn from_str(words: &str) -> Result<Self, Self::Err> {
        let Some((robot, overlay)) = words.split_once('.') else {
            return Ok(Self { overlay: words.parse()?, robot: None });
        };
        let robot = robot.parse().map_err(|_| NoOverlay(words.to_owned()))?;
        Ok(Self { overlay: overlay.parse().map_err(|_| NoOverlay(words.to_owned()))?, robot: Some(robot) })
    }
}

impl fmt::Display for OverlayOf {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.robot.map_or(Ok(()), |robot| write!(formatter, "{robot}."))?;
        self.overlay.fmt(formatter)
    }
}

/// A picture of the field with these drawn over it, seen as in `view`.
pub fn draw_over(world: &World, picture: &Image, view: &View, overlays: &[OverlayOf]) -> Image {
    let mut brush = Brush::on(picture, view);
    let robots = || world.resource::<Roster>().iter().filter(|(_, robot)| is_on_pitch(world, *robot));
    let is_wanted = |overlay: FilmOverlay, id: RobotId| {
        overlays.iter().any(|wanted| wanted.overlay == overlay && wanted.robot.is_none_or(|robot| robot == id))
    };
    for overlay in FilmOverlay::ALL {
        for (id, robot) in robots().filter(|(id, _)| is_wanted(overlay, *id)) {
            let Some(pose) = world.get::<Pose>(robot).copied() else { continue };
            let own_end = world.resource::<Game>().own_end(id.team);
            match overlay {
                FilmOverlay::Senses => draw_senses(world, robot, pose, &mut brush),
                FilmOverlay::Beliefs => {
                    if let Some(belief) = world.get::<Belief>(robot) {
                        draw_belief(id, pose, belief, own_end, &mut brush);
                    }
                }
                FilmOverlay::Drawings => {
                    for drawing in world.get::<Drawings>(robot).into_iter().flat_map(Drawings::iter) {
                        draw_drawing(pose, drawing, own_end, &mut brush);
                    }
                }
            }
        }
    }
    brush.canvas.into_image()
}

fn is_on_pitch(world: &World, robot: Entity) -> bool {
    world.get::<Penalty>(robot).is_none_or(|penalty| !penalty.is_off_pitch())
}

fn draw_senses(world: &World, robot: Entity, pose: Pose, brush: &mut Brush) {
    let is_upright = world.get::<Posture>(robot).is_none_or(|posture| posture.is_upright());
    let looks = world.get::<CameraSettings>(robot).zip(world.get::<Body>(robot)).zip(world.get::<HeadAngles>(robot));
    if let Some(((settings, body), head)) = looks.filter(|_| is_upright) {
        for (_, camera) in settings.views(body, *head).named().filter(|(name, _)| settings.which.includes(*name)) {
            let seen = camera.seen_ground(FURTHEST_M).into_iter().map(|corner| pose.transform_point(corner)).collect();
            brush.area(seen, colour(DrawColour::Yellow), 0.08);
        }
    }
    if let Some((settings, reading)) = world.get::<SonarSettings>(robot).zip(world.get::<SonarReading>(robot)) {
        for (heading, distance) in [(settings.heading, reading.left), (-settings.heading, reading.right)] {
            let Some(distance) = distance else { continue };
            let heard = sector(pose, heading, settings.half_angle, [settings.min_m.min(distance), distance]);
            brush.area(heard, colour(DrawColour::Sky), 0.1);
            brush.path(arc(pose, heading, settings.half_angle, distance), colour(DrawColour::Vermilion));
        }
    }
    if let Some(percepts) = world.get::<Percepts>(robot) {
        draw_percepts(pose, percepts, brush);
    }
}

fn draw_percepts(pose: Pose, percepts: &Percepts, brush: &mut Brush) {
    let on_pitch = |place: Vec2| pose.transform_point(place);
    for landmark in &percepts.landmarks {
        let at = on_pitch(landmark.position_m);
        match landmark.kind {
            LandmarkKind::Line { end_position_m, .. } => {
                brush.path(vec![at, on_pitch(end_position_m)], colour(DrawColour::White));
            }
            _ => brush.cross(at, 0.08, colour(DrawColour::White)),
        }
    }
    for post in &percepts.goal_posts {
        let ink = match post.colour {
            GoalColour::Yellow => DrawColour::Yellow,
            GoalColour::Blue => DrawColour::Sky,
            GoalColour::White => DrawColour::White,
        };
        brush.circle(on_pitch(post.position_m), 0.1, colour(ink));
    }
    for robot in &percepts.robots {
        brush.circle(on_pitch(robot.position_m), ROBOT_RADIUS_M, colour(robot_ink(robot.team)));
    }
    for ball in percepts.all_balls() {
        brush.circle(on_pitch(ball.position_m), BALL_RADIUS_M, colour(DrawColour::Orange));
    }
}

fn draw_belief(id: RobotId, truth: Pose, belief: &Belief, own_end: End, brush: &mut Brush) {
    let on_pitch = |place: Vec2| point_pitch_from_team(place, own_end);
    let own = belief.pose_in_pitch(own_end);
    let [xx, xy, yy, ..] = belief.pose_covariance;
    brush.path(vec![own.position, truth.position], colour(DrawColour::White));
    brush.outline(confidence_ellipse(own.position, [xx, xy, yy]), colour(DrawColour::Purple));
    brush.arrow(own.position, own.transform_point(Vec2::X * 0.3), colour(DrawColour::Purple));
    for (robots, team) in [(&belief.opponents, id.team.opponent()), (&belief.team_mates, id.team)] {
        for RobotBelief { position_m, covariance, .. } in robots {
            brush.cross(on_pitch(*position_m), 0.1, colour(robot_ink(team)));
            brush.outline(confidence_ellipse(on_pitch(*position_m), *covariance), colour(robot_ink(team)));
        }
    }
    if let Some(ball) = &belief.ball {
        let at = on_pitch(ball.position_m);
        brush.path(vec![own.position, at], colour(DrawColour::Orange));
        brush.circle(at, BALL_RADIUS_M, colour(DrawColour::Orange));
        brush.outline(confidence_ellipse(at, ball.position_covariance), colour(DrawColour::Orange));
        if ball.velocity_mps.length() > 0.05 {
            brush.arrow(at, on_pitch(ball.position_m + ROLLS_FOR_S * ball.velocity_mps), colour(DrawColour::Orange));
        }
    }
}

fn draw_drawing(robot: Pose, drawing: &Drawing, own_end: End, brush: &mut Brush) {
    let frame = match drawing.frame {
        Frame::Robot => robot,
        Frame::Team => pitch_from_team(Pose::default(), own_end),
    };
    let on_pitch = |place: Vec2| frame.transform_point(place);
    let ink = colour(drawing.ink);
    match &drawing.shape {
        DrawnShape::Line { start_m, end_m } => brush.path(vec![on_pitch(*start_m), on_pitch(*end_m)], ink),
        DrawnShape::Circle { centre_m, radius_m } => brush.circle(on_pitch(*centre_m), *radius_m, ink),
        DrawnShape::Text { position_m, words } => brush.words(on_pitch(*position_m), words),
        DrawnShape::Target { position_m, words } => {
            brush.path(vec![robot.position, on_pitch(*position_m)], ink);
            brush.cross(on_pitch(*position_m), 0.1, ink);
            brush.words(on_pitch(*position_m), words);
        }
    }
}

/// The colour in which another robot of a team is drawn.
fn robot_ink(team: Team) -> DrawColour {
    match team {
        Team::Blue => DrawColour::Sky,
        Team::Pink => DrawColour::Vermilion,
    }
}

const fn colour(ink: DrawColour) -> Colour {
    Colour(ink.rgb())
}

/// Draws on the ground of a picture; places are in the pitch frame, m.
struct Brush<'a> {
    canvas: Canvas,
    view: &'a View,
    /// Of lines, pixels.
    width: f32,
}

impl<'a> Brush<'a> {
    fn on(picture: &Image, view: &'a View) -> Self {
        let mut canvas = Canvas::new([picture.width, picture.height], PAPER);
        canvas.pixels(picture, Vec2::ZERO);
        Self { canvas, view, width: LINE * (picture.width as f32 / 1000.0).max(0.6) }
    }

    /// The pixels of places on the ground; those behind the eye are left out.
    fn pixels(&self, places: Vec<Vec2>) -> Vec<Vec2> {
        places.into_iter().filter_map(|place| self.view.project(place.extend(0.0))).collect()
    }

    fn path(&mut self, places: Vec<Vec2>, colour: Colour) {
        let pixels = self.pixels(places);
        bright_line(&mut self.canvas, &pixels, colour, self.width);
    }

    fn outline(&mut self, mut places: Vec<Vec2>, colour: Colour) {
        places.extend(places.first().copied());
        self.path(places, colour);
    }

    fn area(&mut self, places: Vec<Vec2>, colour: Colour, cover: f32) {
        let pixels = self.pixels(places);
        self.canvas.fill(&pixels, colour, cover);
        self.canvas.outline(&pixels, colour, self.width / 2.0);
    }

    fn circle(&mut self, centre: Vec2, radius_m: f32, colour: Colour) {
        self.outline(ellipse(centre, Vec2::X * radius_m, Vec2::Y * radius_m), colour);
    }

    fn cross(&mut self, at: Vec2, half_m: f32, colour: Colour) {
        for axis in [Vec2::X, Vec2::Y] {
            self.path(vec![at - half_m * axis, at + half_m * axis], colour);
        }
    }

    fn arrow(&mut self, from: Vec2, to: Vec2, colour: Colour) {
        if let [from, to] = self.pixels(vec![from, to])[..] {
            bright_arrow(&mut self.canvas, [from, to], colour, self.width);
        }
    }

    fn words(&mut self, at: Vec2, words: &str) {
        if let Some(pixel) = self.view.project(at.extend(0.0)) {
            bright_words(&mut self.canvas, words, pixel - 8.0 * Vec2::Y, 9.0 * self.width, Anchor::Middle);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::match_renderer::MatchRenderer;
    use crate::record::picture::FIELD_SAMPLES;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    /// How many pixels of a picture of the field differ when these are drawn over it, after a while of a match.
    fn drawn_pixels(overlays: &[&str]) -> usize {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
        app.run_cycles(60);
        let mut renderer = MatchRenderer::default();
        renderer.look(app.world_mut());
        let plain = renderer.draw_field(app.world_mut(), [320, 180], FIELD_SAMPLES);
        renderer.overlays = overlays.iter().map(|words| words.parse().unwrap()).collect();
        let drawn = renderer.draw_field(app.world_mut(), [320, 180], FIELD_SAMPLES);
        plain.rgb.chunks(3).zip(drawn.rgb.chunks(3)).filter(|(one, other)| one != other).count()
    }

    #[test]
    fn what_is_asked_for_is_drawn_of_whom_it_is_asked_for() {
        assert_eq!(drawn_pixels(&[]), 0);
        let one = drawn_pixels(&["blue2.beliefs"]);
        let all = drawn_pixels(&["beliefs"]);
        assert!(one > 50 && all > 2 * one, "{one} of one robot, {all} of six");
        assert!(drawn_pixels(&["senses"]) > all, "what cameras see covers the ground");
        assert!(drawn_pixels(&["drawings"]) > 50);
    }

    #[test]
    fn overlays_are_named_as_they_are_asked_for() {
        for words in ["beliefs", "senses", "blue2.beliefs", "pink12.drawings"] {
            assert_eq!(words.parse::<OverlayOf>().unwrap().to_string(), words);
        }
        for words in ["", "belief", "blue2", "blue2.", "blue0.beliefs", "top.senses", "beliefs.blue2"] {
            assert_eq!(words.parse::<OverlayOf>(), Err(NoOverlay(words.to_owned())), "{words}");
        }
    }
}
