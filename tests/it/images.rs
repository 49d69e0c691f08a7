//! Robots that see nothing but their camera images.

use bevy::math::{Vec2, ops};
use naoisis::events::KickResult;
use naoisis::prelude::*;
use naoisis::sensing::camera::{CameraImages, CameraSettings};
use naoisis::sensing::jobs::SensingThreads;

use crate::support::{blue, headless_app, match_of};

/// A robot with a behaviour and the ball; images of 160 x 120 pixels.
fn robot_and_ball(model: &str, team: &str, pose: &str, design: &str) -> String {
    format!(
        r#"{{ "rules": "free", "vision": {{ "source": "image" }},
              "cameras": {{ "width": 160, "height": 120, "design": "{design}" }},
              "model": "{model}", "ball": {{ "position_m": [0.1, 0.0] }},
              "robots": [{{ "team": "{team}", "number": 1, "pose": {pose}, "behaviour": "striker" }}] }}"#
    )
}

#[test]
fn robots_find_and_kick_the_ball_by_images_alone() {
    // One has the ball ahead, the others must turn to it; a K1 has another lens, another height, and one camera.
    for (model, team, pose, design) in [
        ("nao", "blue", "[-0.7, 0.2, 0.0]", "simple"),
        ("nao", "pink", "[0.9, -0.3, 60.0]", "nao"),
        ("booster_k1", "blue", "[-1.5, 0.4, 50.0]", "nao"),
    ] {
        let mut app = match_of(&robot_and_ball(model, team, pose, design));
        let kicked = app.run_until(900, |app| {
            app.events().iter().any(|event| matches!(event, MatchEvent::Kick { result: KickResult::Kicked, .. }))
        });
        assert!(
            kicked,
            "{model} of {team} did not kick the ball in 30 s: {:?}",
            app.robot_pose(RobotId::new(Team::Blue, 1))
        );
    }
}

#[test]
fn by_images_a_match_is_the_same_on_any_number_of_threads() {
    let [one, three] = [1, 3].map(|threads| {
        let mut scenario = Scenario::named("match3v3_images").unwrap();
        (scenario.settings.cameras.width, scenario.settings.cameras.height) = (160, 120);
        scenario.settings.cameras.noise.pixel_sd = 3.0;
        let mut app = headless_app();
        app.insert_resource(SensingThreads(threads));
        app.start_match(&scenario).unwrap().run_cycles(20);
        let images = app.robot::<CameraImages>(blue(1)).unwrap().clone();
        (images, app.robot::<Percepts>(blue(1)).unwrap().clone(), app.robot_pose(blue(2)))
    });
    assert!(one == three);
    assert_eq!(one.0.cycle, Some(20));
}

#[test]
fn a_match_without_images_is_the_same_with_them() {
    // Nothing depends on images that are only to be looked at.
    let [without, with] = ["off", "software"].map(|render| {
        let mut scenario = Scenario::named("match3v3").unwrap();
        (scenario.settings.cameras.width, scenario.settings.cameras.height) = (40, 30);
        scenario.settings.cameras.render = serde_json::from_value(render.into()).unwrap();
        scenario.settings.cameras.noise.pixel_sd = 3.0;
        let mut app = headless_app();
        app.start_match(&scenario).unwrap().run_cycles(60);
        (app.ball(), app.robot::<Percepts>(blue(1)).cloned(), app.robot_pose(blue(2)))
    });
    assert_eq!(without, with);
}

/// A match of a robot whose camera is `camera` and looks at a ball 1.5 m ahead, by images.
fn looking(camera: &str) -> bevy::prelude::App {
    match_of(&format!(
        r#"{{ "rules": "free", "model": "booster_k1", "realism": "ideal", "vision": {{ "source": "image" }},
              "cameras": {{ "width": 320, "height": 240, {camera} }}, "ball": {{ "position_m": [1.5, 0.4] }},
              "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "from_s": 0, "until_s": 9, "head_deg": [0, 20] }}] }} }}] }}"#
    ))
}

#[test]
fn a_fisheye_camera_shows_more_and_vision_knows_it() {
    for fov_deg in [100, 150] {
        let mut app = looking(&format!(
            r#""render": "software", "diagonal_fov_deg": {fov_deg}, "lens": {{ "distortion": {{ "fisheye": [-0.02, 0.001] }} }}"#
        ));
        app.run_cycles(30);
        let percepts = app.robot::<Percepts>(blue(1)).unwrap();
        let ball = percepts.ball.unwrap_or_else(|| panic!("no ball with {fov_deg} degrees"));
        assert!(ball.position_m.distance(Vec2::new(1.5, 0.4)) < 0.15, "{fov_deg}: {ball:?}");
        let settings = app.robot::<CameraSettings>(blue(1)).unwrap();
        let intrinsics = settings.intrinsics(settings.mounts.iter().next().unwrap());
        // The corner of the image is half the field of view from the axis.
        let corner = intrinsics.slope(Vec2::new(320.0, 240.0)).length();
        assert!(
            (corner - ops::tan(f32::to_radians(fov_deg as f32) / 2.0)).abs() < 2e-3 * corner,
            "{fov_deg}: {corner}"
        );
    }
}

#[test]
fn a_depth_camera_measures_the_distance_with_its_noise() {
    let depth_of_the_ball = |noise: &str| {
        let mut app = looking(&format!(r#""render": "software", "depth": true, "noise": {noise}"#));
        app.run_cycles(30);
        let images = app.robot::<CameraImages>(blue(1)).unwrap();
        let ball = app.robot::<Percepts>(blue(1)).unwrap().ball.unwrap();
        images.of(ball.camera).depth(ball.pixel.x as u32, ball.pixel.y as u32).unwrap()
    };
    let exact = depth_of_the_ball("{}");
    assert!((1.0..1.6).contains(&exact), "{exact}");
    let noisy = depth_of_the_ball(r#"{ "depth_sd_m": 0.01 }"#);
    assert!(noisy != exact && (noisy - exact).abs() < 0.15, "{noisy} {exact}");
}
