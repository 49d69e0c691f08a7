//! Robots of other models than the NAO: that nothing is baked in.

use bevy::prelude::*;
use naoisis::camera_model::{CameraMount, CameraMounts, Distortion};
use naoisis::events::KickResult;
use naoisis::geometry::Pose;
use naoisis::kick_geometry::{KickDirection, KickGeometry};
use naoisis::prelude::*;
use naoisis::robot::body::{Arms, Body, BodyBox, Legs, Waistband};
use naoisis::robot::falls::FallModel;
use naoisis::robot::gait::Gait;
use naoisis::robot::head::HeadLimits;
use naoisis::robot::kick::{CustomKicks, KickModel, KickSettings};
use naoisis::robot::latency::Latency;
use naoisis::robot::look::Look;
use naoisis::robot::motion::MotionSettings;
use naoisis::scenario::{BehaviourSpec, LEAGUES, MODELS, RobotModel, RobotPatch, RobotSettings, RobotSpec};
use naoisis::sensing::camera::CameraSettings;
use naoisis::sensing::sonar::SonarSettings;
use naoisis::sensing::vision::{VisionSettings, VisionSource};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use crate::support::{blue, headless_app, pink};

/// A body, cameras and kicks of a robot that somebody might build, from numbers between 0 and 1.
fn built(random: [f32; 10]) -> (Body, CameraSettings, KickSettings) {
    let [height, width, depth, legs, head, tilt, fov, reach, foot, two] = random;
    let between = |share: f32, least: f32, most: f32| least + share * (most - least);
    let height_m = between(height, 0.35, 1.4);
    let (hip, neck) = (between(legs, 0.3, 0.5) * height_m, between(head, 0.72, 0.85) * height_m);
    let half_width = between(width, 0.2, 0.3) * height_m;
    let half_depth = between(depth, 0.06, 0.12) * height_m;
    let front = between(foot, 0.12, 0.2) * height_m;
    let foot_y = 0.3 * half_width;
    let body = Body {
        torso: BodyBox { x_m: [-half_depth, half_depth], half_width_m: half_width, z_m: [hip, neck] },
        base: BodyBox { x_m: [-half_depth, front], half_width_m: 0.6 * half_width, z_m: [0.0, hip] },
        height_m,
        lying_height_m: 0.25 * height_m,
        foot_y_m: foot_y,
        neck_m: Vec3::Z * neck,
        waistband: Waistband {
            z_m: [hip, hip + 0.17 * height_m],
            half_size_m: Vec2::new(half_depth + 0.01, 0.6 * half_width),
        },
        legs: (two > 0.3).then_some(Legs {
            hip_m: Vec3::new(0.0, foot_y, hip),
            thigh_m: 0.45 * hip,
            shank_m: 0.45 * hip,
            ankle_m: 0.1 * hip,
        }),
        arms: (two > 0.5)
            .then_some(Arms { shoulder_m: Vec3::new(0.0, 0.7 * half_width, 0.95 * neck), length_m: 0.4 * hip }),
        look: if two > 0.6 { Look::DARK } else { Look::LIGHT },
        jersey: None,
    };
    let camera = |name: &str, tilt: f32| {
        CameraMount::new(name.parse().unwrap(), Vec3::new(0.05, 0.0, between(0.5, neck, height_m)), tilt)
    };
    // A single camera looks down far enough that a head which nods shows it the ball before the feet.
    let has_two = two > 0.5;
    let upper = if has_two { between(tilt, 0.0, 0.3) } else { between(tilt, 0.35, 0.6) };
    let both = [camera("head", upper), camera("chin", upper + 0.6)];
    let cameras = CameraSettings {
        mounts: CameraMounts::new(&both[..if has_two { 2 } else { 1 }]).unwrap(),
        width: 320,
        height: 240,
        diagonal_fov: between(fov, 1.3, 1.9),
        ..default()
    };
    let kick = |side: f32| {
        let near = front;
        let far = front + between(reach, 0.12, 0.25);
        KickModel {
            max_distance_m: between(reach, 2.0, 6.0),
            region: Some(KickGeometry {
                x_m: [near, far],
                y_m: if side > 0.0 { [0.0, 2.0 * foot_y + 0.02] } else { [-2.0 * foot_y - 0.02, 0.0] },
                foot_m: Vec2::new(front, side * foot_y),
                best_m: Vec2::new(near + 0.6 * (far - near), side * foot_y),
                direction: if two > 0.4 { KickDirection::Ahead } else { KickDirection::FromFoot },
            }),
            ..KickModel::of(0.0)
        }
    };
    let none = KickModel::of(0.0);
    let two_feet = KickSettings { left_straight: kick(1.0), right_straight: kick(-1.0), ..default() };
    // One that is aimed, for a ball before either foot.
    let mut aimed = kick(1.0);
    if let Some(region) = &mut aimed.region {
        region.y_m = [-2.0 * foot_y, 2.0 * foot_y];
        region.best_m.y = 0.0;
        region.direction = KickDirection::Chosen { most: between(reach, 0.2, 0.9) };
    }
    let own = CustomKicks::new([("visual".parse().unwrap(), aimed)]).unwrap();
    let only_aimed = KickSettings { left_straight: none, right_straight: none, own, ..default() };
    let kicks = KickSettings { left_side: none, right_side: none, ..if foot > 0.6 { only_aimed } else { two_feet } };
    (body, cameras, kicks)
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(20), ..ProptestConfig::with_cases(models()) })]

    /// Robots of random measures play: they find the ball and kick it, and no invariant breaks.
    #[test]
    fn a_robot_of_random_measures_finds_the_ball_and_kicks_it(random in proptest::array::uniform10(0.0_f32..1.0), seed in 1_u64..1000) {
        let (body, cameras, kicks) = built(random);
        let text = r#"{ "rules": "free", "ball": { "position_m": [1.2, 0.6] }, "sonar": { "fitted": false },
                        "robots": [{ "number": 1, "pose": [-1, 0, 0], "behaviour": "chaser" }] }"#;
        let of_text = Scenario::from_json(text).unwrap();
        let settings = RobotSettings { body, cameras, kicks, ..of_text.settings };
        let scenario = Scenario { seed, settings, ..of_text };
        prop_assert_eq!(scenario.validate(), Ok(()));
        let mut app = headless_app();
        app.start_match(&scenario).unwrap();
        let has_kicked = |app: &App| app.events().iter().any(|event| matches!(event, MatchEvent::Kick { result: KickResult::Kicked, .. }));
        prop_assert!(app.run_until(30 * 90, has_kicked), "{:?} {:?}", body, app.robot_pose(blue(1)));
    }
}

#[test]
fn every_model_plays_in_every_realism_and_meets_every_other() {
    for model in MODELS {
        for realism in ["paper", "ideal", "realistic"] {
            let text = format!(
                r#"{{ "model": "{}", "realism": "{realism}", "field": "spl2025", "rules": {{ "preset": "naoisis", "team_size": 2 }},
                      "teams": {{ "blue": "chasers", "pink": {{ "team": "roles", "model": "nao_v6" }} }} }}"#,
                model.name
            );
            let mut app = headless_app();
            app.start_match(&Scenario::from_json(&text).unwrap()).unwrap();
            app.run_cycles(30 * 10);
            let [own, other] = [blue(1), pink(1)].map(|id| *app.robot::<Body>(id).unwrap());
            assert_eq!(other, Body::default(), "{}", model.name);
            assert_eq!(own == other, model.name.starts_with("nao"), "{}", model.name);
        }
    }
}

#[test]
fn a_robot_without_cameras_plays_blindly() {
    let text = r#"{ "league": "hsl2026_middle", "teams": { "blue": "chasers",
        "pink": { "team": "roles", "model": { "preset": "booster_k1", "cameras": { "mounts": [] } } } } }"#;
    let mut app = headless_app();
    app.start_match(&Scenario::from_json(text).unwrap()).unwrap();
    // Long enough for things that look like a ball or a robot.
    app.run_cycles(30 * 40);
    let percepts = app.robot::<Percepts>(pink(2)).unwrap();
    let seen = percepts.goal_posts.len() + percepts.robots.len() + percepts.landmarks.len();
    assert_eq!((percepts.ball, seen), (None, 0));
}

#[test]
fn a_robot_of_another_model_sees_by_images_where_the_match_does() {
    let text = r#"{ "rules": "free", "vision": { "source": "image" }, "cameras": { "width": 160, "height": 120 },
        "robots": [{ "number": 1 }, { "team": "pink", "number": 1, "pose": [1, 0, 0], "model": "booster_k1" }] }"#;
    let mut app = headless_app();
    app.start_match(&Scenario::from_json(text).unwrap()).unwrap();
    let source = |id| app.robot::<VisionSettings>(id).unwrap().source;
    assert_eq!([source(blue(1)), source(pink(1))], [VisionSource::Image; 2]);
}

#[test]
fn every_model_finds_the_ball_and_kicks_it_however_it_walks() {
    for model in MODELS {
        let text = format!(
            r#"{{ "model": "{}", "realism": "realistic", "rules": "free", "ball": {{ "position_m": [0.8, -0.7] }},
                  "robots": [{{ "number": 1, "pose": [-1, 0.5, 90], "behaviour": "chaser" }}] }}"#,
            model.name
        );
        let mut app = headless_app();
        app.start_match(&Scenario::from_json(&text).unwrap()).unwrap();
        let has_kicked = |app: &App| {
            app.events().iter().any(|event| matches!(event, MatchEvent::Kick { result: KickResult::Kicked, .. }))
        };
        assert!(app.run_until(30 * 120, has_kicked), "{}: {:?}", model.name, app.robot_pose(blue(1)));
    }
}

#[test]
fn every_league_plays() {
    for league in LEAGUES {
        let text = format!(r#"{{ "league": "{}", "teams": {{ "blue": "passers", "pink": "chasers" }} }}"#, league.name);
        let mut app = headless_app();
        app.start_match(&Scenario::from_json(&text).unwrap()).unwrap();
        app.run_cycles(30 * 10);
    }
}

#[test]
fn percepts_and_images_name_the_cameras_of_the_robot() {
    let text = r#"{ "model": "booster_k1", "realism": "ideal", "rules": "free", "cameras": { "width": 64, "height": 36, "render": "software" },
                    "ball": { "position_m": [2, 0] }, "robots": [{ "number": 1 }] }"#;
    let mut app = headless_app();
    app.start_match(&Scenario::from_json(text).unwrap()).unwrap().run_cycles(2);
    let ball = app.robot::<Percepts>(blue(1)).unwrap().ball.unwrap();
    assert_eq!(ball.camera.to_string(), "head");
    let images = app.robot::<naoisis::sensing::camera::CameraImages>(blue(1)).unwrap();
    let taken: Vec<String> =
        images.iter().map(|(name, image)| format!("{name} {}x{}", image.width, image.height)).collect();
    assert_eq!(taken, ["head 64x36"]);
}

#[test]
fn a_model_of_ones_own_is_a_file_and_a_robot_changes_its_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("tall.ron");
    let text = r#"(name: "tall", description: "a tall NAO", settings: (body: (height_m: 0.7), motion: (max_linear_mps: 0.3)), realistic: (), sources: {})"#;
    std::fs::write(&path, text).unwrap();
    let scenario = format!(
        r#"{{ "rules": "free", "robots": [
              {{ "number": 1, "model": {path:?} }}, {{ "number": 2, "pose": [1, 1, 0], "model": {path:?}, "motion": {{ "max_angular_degps": 45 }} }},
              {{ "number": 3, "pose": [-1, -1, 0] }}] }}"#
    );
    let scenario = Scenario::from_json(&scenario).unwrap();
    let heights: Vec<f32> = scenario.robots.iter().map(|robot| scenario.body_of(robot).height_m).collect();
    assert_eq!(heights, [0.7, 0.7, 0.573]);
    let own = scenario.robots[1].own.motion.unwrap();
    assert_eq!((own.max_linear_mps, own.max_angular.to_degrees().round()), (0.3, 45.0));
    // What is written out says it all itself, even if the file is gone.
    std::fs::remove_file(&path).unwrap();
    assert_eq!(Scenario::from_json(&scenario.resolved_json().unwrap()).unwrap(), scenario);
    let model = RobotModel::find(&path.to_string_lossy()).unwrap_err().to_string();
    assert!(model.contains("cannot be read"), "{model}");
}

/// What a robot has in and on its body: from numbers between 0 and 1.
#[derive(Clone, Debug)]
struct Equipment {
    head: HeadLimits,
    cameras: CameraSettings,
    motion: MotionSettings,
    sonar: SonarSettings,
    latency: Latency,
    falls: FallModel,
}

fn equipped(body: &Body, random: [f32; 12]) -> Equipment {
    let [joints, nod, count, tilt, fov, own, speed, gait, walk, sonar, late, fall] = random;
    let between = |share: f32, least: f32, most: f32| least + share * (most - least);
    // A third of the robots has no joints in the neck, a third nods, a third nods and turns.
    let pitch = if joints < 1.0 / 3.0 { [0.0; 2] } else { [-0.3, between(nod, 0.3, 1.0)] };
    let yaw = if joints < 2.0 / 3.0 { [0.0; 2] } else { [-1.5, 1.5] };
    let top = between(0.5, body.neck_m.z, body.height_m);
    let names = ["head", "chin", "chest"];
    let first = between(tilt, 0.1, 0.5);
    let mounts: Vec<CameraMount> = names[..1 + (2.99 * count) as usize]
        .iter()
        .enumerate()
        .map(|(index, name)| {
            let lens = Vec3::new(0.05, if own > 0.7 { 0.03 } else { 0.0 }, top - 0.02 * index as f32);
            let mut mount = CameraMount::new(name.parse().unwrap(), lens, first + 0.5 * index as f32);
            mount.size = (own > 0.5).then_some([480, 300]);
            mount.diagonal_fov = (own > 0.3 && index == 1).then_some(1.4);
            mount.distortion = (own > 0.6).then(|| Distortion::new([-0.1, 0.01, 0.0], [0.0; 2]));
            mount.every_cycles = (own > 0.8 && index > 0).then_some(2);
            mount
        })
        .collect();
    let max_linear_mps = between(speed, 0.15, 0.9);
    let gait = (gait > 0.3).then(|| Gait {
        step_s: between(walk, 0.1, 0.4),
        backward_mps: 0.6 * max_linear_mps,
        sideways_mps: 0.5 * max_linear_mps,
        acceleration_mps2: between(walk, 0.3, 1.0),
        least_mps: between(walk, 0.005, 0.04),
        ..default()
    });
    Equipment {
        head: HeadLimits { yaw, pitch, max_speed: between(nod, 1.5, 6.0), ..default() },
        cameras: CameraSettings {
            mounts: CameraMounts::new(&mounts).unwrap(),
            diagonal_fov: between(fov, 1.3, 1.8),
            ..default()
        },
        motion: MotionSettings { max_linear_mps, max_angular: between(speed, 1.2, 2.5), gait, ..default() },
        sonar: SonarSettings {
            fitted: sonar > 0.4,
            height_m: 0.5 * body.height_m,
            max_m: between(sonar, 0.5, 1.5),
            ..default()
        },
        latency: Latency {
            vision_s: 0.1 * late,
            image_s: 0.05 * late,
            sonar_s: 0.05 * late,
            walk_s: 0.06 * late,
            kick_s: 0.06 * late,
            head_s: 0.06 * late,
        },
        falls: if fall < 0.5 {
            FallModel::default()
        } else {
            FallModel { falls_per_min: fall - 0.5, kick_probability: 0.02, get_up_s: Some(4.0), ..default() }
        },
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, rng_seed: RngSeed::Fixed(20), ..ProptestConfig::with_cases(models()) })]

    /// Robots of random measures with random heads, cameras, gaits, sonars, delays and falls play alone: each finds the ball and kicks it.
    #[test]
    fn a_robot_of_random_parts_finds_the_ball_and_kicks_it(
        measures in proptest::array::uniform10(0.0_f32..1.0), parts in proptest::array::uniform12(0.0_f32..1.0), seed in 1_u64..1000,
    ) {
        let (body, _, kicks) = built(measures);
        let Equipment { head, cameras, motion, sonar, latency, falls } = equipped(&body, parts);
        let text = r#"{ "rules": "free", "ball": { "position_m": [1.2, 0.6] },
                        "robots": [{ "number": 1, "pose": [-1, 0, 0], "behaviour": "chaser" }] }"#;
        let of_text = Scenario::from_json(text).unwrap();
        let settings = RobotSettings { body, kicks, head, cameras, motion, sonar, latency, falls, ..of_text.settings };
        let scenario = Scenario { seed, settings, ..of_text };
        prop_assert_eq!(scenario.validate(), Ok(()));
        let mut app = headless_app();
        app.start_match(&scenario).unwrap();
        let mut broken = None;
        let has_kicked = |app: &App| {
            let events = app.events();
            broken = broken.take().or_else(|| events.iter().find(|event| matches!(event, MatchEvent::InvariantBroken { .. })).cloned());
            events.iter().any(|event| matches!(event, MatchEvent::Kick { result: KickResult::Kicked, .. }))
        };
        prop_assert!(app.run_until(30 * 240, has_kicked), "{:?} {:?} {:?}", body, (head, cameras.mounts, motion), app.robot_pose(blue(1)));
        prop_assert_eq!(broken, None);
    }

    /// Six robots of six random models meet, and nothing breaks that must hold.
    #[test]
    fn robots_of_mixed_random_models_play(
        measures in proptest::array::uniform6(proptest::array::uniform10(0.0_f32..1.0)),
        parts in proptest::array::uniform6(proptest::array::uniform12(0.0_f32..1.0)),
        seed in 1_u64..1000,
    ) {
        let behaviours = ["keeper", "striker", "supporter"];
        let robots = measures.into_iter().zip(parts).enumerate().map(|(index, (measures, parts))| {
            let (body, _, kicks) = built(measures);
            let Equipment { head, cameras, motion, sonar, latency, falls } = equipped(&body, parts);
            let (team, side) = if index < 3 { (Team::Blue, -1.0) } else { (Team::Pink, 1.0) };
            let place = Vec2::new([2.6, 0.9, 1.4][index % 3], [0.0, 0.8, -0.9][index % 3]);
            RobotSpec {
                team,
                number: 1 + index as u8 % 3,
                pose: Pose { position: side * place, heading: if index < 3 { 0.0 } else { core::f32::consts::PI } },
                behaviour: BehaviourSpec::Named(behaviours[index % 3].to_owned()),
                own: RobotPatch {
                    body: Some(body),
                    kicks: Some(kicks),
                    head: Some(head),
                    cameras: Some(cameras),
                    motion: Some(motion),
                    sonar: Some(sonar),
                    latency: Some(latency),
                    falls: Some(falls),
                    ..default()
                },
                ..default()
            }
        });
        let scenario = Scenario { seed, robots: robots.collect(), ..default() };
        prop_assert_eq!(scenario.validate(), Ok(()));
        let mut app = headless_app();
        app.start_match(&scenario).unwrap();
        for _ in 0..30 * 30 {
            app.run_cycles(1);
            let broken = app.events().iter().find(|event| matches!(event, MatchEvent::InvariantBroken { .. }));
            prop_assert_eq!(broken, None);
        }
    }
}

#[test]
fn who_does_not_see_the_ball_at_its_feet_kicks_it_where_it_saw_it_last() {
    for (name, own) in [
        ("a head that does not nod", r#""head": { "pitch_deg": [0, 0] }"#),
        (
            "a camera that looks straight ahead",
            r#""head": { "yaw_deg": [0, 0], "pitch_deg": [0, 0] }, "cameras": { "mounts": [{ "name": "head", "position_m": [0.06, 0, 0.84] }] }"#,
        ),
    ] {
        for realism in ["paper", "realistic"] {
            let text = format!(
                r#"{{ "model": {{ "preset": "booster_k1", {own} }}, "realism": "{realism}", "field": "hsl2026_middle", "rules": "free",
                      "ball": {{ "position_m": [0.8, -0.7] }},
                      "robots": [{{ "number": 1, "pose": [-1, 0.5, 90], "behaviour": "chaser" }}] }}"#
            );
            let mut app = headless_app();
            app.start_match(&Scenario::from_json(&text).unwrap()).unwrap();
            let has_kicked = |app: &App| {
                app.events().iter().any(|event| matches!(event, MatchEvent::Kick { result: KickResult::Kicked, .. }))
            };
            assert!(app.run_until(30 * 120, has_kicked), "{name}, {realism}: {:?}", app.robot_pose(blue(1)));
        }
    }
}

/// How many robots are tried: more where that is asked for.
fn models() -> u32 {
    std::env::var("PROPTEST_CASES").ok().and_then(|count| count.parse().ok()).unwrap_or(12)
}

#[test]
fn who_has_no_kick_pushes_the_ball_towards_the_goal() {
    let text = r#"{ "model": "booster_k1", "realism": "paper", "field": "hsl2026_middle", "rules": "free",
        "kicks": { "left_straight": { "max_distance_m": 0 }, "right_straight": { "max_distance_m": 0 }, "own": { "visual": { "max_distance_m": 0 } } },
        "ball": { "position_m": [0.8, -0.7] }, "robots": [{ "number": 1, "pose": [2, 0.5, 90], "behaviour": "chaser" }] }"#;
    let mut app = headless_app();
    app.start_match(&Scenario::from_json(text).unwrap()).unwrap();
    let is_nearer = |app: &App| app.ball().is_some_and(|ball| ball.position.x > 2.3);
    assert!(app.run_until(30 * 120, is_nearer), "{:?}, {:?}", app.ball(), app.robot_pose(blue(1)));
}
