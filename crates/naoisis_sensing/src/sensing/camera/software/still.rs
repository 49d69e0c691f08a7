//! A renderer for static cameras: static objects are drawn once, and redrawn only where something moves.

use bevy::math::Vec3;
use pulp::Arch;

use super::frame::{Frame, NEAR, Window, first_sample};
use super::light::Light;
use super::prepared::{PreparedScene, Still};
use super::{Renderer, ground, output, shadow, turf};
use crate::appearance::view::View;
use crate::sensing::camera::image::{Image, Layers};

/// Draws the same pictures as a [`Renderer`], faster for a camera that rarely moves.
#[derive(Default)]
pub struct StillRenderer {
    renderer: Renderer,
    /// The view and the static objects of the stored samples.
    background: Option<(View, Still)>,
    /// The samples of the ground, with the shadows of static objects.
    ground: Vec<u32>,
    /// The picture of all static objects.
    image: Image,
    /// The window of each moving body with its shadow, by the body's index.
    moving: Vec<(usize, Window)>,
    /// The windows in which something moves.
    windows: Vec<Window>,
}

impl StillRenderer {
    /// Draws the colours of the `view` of a scene into `image`, whose memory is reused.
    pub fn draw(&mut self, scene: &PreparedScene, view: &View, image: &mut Image) {
        let still = self;
        Arch::new().dispatch(
            #[inline(always)]
            move || {
                // As in `Renderer::draw_with`.
                let still = still;
                let is_same = |(from, stands): &(View, Still)| from == view && Some(stands) == scene.still.as_ref();
                if !still.background.as_ref().is_some_and(is_same) {
                    still.draw_background(scene, view);
                }
                image.clear();
                (image.width, image.height) = (still.image.width, still.image.height);
                image.rgb.extend_from_slice(&still.image.rgb);
                still.find_windows(scene, view);
                let samples = view.supersampling.max(1) as usize;
                let Self { renderer, ground, moving, windows, .. } = still;
                for window in windows {
                    renderer.frame.open(window, ground);
                    let is_there =
                        |body: usize| moving.iter().any(|(other, place)| *other == body && place.overlaps(window));
                    // The samples of the ground include the shadows of static objects.
                    let has_shadow = |body: usize| view.shadows && is_there(body);
                    renderer.draw_on_ground(scene, has_shadow, |body| !scene.bodies[body].moves || is_there(body));
                    output::develop_window(&renderer.frame, samples, &mut image.rgb);
                }
            },
        );
    }

    #[inline(always)]
    fn draw_background(&mut self, scene: &PreparedScene, view: &View) {
        let Renderer { frame, outline, .. } = &mut self.renderer;
        let stands_still = |body: usize| !scene.bodies[body].moves;
        frame.begin(view);
        ground::draw(frame, outline, scene, view);
        turf::draw(frame, view, scene.unevenness);
        if view.shadows {
            shadow::draw(frame, outline, scene, stands_still);
        }
        self.ground.clone_from(&frame.pixels);
        self.renderer.draw_on_ground(scene, |_| false, stands_still);
        output::develop(&self.renderer.frame, view, Layers::default(), &mut self.image);
        self.background = scene.still.clone().map(|still| (*view, still));
    }

    /// Finds the windows in which something moves.
    fn find_windows(&mut self, scene: &PreparedScene, view: &View) {
        self.moving.clear();
        self.windows.clear();
        let frame = &self.renderer.frame;
        for (index, body) in scene.bodies.iter().enumerate() {
            if !body.moves || body.is_hidden_from(view) {
                continue;
            }
            let mut window = window_of(frame, scene.bounds(body), view, &scene.light);
            if window.area() == 0 {
                continue;
            }
            self.moving.push((index, window.clone()));
            // Overlapping windows are merged if this reduces the area to draw.
            while let Some(other) = self
                .windows
                .iter()
                .position(|other| other.overlaps(&window) && other.with(&window).area() <= other.area() + window.area())
            {
                window = window.with(&self.windows.swap_remove(other));
            }
            self.windows.push(window);
        }
    }
}

/// The smallest window of whole pixels that contains a box, given by its least and greatest corner, and the shadow of the box.
pub(super) fn window_of(frame: &Frame, [low, high]: [Vec3; 2], view: &View, light: &Light) -> Window {
    let samples = view.supersampling.max(1) as usize;
    let (mut least, mut most) = ([f32::INFINITY; 2], [f32::NEG_INFINITY; 2]);
    for corner in 0..8 {
        let side = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
        let corner = Vec3::new(side(0), side(1), side(2));
        for point in [corner, if view.shadows { light.on_ground(corner) } else { corner }] {
            let in_camera = frame.to_camera(point);
            if in_camera.z < NEAR {
                return Window { columns: 0..frame.width, rows: 0..frame.height };
            }
            for (axis, place) in frame.project(in_camera).into_iter().enumerate() {
                least[axis] = least[axis].min(place);
                most[axis] = most[axis].max(place);
            }
        }
    }
    // One more sample on every side, for rounding.
    let pixels = |axis: usize, count: usize| {
        let from = first_sample(least[axis] - 1.0, count) / samples;
        let to = first_sample(most[axis] + 1.0, count).div_ceil(samples);
        from * samples..to * samples
    };
    Window { columns: pixels(0, frame.width), rows: pixels(1, frame.height) }
}
