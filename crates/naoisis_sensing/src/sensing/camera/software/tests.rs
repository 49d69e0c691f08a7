use super::*;
use crate::appearance::Label;
use crate::appearance::colours;
use crate::appearance::robot::RobotDesign;
use crate::appearance::scene::{Scene, SceneBall, SceneRobot};
use crate::appearance::stride::Stride;
use bevy::math::{Vec2, Vec3};
use naoisis_core::geometry::{Pose, unit};
use naoisis_core::pitch::Pitch;
use naoisis_core::random::RandomStream;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::{LyingOn, Posture};
use naoisis_core::team::{RobotId, Team};

/// A scene with two robots, one in front of the other, and the ball.
fn scene() -> Scene {
    let mut scene = Scene::empty(Pitch::default());
    let head = HeadAngles { yaw: 0.4, pitch: 0.1 };
    let stride = Stride { time_s: 0.2, speed: 0.2, liveliness: 1.0, kick: None };
    for (team, x, y, heading) in [(Team::Blue, 0.5, 0.2, 1.0), (Team::Pink, 1.2, -0.2, 3.0)] {
        let standing = SceneRobot::standing(RobotId::new(team, 3), Pose::new(x, y, heading), Body::default());
        scene.robots.push(SceneRobot { head, stride, ..standing });
    }
    scene.ball = Some(SceneBall::on_ground(Vec2::new(0.1, -0.3), 0.03));
    scene
}

fn view() -> View {
    let mut view = View::looking_at(Vec3::new(-1.2, -0.4, 0.5), Vec3::new(1.0, 0.0, 0.2), 0.65, [160, 120]);
    view.supersampling = 1;
    view
}

fn draw(scene: &Scene, view: &View, design: RobotDesign) -> Image {
    let mut prepared = PreparedScene::default();
    prepared.prepare(scene, Detail { design, ..Detail::default() });
    let mut image = Image::default();
    Renderer::default().draw(&prepared, view, Layers::ALL, &mut image);
    image
}

/// The FNV-1a hash of bytes.
fn digest(bytes: impl IntoIterator<Item = u8>) -> u64 {
    bytes.into_iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x100_0000_01b3))
}

#[test]
fn every_instruction_set_draws_the_same_picture() {
    let mut prepared = PreparedScene::default();
    for design in RobotDesign::BOTH {
        prepared.prepare(&scene(), Detail { design, ..Detail::default() });
        let [mut plain, mut best] = [Image::default(), Image::default()];
        Renderer::default().draw_with(Arch::Scalar, &prepared, &view(), Layers::ALL, &mut plain);
        Renderer::default().draw_with(Arch::new(), &prepared, &view(), Layers::ALL, &mut best);
        assert!(plain == best, "{design:?}");
    }
}

#[test]
fn the_picture_is_the_same_everywhere() {
    // Debug and release builds draw this same picture on all machines. If it was changed on purpose, write down the new number.
    let image = draw(&scene(), &View { supersampling: 2, ..view() }, RobotDesign::Nao);
    assert_eq!(digest(image.rgb), GOLDEN, "the picture changed");
}

/// See [`the_picture_is_the_same_everywhere`].
const GOLDEN: u64 = 12599529527809776765;

#[test]
fn a_renderer_draws_the_same_when_it_is_used_again() {
    let mut prepared = PreparedScene::default();
    let mut renderer = Renderer::default();
    let [mut first, mut again] = [Image::default(), Image::default()];
    prepared.prepare(&scene(), Detail::default());
    renderer.draw(&prepared, &view(), Layers::ALL, &mut first);
    let mut other = scene();
    other.robots.pop();
    other.ball = None;
    prepared.prepare(&other, Detail { design: RobotDesign::Nao, segments: 7 });
    renderer.draw(&prepared, &View { shadows: false, ..view() }, Layers::default(), &mut again);
    prepared.prepare(&scene(), Detail::default());
    renderer.draw(&prepared, &view(), Layers::ALL, &mut again);
    assert!(first == again);
}

#[test]
fn what_is_at_a_place_is_in_its_pixel() {
    let (scene, view) = (scene(), view());
    for design in RobotDesign::BOTH {
        let image = draw(&scene, &view, design);
        let label_at = |point: Vec3| {
            let pixel = view.project(point).unwrap();
            image.label(pixel.x as u32, pixel.y as u32).unwrap()
        };
        assert_eq!(label_at(Vec3::new(0.1, -0.3, 0.03)), Label::Ball);
        assert_eq!(label_at(Vec3::new(0.5, 0.2, 0.3)), Label::BlueWaistband);
        assert_eq!(label_at(Vec3::new(0.5, 0.2, 0.4)), Label::BlueRobot);
        assert_eq!(label_at(Vec3::new(1.2, -0.2, 0.3)), Label::PinkWaistband);
        assert_eq!(label_at(Vec3::new(1.2, -0.2, 0.52)), Label::PinkRobot);
        // On the halfway line, on the carpet, and a post.
        assert_eq!(label_at(Vec3::new(0.0, -0.15, 0.0)), Label::Line);
        assert_eq!(label_at(Vec3::new(0.2, -0.6, 0.0)), Label::Carpet);
        assert_eq!(label_at(Vec3::new(2.975, -0.7, 0.5)), Label::YellowGoal);
    }
}

#[test]
fn people_beside_the_pitch_are_in_the_picture() {
    // The referee stands beside the halfway line.
    let view = View::looking_at(Vec3::new(0.0, 0.0, 0.5), Vec3::new(0.0, 3.0, 1.0), 0.65, [160, 120]);
    let of_people = |people: u8| {
        let scene = Scene::empty(Pitch { people, ..Pitch::default() });
        let image = draw(&scene, &view, RobotDesign::Nao);
        image.labels.iter().filter(|label| **label == Label::Person as u8).count()
    };
    assert_eq!(of_people(0), 0);
    // A metre at the referee, 3 m away, has 79 pixels: the referee fills at most 0.5 x 1.9 m.
    assert!((1000..5900).contains(&of_people(1)), "{}", of_people(1));
}

#[test]
fn depth_is_the_distance_ahead() {
    let view = view();
    let image = draw(&scene(), &view, RobotDesign::Simple);
    let depth_at = |point: Vec3| {
        let pixel = view.project(point).unwrap();
        image.depth(pixel.x as u32, pixel.y as u32).unwrap()
    };
    // The ball's surface is nearer than its centre by a radius.
    let centre = Vec3::new(0.1, -0.3, 0.03);
    assert!((depth_at(centre) - (view.to_camera(centre).z - 0.03)).abs() < 0.003);
    let ground = Vec3::new(0.2, -0.6, 0.0);
    // Half a pixel up or down is d² / (f h) = 1.4² / (178 * 0.5) = 2 cm.
    assert!((depth_at(ground) - view.to_camera(ground).z).abs() < 0.02);
    assert_eq!(image.depth(0, 0), Some(0.0));
}

#[test]
fn the_ground_is_what_the_pitch_says() {
    let pitch = Pitch::default();
    let mut view = View::looking_at(Vec3::new(-2.0, 0.3, 0.5), Vec3::new(0.0, 0.0, 0.0), 0.8, [160, 120]);
    view.supersampling = 1;
    // A camera that leans to the side.
    let lean = unit(0.3);
    (view.right, view.down) = (lean.x * view.right + lean.y * view.down, lean.x * view.down - lean.y * view.right);
    let image = draw(&Scene { pitch: pitch.clone(), ..Scene::default() }, &view, RobotDesign::Simple);
    let half = pitch.line_width_m / 2.0;
    let mut compared = 0;
    for v in 0..120 {
        for u in 0..160 {
            let ray = view.ray(Vec2::new(u as f32 + 0.5, v as f32 + 0.5));
            if ray.z >= 0.0 {
                assert!(!image.label(u, v).unwrap().is_ground());
                continue;
            }
            let distance = -view.eye.z / ray.z;
            let point = (view.eye + ray * distance).truncate();
            let label = image.label(u, v).unwrap();
            // The distance from the middle of the halfway line and of the circle, away from their ends and from other lines.
            let off = point.x.abs().min((point.length() - 0.6).abs());
            let near_other = point.x.abs() > 1.0 || point.y.abs() > 1.5 || point.length() < 0.1;
            if !near_other && (off - half).abs() > 1e-3 && label.is_ground() {
                compared += 1;
                assert_eq!(label == Label::Line, off < half, "{point}");
            }
        }
    }
    assert!(compared > 3000, "{compared}");
}

/// Two robots that move about, and a ball that appears and disappears.
fn busy_scene(dice: &mut RandomStream, pitch: &Pitch) -> Scene {
    let mut between = |low: f32, high: f32| low + (high - low) * dice.uniform();
    let mut scene = Scene::empty(pitch.clone());
    for number in 1..=2 {
        let pose = Pose::new(between(1.5, 3.5), between(-1.5, 1.5), between(-3.0, 3.0));
        let body = SceneRobot::standing(RobotId::new(Team::Pink, number), pose, Body::default());
        let posture =
            if between(0.0, 1.0) < 0.2 { Posture::Fallen { cycles: 1, on: LyingOn::Front } } else { Posture::Upright };
        scene.robots.push(body.in_posture(posture));
    }
    if between(0.0, 1.0) < 0.7 {
        scene.ball = Some(SceneBall::on_ground(Vec2::new(between(1.0, 3.2), between(-1.0, 1.0)), 0.05));
    }
    scene
}

#[test]
fn a_camera_that_stands_still_sees_what_one_that_moves_does() {
    let mut dice = RandomStream::for_match(1, "still");
    let (mut prepared, mut still) = (PreparedScene::default(), StillRenderer::default());
    let wider = Pitch { length_m: 6.4, people: 20, ..Pitch::default() };
    // Views of the goal with its net: from above, from among the robots, and from one of them.
    let above = View::looking_at(Vec3::new(1.0, -4.0, 4.0), Vec3::new(2.2, 0.0, 0.0), 0.7, [200, 120]);
    let low = View { supersampling: 2, ..View::looking_at(Vec3::new(2.0, 0.1, 0.3), Vec3::X * 3.0, 1.1, [160, 120]) };
    let own = View { hidden: Some(RobotId::new(Team::Pink, 1)), shadows: false, supersampling: 1, ..low };
    let mut changes = 0;
    for (view, pitch) in [(above, &wider), (above, &Pitch::default()), (low, &wider), (own, &wider)] {
        let mut last = Image::default();
        for _ in 0..12 {
            prepared.prepare(&busy_scene(&mut dice, pitch), Detail { design: RobotDesign::Nao, ..Detail::default() });
            let [mut expected, mut image] = [Image::default(), Image::default()];
            Renderer::default().draw(&prepared, &view, Layers::default(), &mut expected);
            still.draw(&prepared, &view, &mut image);
            assert!(image == expected);
            changes += usize::from(image != last);
            last = image;
        }
    }
    assert!(changes > 40, "{changes}");
}

#[test]
fn a_robot_does_not_see_itself() {
    let scene = scene();
    let view = View { hidden: Some(scene.robots[0].id), ..view() };
    let image = draw(&scene, &view, RobotDesign::Simple);
    assert!(!image.labels.contains(&(Label::BlueRobot as u8)) && image.labels.contains(&(Label::PinkRobot as u8)));
}

#[test]
fn a_robot_that_lies_down_is_flat() {
    let mut scene = scene();
    scene.robots.truncate(1);
    let standing = SceneRobot::standing(scene.robots[0].id, Pose::new(1.0, 0.0, 0.0), Body::default());
    scene.robots[0] = standing.in_posture(Posture::Fallen { cycles: 3, on: LyingOn::Front });
    let (image, view) = (draw(&scene, &view(), RobotDesign::Nao), view());
    let highest = image.labels.iter().position(|&label| label == Label::BlueRobot as u8).unwrap() / 160;
    let top = view.project(Vec3::new(1.0, 0.0, 0.25)).unwrap();
    assert!(highest > top.y as usize, "{highest} {top}");
}

#[test]
fn shadows_darken_the_ground_away_from_the_sun_only() {
    let scene = scene();
    let (light, dark) = (View { shadows: false, ..view() }, View { shadows: true, ..view() });
    let [lit, shaded] = [light, dark].map(|view| draw(&scene, &view, RobotDesign::Nao));
    let mut darker = 0;
    for (index, (before, after)) in lit.rgb.chunks(3).zip(shaded.rgb.chunks(3)).enumerate() {
        let label = Label::from_number(shaded.labels[index]).unwrap();
        if before != after {
            assert!(label.is_ground() && after[1] < before[1], "{label:?}");
            darker += 1;
        }
    }
    assert_eq!(lit.labels, shaded.labels);
    assert!(darker > 50, "{darker}");
}

#[test]
fn samples_are_averaged() {
    let view = View { supersampling: 3, ..view() };
    let image = draw(&Scene::empty(Pitch::default()), &view, RobotDesign::Simple);
    assert_eq!((image.width, image.height, image.rgb.len(), image.labels.len()), (160, 120, 3 * 160 * 120, 160 * 120));
    // Some pixels at the edges between carpet and line have neither colour.
    let is_mixed = |pixel: &[u8]| pixel[0] > colours::CARPET.0[0] + 20 && pixel[0] < colours::CHALK.0[0] - 20;
    assert!(image.rgb.chunks(3).any(is_mixed));
}
