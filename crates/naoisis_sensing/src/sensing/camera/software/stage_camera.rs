//! A camera that takes images of [stages](super::stage), with the errors of a real one.

use bevy::math::Vec2;

use super::stage::Stage;
use super::still::window_of;
use super::{PreparedScene, Renderer, polygon, round};
use crate::appearance::view::View;
use crate::sensing::camera::image::{Image, Layers};
use crate::sensing::camera::lens::{Lens, LensBuffer};
use crate::sensing::camera::noise::{ImageNoise, NoiseBuffer};
use naoisis_core::camera_model::CameraIntrinsics;
use naoisis_core::random::RandomStream;

/// A camera that takes images of stages, with lens and noise.
#[derive(Default)]
pub struct StageCamera {
    scene: PreparedScene,
    renderer: Renderer,
    lens: LensBuffer,
    noise: NoiseBuffer,
}

impl StageCamera {
    /// Number of faces around a cylinder.
    const SEGMENTS: usize = 16;

    /// Sets the stage.
    pub fn set(&mut self, stage: &Stage) {
        self.scene.prepare_stage(stage, Self::SEGMENTS);
    }

    /// Draws the stage without lens and noise, with the number of each pixel as its label, and its depth.
    pub fn draw(&mut self, view: &View, image: &mut Image) {
        self.renderer.draw(&self.scene, view, Layers::ALL, image);
    }

    /// Returns the number of pixels of each body in a picture without the other bodies, in the order of the bodies; 0 for bodies out of
    /// view.
    pub fn silhouettes(&mut self, view: &View) -> Vec<usize> {
        let view = View { supersampling: 1, shadows: false, ..*view };
        self.renderer.silhouettes(&self.scene, &view)
    }

    /// Turns a drawn picture, with its labels and depth, into the image of a real camera, which turns by `turn` (yaw and pitch, rad/s).
    pub fn develop(
        &mut self,
        image: &mut Image,
        lens: &Lens,
        intrinsics: CameraIntrinsics,
        turn: Vec2,
        noise: &ImageNoise,
        stream: &mut RandomStream,
    ) {
        lens.effect(intrinsics, turn).apply(image, &mut self.lens);
        noise.draw(stream).apply(image, &mut self.noise);
    }
}

impl Renderer {
    fn silhouettes(&mut self, scene: &PreparedScene, view: &View) -> Vec<usize> {
        let Self { frame, outline, .. } = self;
        frame.begin(view);
        let mut counts = Vec::with_capacity(scene.bodies.len());
        for body in &scene.bodies {
            let whole = frame.window.clone();
            let centre = frame.to_camera(body.centre);
            if !frame.may_see(centre, body.reach) {
                counts.push(0);
                continue;
            }
            frame.window = window_of(frame, scene.bounds(body), view, &scene.light);
            for face in &scene.faces[body.faces.clone()] {
                polygon::draw_face(frame, outline, face, &scene.corners);
            }
            for part in &scene.rounds[body.rounds.clone()] {
                round::draw(frame, &scene.light, part, &[]);
            }
            let mut count = 0;
            for row in frame.window.rows.clone() {
                let columns = frame.window.columns.clone();
                let samples = &mut frame.nearness[row * frame.width + columns.start..row * frame.width + columns.end];
                count += samples.iter().filter(|nearness| **nearness > 0.0).count();
                samples.fill(0.0);
            }
            counts.push(count);
            frame.window = whole;
        }
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::appearance::Label;
    use crate::appearance::colours::Colour;
    use crate::appearance::shapes::{Part, Shape};
    use crate::sensing::camera::software::light::Light;
    use crate::sensing::camera::software::stage::{PatchArea, StageBody};
    use bevy::math::Vec3;

    fn ball(number: u8, x: f32, radius: f32) -> StageBody {
        let part = Part::at((), Label::Ball, Colour([200; 3]), Shape::sphere(radius), Vec3::new(x, 0.0, 1.0));
        StageBody { number, parts: vec![part], ..StageBody::default() }
    }

    fn stage(bodies: Vec<StageBody>) -> Stage {
        let grey = Colour([128; 3]);
        let (ground, nets) = (Vec::new(), Vec::new());
        Stage { light: Light::default(), sky: grey, floor: grey, ground, net: grey, nets, bodies }
    }

    fn view() -> View {
        View::looking_at(Vec3::new(-2.0, 0.0, 1.0), Vec3::Z, 0.8, [160, 120])
    }

    #[test]
    fn bodies_are_found_by_their_numbers_and_counted_as_if_nothing_hid_them() {
        let mut camera = StageCamera::default();
        // A small ball hides a part of the large one behind it, and another is behind the camera.
        camera.set(&stage(vec![ball(5, 0.5, 0.2), ball(100, 0.0, 0.1), ball(101, -5.0, 0.1)]));
        let mut image = Image::default();
        camera.draw(&view(), &mut image);
        let count = |number: u8| image.labels.iter().filter(|label| **label == number).count();
        let [large, small, behind] = camera.silhouettes(&view()).try_into().unwrap();
        assert_eq!(behind, 0);
        assert!(small.abs_diff(count(100)) <= small / 50, "{small} {}", count(100));
        // The large ball without the small one in front of it.
        assert!(large.abs_diff(count(5) + count(100)) <= large / 50, "{large} {} {}", count(5), count(100));
    }

    #[test]
    fn patches_cover_a_part_of_a_ball() {
        let red = Colour([200, 0, 0]);
        let mut striped = ball(5, 0.0, 0.5);
        striped.patches = vec![PatchArea { axis: Vec3::Z, from: 0.0, to: 1.0, colour: red }];
        let mut camera = StageCamera::default();
        camera.set(&stage(vec![striped]));
        let mut image = Image::default();
        camera.draw(&view(), &mut image);
        let [upper, lower] = [50, 70].map(|v| image.colour(80, v).unwrap());
        assert!(upper[0] > 100 && upper[1] == 0 && lower[0] == lower[1], "{upper:?} {lower:?}");
        assert_eq!(image.labels[50 * 160 + 80], 5);
    }

    #[test]
    fn a_match_is_drawn_after_a_stage_as_before_it() {
        use crate::appearance::scene::Scene;
        use crate::sensing::camera::software::Detail;

        let empty = Scene::empty(naoisis_core::pitch::Pitch::default());
        let after = |before: Option<&Stage>| {
            let (mut scene, mut image) = (PreparedScene::default(), Image::default());
            before.inspect(|stage| scene.prepare_stage(stage, 8));
            scene.prepare(&empty, Detail::default());
            Renderer::default().draw(&scene, &view(), Layers::ALL, &mut image);
            image
        };
        let other = Stage { sky: Colour([1, 2, 3]), ..stage(vec![ball(5, 0.0, 0.5)]) };
        assert_eq!(after(Some(&other)), after(None));
    }
}
