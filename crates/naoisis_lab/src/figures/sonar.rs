//! Figure 4: the sectors of a robot's sonars, and what they detect.

use bevy::math::{Vec2, ops};
use serde_json::{Value, json};

use super::FigureError;
use super::axes::{Plan, caption, remark};
use super::figure_match::{BLUE, FigureMatch};
use naoisis_core::geometry::{Pose, to_degrees, to_radians, unit};
use naoisis_record::record::canvas::{Anchor, Canvas, INK, PAPER};
use naoisis_record::record::marks::{ORANGE, SKY_BLUE, arc, bright_words, measure, sector};
use naoisis_sensing::appearance::colours::Colour;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::sonar::{SonarReading, SonarSettings};
use naoisis_sim::scenario::RobotModel;

/// The position of the robot, where no line is near.
const PLACE: Vec2 = Vec2::new(1.2, 1.3);
const SIZE: Vec2 = Vec2::new(1600.0, 1010.0);
/// The colours of the left and the right sonar.
const COLOURS: [Colour; 2] = [SKY_BLUE, ORANGE];

/// The greatest distance of the paper's sonars, m. The dimensions of the figure are for these, and scale with the
/// robot's.
const PAPER_MAX_M: f32 = 0.75;

/// The obstacles of a panel: robots with headings in degrees, and posts. Positions are relative to [`PLACE`], m.
struct Situation {
    words: &'static str,
    robots: &'static [(Vec2, f32)],
    posts: &'static [Vec2],
}

const SITUATIONS: [Situation; 4] = [
    Situation { words: "A robot ahead", robots: &[(Vec2::new(0.58, 0.0), 160.0)], posts: &[] },
    Situation { words: "A post on the left", robots: &[], posts: &[Vec2::new(0.42, 0.24)] },
    Situation {
        words: "Two robots",
        robots: &[(Vec2::new(0.36, -0.22), 120.0), (Vec2::new(0.6, 0.26), -135.0)],
        posts: &[],
    },
    Situation {
        words: "Beside both sectors, or too far",
        robots: &[(Vec2::new(0.12, 0.4), -60.0)],
        posts: &[Vec2::new(0.88, 0.0)],
    },
];

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    let own = own_sectors(&mut canvas, model)?;
    let (size, zoom) = (own.max_m / PAPER_MAX_M, zoom(&own));
    for (index, (shown, letter)) in SITUATIONS.into_iter().zip('c'..).enumerate() {
        let at = Vec2::new(790.0 + 402.0 * (index % 2) as f32, 72.0 + 500.0 * (index / 2) as f32);
        let played = situation(model, &shown, size)?;
        let plan = Plan::new(at, Vec2::new(376.0, 376.0), PLACE + Vec2::X * 0.35 * zoom, 345.0 / zoom, true);
        let plan = plan.counted_from(PLACE);
        plan.picture(&mut canvas, played.scene());
        let reading: SonarReading = played.robot(BLUE);
        draw_sectors(&mut canvas, &plan, &own, reading);
        plan.outline(&mut canvas);
        plan.ruler(&mut canvas, 0.25, "25 cm");
        caption(&mut canvas, &letter.to_string(), shown.words, at - Vec2::Y * 16.0);
        let text = format!("left: {}    right: {}", metres(reading.left), metres(reading.right));
        canvas.words(&text, at + Vec2::new(0.0, 376.0 + 28.0), 20.0, Anchor::Left, INK);
    }
    Ok(canvas.into_image())
}

/// The scale of a plan relative to the paper's sonars, so that the sectors fit; those of the paper reach 37.48° to each
/// side.
fn zoom(settings: &SonarSettings) -> f32 {
    let aside = |angle: f32| ops::sin(angle.min(core::f32::consts::FRAC_PI_2));
    let wider = aside(settings.heading + settings.half_angle) / aside(to_radians(37.48));
    settings.max_m / PAPER_MAX_M * wider.max(1.0)
}

fn metres(distance: Option<f32>) -> String {
    distance.map_or("nothing".to_owned(), |distance| format!("{distance:.2} m"))
}

/// The first cycle of a situation scaled by `size`, with sonars without noise.
fn situation(model: &RobotModel, shown: &Situation, size: f32) -> Result<FigureMatch, FigureError> {
    let mut robots = vec![json!({ "team": "blue", "number": 1, "pose": [PLACE.x, PLACE.y, 0.0] })];
    robots.extend(shown.robots.iter().zip(1..).map(|((offset, heading_deg), number)| {
        let place = PLACE + size * *offset;
        json!({ "team": "pink", "number": number, "pose": [place.x, place.y, heading_deg] })
    }));
    let posts = shown.posts.iter().map(|offset| (PLACE + size * *offset).to_array());
    let posts: Vec<Value> = posts.map(|place| json!({ "position_m": place })).collect();
    let scenario = json!({
        "rules": "free", "ball": null, "sonar": { "noise": "none" }, "robots": robots, "posts": posts,
    });
    let mut played = FigureMatch::begin(model, &scenario.to_string())?;
    played.play(1, |_| ());
    Ok(played)
}

/// Draws the sectors of both sonars, and in each an arc at the measured distance.
fn draw_sectors(canvas: &mut Canvas, plan: &Plan, settings: &SonarSettings, reading: SonarReading) {
    let pose = Pose::new(PLACE.x, PLACE.y, 0.0);
    let range = [settings.min_m, settings.max_m];
    for (index, (heading, distance)) in sonars(settings, reading).into_iter().enumerate() {
        let outline = plan.places(sector(pose, heading, settings.half_angle, range));
        canvas.fill(&outline, COLOURS[index], 0.30);
        canvas.outline(&outline, COLOURS[index], 2.0);
        if let Some(distance) = distance {
            let echo = plan.places(arc(pose, heading, settings.half_angle, distance));
            canvas.line(&echo, INK, 8.0);
            canvas.line(&echo, COLOURS[index], 5.0);
        }
    }
}

/// The direction and reading of the left and of the right sonar.
fn sonars(settings: &SonarSettings, reading: SonarReading) -> [(f32, Option<f32>); 2] {
    [(settings.heading, reading.left), (-settings.heading, reading.right)]
}

/// Draws the large panel with the sectors and their dimensions, and the table of the sonars. Returns their settings.
fn own_sectors(canvas: &mut Canvas, model: &RobotModel) -> Result<SonarSettings, FigureError> {
    let played = situation(model, &Situation { words: "", robots: &[], posts: &[] }, 1.0)?;
    let settings: SonarSettings = played.robot(BLUE);
    if !settings.fitted {
        return Err(FigureError::Lacking { figure: 4, what: "what sonars hear" });
    }
    let size = settings.max_m / PAPER_MAX_M;
    let zoom = zoom(&settings);
    let middle = PLACE + Vec2::X * 0.36 * zoom;
    let plan = Plan::new(Vec2::new(100.0, 72.0), Vec2::new(620.0, 560.0), middle, 590.0 / zoom, true);
    let plan = plan.counted_from(PLACE);
    plan.picture(canvas, played.scene());
    draw_sectors(canvas, &plan, &settings, SonarReading::default());
    let from_robot = |distance: f32, angle: f32| plan.place(PLACE + distance * unit(angle));
    for (heading, colour) in [(settings.heading, COLOURS[0]), (-settings.heading, COLOURS[1])] {
        canvas.dashes(&[from_robot(0.0, 0.0), from_robot(settings.max_m + 0.06 * size, heading)], colour, 2.0);
    }
    canvas.dashes(&[from_robot(0.0, 0.0), from_robot(settings.max_m + 0.03 * size, 0.0)], PAPER, 1.5);
    // The direction of the left sonar, and the opening of the right one.
    let pose = Pose::new(PLACE.x, PLACE.y, 0.0);
    let half = settings.heading / 2.0;
    canvas.line(&plan.places(arc(pose, half, half, 0.56 * size)), PAPER, 2.0);
    let opening = plan.places(arc(pose, -settings.heading, settings.half_angle, 0.45 * size));
    canvas.line(&opening, PAPER, 2.0);
    let degrees = |angle: f32| format!("{}\u{b0}", (100.0 * to_degrees(angle)).round() / 100.0);
    bright_words(
        canvas,
        &degrees(settings.heading),
        from_robot(0.60 * size, half) + Vec2::Y * 6.0,
        20.0,
        Anchor::Middle,
    );
    let words = format!("\u{b1}{}", degrees(settings.half_angle));
    bright_words(canvas, &words, from_robot(0.49 * size, -settings.heading) + Vec2::Y * 6.0, 20.0, Anchor::Middle);
    // The range, beside the sectors.
    let left_edge = settings.heading + settings.half_angle;
    let beside = unit(left_edge).perp() * 0.05 * size;
    let along = |distance: f32| plan.place(PLACE + distance * unit(left_edge) + beside);
    measure(canvas, [along(0.0), along(settings.min_m)], "", PAPER, None);
    measure(canvas, [along(settings.min_m), along(settings.max_m)], "", PAPER, None);
    for (from, to, metres) in [(0.0, settings.min_m, settings.min_m), (settings.min_m, settings.max_m, settings.max_m)]
    {
        let at = (along(from) + along(to)) / 2.0 + Vec2::new(if from == 0.0 { -70.0 } else { -56.0 }, 0.0);
        let words = if from == 0.0 { format!("{metres:.2} m") } else { format!("to {metres:.2} m") };
        bright_words(canvas, &words, at, 20.0, Anchor::Middle);
    }
    plan.frame(canvas, if size > 1.5 { 0.2 } else { 0.1 });
    caption(canvas, "a", "The sectors of both sonars, from above", Vec2::new(100.0, 56.0));
    table(canvas, &settings);
    Ok(settings)
}

fn table(canvas: &mut Canvas, settings: &SonarSettings) {
    let top = 736.0;
    caption(canvas, "b", "Specification", Vec2::new(100.0, top));
    let columns = [100.0, 220.0, 350.0, 470.0, 620.0];
    let row = |canvas: &mut Canvas, y: f32, cells: [String; 5], colour: Colour| {
        for (x, cell) in columns.iter().zip(cells) {
            canvas.words(&cell, Vec2::new(*x, y), 19.0, Anchor::Left, colour);
        }
    };
    let line = |canvas: &mut Canvas, y: f32| canvas.line(&[Vec2::new(100.0, y), Vec2::new(730.0, y)], INK, 1.5);
    line(canvas, top + 20.0);
    row(canvas, top + 46.0, ["Sonar", "Direction", "Height", "Opening", "Range"].map(str::to_owned), INK);
    line(canvas, top + 60.0);
    let round = |angle: f32| super::axes::number((100.0 * to_degrees(angle)).round() / 100.0, 0.01);
    for (index, (name, heading)) in [("left", settings.heading), ("right", -settings.heading)].into_iter().enumerate() {
        let y = top + 88.0 + 30.0 * index as f32;
        let cells = [
            name.to_owned(),
            format!("{}\u{b0}", round(heading)),
            format!("{:.2} m", settings.height_m),
            format!("\u{b1}{:.0}\u{b0}", to_degrees(settings.half_angle)),
            format!("{:.2}\u{2013}{:.2} m", settings.min_m, settings.max_m),
        ];
        row(canvas, y, cells, INK);
    }
    line(canvas, top + 134.0);
    let words = [
        "Bold arcs: the measured distance. A sonar does not tell the direction",
        "within its sector. The ball is too low to be heard.",
    ];
    for (row, words) in words.into_iter().enumerate() {
        remark(canvas, words, Vec2::new(100.0, top + 176.0 + 26.0 * row as f32));
    }
}
