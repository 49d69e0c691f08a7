use super::*;
use crate::appearance::Label;
use crate::sensing::jobs::SensingThreads;
use crate::sensing::testing::{sense, sensing_app, set, spawn_ball, spawn_robot};
use crate::sensing::vision::{VisionSettings, VisionSource};
use naoisis_core::camera_model::{CameraCalibration, Distortion};
use naoisis_core::cycle::run_cycle;
use naoisis_core::geometry::Pose;
use naoisis_core::random::RandomStreams;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::{LyingOn, Posture};
use naoisis_core::team::Team;

/// Small images with all layers.
fn small() -> CameraSettings {
    CameraSettings {
        render: CameraRendering::Software,
        width: 80,
        height: 60,
        labels: true,
        depth: true,
        ..CameraSettings::default()
    }
}

fn images(app: &mut App, robot: Entity, settings: CameraSettings) -> CameraImages {
    set(app, robot, settings);
    sense(app, robot)
}

/// Blue 1 at the centre, looking ahead at pink 1, 1 m away, and the ball.
fn world() -> (App, Entity, Entity) {
    let mut app = sensing_app();
    let robot = spawn_robot(&mut app, Team::Blue, 1, [0.0, 0.0, 0.0], [0.0, 10.0]);
    let other = spawn_robot(&mut app, Team::Pink, 1, [1.5, 0.0, 180.0], [0.0, 0.0]);
    spawn_ball(&mut app, 0.6, 0.1);
    (app, robot, other)
}

#[test]
fn images_show_what_is_in_front_of_the_robot() {
    // A calibrated camera, too, shows objects where the camera model has them.
    let distortion = Distortion::new([-0.3, 0.1, 0.0], [0.01, -0.01]);
    let calibration = CameraCalibration { fx: 88.0, fy: 92.0, cx: 45.0, cy: 26.0, distortion, size: None };
    for settings in [small(), CameraSettings { calibration: Some(calibration), ..small() }] {
        shows_what_is_in_front(settings);
    }
}

fn shows_what_is_in_front(settings: CameraSettings) {
    let (mut app, robot, other) = world();
    let images = images(&mut app, robot, settings);
    assert_eq!(images.cycle, Some(1));
    assert_eq!((images.of(CameraName::TOP).width, images.of(CameraName::TOP).height), (80, 60));
    let views = settings.views(&Body::default(), *app.world().get::<HeadAngles>(robot).unwrap());
    let label = |camera: CameraName, point: Vec3| {
        let pixel = views[settings.mounts.order(camera)].project(point).unwrap();
        images.of(camera).label(pixel.x as u32, pixel.y as u32)
    };
    assert_eq!(label(CameraName::BOTTOM, Vec3::new(0.6, 0.1, 0.03)), Some(Label::Ball));
    assert_eq!(label(CameraName::TOP, Vec3::new(1.5, 0.0, 0.3)), Some(Label::PinkWaistband));
    // The middle of the ball in the image is the ball's pixel.
    let (mut sum, mut count) = (Vec2::ZERO, 0.0);
    for (u, v) in (0..80).flat_map(|u| (0..60).map(move |v| (u, v))) {
        if images.of(CameraName::BOTTOM).label(u, v) == Some(Label::Ball) {
            (sum, count) = (sum + Vec2::new(u as f32 + 0.5, v as f32 + 0.5), count + 1.0);
        }
    }
    let centre = views[settings.mounts.order(CameraName::BOTTOM)].project(Vec3::new(0.6, 0.1, 0.03)).unwrap();
    assert!(count > 10.0 && (sum / count).distance(centre) < 0.7, "{} {centre}", sum / count);
    // The other robot has no images.
    assert_eq!(app.world().get::<CameraImages>(other).unwrap().cycle, None);
}

#[test]
fn labels_and_depth_are_there_only_on_request() {
    let (mut app, robot, _) = world();
    let images = images(&mut app, robot, CameraSettings { labels: false, depth: false, ..small() });
    assert_eq!(images.of(CameraName::TOP).rgb.len(), 3 * 80 * 60);
    assert!(images.of(CameraName::TOP).labels.is_empty() && images.of(CameraName::TOP).depth_m.is_empty());
}

#[test]
fn which_cameras_and_how_often_can_be_chosen() {
    let (mut app, robot, _) = world();
    set(&mut app, robot, CameraSettings { every_cycles: 3, which: CameraChoice::Only(CameraName::BOTTOM), ..small() });
    let cycles: Vec<Option<u64>> = (0..7).map(|_| sense::<CameraImages>(&mut app, robot).cycle).collect();
    assert_eq!(cycles, [1, 1, 1, 4, 4, 4, 7].map(Some));
    let images = app.world().get::<CameraImages>(robot).unwrap();
    assert!(images.of(CameraName::TOP).is_empty() && !images.of(CameraName::BOTTOM).is_empty());
}

#[test]
fn a_camera_may_have_a_rate_and_a_lens_of_its_own() {
    let (mut app, robot, _) = world();
    let mut mounts = CameraMounts::default().as_slice().to_vec();
    mounts[1].every_cycles = Some(2);
    mounts[1].distortion = Some(Distortion::new([-0.3, 0.0, 0.0], [0.0; 2]));
    let settings = CameraSettings { mounts: CameraMounts::new(&mounts).unwrap(), ..small() };
    set(&mut app, robot, settings);
    let straight = images(&mut app, robot, small()).of(CameraName::BOTTOM).clone();
    set(&mut app, robot, settings);
    let of_bottom: Vec<CameraImages> = (0..2).map(|_| sense::<CameraImages>(&mut app, robot)).collect();
    assert!(of_bottom.iter().all(|images| !images.of(CameraName::TOP).is_empty()));
    // Cycles 2 and 3: the lower camera has images in the odd ones.
    assert!(of_bottom[0].of(CameraName::BOTTOM).is_empty());
    let bent = of_bottom[1].of(CameraName::BOTTOM);
    assert!(!bent.is_empty() && bent.rgb != straight.rgb, "the barrel of its lens");
}

#[test]
fn by_default_only_robots_whose_vision_uses_images_have_some() {
    let (mut app, robot, other) = world();
    let settings = CameraSettings { render: CameraRendering::Auto, ..small() };
    set(&mut app, other, settings);
    assert_eq!(images(&mut app, robot, settings).cycle, None);
    set(&mut app, robot, VisionSettings { source: VisionSource::Image, ..default() });
    assert_eq!(sense::<CameraImages>(&mut app, robot).cycle, Some(2));
    assert_eq!(app.world().get::<CameraImages>(other).unwrap().cycle, None);
}

#[test]
fn images_are_the_same_on_any_number_of_threads_noise_included() {
    let noise = ImageNoise { brightness_sd: 0.1, colour_shift_sd: 5.0, pixel_sd: 4.0, blur_px: 0.5, ..default() };
    let taken = [1, 3].map(|threads| {
        let (mut app, robot, other) = world();
        app.insert_resource(SensingThreads(threads));
        set(&mut app, other, CameraSettings { noise, design: RobotDesign::Nao, ..small() });
        let mine = images(&mut app, robot, CameraSettings { noise, shadows: true, ..small() });
        (mine, app.world().get::<CameraImages>(other).unwrap().clone())
    });
    assert!(taken[0] == taken[1]);
    let (mut app, robot, _) = world();
    let clear = images(&mut app, robot, CameraSettings { shadows: true, ..small() });
    assert!(
        clear.of(CameraName::TOP).rgb != taken[0].0.of(CameraName::TOP).rgb
            && clear.of(CameraName::TOP).labels == taken[0].0.of(CameraName::TOP).labels
    );
}

#[test]
fn images_without_noise_draw_no_random_numbers() {
    let (mut app, robot, _) = world();
    let before = app.world().get::<RandomStreams>(robot).unwrap().clone();
    images(&mut app, robot, small());
    assert_eq!(*app.world().get::<RandomStreams>(robot).unwrap(), before);
}

#[test]
fn a_lying_robot_has_no_images() {
    let (mut app, robot, _) = world();
    images(&mut app, robot, small());
    set(&mut app, robot, Posture::Fallen { cycles: 1, on: LyingOn::Front });
    let images: CameraImages = sense(&mut app, robot);
    assert!(images.cycle.is_none() && images.of(CameraName::TOP).is_empty());
}

#[test]
fn a_robot_that_walks_moves_its_legs() {
    let (mut app, robot, other) = world();
    app.world_mut().entity_mut(other).insert(naoisis_core::robot::Velocity { linear: Vec2::Y * 0.2, angular: 0.0 });
    let first = images(&mut app, robot, small());
    (0..8).for_each(|_| run_cycle(app.world_mut()));
    let later: CameraImages = sense(&mut app, robot);
    assert_eq!(*app.world().get::<Pose>(other).unwrap(), Pose::new(1.5, 0.0, core::f32::consts::PI));
    assert!(first.of(CameraName::TOP).rgb != later.of(CameraName::TOP).rgb);
}
