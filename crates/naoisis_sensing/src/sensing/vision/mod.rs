//! Vision: the objects that the cameras detect.
//!
//! **What it measures.** [`Percepts`]: the ball, goal posts with their colour, robots with their team by the waistband, line segments, line
//! junctions (L, T, X), penalty crosses, the centre circle and corner arcs. Each has the pixel in the camera's image, and the position on
//! the ground that follows from that pixel and the measured head angles. No image is rendered: which objects are in view follows from the
//! [camera model](naoisis_core::camera_model), and from the robots' boxes and the posts, which hide other objects.
//!
//! | class | detected when | measured at |
//! |---|---|---|
//! | ball | 3 of 5 points of its disc (centre, left, right, above, below) are visible | its centre, a ball's radius above the ground |
//! | goal post | 2 of 5 points of its axis are visible | its foot; if that is not visible, its top; otherwise by its width in the image |
//! | robot | 3 of 9 points of its waistband (25 to 35 cm high) are visible | its foot; otherwise the highest visible row of its waistband |
//! | line | a segment of at least 10 pixels is in the image, and 2 of 3 points of it are visible | both ends of the segment |
//! | junction, cross | it is visible | itself |
//! | centre circle, corner arc | 3 of 8 points of it are visible, of an arc 3 of 5 | its centre, in the image or not; the corner |
//!
//! A visible point is in the image, and no robot or post is in front of it. An object that two cameras see is one percept, from the camera
//! that sees its foot, or otherwise has it nearer to the middle of the image; of a line, each camera reports its own segment. Percepts are
//! ordered from left to right in the image, so that their order carries no other information. Of several balls the nearest is the ball.
//!
//! **Units and rate.** Pixels and metres, the robot frame; once a cycle, both cameras.
//!
//! **Noise** is added in the image ([`VisionNoise`]): an error of the pixel, misses, false detections and a greatest distance for each
//! class, and an error of the head angles. So the error of a position grows with the square of its distance, as on a real robot. The preset
//! `default` has the figures of B-Human's simulator for its own vision, in which the errors of successive images are independent.
//!
//! The errors of a real vision last longer than an image, and so do those of `realistic` robots: the [`gaze`] has a drift that lasts for
//! about a step, greater while walking, and a bias for a whole match ([`GazeNoise`]); objects that are far away or partly hidden are
//! detected less often, without a greatest distance ([`Falloff`]); a line junction looks like a ball for seconds, from any direction
//! ([`FalsePositives`]); and the distance to a robot whose feet are hidden is too great ([`HiddenFeet`]). Percepts have a confidence
//! ([`VisionNoise::confidence`]).
//!
//! **By images** ([`VisionSource::Image`]), everything is detected in the [rendered images](crate::sensing::camera) alone: see [`image`].
//! The noise is then that of the images. A program's own vision processes the images in [`SensingSystems::Custom`], and fills the percepts
//! itself.
//!
//! **Truth** ([`VisionSource::Truth`]) is for debugging: all objects on the pitch at their true positions, in view or not.
//!
//! **The real NAO** in 2011 segmented colours in 160 x 120 or 320 x 240 images at 15 to 30 images per second, knew the pose of its camera to
//! about a degree, and detected a ball at up to 3 m, and goals across the pitch.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::appearance::scene::Scene;
use crate::sensing::camera::CameraSettings;
use crate::sensing::jobs::SensingThreads;
use crate::sensing::scene::{ScenePlugin, SensesNothing, SensingSystems};
use naoisis_core::cycle::{Cycle, CycleClock};
use naoisis_core::geometry::Pose;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::RandomStreams;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::motion::ExecutedStep;
use naoisis_core::team::RobotId;

mod ahead;
mod confidence;
mod false_positives;
pub mod gaze;
mod geometric;
pub mod image;
mod jersey_colours;
mod landmarks;
mod measuring;
mod missed;
mod noise;
mod observer;
mod occlusion;
mod percepts;
mod points;
mod robots;
mod truth;
mod unrecognised;

use ahead::LandmarksAhead;
use confidence::Counts;
use false_positives::ActiveFalsePositives;
use gaze::GazeError;
pub(crate) use noise::GazeDecay;
pub use noise::{ClassNoise, Falloff, FalsePositives, GazeNoise, HiddenFeet, JerseyVision, VisionNoise};
use observer::{Observer, Views};
use occlusion::Occluders;
pub use percepts::{BallPercept, GoalPostPercept, GroundPoint, LandmarkKind, LandmarkPercept, Percepts, RobotPercept};

pub use missed::{Cover, MissedObject, SceneObject, Unrecognised, WhyMissed};

/// Fills every robot's [`Percepts`].
pub struct VisionPlugin;

impl Plugin for VisionPlugin {
    fn build(&self, app: &mut App) {
        if !app.is_plugin_added::<ScenePlugin>() {
            app.add_plugins(ScenePlugin);
        }
        app.register_type::<VisionSettings>()
            .register_type::<Percepts>()
            .register_type::<GazeError>()
            .register_type::<ActiveFalsePositives>()
            .init_resource::<SensingThreads>()
            .add_systems(Cycle, gaze::move_cameras.in_set(SensingSystems::Scene))
            .add_systems(Cycle, (recognise, image::seeing::process_images).chain().in_set(SensingSystems::Vision))
            .add_systems(
                Cycle,
                unrecognised::look_at_images
                    .in_set(SensingSystems::Vision)
                    .after(image::seeing::process_images)
                    .run_if(resource_exists::<Unrecognised>),
            );
    }
}

/// The source of a robot's percepts.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum VisionSource {
    /// The geometry of the objects in view, with the noise of a real vision system.
    #[default]
    Geometric,
    /// The robot's camera images alone.
    Image,
    /// All objects on the pitch at their true positions, for debugging.
    Truth,
}

/// The vision of a robot.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[require(Percepts, CameraSettings, GazeError, ActiveFalsePositives, ExecutedStep)]
#[reflect(Component, @Knowledge::Public)]
#[serde(default, deny_unknown_fields)]
pub struct VisionSettings {
    /// The source of the percepts.
    pub source: VisionSource,
    /// Errors of the geometric vision.
    pub noise: VisionNoise,
    /// Whether the percepts have points along the lines and along the edge of the carpet, every 20 pixels.
    pub points: bool,
}

fn recognise(
    scene: Res<Scene>,
    clock: Res<CycleClock>,
    (mut occluders, mut views, mut ahead): (Local<Occluders>, Local<Views>, Local<LandmarksAhead>),
    mut unrecognised: Option<ResMut<Unrecognised>>,
    mut robots: Query<
        (
            &RobotId,
            &Pose,
            (&HeadAngles, &GazeError, &Body),
            &CameraSettings,
            &VisionSettings,
            &mut ActiveFalsePositives,
            &mut Percepts,
            &mut RandomStreams,
        ),
        Without<SensesNothing>,
    >,
) {
    for (&id, &pose, (&head, gaze, body), cameras, settings, mut false_positives, mut percepts, mut streams) in
        &mut robots
    {
        percepts.clear();
        let RandomStreams { vision, recognition, false_places, .. } = &mut *streams;
        let own_index = scene.robots.iter().position(|robot| robot.id == id);
        match settings.source {
            VisionSource::Truth => {
                truth::know_everything(&mut percepts, &scene, own_index, pose, (cameras, body), head);
            }
            // These images are processed by the next system.
            VisionSource::Image => {}
            VisionSource::Geometric => {
                views.update((cameras, body), (head, gaze), &settings.noise, vision);
                occluders.gather(&scene, own_index, pose, views.actual());
                let mut observer = Observer::new(&views, pose, &settings.noise, &occluders, [vision, recognition]);
                let mut missed = unrecognised.is_some().then(Vec::new);
                observer.recognise_everything(&mut percepts, &scene, own_index, &mut ahead, missed.as_mut());
                let true_ones = Counts::of(&percepts);
                observer.add_false_positives(&mut percepts, &scene);
                if settings.points {
                    observer.add_points(&mut percepts, &scene);
                }
                false_positives.bypass_change_detection().advance(
                    &settings.noise,
                    &scene,
                    clock.period(),
                    false_places,
                );
                false_positives.see(&mut observer.with_stream(false_places), &mut percepts, &scene);
                if settings.noise.jerseys.colour_m > 0.0 {
                    jersey_colours::mistake(&mut percepts, &settings.noise.jerseys, streams.own("jerseys"));
                }
                if settings.noise.confidence {
                    confidence::rate(&mut percepts, true_ones, &settings.noise, streams.own("confidence"));
                }
                if let Some((unrecognised, missed)) = unrecognised.as_mut().zip(missed) {
                    unrecognised.note(id, clock.start_time_s(), percepts.time_s, missed);
                }
            }
        }
        percepts.sort(&cameras.mounts);
    }
}

#[cfg(test)]
mod tests;
