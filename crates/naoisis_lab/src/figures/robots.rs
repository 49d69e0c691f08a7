//! Figure 2: both robot designs, from the front and the side.

use bevy::math::{Vec2, Vec3};

use super::FigureError;
use super::axes::{Axes, caption};
use super::figure_match::{BLUE, FigureMatch, draw_with, pixels, view_from};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::look::LookShape;
use naoisis_record::record::canvas::{Canvas, GREY, PAPER};
use naoisis_sensing::appearance::Label;
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::{Image, Layers};
use naoisis_sim::scenario::RobotModel;

const SIZE: Vec2 = Vec2::new(1600.0, 800.0);
const PANEL: Vec2 = Vec2::new(300.0, 620.0);
/// The range of heights in a panel, m: from a little below the ground to the head of a larger robot.
const HEIGHT_M: [f32; 2] = [-0.02, 0.62];
/// The distance of the eye, m; large enough that there is no visible perspective, so the axes hold for the whole robot.
const EYE_M: f32 = 60.0;
/// Samples per side of a pixel, for smooth edges of the cut-out.
const SAMPLES: u32 = 4;

/// Draws the figure.
pub fn draw(model: &RobotModel, scale: f32) -> Result<Image, FigureError> {
    // The robots stand on the halfway line, and the eye is beside the pitch, so that nothing is in between.
    let robot = |team: &str, heading_deg: f32| {
        let scenario = format!(
            r#"{{ "rules": "free", "ball": null,
                  "robots": [{{ "team": "{team}", "number": 1, "pose": [0, 0, {heading_deg}] }}] }}"#
        );
        FigureMatch::begin(model, &scenario)
    };
    let mut canvas = Canvas::scaled(SIZE, scale, PAPER);
    let first = robot("blue", -90.0)?;
    let body: Body = first.robot(BLUE);
    let words = if body.look.shape == LookShape::Nao { "Like a NAO" } else { "Of its measures" };
    let up = [HEIGHT_M[0], HEIGHT_M[1].max(1.08 * body.height_m)];
    let step = if body.height_m > 0.8 { 0.2 } else { 0.1 };
    let panels = [
        ("a", words, first, RobotDesign::Nao, "y, m"),
        ("b", "The same from its right", robot("blue", 0.0)?, RobotDesign::Nao, "x, m"),
        ("c", "Of few boxes", robot("pink", -90.0)?, RobotDesign::Simple, "y, m"),
        ("d", "The same from its right", robot("pink", 0.0)?, RobotDesign::Simple, "x, m"),
    ];
    for (column, (letter, words, played, design, across_label)) in panels.into_iter().enumerate() {
        let at = Vec2::new(90.0 + 384.0 * column as f32, 70.0);
        let half_width_m = (up[1] - up[0]) * PANEL.x / PANEL.y / 2.0;
        // From the front, the robot's left is on the right.
        let across = [-half_width_m, half_width_m];
        let axes = Axes { at, size: PANEL, across, up };
        let middle = Vec3::Z * (up[0] + up[1]) / 2.0;
        let fov = 2.0 * bevy::math::ops::atan((up[1] - up[0]) / 2.0 / EYE_M);
        let view = view_from(middle + EYE_M * Vec3::NEG_Y, middle, fov, PANEL, scale);
        canvas.pixels(&cut_out(played.scene(), &view, design, pixels(PANEL, scale)), at);
        axes.frame(&mut canvas, [step, step], [across_label, if column % 2 == 0 { "z, m" } else { "" }]);
        for z in [0.0, body.height_m] {
            let ends = [across[0], across[1]].map(|x| axes.place(Vec2::new(x, z)));
            canvas.dashes(&ends, GREY, 1.2);
        }
        caption(&mut canvas, letter, words, at - Vec2::new(0.0, 22.0));
    }
    Ok(canvas.into_image())
}

/// A picture of only the robots of a scene, on a blank background.
pub(super) fn cut_out(scene: &Scene, view: &View, design: RobotDesign, [width, height]: [u32; 2]) -> Image {
    let mut intrinsics = view.intrinsics;
    intrinsics.size = Vec2::new((SAMPLES * width) as f32, (SAMPLES * height) as f32);
    intrinsics.centre = intrinsics.size / 2.0;
    intrinsics.focal_length *= SAMPLES as f32;
    let view = View { intrinsics, supersampling: 1, ..*view };
    let samples = draw_with(scene, &view, design, Layers { labels: true, depth: false });
    on_paper(&samples, SAMPLES)
}

/// Cuts out the robots of a labelled picture; each pixel is the mean of `count` x `count` samples.
fn on_paper(samples: &Image, count: u32) -> Image {
    let is_robot = |number: u8| {
        use Label::{BlueRobot, BlueWaistband, PinkRobot, PinkWaistband};
        matches!(Label::from_number(number), Some(BlueRobot | BlueWaistband | PinkRobot | PinkWaistband))
    };
    let [width, height] = [samples.width / count, samples.height / count];
    let mut rgb = Vec::with_capacity(3 * (width * height) as usize);
    for (v, u) in (0..height).flat_map(|v| (0..width).map(move |u| (v, u))) {
        let mut sums = [0_u32; 3];
        for (y, x) in (0..count).flat_map(|y| (0..count).map(move |x| (y, x))) {
            let index = ((v * count + y) * samples.width + u * count + x) as usize;
            let colour = if samples.labels.get(index).is_some_and(|&number| is_robot(number)) {
                [samples.rgb[3 * index], samples.rgb[3 * index + 1], samples.rgb[3 * index + 2]]
            } else {
                PAPER.0
            };
            sums.iter_mut().zip(colour).for_each(|(sum, channel)| *sum += u32::from(channel));
        }
        rgb.extend(sums.map(|sum| ((sum + count * count / 2) / (count * count)) as u8));
    }
    Image { width, height, rgb, ..Image::default() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_robot_is_paper_and_edges_are_smooth() {
        let [robot, carpet] = [Label::BlueRobot, Label::Carpet].map(|label| label as u8);
        let samples = Image {
            width: 4,
            height: 2,
            rgb: vec![55; 24],
            labels: vec![robot, robot, robot, carpet, robot, robot, carpet, carpet],
            ..Image::default()
        };
        let image = on_paper(&samples, 2);
        assert_eq!([image.width, image.height], [2, 1]);
        assert_eq!(image.colour(0, 0), Some([55; 3]));
        // A quarter of it is robot: (55 + 3 · 255) / 4.
        assert_eq!(image.colour(1, 0), Some([205; 3]));
    }
}
