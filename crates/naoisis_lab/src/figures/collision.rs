//! Figure 6: the ball before and after a collision with a robot.

use bevy::math::{Vec2, Vec3, ops};

use super::FigureError;
use super::axes::{Axes, Plan, caption};
use super::figure_match::{self, FigureMatch, PINK, view_from};
use naoisis_core::events::{CollisionPartner, MatchEvent};
use naoisis_core::geometry::{angle_of, to_degrees};
use naoisis_core::robot::body::Body;
use naoisis_record::record::canvas::{Anchor, Canvas, INK, PAPER};
use naoisis_record::record::marks::{
    BLUE, ORANGE, SKY_BLUE, VERMILION, bright_arrow, bright_dot, bright_line, bright_words,
};
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

const SIZE: Vec2 = Vec2::new(1600.0, 1130.0);
const PICTURE: Vec2 = Vec2::new(760.0, 520.0);
const SCENARIO: &str = r#"{ "rules": "free", "ball": { "position_m": [-0.9, -0.55], "velocity_mps": [1.5, 0.62] },
    "robots": [{ "team": "pink", "number": 1, "pose": [0.5, 0.0, 168.0] }] }"#;
/// The length of the match, cycles.
const CYCLES: usize = 150;
/// The time from the pictures to the collision, before and after it, s.
const BEFORE_S: f64 = 0.35;
const AFTER_S: f64 = 1.3;

/// The ball at the end of a cycle.
struct Sample {
    time_s: f64,
    ball: Vec2,
    velocity: Vec2,
    scene: Scene,
}

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let mut played = FigureMatch::begin(model, SCENARIO)?;
    let sample = |played: &FigureMatch| Sample {
        time_s: played.time_s(),
        ball: played.ball(),
        velocity: played.app.ball_velocity().unwrap_or_default(),
        scene: played.scene().clone(),
    };
    let mut samples = vec![sample(&played)];
    let mut hit = None;
    played.play(CYCLES, |played| {
        let is_hit =
            |event: &MatchEvent| matches!(event, MatchEvent::Collision { with, .. } if *with == CollisionPartner::Ball);
        if hit.is_none() && played.app.events().iter().any(is_hit) {
            hit = Some(samples.len());
        }
        samples.push(sample(played));
    });
    let Some(hit) = hit.filter(|&hit| hit > 2) else {
        return Err(FigureError::Missing { figure: 6, missing: "the ball hit nothing" });
    };
    let hit_s = samples[hit].time_s;
    let at_time = |time_s: f64| samples.iter().position(|sample| sample.time_s >= time_s).unwrap_or(hit);
    let (before, after) = (at_time(hit_s - BEFORE_S), at_time(hit_s + AFTER_S));

    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    for (index, (letter, words, at)) in [("a", "before", before), ("b", "after", after)].into_iter().enumerate() {
        let corner = Vec2::new(30.0 + 780.0 * index as f32, 50.0);
        let words = format!("{:.2} s {words} the collision", (samples[at].time_s - hit_s).abs());
        caption(&mut canvas, letter, &words, corner - Vec2::Y * 16.0);
        draw_scene(&mut canvas, corner, &samples, hit, at, played.height_in_naos(PINK));
    }
    draw_plan(&mut canvas, &samples, hit, base(&played));
    draw_speed(&mut canvas, &samples, hit);
    Ok(canvas.into_image())
}

/// The corners of the bounds of the robot's base, pitch frame, m.
fn base(played: &FigureMatch) -> [Vec2; 4] {
    let pose = played.app.robot_pose(PINK).unwrap_or_default();
    let area = played.robot::<Body>(PINK).base.footprint(pose);
    let [x, y] = [area.half_extents.x * area.forward, area.half_extents.y * area.forward.perp()];
    [area.centre + x + y, area.centre - x + y, area.centre - x - y, area.centre + x - y]
}

/// Draws the scene at a sample, with the path of the ball until then and its path without obstacles.
fn draw_scene(canvas: &mut Canvas, corner: Vec2, samples: &[Sample], hit: usize, at: usize, height_in_naos: f32) {
    let scale = canvas.scale();
    let target = Vec3::new(-0.16, -0.02, 0.1);
    let away = Vec3::new(-1.34, -1.98, 1.45) * height_in_naos.max(1.0);
    let view = view_from(target + away, target, 0.52, PICTURE, scale);
    let mut picture = Canvas::scaled(PICTURE, scale, PAPER);
    picture.pixels(&figure_match::draw(&samples[at].scene, &view), Vec2::ZERO);
    let before: Vec<Vec2> = samples[..hit.min(at + 1)].iter().map(|sample| sample.ball).collect();
    bright_line(&mut picture, &on_picture(&view, &before, scale), ORANGE, 3.0);
    if at < hit {
        let ahead = [samples[at].ball, samples[at].ball + 0.62 * samples[at].velocity];
        picture.dashes(&on_picture(&view, &ahead, scale), PAPER, 2.0);
    } else {
        let after: Vec<Vec2> = samples[hit - 1..=at].iter().map(|sample| sample.ball).collect();
        bright_line(&mut picture, &on_picture(&view, &after, scale), SKY_BLUE, 3.0);
    }
    canvas.pixels(&picture.into_image(), corner);
}

/// The points of positions on the ground in a picture.
fn on_picture(view: &View, places: &[Vec2], scale: f32) -> Vec<Vec2> {
    places.iter().filter_map(|place| Some(view.project(place.extend(0.0))? / scale)).collect()
}

/// Draws a plan: the ball every tenth of a second, and its directions before and after the collision.
fn draw_plan(canvas: &mut Canvas, samples: &[Sample], hit: usize, base: [Vec2; 4]) {
    let at = Vec2::new(110.0, 650.0);
    let plan = Plan::new(at, Vec2::new(680.0, 400.0), Vec2::new(-0.1, 0.03), 320.0, false);
    plan.picture(canvas, &samples[hit].scene);
    // The ball bounces off the bounds of the robot's base.
    let corners = base.map(|corner| plan.place(corner));
    canvas.dashes(&[corners[0], corners[1], corners[2], corners[3], corners[0]], PAPER, 2.0);
    let radius = 0.03 * plan.points_per_metre() * 0.7;
    let edge = Vec2::splat(radius + 2.0);
    let is_inside = |place: &Vec2| place.cmpgt(at + edge).all() && place.cmplt(at + plan.axes.size - edge).all();
    for (index, sample) in samples.iter().enumerate().step_by(3) {
        let place = plan.place(sample.ball);
        if is_inside(&place) {
            bright_dot(canvas, place, radius, if index < hit { ORANGE } else { SKY_BLUE });
        }
    }
    let [arriving, leaving] = [samples[hit - 1].velocity, samples[hit].velocity];
    let contact = samples[hit].ball;
    for (from, to, velocity, colour) in [
        (
            contact - 0.80 * arriving.normalize_or(Vec2::X),
            contact - 0.35 * arriving.normalize_or(Vec2::X),
            arriving,
            ORANGE,
        ),
        (contact, contact + 0.45 * leaving.normalize_or(Vec2::X), leaving, SKY_BLUE),
    ] {
        // Beside the path of the ball, on its left.
        let beside = velocity.normalize_or(Vec2::X).perp() * 0.09;
        let ends = [from, to].map(|place| plan.place(place + beside));
        bright_arrow(canvas, ends, colour, 3.0);
        let words = format!("{:.0}\u{b0}", to_degrees(angle_of(velocity)));
        let at = plan.place((from + to) / 2.0 + 1.8 * beside) + Vec2::Y * 7.0;
        bright_words(canvas, &words, at, 20.0, Anchor::Middle);
    }
    plan.frame(canvas, 0.2);
    caption(canvas, "c", "The ball every 0.1 s, and its direction", at - Vec2::Y * 16.0);
}

/// Plots the speed of the ball over time.
fn draw_speed(canvas: &mut Canvas, samples: &[Sample], hit: usize) {
    let at = Vec2::new(900.0, 650.0);
    let end_s = 3.0;
    let axes = Axes { at, size: Vec2::new(660.0, 400.0), across: [0.0, end_s], up: [0.0, 1.8] };
    axes.grid(canvas, [0.5, 0.3]);
    let place = |sample: &Sample| axes.place(Vec2::new(sample.time_s as f32, sample.velocity.length()));
    let shown = |sample: &&Sample| sample.time_s <= f64::from(end_s);
    let before: Vec<Vec2> = samples[..hit].iter().map(place).collect();
    let after: Vec<Vec2> = samples[hit..].iter().take_while(shown).map(place).collect();
    let x = axes.place(Vec2::new(samples[hit].time_s as f32, 0.0)).x;
    canvas.dashes(&[Vec2::new(x, at.y), Vec2::new(x, at.y + axes.size.y)], INK, 1.5);
    canvas.words("collision", Vec2::new(x + 10.0, at.y + 28.0), 19.0, Anchor::Left, INK);
    canvas.line(&before, VERMILION, 4.0);
    canvas.line(&after, BLUE, 4.0);
    // The speed without the collision: the ball slows down as it did before.
    let rate = ops::ln(samples[0].velocity.length() / samples[hit - 1].velocity.length())
        / (samples[hit - 1].time_s - samples[0].time_s) as f32;
    let free: Vec<Vec2> = (0..=40_u8)
        .map(|step| {
            let time = samples[hit].time_s as f32 * (1.0 - f32::from(step) / 40.0) + end_s * f32::from(step) / 40.0;
            axes.place(Vec2::new(time, samples[0].velocity.length() * ops::exp(-rate * time)))
        })
        .collect();
    canvas.dashes(&free, VERMILION, 2.0);
    if let Some(end) = free.last() {
        canvas.words("with nothing in its way", *end + Vec2::new(-8.0, -96.0), 18.0, Anchor::Right, VERMILION);
    }
    axes.frame(canvas, [0.5, 0.3], ["time, s", "speed of the ball, m/s"]);
    caption(canvas, "d", "Its speed", at - Vec2::Y * 16.0);
}
