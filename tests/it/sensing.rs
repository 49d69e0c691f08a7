//! Sensors in a match.

use naoisis::prelude::*;

use crate::support::{blue, match_of, pink};

/// Four robots that see each other walk by their scripts, whatever they sense. `of_blue1` are blue 1's own settings.
fn scripted_match(of_blue1: &str) -> bevy::prelude::App {
    let script = r#""behaviour": { "script": [
        { "until_s": 60, "walk": [0.003, 0.001, 1.0] }, { "from_s": 0.5, "head_deg": [40, 10] },
        { "from_s": 1.5, "head_deg": [-40, 20] }] }"#;
    match_of(&format!(
        r#"{{ "rules": "free", "seed": 4, "ball": {{ "position_m": [0.2, 0.3], "velocity_mps": [0.3, 0.1] }},
             "motion": {{ "error_sd": {{ "dx_m": 0.001, "dy_m": 0.001, "dtheta_deg": 0.3 }} }}, "robots": [
             {{ "number": 1, "pose": [-0.4, 0, 0], {of_blue1} {script} }},
             {{ "number": 2, "pose": [-0.4, 0.5, -30], {script} }},
             {{ "team": "pink", "number": 1, "pose": [0.3, 0, 180], {script} }},
             {{ "team": "pink", "number": 2, "pose": [0.5, 0.5, 200], {script} }}] }}"#
    ))
}

#[test]
fn one_robots_settings_leave_every_other_robots_readings_untouched() {
    for changed in [
        r#""vision": { "noise": "none" }, "#,
        r#""vision": { "noise": { "ball": { "pixel_sd": 9.0, "false_positive_probability": 0.5 } } }, "#,
        r#""sonar": { "noise": "none", "miss_probability": 0.5 }, "#,
        r#""odometry": { "noise": "none" }, "#,
        r#""motion": { "max_linear_mps": 0.2 }, "#,
    ] {
        let mut plain = scripted_match("");
        let mut seen = false;
        let mut other = scripted_match(changed);
        let mut differed = false;
        for _ in 0..90 {
            plain.run_cycles(1);
            other.run_cycles(1);
            for id in [blue(2), pink(1), pink(2)] {
                assert_eq!(plain.robot::<Percepts>(id), other.robot::<Percepts>(id), "{changed}");
                assert_eq!(plain.robot::<SonarReading>(id), other.robot::<SonarReading>(id), "{changed}");
                assert_eq!(plain.robot::<Odometry>(id), other.robot::<Odometry>(id), "{changed}");
            }
            seen |= plain.robot::<Percepts>(pink(1)).is_some_and(|percepts| *percepts != Percepts::default());
            let own = blue(1);
            differed |= plain.robot::<Percepts>(own) != other.robot::<Percepts>(own)
                || plain.robot::<SonarReading>(own) != other.robot::<SonarReading>(own)
                || plain.robot::<Odometry>(own) != other.robot::<Odometry>(own);
        }
        assert!(seen, "there was nothing to compare");
        // The last setting is the default, by which nothing at all changes.
        assert_eq!(differed, !changed.contains("max_linear"), "{changed}");
    }
}

#[test]
fn a_word_says_how_true_a_robots_sensors_are() {
    // All look away from the ball and from each other; only the truth knows of them.
    let robots = |of_all: &str| {
        match_of(&format!(
            r#"{{ "rules": "free", {of_all} "ball": {{ "position_m": [0, 0] }}, "robots": [
                 {{ "number": 1, "pose": [1, 0, 0] }},
                 {{ "number": 2, "pose": [1, 1, 0], "fidelity": "truth" }},
                 {{ "number": 3, "pose": [1, -1, 0], "fidelity": {{ "sonar": "truth" }} }}] }}"#
        ))
    };
    let sees = |app: &bevy::prelude::App, number| app.robot::<Percepts>(blue(number)).unwrap().ball.is_some();
    for (of_all, all_see) in [("", false), (r#""fidelity": "ideal","#, false), (r#""fidelity": "truth","#, true)] {
        let mut app = robots(of_all);
        app.run_cycles(1);
        assert_eq!([1, 2, 3].map(|number| sees(&app, number)), [all_see, true, all_see], "{of_all}");
    }
    // Without noise, the same place is seen in every cycle.
    let ball_places = |fidelity: &str| {
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "fidelity": "{fidelity}", "ball": {{ "position_m": [1, 0] }},
                 "robots": [{{ "number": 1, "pose": [-1, 0, 0] }}] }}"#
        ));
        let places: Vec<_> = (0..30)
            .filter_map(|_| {
                app.run_cycles(1);
                app.robot::<Percepts>(blue(1)).unwrap().ball.map(|ball| ball.position_m)
            })
            .collect();
        assert!(!places.is_empty());
        places
    };
    let ideal = ball_places("ideal");
    assert!(ideal.len() == 30 && ideal.windows(2).all(|pair| pair[0] == pair[1]));
    assert!(ball_places("noisy").windows(2).any(|pair| pair[0] != pair[1]));
}

#[test]
fn an_image_vision_of_ones_own_takes_the_place_of_the_built_in_one() {
    use bevy::prelude::*;
    use naoisis::camera_model::CameraName;
    use naoisis::cycle::Cycle;
    use naoisis::sensing::camera::CameraImages;
    use naoisis::sensing::scene::SensingSystems;
    use naoisis::sensing::vision::BallPercept;

    /// Sees the ball a metre ahead in any image.
    fn hallucinate(mut robots: Query<(&CameraImages, &mut Percepts)>) {
        for (images, mut percepts) in &mut robots {
            if !images.of(CameraName::TOP).is_empty() {
                let position_m = Vec2::X;
                percepts.ball = Some(BallPercept::new(CameraName::TOP, Vec2::ZERO, position_m));
            }
        }
    }

    let text = r#"{ "rules": "free", "ball": { "position_m": [-1, 0] }, "cameras": { "width": 80, "height": 60 },
                    "robots": [{ "number": 1 }, { "number": 2, "pose": [1, 1, 0], "fidelity": "image" }] }"#;
    let mut app = crate::support::headless_app();
    app.add_systems(Cycle, hallucinate.in_set(SensingSystems::Custom));
    app.start_match(&Scenario::from_json(text).unwrap()).unwrap().run_cycles(2);
    assert_eq!(app.robot::<Percepts>(blue(2)).unwrap().ball.unwrap().position_m, Vec2::X);
    assert_eq!(app.robot::<Percepts>(blue(1)).unwrap().ball, None);
}

#[test]
fn a_robot_keeps_its_own_body_when_it_dives_gets_up_and_is_placed() {
    use naoisis::game::Intervention;
    use naoisis::robot::body::{Body, BodyBox};
    use naoisis::robot::posture::Posture;

    let standard = Body::default();
    // Below the sonars, which are 40 cm high; and so high that they hear it.
    for (top_m, is_heard) in [(0.35, false), (1.0, true)] {
        let own = Body {
            torso: BodyBox { z_m: [0.2, top_m], ..standard.torso },
            base: BodyBox { z_m: [0.0, 0.2], ..standard.base },
            height_m: top_m + 0.1,
            ..standard
        };
        let mut app = match_of(
            r#"{ "rules": { "preset": "free", "dives": true }, "ball": { "position_m": [0, 1] },
                 "sonar": { "noise": "none" }, "robots": [{ "number": 1 },
                   { "team": "pink", "number": 1, "pose": [0.5, 0, 180], "behaviour": { "script": [
                     { "from_s": 0.5, "posture": { "dive": "left" } }, { "from_s": 4.0, "posture": "get_up" }] } }] }"#,
        );
        let low = app.world().resource::<naoisis::robot::Roster>().get(pink(1)).unwrap();
        app.world_mut().entity_mut(low).insert(own);
        let hears = |app: &bevy::prelude::App| {
            let reading = app.robot::<SonarReading>(blue(1)).unwrap();
            reading.left.is_some() || reading.right.is_some()
        };
        let posture = |app: &bevy::prelude::App| *app.robot::<Posture>(pink(1)).unwrap();
        assert_eq!(hears(app.run_cycles(2)), is_heard);
        assert!(app.run_until(90, |app| matches!(posture(app), Posture::Fallen { .. })));
        assert!(!hears(app.run_cycles(2)), "a robot that lies is too low for sonars");
        assert!(app.run_until(600, |app| posture(app) == Posture::Upright));
        assert_eq!(hears(app.run_cycles(2)), is_heard, "it has got up");
        app.world_mut().commands().queue(Intervention::PlaceRobot { robot: pink(1), pose: Pose::new(0.4, 0.0, 3.0) });
        app.world_mut().flush();
        assert_eq!(hears(app.run_cycles(3)), is_heard, "it was placed");
        assert_eq!(app.robot::<Body>(pink(1)), Some(&own));
    }
}
