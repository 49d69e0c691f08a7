//! Draws a match: the field and the views of the robots' cameras.
//!
//! Recording does not change the match: these images are drawn in addition to the match's own ones. They are drawn on the graphics card if
//! the match's camera images are, otherwise in software.

use bevy::math::ops;
use bevy::prelude::*;

use super::overlay::{OverlayOf, draw_over};
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::CycleClock;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::robot::RobotDesign;
use naoisis_sensing::appearance::scene::Scene;
use naoisis_sensing::appearance::view::View;
use naoisis_sensing::sensing::camera::image::{Image, ImageRequest, Layers};
use naoisis_sensing::sensing::camera::software::{Detail, PreparedScene, Renderer, StillRenderer};
use naoisis_sensing::sensing::camera::{CameraImages, CameraSettings, GpuCameras};
use naoisis_sensing::sensing::vision::VisionSettings;

/// Number of faces around a cylinder.
const SEGMENTS: usize = 20;

/// Draws a match.
#[derive(Default)]
pub struct MatchRenderer {
    scene: Scene,
    /// The scene for each design, and whether it is up to date.
    prepared: [PreparedScene; 2],
    is_prepared: [bool; 2],
    renderer: Renderer,
    still_renderer: StillRenderer,
    /// Overlays on pictures of the field.
    pub overlays: Vec<OverlayOf>,
}

impl MatchRenderer {
    /// Takes over the current state of the match.
    pub fn look(&mut self, world: &mut World) {
        self.is_prepared = [false; 2];
        self.scene.gather(world);
    }

    /// Returns the scene of the last [`look`](Self::look).
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Draws the scene with robots that look like a NAO. Objects that do not move are only drawn once for a camera that does not move.
    pub fn draw(&mut self, world: &mut World, view: &View) -> Image {
        let design = Detail::FINE.design;
        let mut shot = ImageRequest { view: *view, design, layers: Layers::default(), image: Image::default() };
        if !self.is_drawn_by_gpu(world, &mut shot) {
            self.prepare(design);
            self.still_renderer.draw(&self.prepared[design as usize], view, &mut shot.image);
        }
        shot.image
    }

    /// Draws the whole field with the overlays, in a size in pixels, each of which has `samples` across and down.
    pub fn draw_field(&mut self, world: &mut World, size: [u32; 2], samples: u32) -> Image {
        let view = View { supersampling: samples, ..view_of_field(&self.scene.pitch, size) };
        let picture = self.draw(world, &view);
        if self.overlays.is_empty() { picture } else { draw_over(world, &picture, &view, &self.overlays) }
    }

    /// Draws the image of a moving camera.
    fn draw_shot(&mut self, world: &mut World, mut shot: ImageRequest) -> Image {
        if !self.is_drawn_by_gpu(world, &mut shot) {
            self.prepare(shot.design);
            let prepared = &self.prepared[shot.design as usize];
            self.renderer.draw(prepared, &shot.view, shot.layers, &mut shot.image);
        }
        shot.image
    }

    fn is_drawn_by_gpu(&self, world: &mut World, shot: &mut ImageRequest) -> bool {
        let Some(mut gpu) = world.get_resource_mut::<GpuCameras>() else { return false };
        let drawn = gpu.0.draw(&self.scene, &mut [shot]);
        drawn.inspect_err(|error| error!("a picture is drawn in software: {error}")).is_ok()
    }

    fn prepare(&mut self, design: RobotDesign) {
        if !core::mem::replace(&mut self.is_prepared[design as usize], true) {
            self.prepared[design as usize].prepare(&self.scene, Detail { design, segments: SEGMENTS });
        }
    }

    /// Returns what a robot's camera sees: the newest image that the match rendered for it or, if there is none, an image drawn now.
    /// Returns `None` if the robot is not on the pitch.
    pub fn through_the_eyes_of(&mut self, world: &mut World, id: RobotId, side: CameraName) -> Option<Image> {
        if let Some((_, image)) = newest_image(world, id, side) {
            return Some(image.clone());
        }
        let entity = world.resource::<Roster>().get(id)?;
        let settings = world.get::<CameraSettings>(entity).copied().unwrap_or_default();
        self.draw_view_of_robot(world, id, side, Layers { labels: settings.labels, depth: settings.depth })
    }

    /// Draws what a robot's camera would see now, with these layers. Returns `None` if the robot is not on the pitch.
    pub fn draw_view_of_robot(
        &mut self,
        world: &mut World,
        id: RobotId,
        side: CameraName,
        layers: Layers,
    ) -> Option<Image> {
        let robot = *self.scene.robot(id)?;
        let entity = world.resource::<Roster>().get(id)?;
        let settings = world.get::<CameraSettings>(entity).copied().unwrap_or_default();
        let camera = settings.view(side, &robot.body, robot.head)?;
        let mut view = View::of_robot(&camera, robot.world_from_robot(), id);
        view.shadows = settings.shadows;
        // Before the first image of the match, the picture already has that image's design.
        let has_images = settings.renderer(world.get::<VisionSettings>(entity)).is_some();
        let design = if has_images { settings.design } else { RobotDesign::Nao };
        Some(self.draw_shot(world, ImageRequest { view, design, layers, image: Image::default() }))
    }
}

/// Returns the newest image that the match rendered for a robot's camera, with the cycles in which it was taken and arrived. An image that
/// should have been replaced by now does not count.
pub(super) fn newest_image(world: &World, id: RobotId, side: CameraName) -> Option<([u64; 2], &Image)> {
    let entity = world.resource::<Roster>().get(id)?;
    let images = world.get::<CameraImages>(entity)?;
    let every = world.get::<CameraSettings>(entity).map_or(1, |settings| settings.every_cycles.max(1));
    let (taken, arrived) = images.cycle.zip(images.arrived)?;
    let age = world.resource::<CycleClock>().cycle.checked_sub(arrived)?;
    (age < u64::from(every) && !images.of(side).is_empty()).then(|| ([taken, arrived], images.of(side)))
}

/// Returns a view of the whole pitch and both goals from above a side line, as large as possible in a picture of this size in pixels.
pub fn view_of_field(pitch: &Pitch, size: [u32; 2]) -> View {
    /// Angle of the view below the horizontal, and its vertical field of view, rad.
    const DOWN: f32 = 0.80;
    const VERTICAL_FOV: f32 = 0.61;
    /// Margin on every side, as a share of the picture.
    const MARGIN: f32 = 0.025;

    let corner = pitch.outer_half_extents();
    let top_m = pitch.goal.height_m;
    let corners = [-1.0, 1.0].into_iter().flat_map(|x| {
        [(-1.0, 0.0), (1.0, 0.0), (0.0, top_m)].map(|(y, height_m)| Vec3::new(x * corner.x, y * corner.y, height_m))
    });
    let corners: Vec<Vec3> = corners.collect();
    let (sin, cos) = ops::sin_cos(DOWN);
    let picture = Vec2::new(size[0] as f32, size[1] as f32);
    // The shortest distance at which everything is in the picture, by bisection. At every distance, a few steps find the point to look at
    // for which the visible part is vertically centred.
    let (mut near_m, mut far_m) = (0.0, 20.0 * corner.length());
    let (mut target, mut view) = (Vec3::ZERO, View::looking_at(Vec3::Z, Vec3::ZERO, VERTICAL_FOV, size));
    for _ in 0..24 {
        let distance_m = (near_m + far_m) / 2.0;
        let mut is_whole = false;
        for _ in 0..4 {
            let eye = target + distance_m * Vec3::new(0.0, -cos, sin);
            view = View::looking_at(eye, target, VERTICAL_FOV, size);
            let pixels: Option<Vec<Vec2>> = corners.iter().map(|corner| view.project(*corner)).collect();
            let Some(pixels) = pixels else { break };
            let least = pixels.iter().copied().fold(Vec2::INFINITY, Vec2::min);
            let most = pixels.iter().copied().fold(Vec2::NEG_INFINITY, Vec2::max);
            is_whole = least.cmpge(MARGIN * picture).all() && most.cmple((1.0 - MARGIN) * picture).all();
            // Length on the ground, away from the viewer, that a pixel near the middle covers.
            let pixel_m = distance_m / view.intrinsics.focal_length / sin;
            target.y -= ((least.y + most.y) / 2.0 - picture.y / 2.0) * pixel_m;
        }
        if is_whole {
            far_m = distance_m;
        } else {
            near_m = distance_m;
        }
    }
    let eye = target + far_m * Vec3::new(0.0, -cos, sin);
    View { eye, ..view }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_sim::scenario::Scenario;
    use naoisis_sim::scenario::pitch_preset;
    use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

    #[test]
    fn a_leg_swings_in_pictures_of_a_kick() {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        let scenario = r#"{ "rules": "free", "ball": { "position_m": [0.15, -0.05] }, "robots": [{ "number": 1,
            "behaviour": { "script": [{ "from_s": 0.1, "kick": { "type": "right_straight", "speed": 1.0 } }] } }] }"#;
        app.start_match(&Scenario::from_json(scenario).unwrap()).unwrap();
        let mut renderer = MatchRenderer::default();
        let mut hips = Vec::new();
        for _ in 0..8 {
            app.run_cycles(1);
            renderer.look(app.world_mut());
            let robot = renderer.scene().robots[0];
            hips.push(robot.stride.joints(robot.id, robot.head, &robot.body).legs[1].hip);
        }
        // The robot stands still at first. When it strikes the ball, its right leg is far in front.
        assert!(hips[0].abs() < 0.01 && hips.iter().any(|hip| *hip > 0.3), "{hips:?}");
    }

    #[test]
    fn the_whole_pitch_is_in_the_picture() {
        for pitch in ["naoisis", "spl2025"].map(|name| pitch_preset(name).unwrap()) {
            let (view, corner) = (view_of_field(&pitch, [960, 540]), pitch.outer_half_extents());
            let mut pixels = [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)]
                .map(|(x, y)| view.project(Vec3::new(x * corner.x, y * corner.y, 0.0)).unwrap());
            for pixel in pixels {
                assert!(pixel.cmpgt(Vec2::ZERO).all() && pixel.cmplt(Vec2::new(960.0, 540.0)).all(), "{pixel}");
            }
            // The pitch fills the picture in one direction.
            pixels.sort_by(|a, b| a.x.total_cmp(&b.x));
            let width = pixels[3].x - pixels[0].x;
            pixels.sort_by(|a, b| a.y.total_cmp(&b.y));
            let height = pixels[3].y - pixels[0].y;
            assert!(width > 0.93 * 960.0 || height > 0.85 * 540.0, "{width} x {height}");
        }
    }
}
