//! The software renderer: pictures of a [scene](crate::appearance::scene::Scene) without a graphics card.
//!
//! The ground and its markings are drawn analytically: each marking is an area of the image with straight or conic edges, whose span is
//! computed and filled in each row; a partly covered pixel has a mixed colour. Bodies are drawn by a rasteriser with a depth buffer: flat
//! and smoothly shaded faces, and ellipsoids, which are intersected with the ray of each pixel. There is one sun and ambient light; shadows
//! on the ground are optional.
//!
//! The same scene and view give the same picture, bit by bit, in every run and on every machine: it is computed with additions,
//! multiplications, divisions and square roots in a fixed order, with any instruction set of the processor.
//!
//! ```
//! use bevy::math::Vec3;
//! use naoisis::internal::appearance::scene::Scene;
//! use naoisis::internal::appearance::view::View;
//! use naoisis::pitch::Pitch;
//! use naoisis::sensing::camera::image::{Image, Layers};
//! use naoisis::sensing::camera::software::{Detail, PreparedScene, Renderer};
//!
//! let mut scene = PreparedScene::default();
//! scene.prepare(&Scene::empty(Pitch::default()), Detail::default());
//! let view = View::looking_at(Vec3::new(0.0, -4.0, 5.0), Vec3::ZERO, 0.8, [320, 240]);
//! let mut image = Image::default();
//! Renderer::default().draw(&scene, &view, Layers::default(), &mut image);
//! // The halfway line is in the middle.
//! assert!(image.colour(160, 100).unwrap().iter().all(|channel| *channel > 200));
//! ```

use pulp::Arch;

mod conic;
mod coverage;
mod frame;
mod ground;
pub mod light;
mod lines;
mod model;
mod output;
mod polygon;
mod prepared;
mod round;
mod shadow;
pub mod stage;
pub mod stage_camera;
mod still;
mod turf;

pub use frame::NEAR;
pub use prepared::{Detail, PreparedScene};
pub use still::StillRenderer;

use super::image::{Image, Layers};
use crate::appearance::view::View;
use frame::Frame;
use polygon::Outline;

/// The software renderer. It reuses its memory from picture to picture, so keep it.
#[derive(Default)]
pub struct Renderer {
    frame: Frame,
    outline: Outline,
    order: Vec<(f32, usize)>,
}

impl Renderer {
    /// Draws the `view` of a scene into `image`, whose memory is reused.
    pub fn draw(&mut self, scene: &PreparedScene, view: &View, layers: Layers, image: &mut Image) {
        self.draw_with(Arch::new(), scene, view, layers, image);
    }

    /// Draws with a chosen instruction set.
    fn draw_with(&mut self, arch: Arch, scene: &PreparedScene, view: &View, layers: Layers, image: &mut Image) {
        let renderer = self;
        arch.dispatch(
            #[inline(always)]
            move || {
                // As `renderer` is moved, the closure can be called only once. Otherwise the compiler would insert a function without these
                // instructions.
                let renderer = renderer;
                renderer.frame.begin(view);
                ground::draw(&mut renderer.frame, &mut renderer.outline, scene, view);
                turf::draw(&mut renderer.frame, view, scene.unevenness);
                let is_drawn = |body: usize| !scene.bodies[body].is_hidden_from(view);
                renderer.draw_on_ground(scene, |body| view.shadows && is_drawn(body), is_drawn);
                output::develop(&renderer.frame, view, layers, image);
            },
        );
    }

    /// Draws the shadows and bodies that the predicates choose by index, and the nets, into a frame with the ground alone.
    #[inline(always)]
    fn draw_on_ground(
        &mut self,
        scene: &PreparedScene,
        has_shadow: impl Fn(usize) -> bool,
        is_drawn: impl Fn(usize) -> bool,
    ) {
        let Self { frame, outline, order } = self;
        shadow::draw(frame, outline, scene, has_shadow);
        scene.nearest_first(frame, is_drawn, order);
        for &(_, index) in order.iter() {
            let body = &scene.bodies[index];
            for face in &scene.faces[body.faces.clone()] {
                polygon::draw_face(frame, outline, face, &scene.corners);
            }
            for round in &scene.rounds[body.rounds.clone()] {
                round::draw(frame, &scene.light, round, &scene.patches[round.patches.clone()]);
            }
        }
        lines::draw_nets(frame, scene);
    }
}

#[cfg(test)]
mod tests;
