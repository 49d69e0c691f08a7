//! Figure 5: kicks. The robot's view, what lies where before its feet, and how the ball rolls.

use bevy::math::Vec2;

use super::FigureError;
use super::axes::{Plan, caption, remark};
use super::figure_match::{self, BLUE, FigureMatch, view_of_robot};
use super::marks::{ORANGE, YELLOW, bright_arrow, bright_dot, bright_line};
use crate::appearance::colours::{self, Colour};
use crate::camera_model::CameraName;
use crate::events::{KickResult, MatchEvent};
use crate::geometry::{Pose, to_degrees, wrap_angle};
use crate::kick_geometry::{KickGeometry, KickType};
use crate::record::canvas::{Canvas, PAPER};
use crate::sensing::camera::image::Image;
use crate::simulation::MatchApp;

const SIZE: Vec2 = Vec2::new(1600.0, 1264.0);
const WIDTH: f32 = 340.0;
const ROBOT: Pose = Pose::new(-2.0, 0.0, 0.0);
/// Cycles between the dots on a path: half a second.
const DOT_CYCLES: usize = 15;
/// After so many cycles every ball lies.
const CYCLES: usize = 520;

/// A kick: which, where the ball lies in the robot frame, m, and what there is to say.
const KICKS: [(KickType, &str, Vec2, &str); 4] = [
    (KickType::RightSide, "right_side", Vec2::new(0.16, 0.08), "Right side kick"),
    (KickType::RightStraight, "right_straight", Vec2::new(0.18, -0.085), "Right straight kick, at an angle"),
    (KickType::RightStraight, "right_straight", Vec2::new(0.23, 0.05), "Right straight kick, out of reach"),
    (KickType::RightSide, "right_side", Vec2::new(0.175, -0.04), "Right side kick, wrong side"),
];

/// Draws it.
pub fn draw(scale: f32) -> Result<Image, FigureError> {
    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    for (column, ((kick, name, ball, words), letter)) in KICKS.into_iter().zip('a'..).enumerate() {
        let left = 84.0 + 384.0 * column as f32;
        let place = ROBOT.transform_point(ball);
        let mut played = FigureMatch::begin(&format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [{}, {}] }},
                 "robots": [{{ "team": "blue", "number": 1, "pose": [{}, {}, 0], "head_deg": [0, 30],
                    "behaviour": {{ "script": [{{ "from_s": 0, "kick": {{ "type": "{name}", "speed": 1.0 }} }}] }} }}] }}"#,
            place.x, place.y, ROBOT.position.x, ROBOT.position.y
        ))?;
        caption(&mut canvas, &letter.to_string(), words, Vec2::new(left - 34.0, 34.0));
        draw_view(&mut canvas, &played, kick, Vec2::new(left, 98.0))?;
        draw_reach(&mut canvas, &played, kick, ball, Vec2::new(left, 392.0), column == 0);

        let mut path = vec![played.ball()];
        let mut outcome = None;
        played.play(CYCLES, |played| {
            path.push(played.ball());
            outcome = outcome.or_else(|| played.app.events().iter().find_map(outcome_of));
        });
        let Some((result, direction)) = outcome else {
            return Err(FigureError::Missing { figure: 5, missing: "there was no kick" });
        };
        remark(&mut canvas, &what_came_of_it(result, direction, &path), Vec2::new(left - 34.0, 60.0));
        draw_path(&mut canvas, &played, &path, Vec2::new(left, 766.0), column == 0);
    }
    for (words, y) in [
        ("The robot's bottom camera", 88.0),
        ("The ball and the kick's rectangle", 382.0),
        ("The way of the ball, a dot every half a second", 756.0),
    ] {
        remark(&mut canvas, words, Vec2::new(84.0, y));
    }
    Ok(canvas.into_image())
}

fn outcome_of(event: &MatchEvent) -> Option<(KickResult, Option<f32>)> {
    match event {
        MatchEvent::Kick { result, direction, .. } => Some((*result, *direction)),
        _ => None,
    }
}

fn what_came_of_it(result: KickResult, direction: Option<f32>, path: &[Vec2]) -> String {
    let rolled = path.first().zip(path.last()).map_or(0.0, |(from, to)| from.distance(*to));
    let direction = direction.map_or(0.0, |direction| to_degrees(wrap_angle(direction - ROBOT.heading)));
    let side = if direction > 0.0 { "left" } else { "right" };
    let direction = format!("{:.0}\u{b0} to the {side}", direction.abs());
    match result {
        KickResult::Kicked => format!("rolls {rolled:.2} m, {direction}"),
        KickResult::Reduced => format!("straight at half the speed: {rolled:.2} m"),
        KickResult::Missed => "the ball stays where it is".to_owned(),
    }
}

/// The corners of the rectangle in which a kick reaches the ball, pitch frame, m.
fn reach(kick: KickType) -> Vec<Vec2> {
    let area = kick.admissible_rectangle();
    let corners = [area.min, Vec2::new(area.max.x, area.min.y), area.max, Vec2::new(area.min.x, area.max.y)];
    corners.map(|corner| ROBOT.transform_point(corner)).to_vec()
}

/// What the robot sees of its bottom camera, with the rectangle of the kick.
fn draw_view(canvas: &mut Canvas, played: &FigureMatch, kick: KickType, at: Vec2) -> Result<(), FigureError> {
    let scale = canvas.scale();
    let Some((view, _)) = view_of_robot(played.scene(), BLUE, CameraName::BOTTOM, WIDTH, scale) else {
        return Err(FigureError::Missing { figure: 5, missing: "the robot is not on the pitch" });
    };
    let mut image = Canvas::scaled(Vec2::new(WIDTH, 0.75 * WIDTH), scale, PAPER);
    image.pixels(&figure_match::draw(played.scene(), &view), Vec2::ZERO);
    let mut corners = reach(kick);
    corners.extend(corners.first().copied());
    let corners: Option<Vec<Vec2>> =
        corners.iter().map(|corner| Some(view.project(corner.extend(0.0))? / scale)).collect();
    if let Some(corners) = corners {
        image.dashes(&corners, PAPER, 2.0);
    }
    canvas.pixels(&image.into_image(), at);
    Ok(())
}

/// From above: the rectangle, the foot's tip, and the ray from it through the ball.
fn draw_reach(canvas: &mut Canvas, played: &FigureMatch, kick: KickType, ball: Vec2, at: Vec2, is_first: bool) {
    let centre = ROBOT.transform_point(Vec2::new(0.13, 0.0));
    let plan = Plan::new(at, Vec2::new(WIDTH, 250.0), centre, 740.0, true).counted_from(ROBOT.position);
    plan.picture(canvas, played.scene());
    let area = plan.places(reach(kick));
    canvas.fill(&area, PAPER, 0.14);
    let closed = |area: &[Vec2]| -> Vec<Vec2> { area.iter().chain(area.first()).copied().collect() };
    canvas.dashes(&closed(&area), PAPER, 2.0);
    if kick == KickType::RightSide && !kick.admits(ball) {
        // From the wrong side it is a straight kick, whose rectangle this is.
        canvas.dashes(&closed(&plan.places(reach(KickType::RightStraight))), YELLOW, 1.6);
    }
    let tip = KickGeometry::of_paper(kick).foot_m;
    let [tip_place, ball_place] = [tip, ball].map(|place| plan.place(ROBOT.transform_point(place)));
    if kick.admits(ball) || kick == KickType::RightSide {
        let end = ball_place + (ball_place - tip_place).normalize_or(Vec2::NEG_Y) * 46.0;
        bright_line(canvas, &[tip_place, ball_place], YELLOW, 2.0);
        bright_arrow(canvas, [ball_place, end], YELLOW, 3.0);
    }
    bright_dot(canvas, tip_place, 4.5, YELLOW);
    plan.axes.frame(canvas, [0.1; 2], ["y, m", if is_first { "x, m" } else { "" }]);
}

/// From above: the way of the ball with a dot every half a second.
fn draw_path(canvas: &mut Canvas, played: &FigureMatch, path: &[Vec2], at: Vec2, is_first: bool) {
    let plan = Plan::new(at, Vec2::new(WIDTH, 430.0), Vec2::new(0.15, 0.1), 86.0, true);
    plan.picture(canvas, played.scene());
    let places = plan.places(path.iter().copied());
    bright_line(canvas, &places, ORANGE, 2.5);
    for place in places.iter().step_by(DOT_CYCLES) {
        bright_dot(canvas, *place, 2.5, PAPER);
    }
    if let Some(place) = places.last() {
        bright_dot(canvas, *place, 5.0, BALL);
    }
    plan.axes.frame(canvas, [1.0; 2], ["y, m", if is_first { "x, m" } else { "" }]);
}

const BALL: Colour = colours::BALL;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_said_how_far_and_where_the_ball_went() {
        let path = [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::new(1.0, 0.0)];
        let said = |result, direction| what_came_of_it(result, direction, &path);
        assert_eq!(said(KickResult::Kicked, Some(-0.5)), "rolls 1.00 m, 29\u{b0} to the right");
        assert!(said(KickResult::Missed, None).contains("stays"));
    }
}
