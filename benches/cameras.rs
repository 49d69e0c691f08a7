//! What camera images cost: drawing them, looking through them, and matches with the cameras of all robots.
#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a benchmark prints its figures and may panic")]

mod common;

use bevy::prelude::*;
use common::fastest;
use naoisis::camera_model::{CameraName, CameraView};
use naoisis::internal::appearance::robot::RobotDesign;
use naoisis::internal::appearance::scene::Scene;
use naoisis::internal::appearance::view::View;
use naoisis::prelude::*;
use naoisis::sensing::camera::image::{Image, Layers};
use naoisis::sensing::camera::software::{Detail, PreparedScene, Renderer};
use naoisis::sensing::camera::{CameraRendering, CameraSettings};
use naoisis::sensing::jobs::SensingThreads;
use naoisis::sensing::vision::VisionSource;
use naoisis::sensing::vision::image::{ImageDetections, ImageVision, ObjectModel};
use std::thread;
use std::time::Instant;

/// Cycles before anything is measured: the teams have walked to the ball.
const WARM_UP_CYCLES: usize = 600;
/// Images of one measurement, on each thread.
const IMAGES: usize = 6000;
/// Measurements of each figure; the best counts.
const ROUNDS: usize = 3;

/// The camera views of all robots of a match that is under way.
fn views_of_match(name: &str) -> (Scene, Vec<(CameraName, CameraView, View)>) {
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app.start_match(&Scenario::named(name).unwrap()).unwrap().run_cycles(WARM_UP_CYCLES);
    let mut scene = Scene::default();
    scene.gather(app.world_mut());
    let mut views = Vec::new();
    for robot in &scene.robots {
        for (name, &camera) in CameraSettings::default().views(&robot.body, robot.head).named() {
            views.push((name, camera, View::of_robot(&camera, robot.world_from_robot(), robot.id)));
        }
    }
    (scene, views)
}

/// Images a second of `threads` threads that each do `work` over and over.
fn rate<W: FnMut(usize)>(threads: usize, make: impl Fn() -> W + Sync) -> f64 {
    (0..ROUNDS)
        .map(|_| {
            let started = Instant::now();
            thread::scope(|scope| {
                for _ in 0..threads {
                    scope.spawn(|| {
                        let mut work = make();
                        (0..IMAGES).for_each(&mut work);
                    });
                }
            });
            (threads * IMAGES) as f64 / started.elapsed().as_secs_f64()
        })
        .fold(0.0, f64::max)
}

fn drawing_and_looking() {
    let (scene, views) = views_of_match("match3v3");
    for design in RobotDesign::BOTH {
        let mut prepared = PreparedScene::default();
        prepared.prepare(&scene, Detail { design, ..Detail::default() });
        for antialiasing in [true, false] {
            let draw = || {
                let (mut renderer, mut image) = (Renderer::default(), Image::default());
                let (prepared, views) = (&prepared, &views);
                move |index: usize| {
                    let view = View { antialiasing, ..views[index % views.len()].2 };
                    renderer.draw(prepared, &view, Layers::default(), &mut image);
                }
            };
            let (one, two) = (rate(1, draw), rate(2, draw));
            let how = if antialiasing { "" } else { ", aliased" };
            println!("drawing, 3v3, {design:?} robots, 320 x 240{how}: {one:.0} images/s on one core, {two:.0} on two");
        }
        let mut renderer = Renderer::default();
        let images: Vec<(CameraName, CameraView, Image)> = views
            .iter()
            .map(|(name, camera, view)| {
                let mut image = Image::default();
                renderer.draw(&prepared, view, Layers::default(), &mut image);
                (*name, *camera, image)
            })
            .collect();
        let known = ObjectModel::new(&scene.pitch, 0.03);
        let looking = rate(1, || {
            let (mut vision, mut detections) = (ImageVision::default(), ImageDetections::default());
            let (images, known) = (&images, &known);
            move |index: usize| {
                let (name, camera, image) = &images[index % images.len()];
                vision.recognise(image, *name, camera, known, &mut detections);
            }
        });
        println!("looking, 3v3, {design:?} robots, 320 x 240: {looking:.0} images/s on one core");
    }
}

/// How many times faster than real time a match runs.
fn speed(name: &str, threads: usize, change: impl Fn(&mut Scenario)) -> f64 {
    /// Ten seconds.
    const CYCLES: usize = 300;
    let mut scenario = Scenario::named(name).unwrap();
    change(&mut scenario);
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    app.insert_resource(SensingThreads(threads));
    app.start_match(&scenario).unwrap().run_cycles(WARM_UP_CYCLES);
    let fastest = fastest(ROUNDS, || {
        app.run_cycles(CYCLES);
    });
    CYCLES as f64 * scenario.cycle_s / fastest
}

fn matches() {
    for (name, cameras) in [("match3v3", 12), ("match7v7", 28)] {
        for threads in [1, 2] {
            let drawn = |scenario: &mut Scenario| scenario.settings.cameras.render = CameraRendering::Software;
            let seen = |scenario: &mut Scenario| scenario.settings.vision.source = VisionSource::Image;
            println!(
                "{name}, {cameras} cameras at 30 Hz, {threads} thread(s): {:.1} times real time with images, {:.1} playing by them",
                speed(name, threads, drawn),
                speed(name, threads, seen),
            );
        }
    }
}

fn main() {
    // Cargo asks every benchmark binary for its tests too.
    if std::env::args().any(|argument| argument == "--test") {
        return;
    }
    drawing_and_looking();
    matches();
}
