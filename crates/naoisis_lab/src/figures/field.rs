//! Figure 1: the field from above, with its dimensions.

use bevy::math::Vec2;

use super::FigureError;
use super::axes::Plan;
use super::figure_match::FigureMatch;
use naoisis_core::ball::BallPhysics;
use naoisis_record::record::canvas::{Anchor, Canvas, INK, PAPER};
use naoisis_record::record::marks::{YELLOW, bright_arrow, bright_words, measure};
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::RobotModel;

const SIZE: Vec2 = Vec2::new(1600.0, 1230.0);
const POINTS_PER_METRE: f32 = 196.0;

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let played = FigureMatch::begin(model, r#"{ "rules": "free", "ball": { "position_m": [0.95, 0.95] } }"#)?;
    let pitch = &played.scene().pitch;
    let carpet = pitch.carpet_half_extents();
    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    let plan = Plan::new(Vec2::new(110.0, 82.0), 2.0 * carpet * POINTS_PER_METRE, Vec2::ZERO, POINTS_PER_METRE, false);
    plan.picture(&mut canvas, played.scene());
    plan.frame(&mut canvas, 0.5);

    let (x, y) = (pitch.half_length(), pitch.half_width());
    let metres = |length_m: f32| format!("{length_m:.2} m");
    let mut between = |from: Vec2, to: Vec2, words: &str| {
        measure(
            &mut canvas,
            [plan.place(from), plan.place(to)],
            words,
            PAPER,
            Some(naoisis_sensing::appearance::colours::CARPET),
        );
    };
    // In the border around the pitch.
    let border = y + 0.36;
    between(Vec2::new(-x, border), Vec2::new(x, border), &metres(pitch.length_m));
    between(Vec2::new(-x - 0.54, -y), Vec2::new(-x - 0.54, y), &metres(pitch.width_m));
    between(Vec2::new(x - 0.9, y), Vec2::new(x - 0.9, carpet.y), &metres(pitch.border_m));
    // On the pitch.
    let area = pitch.penalty_area;
    between(Vec2::new(-x, 1.45), Vec2::new(-x + area.depth_m, 1.45), &metres(area.depth_m));
    between(
        Vec2::new(-x + area.depth_m + 0.2, -area.width_m / 2.0),
        Vec2::new(-x + area.depth_m + 0.2, area.width_m / 2.0),
        &metres(area.width_m),
    );
    let [negative_cross, positive_cross, _] = pitch.marks();
    let below = Vec2::NEG_Y * 0.3;
    between(positive_cross + below, Vec2::new(x, positive_cross.y) + below, &metres(pitch.penalty_mark_distance_m));
    let radius = pitch.centre_circle_diameter_m / 2.0;
    between(
        Vec2::new(-radius, -radius - 0.25),
        Vec2::new(radius, -radius - 0.25),
        &metres(pitch.centre_circle_diameter_m),
    );
    let goal = pitch.goal;
    between(Vec2::new(x - 0.28, -goal.width_m / 2.0), Vec2::new(x - 0.28, goal.width_m / 2.0), &metres(goal.width_m));

    // The pitch frame.
    for (axis, name) in [(Vec2::X, "x"), (Vec2::Y, "y")] {
        // The centre mark stays visible.
        let [from, to] = [plan.place(0.09 * axis), plan.place(0.42 * axis)];
        bright_arrow(&mut canvas, [from, to], YELLOW, 3.0);
        bright_words(&mut canvas, name, plan.place(0.42 * axis + Vec2::new(0.08, 0.04)), 22.0, Anchor::Middle);
    }
    let name = |canvas: &mut Canvas, place: Vec2, words: &str| {
        bright_words(canvas, words, plan.place(place), 19.0, Anchor::Middle);
    };
    let ball = format!("ball, {:.0} cm", 200.0 * BallPhysics::default().radius_m);
    name(&mut canvas, played.ball() + Vec2::new(0.0, 0.1), &ball);
    name(&mut canvas, negative_cross + Vec2::new(0.0, 0.13), "penalty mark");
    name(&mut canvas, positive_cross + Vec2::new(0.0, 0.13), "penalty mark");
    name(&mut canvas, Vec2::new(-x - 0.26, -goal.width_m / 2.0 - 0.2), "blue goal");
    name(&mut canvas, Vec2::new(x + 0.32, -goal.width_m / 2.0 - 0.2), "yellow goal");
    let title = format!(
        "Carpet {:.1} m x {:.1} m; lines {:.0} cm wide; goals {:.0} cm high, posts {:.0} cm thick",
        2.0 * carpet.x,
        2.0 * carpet.y,
        100.0 * pitch.line_width_m,
        100.0 * goal.height_m,
        100.0 * goal.post_diameter_m
    );
    canvas.words(&title.replace(" x ", " \u{d7} "), Vec2::new(110.0, 52.0), 22.0, Anchor::Left, INK);
    Ok(canvas.into_image())
}
