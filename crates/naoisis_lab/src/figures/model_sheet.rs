//! The sheet of a robot model: the robot from three sides and in both designs with its dimensions, the images of its
//! cameras, the regions of its kicks, and its walking speed in each direction.

use bevy::math::{Vec2, Vec3, ops};
use core::f32::consts::TAU;
use serde_json::json;

use super::FigureError;
use super::axes::{Axes, caption, remark};
use super::figure_match::{self, BLUE, FigureMatch, pixels, supersampling, view_from};
use super::robots::cut_out;
use naoisis_core::camera_model::CameraView;
use naoisis_core::geometry::{Pose, to_degrees};
use naoisis_core::kick_geometry::KickGeometry;
use naoisis_core::robot::body::{Body, Footprint};
use naoisis_core::robot::kick::KickSettings;
use naoisis_core::robot::motion::MotionSettings;
use naoisis_record::record::canvas::{Canvas, GREY, INK, PAPER};
use naoisis_record::record::marks::{ORANGE, bright_line, key};
use naoisis_sensing::appearance::colours;
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::RobotModel;
use naoisis_sim::simulation::MatchApp;

const SIZE: Vec2 = Vec2::new(1600.0, 1240.0);
const PANEL: Vec2 = Vec2::new(300.0, 470.0);
/// The distance from which the robot is drawn, m; large enough that there is no visible perspective.
const EYE_M: f32 = 60.0;
/// The width of a camera view, points.
const VIEW_WIDTH: f32 = 440.0;
/// The gap between camera views, points.
const VIEW_GAP: f32 = 12.0;
/// The pose of the robot that looks at a ball and at another robot.
const LOOKER: Pose = Pose::new(-1.5, 0.0, 0.0);
/// The number of directions in which the speed is drawn.
const DIRECTIONS: usize = 72;

/// The side from which the robot is drawn.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    Front,
    Right,
    Back,
}

/// Draws the sheet of a model.
///
/// # Errors
/// If the model makes no valid scenario, or its match cannot start.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    remark(&mut canvas, &format!("{}: {}", model.name, model.description), Vec2::new(60.0, 34.0));
    draw_sides(&mut canvas, model, scale)?;
    let ball_m = ball_distance_m(&model.scenario()?.settings.body);
    let played = FigureMatch::begin(model, &scene_of(LOOKER, Some(ball_m)))?;
    draw_views(&mut canvas, &played, ball_m, Vec2::new(60.0, 700.0), scale);
    let robot = &played.app;
    let body = robot.robot::<Body>(BLUE).copied().unwrap_or_default();
    let kicks = robot.robot::<KickSettings>(BLUE).copied().unwrap_or_default();
    let motion = robot.robot::<MotionSettings>(BLUE).copied().unwrap_or_default();
    draw_kicks(&mut canvas, &body, &kicks, Vec2::new(600.0, 700.0));
    draw_speeds(&mut canvas, &motion, Vec2::new(1130.0, 700.0));
    Ok(canvas.into_image())
}

/// The distance of the ball in the camera views, m: 1.2 m, and a multiple of 0.1 m more for larger robots.
fn ball_distance_m(body: &Body) -> f32 {
    /// The distance from the edge of a robot to the centre of the ball, m.
    const CLEAR_M: f32 = 0.4;
    let reach_m = body.torso.reach().max(body.base.reach());
    (ops::ceil(10.0 * (reach_m + CLEAR_M)) / 10.0).max(1.2)
}

/// A scenario in JSON with a robot at `pose`, alone or with a ball at `ball_m` and another robot behind the ball.
fn scene_of(pose: Pose, ball_m: Option<f32>) -> String {
    let robot = |team: &str, pose: [f32; 3]| json!({ "team": team, "number": 1, "pose": pose });
    let mut robots = vec![robot("blue", [pose.position.x, pose.position.y, to_degrees(pose.heading)])];
    let mut scenario = json!({ "realism": "realistic", "rules": "free", "field": "spl2025" });
    if let Some(ball_m) = ball_m {
        // The other robot is as far behind the ball as the ball is from the robot, apart from objects side by side.
        let other_m = if ball_m > 1.2 { 2.0 * ball_m } else { 2.0 };
        robots.push(robot("pink", [pose.position.x + other_m, 0.5, 200.0]));
        scenario["ball"] = json!({ "position_m": [pose.position.x + ball_m, -0.2] });
    } else {
        scenario["ball"] = json!(null);
    }
    scenario["robots"] = json!(robots);
    scenario.to_string()
}

/// Draws front, side and back, and the front in the simple design, with the bounding boxes of collisions.
fn draw_sides(canvas: &mut Canvas, model: &RobotModel, scale: f32) -> Result<(), FigureError> {
    // It stands in the middle, and the eye is beside the pitch.
    let from_front = FigureMatch::begin(model, &scene_of(Pose::new(0.0, 0.0, -core::f32::consts::FRAC_PI_2), None))?;
    let from_right = FigureMatch::begin(model, &scene_of(Pose::new(0.0, 0.0, 0.0), None))?;
    let from_behind = FigureMatch::begin(model, &scene_of(Pose::new(0.0, 0.0, core::f32::consts::FRAC_PI_2), None))?;
    let panels = [
        ("a", "From the front", &from_front, RobotDesign::Nao, Side::Front),
        ("b", "From its right", &from_right, RobotDesign::Nao, Side::Right),
        ("c", "From behind", &from_behind, RobotDesign::Nao, Side::Back),
        ("d", "Of few boxes", &from_front, RobotDesign::Simple, Side::Front),
    ];
    for (column, (letter, words, played, design, side)) in panels.into_iter().enumerate() {
        let Some(body) = played.app.robot::<Body>(BLUE).copied() else { continue };
        let up = [-0.05 * body.height_m, 1.1 * body.height_m];
        let at = Vec2::new(90.0 + 384.0 * column as f32, 96.0);
        let half_width_m = (up[1] - up[0]) * PANEL.x / PANEL.y / 2.0;
        let across = match side {
            Side::Front | Side::Right => [-half_width_m, half_width_m],
            Side::Back => [half_width_m, -half_width_m],
        };
        let axes = Axes { at, size: PANEL, across, up };
        let middle = Vec3::Z * (up[0] + up[1]) / 2.0;
        let fov = 2.0 * ops::atan((up[1] - up[0]) / 2.0 / EYE_M);
        let view = view_from(middle + EYE_M * Vec3::NEG_Y, middle, fov, PANEL, scale);
        canvas.pixels(&cut_out(played.scene(), &view, design, pixels(PANEL, scale)), at);
        let step = if body.height_m > 0.8 { 0.2 } else { 0.1 };
        axes.frame(
            canvas,
            [step, step],
            [if side == Side::Right { "x, m" } else { "y, m" }, if column == 0 { "z, m" } else { "" }],
        );
        for z in [0.0, body.height_m] {
            canvas.dashes(&across.map(|x| axes.place(Vec2::new(x, z))), GREY, 1.2);
        }
        for part in [body.torso, body.base] {
            let [from, to] = if side == Side::Right { part.x_m } else { [-part.half_width_m, part.half_width_m] };
            let corners = [[from, part.z_m[0]], [to, part.z_m[0]], [to, part.z_m[1]], [from, part.z_m[1]]];
            canvas.outline(&corners.map(|corner| axes.place(corner.into())), ORANGE, 1.6);
        }
        caption(canvas, letter, words, at - Vec2::new(0.0, 22.0));
    }
    Ok(())
}

/// Draws the images of all cameras of a ball and another robot behind it, in two rows.
fn draw_views(canvas: &mut Canvas, played: &FigureMatch, ball_m: f32, at: Vec2, scale: f32) {
    let settings = played.app.robot::<CameraSettings>(BLUE).copied().unwrap_or_default();
    let Some(robot) = played.scene().robot(BLUE) else { return };
    caption(canvas, "e", &format!("What its cameras see: a ball {ball_m:.1} m away"), at - Vec2::new(0.0, 22.0));
    let mounts = settings.mounts.as_slice();
    if mounts.is_empty() {
        remark(canvas, "It has no camera.", at + Vec2::Y * 20.0);
    }
    let columns = mounts.len().div_ceil(2).max(1);
    let width = match mounts.len() {
        0 | 1 => VIEW_WIDTH,
        2 => 0.62 * VIEW_WIDTH,
        _ => VIEW_WIDTH / columns as f32 - VIEW_GAP,
    };
    let (mut top, mut lowest) = (0.0, 0.0_f32);
    for (index, mount) in mounts.iter().enumerate() {
        let column = index % columns;
        if column == 0 {
            top = lowest;
        }
        let place = at + Vec2::new(column as f32 * (width + VIEW_GAP), top);
        let [full_width, full_height] = mount.size.unwrap_or([settings.width, settings.height]);
        let height = width * full_height as f32 / full_width as f32;
        let size = pixels(Vec2::new(width, height), scale);
        let drawn = CameraSettings { width: size[0], height: size[1], ..settings };
        let mut mount = *mount;
        mount.size = None;
        let camera = CameraView::new(drawn.intrinsics(&mount), &mount, robot.body.neck_m, robot.head);
        let view = View::of_robot(&camera, robot.world_from_robot(), BLUE);
        let view = View { supersampling: supersampling(size), shadows: true, ..view };
        canvas.pixels(&figure_match::draw(played.scene(), &view), place);
        let words = match columns {
            1 => format!("{}: {full_width} x {full_height} pixels", mount.name),
            2 => format!("{}: {full_width} x {full_height}", mount.name),
            _ => mount.name.to_string(),
        };
        remark(canvas, &words, place + Vec2::new(0.0, height + 22.0));
        lowest = lowest.max(top + height + 38.0);
    }
}

/// Draws feet, trunk and the region of the ball for each kick, from above.
fn draw_kicks(canvas: &mut Canvas, body: &Body, kicks: &KickSettings, at: Vec2) {
    let geometries: Vec<KickGeometry> = kicks.types().filter_map(|kick| kicks.geometry(kick)).collect();
    let reach = geometries.iter().map(|geometry| geometry.x_m[1]).fold(0.3, f32::max);
    let size = Vec2::splat(420.0);
    let half = (0.62 * (reach + 0.1)).max(body.torso.half_width_m + 0.05);
    let axes = Axes { at, size, across: [half, -half], up: [-2.0 * half + reach + 0.06, reach + 0.06] };
    caption(canvas, "f", "Where the ball lies for its kicks, from above", at - Vec2::new(0.0, 22.0));
    axes.frame(canvas, [0.1, 0.1], ["y, m", "x, m"]);
    let place = |point: Vec2| axes.place(Vec2::new(point.y, point.x));
    let outline = |footprint: Footprint| footprint.corners().map(place);
    canvas.fill(&outline(body.torso.footprint(Pose::default())), colours::SHELL, 1.0);
    canvas.outline(&outline(body.torso.footprint(Pose::default())), INK, 1.5);
    canvas.outline(&outline(body.base.footprint(Pose::default())), ORANGE, 2.0);
    for geometry in geometries {
        let rectangle = geometry.rectangle();
        let corners = [
            rectangle.min,
            Vec2::new(rectangle.max.x, rectangle.min.y),
            rectangle.max,
            Vec2::new(rectangle.min.x, rectangle.max.y),
        ];
        canvas.fill(&corners.map(place), colours::CARPET, 0.18);
        canvas.outline(&corners.map(place), colours::CARPET, 1.5);
        let from = geometry.best_m;
        let most = geometry.aims_within();
        // A kick that can be aimed gets a fan of its directions.
        for wanted in if most > 0.0 { vec![-most, 0.0, most] } else { vec![0.0] } {
            let to = from + 0.08 * geometry.leaves(from, wanted);
            canvas.arrow(place(from), place(to), INK, 2.0);
        }
        canvas.disc(place(from), 4.0, colours::BALL, 1.0);
    }
    let lines: Vec<String> = kicks.types().map(|kick| format!("{kick}: {} m", kicks.max_distance_m(kick))).collect();
    // There is room for two rows.
    for (row, kicks) in lines.chunks(lines.len().div_ceil(2).max(2)).enumerate() {
        remark(canvas, &kicks.join(", "), at + Vec2::new(0.0, size.y + 78.0 + 24.0 * row as f32));
    }
}

/// Plots the walking speed in each direction, without turning and with half of the greatest turning speed.
fn draw_speeds(canvas: &mut Canvas, motion: &MotionSettings, at: Vec2) {
    let size = Vec2::splat(420.0);
    let most = 1.15 * motion.max_linear_mps.max(0.05);
    let axes = Axes { at, size, across: [most, -most], up: [-most, most] };
    caption(canvas, "g", "How fast it walks into each direction", at - Vec2::new(0.0, 22.0));
    let step = if most > 0.6 { 0.4 } else { 0.1 };
    axes.grid(canvas, [step, step]);
    axes.frame(canvas, [step, step], ["to the left, m/s", "ahead, m/s"]);
    let turns = [(0.0, colours::CARPET), (0.5, ORANGE)];
    for (share, colour) in turns {
        let places: Vec<Vec2> = (0..=DIRECTIONS)
            .map(|index| {
                let angle = TAU * index as f32 / DIRECTIONS as f32;
                let direction = Vec2::new(ops::cos(angle), ops::sin(angle));
                let speed = fastest(motion, direction, share * motion.max_angular);
                axes.place(Vec2::new(speed.y, speed.x))
            })
            .collect();
        bright_line(canvas, &places, colour, 2.5);
    }
    let entries = [(turns[0].1, "straight"), (turns[1].1, "with half of the fastest turn")];
    key(canvas, &entries, at + Vec2::new(0.0, size.y + 78.0));
}

/// The greatest velocity in `direction` while turning at `turn` (rad/s), m/s, robot frame.
fn fastest(motion: &MotionSettings, direction: Vec2, turn: f32) -> Vec2 {
    let wanted = direction * motion.max_linear_mps;
    match &motion.gait {
        Some(gait) => gait.reachable(wanted.extend(turn), motion).truncate(),
        None => wanted,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::MODELS;

    #[test]
    fn every_model_has_a_sheet() {
        for preset in MODELS {
            let model = RobotModel::named(preset.name).unwrap();
            let image = draw(&model, 0.25).unwrap();
            assert_eq!([image.width, image.height], [400, 310], "{}", model.name);
        }
    }

    #[test]
    fn the_widest_robot_that_there_may_be_has_a_sheet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("wide.ron");
        let text = r#"(name: "wide", description: "", settings: (
                body: (
                    torso: (x_m: (-0.6, 0.6), half_width_m: 0.95, z_m: (0.3, 1.0)),
                    base: (x_m: (-0.9, 0.9), half_width_m: 0.95, z_m: (0.0, 0.3)),
                    waistband: (z_m: (0.5, 0.7), half_size_m: (0.61, 0.96)),
                    height_m: 1.1, lying_height_m: 0.3, neck_m: (0.0, 0.0, 1.0),
                ),
                cameras: (mounts: [(name: "head", position_m: (0.0, 0.0, 1.05))]),
            ), realistic: (ball: "hsl2026"), sources: {})"#;
        std::fs::write(&path, text).unwrap();
        let model = RobotModel::find(&path.to_string_lossy()).unwrap();
        assert_eq!(ball_distance_m(&model.scenario().unwrap().settings.body), 1.8);
        draw(&model, 0.2).unwrap();
        assert_eq!(ball_distance_m(&Body::default()), 1.2);
    }
}
