//! How good a vision is: what it finds in random scenes, against what is there.
//!
//! A robot looks once in each scene, with all its cameras; what it sees is what it would in a match. It may be any robot on any
//! pitch with any ball ([`Conditions`]), and the geometric vision can be measured in the same scenes. Its cameras look where it thinks
//! that they do: what is measured is what is made of an image, and not the errors of the [gaze](super::super::gaze).
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
use super::{Findings, ImageVision, Known};
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
use crate::sensing::vision::geometric::{Observer, Views};
use crate::sensing::vision::occlusion::Occluders;
use crate::sensing::vision::{Percepts, VisionNoise, VisionSettings, VisionSource};
use naoisis_core::pitch::Pitch;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadLimits;
use naoisis_core::team::{PerTeam, Team};

/// Who looks at what.
#[derive(Clone, PartialEq, Debug)]
pub struct Conditions {
    /// The pitch.
    pub pitch: Pitch,
    /// The ball's radius, m.
    pub ball_radius_m: f32,
    /// The bodies of the teams' robots. One of the blue team looks.
    pub bodies: PerTeam<Body>,
    /// How far its head turns.
    pub head: HeadLimits,
    /// Its cameras, and how images are drawn.
    pub cameras: CameraSettings,
    /// What it sees by: its images, or geometry with these errors.
    pub vision: VisionSettings,
}

impl Default for Conditions {
    /// A NAO on the paper's pitch that looks at its images.
    fn default() -> Self {
        Self {
            pitch: Pitch::default(),
            ball_radius_m: 0.03,
            bodies: PerTeam::default(),
            head: HeadLimits::default(),
            cameras: CameraSettings::default(),
            vision: VisionSettings { source: VisionSource::Image, ..VisionSettings::default() },
        }
    }
}

impl Conditions {
    /// What the robot knows of what it looks for.
    fn known(&self) -> Known {
        Known::new(&self.pitch, self.ball_radius_m).with_robots(Team::BOTH.map(|team| (team, &self.bodies[team])))
    }
}

/// What came of all.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Accuracy {
    /// How often the robot looked, with all its cameras.
    pub looks: usize,
    /// Images that were looked through.
    pub images: usize,
    /// How long looking through them took, drawing aside, of wall-clock time: it differs from run to run.
    pub looking: Duration,
    /// The ball.
    pub ball: ClassAccuracy,
    /// Goal posts.
    pub goal_posts: ClassAccuracy,
    /// Robots.
    pub robots: ClassAccuracy,
    /// Stretches of straight lines: each by the point of it that is nearest to the robot.
    pub lines: ClassAccuracy,
    /// Where lines meet, those with the centre circle aside.
    pub junctions: ClassAccuracy,
    /// Penalty crosses.
    pub penalty_crosses: ClassAccuracy,
    /// The centre circle, by its centre.
    pub centre_circle: ClassAccuracy,
    /// Arcs at corners, each by its corner.
    pub corner_arcs: ClassAccuracy,
}

/// Memory for drawing and looking.
#[derive(Default)]
struct Workshop {
    prepared: PreparedScene,
    renderer: Renderer,
    lens: LensBuffer,
    noise: NoiseBuffer,
    vision: ImageVision,
    findings: Findings,
    image: Image,
    occluders: Occluders,
}

/// Looks at random scenes.
pub fn measure(scenes: usize, conditions: &Conditions, stream: &mut RandomStream) -> Accuracy {
    let mut accuracy = Accuracy::default();
    let mut workshop = Workshop::default();
    // The scenes are the same, whatever else is drawn by chance.
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
    /// What the geometric vision with these errors sees.
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
        views.look(cameras, looks, noise, streams[0]);
        self.occluders.gather(scene, Some(0), own.pose, views.actual());
        let mut observer = Observer::new(&views, own.pose, noise, &self.occluders, streams);
        observer.recognise_everything(percepts, scene, Some(0), &mut LandmarksAhead::default());
    }

    /// Draws the images of all cameras and looks through them. Returns what they show.
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
        let known = conditions.known();
        let own = scene.robots[0];
        self.prepared.prepare(scene, Detail { design: settings.design, ..Detail::default() });
        let mut shown = Vec::new();
        for (index, (mount, (side, camera))) in
            settings.mounts.as_slice().iter().zip(settings.views(own.head).named()).enumerate()
        {
            let lens = settings.lens_of(mount).effect(camera.intrinsics, Vec2::ZERO);
            let mut view = View::of_robot(camera, own.world_from_robot(), own.id);
            view.intrinsics = lens.drawn();
            view.shadows = settings.shadows;
            view.antialiasing = settings.antialiasing;
            self.renderer.draw(&self.prepared, &view, Layers::ALL, &mut self.image);
            shown.push(Shown::new(&self.image, &view));
            lens.apply(&mut self.image, &mut self.lens);
            settings.noise.draw(stream).apply(&mut self.image, &mut self.noise);
            let started = Instant::now();
            self.vision.recognise(&self.image, side, camera, &known, &mut self.findings);
            accuracy.looking += started.elapsed();
            accuracy.images += 1;
            merge(percepts, index > 0, &self.findings);
        }
        shown
    }
}

/// What the pixels of an image show, with their labels: points in the pitch frame, m.
struct Shown {
    points: Vec<(Label, Vec3)>,
    view: View,
}

impl Shown {
    fn new(image: &Image, view: &View) -> Self {
        let mut points = Vec::new();
        for v in 0..image.height {
            for u in 0..image.width {
                let (Some(label), Some(depth)) = (image.label(u, v), image.depth(u, v)) else { continue };
                if label == Label::Line || !label.is_ground() && label != Label::Sky {
                    points.push((label, view.eye + depth * view.ray(Vec2::new(u as f32 + 0.5, v as f32 + 0.5))));
                }
            }
        }
        Self { points, view: *view }
    }

    /// How many pixels with this label show something that is so.
    fn count(&self, label: Label, is_so: impl Fn(Vec3) -> bool) -> usize {
        self.points.iter().filter(|(other, point)| *other == label && is_so(*point)).count()
    }
}
