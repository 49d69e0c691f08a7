//! Figure 3: a scene, and the images of the lower camera of a robot in it at several angles of its head.

use bevy::math::{Vec2, Vec3};

use super::FigureError;
use super::axes::{caption, remark};
use super::figure_match::{self, BLUE, FigureMatch, view_from};
use naoisis_core::camera_model::CameraMount;
use naoisis_core::geometry::to_degrees;
use naoisis_core::robot::head::HeadAngles;
use naoisis_record::record::canvas::{Anchor, Canvas, PAPER};
use naoisis_record::record::marks::bright_words;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sim::scenario::RobotModel;

const PAGE_WIDTH: f32 = 1600.0;
/// Yaw and pitch of the head in each view, degrees.
const HEAD_DEG: [[f32; 2]; 8] = [
    [55.0, -30.0],
    [15.0, -30.0],
    [-20.0, -30.0],
    [-60.0, -30.0],
    [45.0, -10.0],
    [15.0, -10.0],
    [-15.0, 0.0],
    [-10.0, 25.0],
];
/// The time for each head movement, s.
const LOOK_S: f32 = 1.0;
const SCENE: Vec2 = Vec2::new(1540.0, 560.0);
const VIEW_WIDTH: f32 = 374.0;
/// The height of a row of views for a robot as high as a NAO, and the gaps between views, points.
const ROW: f32 = 332.0;
const BETWEEN: f32 = 51.5;
/// Angles that differ by less are treated as the same, degrees.
const SAME_DEG: f32 = 0.5;

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    let alone = FigureMatch::begin(model, r#"{ "rules": "free", "ball": null, "robots": [{ "number": 1 }] }"#)?;
    // A head that reaches only some of these angles gets only those views.
    let looks = distinct(HEAD_DEG.map(|angles| alone.within_head_limits(BLUE, angles)));
    let script: Vec<String> = looks
        .iter()
        .enumerate()
        .map(|(index, [yaw, pitch])| {
            format!(r#"{{ "from_s": {}, "head_deg": [{yaw}, {pitch}] }}"#, LOOK_S * index as f32)
        })
        .collect();
    let scenario = format!(
        r#"{{ "rules": "free", "ball": {{ "position_m": [0.351, -0.739] }},
             "robots": [{{ "team": "blue", "number": 1, "pose": [0.0, -0.9, 35.0], "behaviour": {{ "script": [{}] }} }},
                        {{ "team": "pink", "number": 1, "pose": [1.1, 0.35, -140.0] }}] }}"#,
        script.join(", ")
    );
    let mut played = FigureMatch::begin(model, &scenario)?;
    let cameras: CameraSettings = played.robot(BLUE);
    let Some(camera) = cameras.mounts.as_slice().last().copied() else {
        return Err(FigureError::Lacking { figure: 3, what: "what a camera sees" });
    };
    let width = view_width(&cameras, &camera, looks.len());
    let [own_width, own_height] = camera.size.unwrap_or([cameras.width, cameras.height]);
    // A single view takes both rows.
    let view_height = width * own_height as f32 / own_width as f32;
    let row_height = if looks.len() > 1 { view_height + BETWEEN } else { ROW };
    let mut canvas = Canvas::scaled(Vec2::new(PAGE_WIDTH, 672.0 + 2.0 * row_height), scale, PAPER);
    let origin = Vec2::new(30.0, 56.0);
    caption(&mut canvas, "a", "The scene: the blue robot is on the halfway line", origin - Vec2::Y * 18.0);
    let target = Vec3::new(1.35, -0.35, 0.05);
    let away = Vec3::new(-0.75, -5.25, 2.85) * played.height_in_naos(BLUE).max(1.0);
    let scene_view = view_from(target + away, target, 0.42, SCENE, scale);
    canvas.pixels(&figure_match::draw(played.scene(), &scene_view), origin);

    let mut marked = 0;
    for (index, letter) in ('b'..='i').take(looks.len()).enumerate() {
        played.play((30.0 * LOOK_S) as usize, |_| ());
        let Some((view, _)) = played.view_of_robot(BLUE, camera.name, width, scale) else {
            return Err(FigureError::Missing { figure: 3, missing: "the robot is not on the pitch" });
        };
        let (column, row) = ((index % 4) as f32, (index / 4) as f32);
        let at = Vec2::new(30.0 + 388.7 * column, 694.0 + row_height * row);
        let head: HeadAngles = played.robot(BLUE);
        let [yaw, pitch] = [head.yaw, head.pitch].map(|angle| degrees(to_degrees(angle)));
        let words = if looks.len() > 1 {
            format!("yaw {yaw}, pitch {pitch}")
        } else {
            "What it sees: its head is fixed".to_owned()
        };
        caption(&mut canvas, &letter.to_string(), &words, at - Vec2::Y * 14.0);
        canvas.pixels(&figure_match::draw(played.scene(), &view), at);
        if let Some(pixel) = middle_on_the_ground(&view).and_then(|place| scene_view.project(place)) {
            let place = origin + pixel / scale;
            if place.cmpgt(origin).all() && place.cmplt(origin + SCENE).all() {
                marked += 1;
                canvas.disc(place, 3.5, PAPER, 1.0);
                bright_words(&mut canvas, &letter.to_string(), place + Vec2::new(0.0, -7.0), 22.0, Anchor::Middle);
            }
        }
    }
    let all = if marked < looks.len() { "; without one, it is above the ground or far away" } else { "" };
    let words = format!(
        "Letters in the scene: where the middle of each view is on the ground{all}. The {} camera looks {} further down than the head.",
        camera.name,
        degrees(to_degrees(camera.tilt()))
    );
    remark(&mut canvas, &words, origin + Vec2::new(0.0, SCENE.y + 26.0));
    Ok(canvas.into_image())
}

/// The angles without duplicates.
fn distinct(angles: [[f32; 2]; 8]) -> Vec<[f32; 2]> {
    let mut distinct: Vec<[f32; 2]> = Vec::new();
    for one in angles {
        let is_same = |other: &[f32; 2]| (0..2).all(|joint| (one[joint] - other[joint]).abs() < SAME_DEG);
        if !distinct.iter().any(is_same) {
            distinct.push(one);
        }
    }
    distinct
}

/// The width of each of `views` camera views, points. Views fill two rows, a single view both.
fn view_width(cameras: &CameraSettings, camera: &CameraMount, views: usize) -> f32 {
    let [width, height] = camera.size.unwrap_or([cameras.width, cameras.height]);
    let room = if views > 1 { Vec2::new(VIEW_WIDTH, ROW - 36.0) } else { Vec2::new(SCENE.x, 2.0 * ROW - 36.0) };
    room.x.min(room.y * width as f32 / height as f32)
}

/// The angle in whole degrees, as text.
fn degrees(angle: f32) -> String {
    format!("{}\u{b0}", super::axes::number(angle.round(), 1.0))
}

/// The point on the ground at the centre of a view.
fn middle_on_the_ground(view: &View) -> Option<Vec3> {
    (view.forward.z < -1e-3).then(|| view.eye - view.forward * (view.eye.z / view.forward.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_head_that_is_fixed_looks_once_and_one_that_turns_alone_at_each_yaw() {
        assert_eq!(distinct([[0.0; 2]; 8]), [[0.0; 2]]);
        assert_eq!(distinct(HEAD_DEG), HEAD_DEG);
        assert_eq!(distinct(HEAD_DEG.map(|[yaw, _]| [yaw, 0.0])).len(), 7);
    }

    #[test]
    fn views_have_room_and_a_single_one_has_more() {
        let nao = CameraSettings::default();
        let camera = nao.mounts.as_slice()[0];
        assert_eq!(view_width(&nao, &camera, 8), VIEW_WIDTH);
        assert!(view_width(&nao, &camera, 1) > 2.0 * VIEW_WIDTH);
        let upright = CameraSettings { width: 240, height: 320, ..nao };
        assert!(view_width(&upright, &camera, 8) * 320.0 / 240.0 < ROW);
    }

    #[test]
    fn a_view_half_down_has_its_middle_as_far_away_as_the_eye_is_high() {
        let view = View::looking_at(Vec3::new(1.0, 2.0, 0.5), Vec3::new(1.0, 2.5, 0.0), 0.5, [40, 30]);
        assert!(middle_on_the_ground(&view).unwrap().abs_diff_eq(Vec3::new(1.0, 2.5, 0.0), 1e-5));
        let level = View::looking_at(Vec3::Z, Vec3::new(1.0, 0.0, 1.0), 0.5, [40, 30]);
        assert_eq!(middle_on_the_ground(&level), None);
    }
}
