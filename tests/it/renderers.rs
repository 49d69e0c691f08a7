//! The renderer of the graphics card and that in software show the same scene. Where there is no adapter there is nothing
//! to compare, unless `NAOISIS_REQUIRE_GPU` says that there must be one.

use bevy::prelude::*;
use naoisis::camera_model::CameraName;
use naoisis::geometry::Pose;
use naoisis::gpu::renderer::{GpuCamerasPlugin, GpuError, GpuRenderer};
use naoisis::internal::appearance::Label;
use naoisis::internal::appearance::colours;
use naoisis::internal::appearance::robot::{RobotDesign, labels};
use naoisis::internal::appearance::scene::{Scene, SceneBall, SceneRobot};
use naoisis::internal::appearance::stride::Stride;
use naoisis::internal::appearance::view::View;
use naoisis::pitch::Pitch;
use naoisis::random::RandomStream;
use naoisis::robot::body::Body;
use naoisis::robot::head::HeadAngles;
use naoisis::scenario::Scenario;
use naoisis::sensing::camera::image::{Image, ImageRequest, Layers};
use naoisis::sensing::camera::software::{Detail, PreparedScene, Renderer};
use naoisis::sensing::camera::{CameraImages, CameraRendering, CameraSettings};
use naoisis::simulation::{MatchApp, NaoisisPlugins};
use naoisis::team::{RobotId, Team};

const SCENES: usize = 50;

fn renderer() -> Option<GpuRenderer> {
    match GpuRenderer::new() {
        Ok(renderer) => Some(renderer),
        Err(GpuError::NoAdapter) if std::env::var_os("NAOISIS_REQUIRE_GPU").is_none() => None,
        Err(error) => panic!("{error}"),
    }
}

/// A scene with people beside the pitch, and with robots and ball somewhere, before the first robot more often than not.
fn random_scene(dice: &mut RandomStream) -> Scene {
    let mut between = |low: f32, high: f32| low + (high - low) * dice.uniform();
    let mut scene = Scene::empty(Pitch { people: 12, ..Pitch::default() });
    let looker = Pose::new(between(-2.5, 2.0), between(-1.8, 1.8), between(-3.1, 3.1));
    let ahead = |distance: f32, angle: f32| looker.position + distance * Vec2::from_angle(looker.heading + angle);
    scene.ball = Some(SceneBall::on_ground(ahead(between(0.25, 2.5), between(-0.4, 0.4)), 0.03));
    for number in 0..5u8 {
        let team = if number % 2 == 0 { Team::Blue } else { Team::Pink };
        let pose = match number {
            0 => looker,
            _ => Pose { position: ahead(between(0.5, 4.0), between(-0.6, 0.6)), heading: between(-3.1, 3.1) },
        };
        let head = HeadAngles { yaw: between(-0.5, 0.5), pitch: between(-0.3, 0.4) };
        let stride =
            Stride { time_s: between(0.0, 1.0).into(), speed: between(-0.2, 0.2), liveliness: 1.0, kick: None };
        let standing = SceneRobot::standing(RobotId::new(team, 1 + number), pose, Body::default());
        scene.robots.push(SceneRobot { head, stride, ..standing });
    }
    scene
}

fn shot(scene: &Scene, index: usize) -> ImageRequest {
    let robot = scene.robots[0];
    let camera = CameraSettings::default().views(&robot.body, robot.head)[index % 2];
    let mut view = View::of_robot(&camera, robot.world_from_robot(), robot.id);
    view.shadows = index.is_multiple_of(3);
    let design = if index % 4 < 2 { RobotDesign::Nao } else { RobotDesign::Simple };
    ImageRequest { view, design, layers: Layers::ALL, image: Image::default() }
}

/// A picture of the graphics card, and the same in software.
fn draw_by_both(gpu: &mut GpuRenderer, scene: &Scene, index: usize) -> (ImageRequest, Image) {
    let mut shot = shot(scene, index);
    gpu.draw(scene, &mut [&mut shot]).expect("a picture");
    let mut prepared = PreparedScene::default();
    prepared.prepare(scene, Detail { design: shot.design, ..Detail::default() });
    let mut image = Image::default();
    Renderer::default().draw(&prepared, &shot.view, Layers::ALL, &mut image);
    (shot, image)
}

/// Whether a pixel and those around it are all of one label.
fn is_inside(image: &Image, u: u32, v: u32) -> bool {
    let label = image.label(u, v);
    let around = |at: u32| at.saturating_sub(1)..=at + 1;
    around(v).all(|v| around(u).all(|u| image.label(u, v).is_none_or(|other| Some(other) == label)))
}

#[test]
fn both_renderers_show_the_same() {
    let Some(mut gpu) = renderer() else { return };
    let mut dice = RandomStream::for_match(50, "scenes");
    let (mut inside, mut same, mut coloured_alike, mut farther) = (0, 0, 0, 0);
    for index in 0..SCENES {
        let scene = random_scene(&mut dice);
        let (shot, image) = draw_by_both(&mut gpu, &scene, index);
        assert_eq!([image.width, image.height], [shot.image.width, shot.image.height]);
        for v in 0..image.height {
            for u in 0..image.width {
                if !is_inside(&image, u, v) || !is_inside(&shot.image, u, v) {
                    continue;
                }
                inside += 1;
                if image.label(u, v) != shot.image.label(u, v) {
                    continue;
                }
                same += 1;
                let colours = [&image, &shot.image].map(|image| image.colour(u, v).unwrap());
                let off = colours[0].iter().zip(colours[1]).map(|(one, other)| one.abs_diff(other)).max().unwrap();
                coloured_alike += usize::from(off <= 12);
                let depths = [&image, &shot.image].map(|image| image.depth(u, v).unwrap());
                // Beyond 64 m the graphics card does not tell distances apart.
                farther += usize::from((depths[0] - depths[1]).abs() > 0.02 + 0.02 * depths[0] && depths[0] < 60.0);
            }
        }
    }
    let share = |count: usize| count as f64 / inside as f64;
    assert!(inside > SCENES * 320 * 240 / 2, "{inside} pixels are not on an edge");
    assert!(share(same) > 0.98, "labels agree in {:.4} of the pixels", share(same));
    // Nets and shadows apart, which are drawn otherwise.
    assert!(share(coloured_alike) > 0.95, "colours agree in {:.4} of the pixels", share(coloured_alike));
    assert!(share(farther) < 0.01, "distances differ in {:.4} of the pixels", share(farther));
}

/// The light of a row of pixels about a place: less than a line is wide, and long enough to see dashes.
fn light_along(image: &Image, [first, end]: [u32; 2], row: u32) -> Vec<f32> {
    let light = |u: u32, v: u32| image.colour(u, v).map_or(0.0, |colour| f32::from(colour[0]));
    (first..end).map(|u| (row - 3..=row + 3).map(|v| light(u, v)).sum::<f32>() / 7.0).collect()
}

#[test]
fn far_lines_are_lines_in_both_and_dashes_in_none() {
    let Some(mut gpu) = renderer() else { return };
    // Along the pitch from beside one goal, turned a little: the halfway line is 4 m away, half a pixel wide.
    let scene = Scene::empty(Pitch { length_m: 9.0, width_m: 6.0, ..Pitch::default() });
    let camera = CameraSettings::default().views(&Body::default(), HeadAngles::default())[0];
    let place = Pose::new(-4.2, 1.0, 0.06);
    let looker = SceneRobot::standing(RobotId::new(Team::Blue, 1), place, Body::default());
    for antialiasing in [true, false] {
        let view = View { antialiasing, ..View::of_robot(&camera, looker.world_from_robot(), looker.id) };
        let mut shot = ImageRequest { view, design: RobotDesign::Simple, layers: Layers::ALL, image: Image::default() };
        gpu.draw(&scene, &mut [&mut shot]).expect("a picture");
        let mut prepared = PreparedScene::default();
        prepared.prepare(&scene, Detail::default());
        let mut image = Image::default();
        Renderer::default().draw(&prepared, &view, Layers::ALL, &mut image);
        // Along the line in the image, before the circle crosses it.
        let [left, right] = [2.6, 0.8].map(|y| view.project(Vec3::new(0.0, y, 0.0)).expect("a place ahead"));
        let of = |image: &Image| {
            (left.x as u32..right.x as u32)
                .flat_map(|u| {
                    let along = (u as f32 - left.x) / (right.x - left.x);
                    light_along(image, [u, u + 1], left.lerp(right, along).y as u32)
                })
                .collect::<Vec<f32>>()
        };
        let lights = [of(&image), of(&shot.image)];
        let apart: f32 = lights[0].iter().zip(&lights[1]).map(|(one, other)| (one - other).abs()).sum();
        let apart = apart / lights[0].len() as f32;
        assert!(apart < if antialiasing { 6.0 } else { 12.0 }, "{apart}");
        // Dashes have gaps between them, in which there is nothing but carpet.
        let carpet = f32::from(colours::CARPET.0[0]);
        for light in &lights {
            let gaps = light.iter().filter(|light| **light < carpet + 5.0).count();
            assert!(if antialiasing { gaps == 0 } else { gaps > light.len() / 10 }, "{gaps} of {}", light.len());
        }
    }
}

#[test]
fn the_pixel_of_a_point_shows_what_is_there() {
    let Some(mut gpu) = renderer() else { return };
    let mut dice = RandomStream::for_match(51, "scenes");
    let mut seen = 0;
    for index in 0..SCENES {
        let scene = random_scene(&mut dice);
        let (shot, image) = draw_by_both(&mut gpu, &scene, index);
        // The middles of ball, waistbands and posts: label, place, and what it is thick.
        let mut points = Vec::new();
        points.extend(scene.ball.map(|ball| (Label::Ball, ball.position.extend(ball.radius), ball.radius)));
        let waist = Body::default().waistband.middle();
        points.extend(scene.robots[1..].iter().map(|robot| {
            let [_, band] = labels(robot.id.team);
            (band, robot.world_from_robot().transform_point3(waist), 0.056)
        }));
        points.extend(scene.posts.iter().filter_map(|there| {
            let label = naoisis::internal::appearance::field::goal_label(there.post.colour?);
            Some((label, there.position.extend(there.post.height / 2.0), there.post.radius))
        }));
        for (label, point, half) in points {
            let ahead = shot.view.to_camera(point).z;
            let Some(pixel) = shot.view.project(point) else { continue };
            // At least three pixels wide.
            let is_in = pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x < 320.0 && pixel.y < 240.0;
            if !is_in || half * 360.0 / ahead < 1.5 {
                continue;
            }
            for image in [&image, &shot.image] {
                let (u, v) = (pixel.x as u32, pixel.y as u32);
                let found = image.label(u, v).unwrap();
                let depth = image.depth(u, v).unwrap();
                // Something else may be before it, a robot's arm or another robot.
                let is_hidden = depth < ahead - half;
                assert!(found == label || is_hidden, "scene {index}: {found:?} at {pixel}, not {label:?}");
                seen += usize::from(found == label);
            }
        }
    }
    assert!(seen > 2 * SCENES, "only {seen} points were seen");
}

#[test]
fn a_match_has_images_of_each_cycle_from_the_graphics_card() {
    if renderer().is_none() {
        return;
    }
    let mut scenario = Scenario::named("match3v3").expect("a scenario");
    scenario.settings.cameras.render = CameraRendering::Gpu;
    (scenario.settings.cameras.width, scenario.settings.cameras.height) = (80, 60);
    scenario.settings.cameras.labels = true;
    let mut images = |rendering| {
        scenario.settings.cameras.render = rendering;
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, GpuCamerasPlugin));
        app.start_match(&scenario).expect("a match");
        let mut images = Vec::new();
        for _ in 0..6 {
            app.run_cycles(5);
            let of_cycle: &CameraImages = app.robot(RobotId::new(Team::Blue, 1)).expect("a robot");
            assert_eq!(of_cycle.cycle, Some(app.cycle()));
            images.push(of_cycle.of(CameraName::TOP).clone());
        }
        images
    };
    let [gpu, software] = [CameraRendering::Gpu, CameraRendering::Software].map(&mut images);
    for (cycle, (one, other)) in gpu.iter().zip(&software).enumerate() {
        let same = one.labels.iter().zip(&other.labels).filter(|(one, other)| one == other).count();
        // Each shows its own cycle: heads turn on the way.
        assert!(same as f64 > 0.95 * other.labels.len() as f64, "image {cycle}: {same} of {}", other.labels.len());
    }
    assert!(gpu[0].labels != gpu[5].labels, "the robot has moved its head");
}
