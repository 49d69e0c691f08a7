//! The accuracy of a vision: its detections in random scenes, compared with the true objects.
//!
//! A robot looks once in each scene, with all its cameras, as in a match. It may be any robot on any pitch with any ball ([`Conditions`]), and
//! the geometric vision can be measured in the same scenes. The camera directions are exact: the errors of the [gaze](super::super::gaze) are
//! not included.
//!
//! ```
//! use naoisis::random::RandomStream;
//! use naoisis::sensing::vision::image::accuracy::{self, Conditions, EVERYWHERE_M};
//!
//! let mut stream = RandomStream::for_match(1, "accuracy");
//! let table = accuracy::measure(20, &Conditions::default(), &mut stream);
//! assert!(table.ball.found_share(EVERYWHERE_M) > 0.5);
//! println!("{table}");
//! ```

use bevy::math::{Vec2, Vec3};
use rand::Rng;
use std::time::{Duration, Instant};

mod class;
mod judging;
mod scenes;
mod table;

pub use class::{ClassAccuracy, LEAST_PIXELS, SceneSighting};
pub use table::EVERYWHERE_M;

use super::seeing::merge;
use super::{ImageDetections, ImageVision, ObjectModel};
use crate::appearance::Label;
use crate::appearance::scene::Scene;
use crate::appearance::view::View;
use crate::sensing::camera::CameraSettings;
use crate::sensing::camera::image::{Image, Layers};
use crate::sensing::camera::lens::LensBuffer;
use crate::sensing::camera::noise::NoiseBuffer;
use crate::sensing::camera::software::{Detail, PreparedScene, Renderer};
use crate::sensing::vision::ahead::LandmarksAhead;
use crate::sensing::vision::gaze::GazeError;
use crate::sensing::vision::observer::{Observer, Views};
use crate::sensing::vision::occlusion::Occluders;
use crate::sensing::vision::{Percepts, VisionNoise, VisionSettings, VisionSource};
use naoisis_core::ball::BallLook;
use naoisis_core::camera_model::CameraIntrinsics;
use naoisis_core::pitch::Pitch;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::team::{PerTeam, Team};

/// The conditions of a measurement.
#[derive(Clone, PartialEq, Debug)]
pub struct Conditions {
    /// The pitch.
    pub pitch: Pitch,
    /// The ball's radius, m.
    pub ball_radius_m: f32,
    /// The ball's colours.
    pub ball_look: BallLook,
    /// The bodies of the teams' robots. A robot of the blue team looks.
    pub bodies: PerTeam<Body>,
    /// The limits of the looking robot's head.
    pub head: HeadLimits,
    /// The looking robot's cameras.
    pub cameras: CameraSettings,
    /// The looking robot's vision: from images, or geometric with these errors.
    pub vision: VisionSettings,
}

impl Default for Conditions {
    /// A NAO on the paper's pitch with the image vision.
    fn default() -> Self {
        Self {
            pitch: Pitch::default(),
            ball_radius_m: 0.03,
            ball_look: BallLook::Orange,
            bodies: PerTeam::default(),
            head: HeadLimits::default(),
            cameras: CameraSettings::default(),
            vision: VisionSettings { source: VisionSource::Image, ..VisionSettings::default() },
        }
    }
}

impl Conditions {
    /// The object model of the image vision.
    fn object_model(&self) -> ObjectModel {
        let model = ObjectModel { ball_look: self.ball_look, ..ObjectModel::new(&self.pitch, self.ball_radius_m) };
        model.with_robots(Team::BOTH.map(|team| (team, &self.bodies[team])))
    }
}

/// The accuracy of a vision.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Accuracy {
    /// The number of looks, with all cameras each.
    pub looks: usize,
    /// The number of images.
    pub images: usize,
    /// The wall-clock time of processing the images, without drawing them. It differs from run to run.
    pub looking: Duration,
    /// The ball.
    pub ball: ClassAccuracy,
    /// Goal posts.
    pub goal_posts: ClassAccuracy,
    /// Robots.
    pub robots: ClassAccuracy,
    /// Line segments, each by its point nearest to the robot.
    pub lines: ClassAccuracy,
    /// Junctions, without those with the centre circle.
    pub junctions: ClassAccuracy,
    /// Penalty crosses.
    pub penalty_crosses: ClassAccuracy,
    /// The centre circle, by its centre.
    pub centre_circle: ClassAccuracy,
    /// Corner arcs, each by its corner.
    pub corner_arcs: ClassAccuracy,
}

/// Memory for drawing and processing.
#[derive(Default)]
struct Workshop {
    prepared: PreparedScene,
    renderer: Renderer,
    lens: LensBuffer,
    noise: NoiseBuffer,
    vision: ImageVision,
    detections: ImageDetections,
    image: Image,
    occluders: Occluders,
}

/// Measures the accuracy in a number of random scenes.
pub fn measure(scenes: usize, conditions: &Conditions, stream: &mut RandomStream) -> Accuracy {
    let mut accuracy = Accuracy::default();
    let mut workshop = Workshop::default();
    // Separate streams, so that the scenes do not depend on the noise.
    let [mut of_images, mut of_vision, mut of_recognition] =
        ["images", "vision", "recognition"].map(|purpose| RandomStream::for_match(stream.next_u64(), purpose));
    let (exact, mut seen) = (VisionNoise::none(), Percepts::default());
    let mut in_view = Percepts::default();
    for _ in 0..scenes {
        let scene = scenes::random_scene(conditions, stream);
        let streams = [&mut of_vision, &mut of_recognition];
        workshop.see_geometrically(&scene, &conditions.cameras, &exact, streams, &mut in_view);
        let images = workshop.look_through_images(&scene, conditions, &mut of_images, &mut seen, &mut accuracy);
        if conditions.vision.source == VisionSource::Geometric {
            let streams = [&mut of_vision, &mut of_recognition];
            workshop.see_geometrically(&scene, &conditions.cameras, &conditions.vision.noise, streams, &mut seen);
        }
        accuracy.looks += 1;
        accuracy.judge(&scene, &images, &in_view, &seen);
    }
    accuracy
}

impl Workshop {
    /// Fills `percepts` by the geometric vision with these errors.
    fn see_geometrically(
        &mut self,
        scene: &Scene,
        cameras: &CameraSettings,
        noise: &VisionNoise,
        streams: [&mut RandomStream; 2],
        percepts: &mut Percepts,
    ) {
        percepts.clear();
        let own = scene.robots[0];
        let looks = (own.head, &GazeError::default());
        let mut views = Views::default();
        views.update((cameras, &own.body), looks, noise, streams[0]);
        self.occluders.gather(scene, Some(0), own.pose, views.actual());
        let mut observer = Observer::new(&views, own.pose, noise, &self.occluders, streams);
        observer.recognise_everything(percepts, scene, Some(0), &mut LandmarksAhead::default(), None);
        observer.add_false_positives(percepts, scene);
    }

    /// Draws the images of all cameras, and fills `percepts` by the image vision. Returns the true contents of the images.
    fn look_through_images(
        &mut self,
        scene: &Scene,
        conditions: &Conditions,
        stream: &mut RandomStream,
        percepts: &mut Percepts,
        accuracy: &mut Accuracy,
    ) -> Vec<Shown> {
        percepts.clear();
        let settings = &conditions.cameras;
        let model = conditions.object_model();
        let own = scene.robots[0];
        self.prepared.prepare(scene, Detail { design: settings.design, ..Detail::default() });
        let mut shown = Vec::new();
        for (index, (camera, view_of_camera)) in settings.views(&own.body, own.head).named().enumerate() {
            let lens = settings.lens.effect(view_of_camera.intrinsics, Vec2::ZERO);
            let mut view = View::of_robot(view_of_camera, own.world_from_robot(), own.id);
            view.shadows = settings.shadows;
            view.antialiasing = settings.antialiasing;
            self.renderer.draw(&self.prepared, &view, Layers::ALL, &mut self.image);
            lens.apply(&mut self.image, &mut self.lens);
            shown.push(Shown::new(&self.image, &view, view_of_camera.intrinsics));
            settings.noise.draw(stream).apply(&mut self.image, &mut self.noise);
            let started = Instant::now();
            self.vision.recognise(&self.image, camera, view_of_camera, &model, &mut self.detections);
            accuracy.looking += started.elapsed();
            accuracy.images += 1;
            merge(percepts, index > 0, &self.detections);
        }
        shown
    }
}

/// The true contents of an image: labelled points in the pitch frame, m.
struct Shown {
    points: Vec<(Label, Vec3)>,
    view: View,
    intrinsics: CameraIntrinsics,
}

impl Shown {
    fn new(image: &Image, view: &View, intrinsics: CameraIntrinsics) -> Self {
        let mut points = Vec::new();
        for v in 0..image.height {
            for u in 0..image.width {
                let (Some(label), Some(depth)) = (image.label(u, v), image.depth(u, v)) else { continue };
                if label == Label::Line || !label.is_ground() && label != Label::Sky {
                    let pixel = intrinsics.in_drawn(Vec2::new(u as f32 + 0.5, v as f32 + 0.5));
                    points.push((label, view.eye + depth * view.ray(pixel)));
                }
            }
        }
        Self { points, view: *view, intrinsics }
    }

    /// The number of pixels with this label whose point fulfils `is_so`.
    fn count(&self, label: Label, is_so: impl Fn(Vec3) -> bool) -> usize {
        self.points.iter().filter(|(other, point)| *other == label && is_so(*point)).count()
    }
}
