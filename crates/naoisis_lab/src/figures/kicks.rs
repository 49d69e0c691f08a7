//! Figure 5: kicks: the view of the robot, the region of the ball in front of its feet, and the path of the ball.

use bevy::math::Vec2;
use std::borrow::Cow;

use super::FigureError;
use super::axes::{Plan, caption, remark};
use super::figure_match::{self, BLUE, FigureMatch};
use naoisis_core::events::{KickResult, MatchEvent};
use naoisis_core::geometry::{Pose, to_degrees, wrap_angle};
use naoisis_core::kick_geometry::{KickGeometry, KickType};
use naoisis_core::robot::kick::KickSettings;
use naoisis_record::record::canvas::{Canvas, PAPER};
use naoisis_record::record::marks::{ORANGE, YELLOW, bright_arrow, bright_dot, bright_line};
use naoisis_sensing::appearance::colours::{self, Colour};
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

const SIZE: Vec2 = Vec2::new(1600.0, 1264.0);
const WIDTH: f32 = 340.0;
const ROBOT: Pose = Pose::new(-2.0, 0.0, 0.0);
/// Cycles between the dots on a path: half a second.
const DOT_CYCLES: usize = 15;
/// The most kicks that fit.
const MOST_SHOWN: usize = 4;
/// The direction of a kick that can be aimed, as a fraction of its greatest angle to the left.
const AIM_SHARE: f32 = 0.5;
/// The number of cycles after which every ball has stopped.
const CYCLES: usize = 520;

/// A kick of the figure.
#[derive(Clone)]
struct Shown {
    kick: KickType,
    /// The region in which the ball must lie.
    geometry: KickGeometry,
    /// The position of the ball, m, robot frame.
    ball: Vec2,
    /// The direction of the kick, radians, counter-clockwise.
    aim: f32,
    words: Cow<'static, str>,
}

/// The kicks of a robot that are shown: those of the paper's figure, otherwise others that it has.
fn kicks_of(settings: &KickSettings) -> Vec<Shown> {
    let shown = |kick: KickType, words: &str, ball: &dyn Fn(&KickGeometry) -> Vec2| {
        let geometry = settings.geometry(kick)?;
        Some(Shown { kick, geometry, ball: ball(&geometry), aim: 0.0, words: words.to_owned().into() })
    };
    let [straight, side] = [KickType::RightStraight, KickType::RightSide];
    let is_of_paper = settings.own.is_empty()
        && [straight, side].iter().all(|kick| settings.geometry(*kick) == KickGeometry::of_paper(*kick));
    if is_of_paper {
        let paper = [
            shown(side, "Right side kick", &|_| Vec2::new(0.16, 0.08)),
            shown(straight, "Right straight kick, at an angle", &|_| Vec2::new(0.18, -0.085)),
            shown(straight, "Right straight kick, out of reach", &|_| Vec2::new(0.23, 0.05)),
            shown(side, "Right side kick, wrong side", &|_| Vec2::new(0.175, -0.04)),
        ];
        return paper.into_iter().flatten().collect();
    }
    let beside = |geometry: &KickGeometry| Vec2::new(geometry.best_m.x, 0.9 * geometry.y_m[0] + 0.1 * geometry.y_m[1]);
    let beyond = |geometry: &KickGeometry| geometry.best_m + Vec2::X * (geometry.x_m[1] - geometry.best_m.x + 0.05);
    let best = |geometry: &KickGeometry| geometry.best_m;
    let first = [shown(straight, "Right straight kick", &best), shown(side, "Right side kick", &best)];
    let more = [
        shown(straight, "Right straight kick, off the middle", &beside),
        shown(straight, "Right straight kick, out of reach", &beyond),
        shown(KickType::LeftStraight, "Left straight kick", &best),
        shown(KickType::LeftSide, "Left side kick", &best),
    ];
    // Custom kicks, as many as fit.
    let own = settings.own.iter().filter_map(|(name, _)| {
        let kick = KickType::Custom(*name);
        let words = format!("Kick {}", kick.words());
        let ahead = shown(kick, &words, &best)?;
        let most = ahead.geometry.aims_within();
        if most == 0.0 {
            return Some(ahead);
        }
        let aim = AIM_SHARE * most;
        let words = format!("{words}, aimed {:.0}\u{b0} to the left", to_degrees(aim));
        Some(Shown { aim, words: words.into(), ..ahead })
    });
    let mut chosen: Vec<Shown> = first.into_iter().flatten().chain(own).take(MOST_SHOWN).collect();
    // The paper's order: from the best kick to one that does not work.
    chosen.extend(more.into_iter().flatten());
    chosen.truncate(MOST_SHOWN);
    chosen
}

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let alone = FigureMatch::begin(model, r#"{ "rules": "free", "ball": null, "robots": [{ "number": 1 }] }"#)?;
    let settings: KickSettings = alone.robot(BLUE);
    let kicks = kicks_of(&settings);
    if kicks.is_empty() {
        return Err(FigureError::Lacking { figure: 5, what: "kicks" });
    }
    let furthest_m = kicks.iter().map(|shown| settings.max_distance_m(shown.kick)).fold(0.0, f32::max);
    let [_, head_pitch] = alone.within_head_limits(BLUE, [0.0, 30.0]);
    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    for (column, (shown, letter)) in kicks.into_iter().zip('a'..).enumerate() {
        let Shown { kick, ball, aim, ref words, .. } = shown;
        let aim_deg = to_degrees(aim);
        let name = kick.name();
        let left = 84.0 + 384.0 * column as f32;
        let place = ROBOT.transform_point(ball);
        let scenario = format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [{}, {}] }},
                 "robots": [{{ "team": "blue", "number": 1, "pose": [{}, {}, 0], "head_deg": [0, {head_pitch}],
                    "behaviour": {{ "script": [{{ "from_s": 0, "kick": {{ "type": "{name}", "speed": 1.0, "direction_deg": {aim_deg} }} }}] }} }}] }}"#,
            place.x, place.y, ROBOT.position.x, ROBOT.position.y
        );
        let mut played = FigureMatch::begin(model, &scenario)?;
        caption(&mut canvas, &letter.to_string(), words, Vec2::new(left - 34.0, 34.0));
        draw_view(&mut canvas, &played, &shown, Vec2::new(left, 98.0));
        draw_reach(&mut canvas, &played, &shown, Vec2::new(left, 392.0), column == 0);

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
        draw_path(&mut canvas, &played, &path, furthest_m, Vec2::new(left, 766.0), column == 0);
    }
    let has_two = alone.robot::<CameraSettings>(BLUE).mounts.as_slice().len() > 1;
    for (words, y) in [
        (if has_two { "The robot's lower camera" } else { "The robot's camera" }, 88.0),
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
    let direction = match direction.abs() {
        straight if straight < 0.5 => "straight ahead".to_owned(),
        aside => format!("{aside:.0}\u{b0} to the {side}"),
    };
    match result {
        KickResult::Kicked => format!("rolls {rolled:.2} m, {direction}"),
        KickResult::Reduced => format!("straight at half the speed: {rolled:.2} m"),
        KickResult::Missed => "the ball stays where it is".to_owned(),
    }
}

/// The corners of the rectangle in which a kick reaches the ball, pitch frame, m.
fn reach(geometry: &KickGeometry) -> Vec<Vec2> {
    let area = geometry.rectangle();
    let corners = [area.min, Vec2::new(area.max.x, area.min.y), area.max, Vec2::new(area.min.x, area.max.y)];
    corners.map(|corner| ROBOT.transform_point(corner)).to_vec()
}

/// Draws the view of the lower camera, if there is one, with the rectangle of the kick.
fn draw_view(canvas: &mut Canvas, played: &FigureMatch, shown: &Shown, at: Vec2) {
    let scale = canvas.scale();
    let cameras: CameraSettings = played.robot(BLUE);
    let lower = cameras.mounts.names().last();
    let Some((view, _)) = lower.and_then(|camera| played.view_of_robot(BLUE, camera, WIDTH, scale)) else {
        remark(canvas, "It has no camera.", at + Vec2::Y * 30.0);
        return;
    };
    let mut image = Canvas::scaled(view.intrinsics.size / scale, scale, PAPER);
    image.pixels(&figure_match::draw(played.scene(), &view), Vec2::ZERO);
    let mut corners = reach(&shown.geometry);
    corners.extend(corners.first().copied());
    let corners: Option<Vec<Vec2>> =
        corners.iter().map(|corner| Some(view.project(corner.extend(0.0))? / scale)).collect();
    if let Some(corners) = corners {
        image.dashes(&corners, PAPER, 2.0);
    }
    canvas.pixels(&image.into_image(), at);
}

/// Draws a plan of the rectangle, the tip of the foot, and the ray from it through the ball.
fn draw_reach(canvas: &mut Canvas, played: &FigureMatch, shown: &Shown, at: Vec2, is_first: bool) {
    let &Shown { kick, geometry, ball, aim, .. } = shown;
    // The size is relative to the rectangle of a NAO's kicks, which end 23 cm ahead.
    let size = (geometry.x_m[1] / 0.23).max(1.0);
    let centre = ROBOT.transform_point(Vec2::new(0.13 * size, 0.0));
    let plan = Plan::new(at, Vec2::new(WIDTH, 250.0), centre, 740.0 / size, true).counted_from(ROBOT.position);
    plan.picture(canvas, played.scene());
    let area = plan.places(reach(&geometry));
    canvas.fill(&area, PAPER, 0.14);
    let closed = |area: &[Vec2]| -> Vec<Vec2> { area.iter().chain(area.first()).copied().collect() };
    canvas.dashes(&closed(&area), PAPER, 2.0);
    let strike = played.robot::<KickSettings>(BLUE).strike(kick, ball, aim);
    if strike.is_some() && !geometry.admits(ball) {
        // From the wrong side this is a straight kick, with this rectangle.
        let straight = played.robot::<KickSettings>(BLUE).geometry(KickType::RightStraight).unwrap_or(geometry);
        canvas.dashes(&closed(&plan.places(reach(&straight))), YELLOW, 1.6);
    }
    let tip = geometry.foot_m;
    let [tip_place, ball_place] = [tip, ball].map(|place| plan.place(ROBOT.transform_point(place)));
    if let Some(strike) = strike {
        let along = plan.place(ROBOT.transform_point(ball + strike.direction)) - ball_place;
        let end = ball_place + along.normalize_or(Vec2::NEG_Y) * 46.0;
        bright_line(canvas, &[tip_place, ball_place], YELLOW, 2.0);
        bright_arrow(canvas, [ball_place, end], YELLOW, 3.0);
    }
    bright_dot(canvas, tip_place, 4.5, YELLOW);
    plan.axes.frame(canvas, [0.1; 2], ["y, m", if is_first { "x, m" } else { "" }]);
}

/// Draws a plan of the ball's path with a dot every half second.
fn draw_path(canvas: &mut Canvas, played: &FigureMatch, path: &[Vec2], furthest_m: f32, at: Vec2, is_first: bool) {
    // A NAO's kicks go 4 m; the robot is 35 cm from the lower edge.
    let size = (furthest_m / 4.0).max(1.0);
    let centre = Vec2::new(ROBOT.position.x - 0.35 + 2.5 * size, 0.1);
    let plan = Plan::new(at, Vec2::new(WIDTH, 430.0), centre, 86.0 / size, true);
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
    fn a_robot_with_kicks_of_its_own_shows_them_and_aims_them() {
        let kicks = |model: &str| RobotModel::named(model).unwrap().scenario().unwrap().settings.kicks;
        let shown = |settings: &KickSettings| {
            kicks_of(settings).into_iter().map(|shown| (shown.kick.to_string(), shown.aim)).collect::<Vec<_>>()
        };
        let of_k1 = shown(&kicks("booster_k1"));
        assert_eq!((of_k1.len(), of_k1[0].0.as_str()), (4, "right_straight"));
        assert!(of_k1.iter().any(|(kick, aim)| kick == "visual" && *aim > 0.2), "{of_k1:?}");
        // With the NAO, the figure is that of the paper.
        let words: Vec<String> = kicks_of(&kicks("nao")).into_iter().map(|shown| shown.words.into_owned()).collect();
        assert_eq!(words[1], "Right straight kick, at an angle");
        assert_eq!(shown(&KickSettings { own: kicks("booster_k1").own, ..kicks("rover") }).len(), 4);
    }

    #[test]
    fn it_is_said_how_far_and_where_the_ball_went() {
        let path = [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::new(1.0, 0.0)];
        let said = |result, direction| what_came_of_it(result, direction, &path);
        assert_eq!(said(KickResult::Kicked, Some(-0.5)), "rolls 1.00 m, 29\u{b0} to the right");
        assert_eq!(said(KickResult::Kicked, Some(0.001)), "rolls 1.00 m, straight ahead");
        assert!(said(KickResult::Missed, None).contains("stays"));
    }
}
