//! A match that is played for a figure, and pictures of it.

use bevy::math::{Vec2, Vec3};
use bevy::prelude::*;
use serde_json::{Value, json};

use super::FigureError;
use naoisis_core::camera_model::{CameraName, CameraView, Pinhole};
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::{to_degrees, to_radians};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::{HeadAngles, HeadLimits};
use naoisis_core::team::{RobotId, Team};
use naoisis_record::record::match_renderer::MatchRenderer;
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::image::{Image, Layers};
use naoisis_sensing::sensing::camera::software::{Detail, PreparedScene, Renderer};
use naoisis_sim::scenario::{RobotModel, Scenario};
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

/// The first robot of the blue team.
pub const BLUE: RobotId = RobotId::new(Team::Blue, 1);
/// The first robot of the pink team.
pub const PINK: RobotId = RobotId::new(Team::Pink, 1);

/// The most samples along a side of a picture. Larger pictures get fewer samples per pixel.
const MOST_SAMPLES: u32 = 6_000;
/// The height of a view from above, in widths of the area; large enough that it looks like a plan. It is kept within
/// these limits, m, because farther away, round bodies suffer from rounding.
const ABOVE: f32 = 14.0;
const ABOVE_M: [f32; 2] = [14.0, 110.0];

/// A running match.
pub struct FigureMatch {
    /// The app that plays it.
    pub app: App,
    renderer: MatchRenderer,
}

impl FigureMatch {
    /// Starts the match of a scenario in JSON, with robots of `model`.
    ///
    /// # Errors
    /// When the scenario is invalid.
    pub fn begin(model: &RobotModel, scenario: &str) -> Result<FigureMatch, FigureError> {
        // A value that is no object is refused, with its place and the reason.
        let mut fields: Value = serde_json::from_str(scenario).unwrap_or_else(|_| json!(scenario));
        if let Value::Object(fields) = &mut fields {
            fields.insert("model".to_owned(), json!(model.reference()));
        }
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app.start_match(&Scenario::from_json(&fields.to_string())?)?;
        let mut played = FigureMatch { app, renderer: MatchRenderer::default() };
        played.renderer.look(played.app.world_mut());
        Ok(played)
    }

    /// Plays `cycles` cycles and calls `after` after each.
    pub fn play(&mut self, cycles: usize, mut after: impl FnMut(&FigureMatch)) {
        for _ in 0..cycles {
            self.app.run_cycles(1);
            self.renderer.look(self.app.world_mut());
            after(self);
        }
    }

    /// Returns the time of the match, s.
    pub fn time_s(&self) -> f64 {
        self.app.world().resource::<CycleClock>().end_time_s()
    }

    /// Returns the current scene.
    pub fn scene(&self) -> &Scene {
        self.renderer.scene()
    }

    /// Returns a component of a robot; the default if the robot is not in the match.
    pub fn robot<C: Component + Clone + Default>(&self, id: RobotId) -> C {
        self.app.robot::<C>(id).cloned().unwrap_or_default()
    }

    /// Returns the yaw and pitch of the head, degrees, limited to those that the robot can reach.
    pub fn within_head_limits(&self, id: RobotId, [yaw, pitch]: [f32; 2]) -> [f32; 2] {
        let limits = self.robot::<HeadLimits>(id).reached_from(self.robot::<HeadAngles>(id));
        let within = |angle: f32, [least, most]: [f32; 2]| angle.max(to_degrees(least)).min(to_degrees(most));
        let yaw = within(yaw, limits.yaw);
        [yaw, within(pitch, limits.pitch_at(to_radians(yaw)))]
    }

    /// Returns the height of its robots, as a multiple of the NAO's.
    pub fn height_in_naos(&self, id: RobotId) -> f32 {
        self.robot::<Body>(id).height_m / Body::default().height_m
    }

    /// Returns the current image of a robot's camera as a view of `width` points with smooth edges. `None` if the robot or the
    /// camera does not exist.
    pub fn view_of_robot(&self, id: RobotId, side: CameraName, width: f32, scale: f32) -> Option<(View, CameraView)> {
        view_of_robot(self.scene(), &self.robot(id), id, side, width, scale)
    }

    /// Returns the position of the ball, m, pitch frame; the origin if there is none.
    pub fn ball(&self) -> Vec2 {
        self.app.ball().unwrap_or_default().position
    }
}

/// Draws a scene with robots of the detailed design.
pub fn draw(scene: &Scene, view: &View) -> Image {
    draw_with(scene, view, RobotDesign::Nao, Layers::default())
}

/// Draws a scene with robots of the given design.
pub fn draw_with(scene: &Scene, view: &View, design: RobotDesign, layers: Layers) -> Image {
    let mut prepared = PreparedScene::default();
    prepared.prepare(scene, Detail { design, ..Detail::FINE });
    let mut image = Image::default();
    Renderer::default().draw(&prepared, view, layers, &mut image);
    image
}

/// Returns the samples per side of a pixel for a picture of this size.
pub fn supersampling([width, height]: [u32; 2]) -> u32 {
    (MOST_SAMPLES / width.max(height).max(1)).clamp(1, 3)
}

/// Returns the pixels of an area of points.
pub fn pixels(size: Vec2, scale: f32) -> [u32; 2] {
    (size * scale).round().to_array().map(|side| (side as u32).max(1))
}

/// Returns a perspective view from `eye` to `target`, for an area of points.
pub fn view_from(eye: Vec3, target: Vec3, vertical_fov: f32, size: Vec2, scale: f32) -> View {
    let size = pixels(size, scale);
    View { supersampling: supersampling(size), ..View::looking_at(eye, target, vertical_fov, size) }
}

/// Returns a view straight down on `centre`, for an area of points; with +x to the right, or up if `x_is_up`.
pub fn view_from_above(centre: Vec2, points_per_metre: f32, x_is_up: bool, size: Vec2, scale: f32) -> View {
    let pixels = pixels(size, scale);
    let size = Vec2::from(pixels.map(|side| side as f32));
    let height_m = (ABOVE * size.x / (points_per_metre * scale)).clamp(ABOVE_M[0], ABOVE_M[1]);
    let [right, down] = if x_is_up { [Vec3::NEG_Y, Vec3::NEG_X] } else { [Vec3::X, Vec3::NEG_Y] };
    View {
        intrinsics: Pinhole { focal_length: height_m * points_per_metre * scale, centre: size / 2.0, size },
        eye: centre.extend(height_m),
        right,
        down,
        forward: Vec3::NEG_Z,
        hidden: None,
        supersampling: supersampling(pixels),
        antialiasing: true,
        shadows: false,
    }
}

/// Returns the image of a camera of a robot in a scene, as for [`FigureMatch::view_of_robot`].
pub fn view_of_robot(
    scene: &Scene,
    settings: &CameraSettings,
    id: RobotId,
    side: CameraName,
    width: f32,
    scale: f32,
) -> Option<(View, CameraView)> {
    let robot = scene.robot(id)?;
    let mut mount = *settings.mounts.get(side)?;
    let [own_width, own_height] = mount.size.take().unwrap_or([settings.width, settings.height]);
    let height = width * own_height as f32 / own_width as f32;
    let [width, height] = pixels(Vec2::new(width, height), scale);
    let settings = CameraSettings { width, height, ..*settings };
    let camera = CameraView::new(settings.intrinsics(&mount), &mount, robot.body.neck_m, robot.head);
    let view = View::of_robot(&camera, robot.world_from_robot(), id);
    Some((View { supersampling: supersampling([width, height]), shadows: true, ..view }, camera))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn from_above_a_metre_is_as_many_points_everywhere() {
        let size = Vec2::new(400.0, 300.0);
        for (x_is_up, right, up) in [(false, Vec2::X, Vec2::Y), (true, Vec2::NEG_Y, Vec2::X)] {
            let view = view_from_above(Vec2::new(1.0, 2.0), 100.0, x_is_up, size, 2.0);
            assert!((view.right.cross(view.down) - view.forward).length() < 1e-6);
            let pixel = |offset: Vec2| view.project((Vec2::new(1.0, 2.0) + offset).extend(0.0)).unwrap();
            assert!(pixel(Vec2::ZERO).abs_diff_eq(size, 0.05));
            assert!(pixel(right).abs_diff_eq(size + Vec2::X * 200.0, 0.05), "{}", pixel(right));
            assert!(pixel(up).abs_diff_eq(size - Vec2::Y * 200.0, 0.05), "{}", pixel(up));
        }
    }
}
