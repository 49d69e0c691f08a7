//! Realistic robots: their walk, their falls, and how late they are.

use crate::support::{blue, collect_events, match_of};
use bevy::prelude::*;
use naoisis::events::{FallCause, MatchEvent};
use naoisis::prelude::*;
use naoisis::robot::Roster;
use naoisis::sensing::camera::CameraImages;
use naoisis::sensing::odometry::Odometry;
use naoisis::sensing::vision::Percepts;

/// A scenario with one robot that walks like this, without chance but for what is given.
fn walker(own: &str, walk: &str) -> String {
    format!(
        r#"{{ "realism": {{ "motion": "realistic" }}, "model": "nao_v6", "rules": "free", "ball": null, {own}
             "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "until_s": 100, "walk": {walk} }}] }} }}] }}"#
    )
}

#[test]
fn a_realistic_robot_gets_into_its_stride_step_by_step_and_slips() {
    let mut app = match_of(&walker(r#""odometry": { "noise": "none" },"#, "[1, 0, 0]"));
    let mut ways = Vec::new();
    for _ in 0..8 {
        let before = app.robot_pose(blue(1)).unwrap().position;
        app.run_cycles(15);
        ways.push(app.robot_pose(blue(1)).unwrap().position.distance(before));
    }
    // Two steps of 0.25 s each half second: 0.075 and 0.15, then 0.225 and 0.242 m/s, of which the ground lets it go some 95 %.
    assert!(ways[0] < 0.8 * ways[2] && ways[2] < 1.2 * ways[7], "{ways:?}");
    app.run_cycles(1);
    let Odometry(counted) = app.robot::<Odometry>(blue(1)).copied().unwrap();
    let gone = app.robot_pose(blue(1)).unwrap().position.length();
    // A robot's share is 95 % with a spread of 3 %, and its steps add 2 % after a metre: three of them, 99.7 % confidence.
    assert!((gone / counted.position.length() - 0.95).abs() < 3.0 * 0.036, "{gone} of {}", counted.position.length());
}

#[test]
fn sideways_is_slower_than_ahead_and_a_whisper_of_a_command_moves_nothing() {
    let speed = |walk: &str| {
        let mut app = match_of(&walker("", walk));
        app.run_cycles(120);
        app.robot_pose(blue(1)).unwrap().position.length() / 4.0
    };
    assert!(speed("[0, 1, 0]") < 0.9 * speed("[1, 0, 0]"));
    // 0.015 m/s is less than the play of the joints.
    assert_eq!(speed("[0.0005, 0, 0]"), 0.0);
}

#[test]
fn a_robot_that_falls_while_it_walks_is_told_so_and_gets_up() {
    let script = r#"{ "until_s": 100, "walk": [1, 0, 0], "posture": "get_up" }"#;
    let mut app = match_of(&format!(
        r#"{{ "rules": "free", "ball": null, "falls": {{ "falls_per_min": 60, "get_up_s": 1, "get_up_failure": 0.3 }},
             "robots": [{{ "number": 1, "behaviour": {{ "script": [{script}] }} }}] }}"#
    ));
    let events = collect_events(&mut app, 30 * 60);
    let count = |wanted: fn(&MatchEvent) -> bool| events.iter().filter(|(_, event)| wanted(event)).count();
    let fell = count(|event| matches!(event, MatchEvent::Fall { cause: FallCause::Walking, .. }));
    let fell_back = count(|event| matches!(event, MatchEvent::Fall { cause: FallCause::GettingUp, .. }));
    let got_up = count(|event| matches!(event, MatchEvent::GotUp { .. }));
    // Each second it walks a fall, and 1.4 s to get up: some 25 in a minute.
    assert!((10..40).contains(&fell) && fell_back > 0 && got_up + 1 >= fell, "{fell} {fell_back} {got_up}");
}

#[test]
fn what_is_seen_late_is_where_it_was_and_says_when_that_was() {
    let mut app = match_of(
        r#"{ "latency": { "vision_s": 0.1 }, "vision": { "noise": "none" }, "rules": "free",
             "ball": { "position_m": [0, 0], "velocity_mps": [1, 0] },
             "robots": [{ "number": 1, "pose": [-2, 0, 0], "behaviour": "idle" }] }"#,
    );
    let mut places = Vec::new();
    for cycle in 1..=30 {
        // The instant that is sensed is the start of the cycle.
        places.push(app.ball().unwrap().position);
        app.run_cycles(1);
        let percepts = app.robot::<Percepts>(blue(1)).unwrap();
        let Some(seen) = percepts.ball else {
            assert!(cycle <= 3, "nothing is seen in cycle {cycle}");
            continue;
        };
        let then = (percepts.time_s * 30.0).round() as usize;
        assert_eq!(then + 3, cycle - 1, "three cycles of 1/30 s");
        let place = seen.position_m - Vec2::new(2.0, 0.0);
        assert!(place.distance(places[then]) < 1e-3, "cycle {cycle}: {place} instead of {}", places[then]);
    }
}

#[test]
fn echoes_and_images_are_those_of_earlier_and_say_when_that_was() {
    for (rate_hz, every_cycles) in [("null", 1), ("10.0", 2)] {
        let match_with = |latency: &str| {
            match_of(&format!(
                r#"{{ "latency": {latency}, "rules": "free", "ball": null, "sonar": {{ "noise": "none", "rate_hz": {rate_hz} }},
                     "cameras": {{ "render": "software", "width": 32, "height": 24, "every_cycles": {every_cycles} }},
                     "posts": [{{ "position_m": [0.6, 0.15] }}], "robots": [{{ "number": 1, "pose": [0, 0, 0],
                     "behaviour": {{ "script": [{{ "from_s": 0, "until_s": 9, "walk": [0.003, 0, 0] }}] }} }}] }}"#
            ))
        };
        let (mut fresh, mut late) = (match_with("{}"), match_with(r#"{ "sonar_s": 0.1, "image_s": 0.1 }"#));
        let read = |app: &App| {
            (*app.robot::<SonarReading>(blue(1)).unwrap(), app.robot::<CameraImages>(blue(1)).unwrap().clone())
        };
        let mut earlier = Vec::new();
        let mut echoes = 0;
        for cycle in 1..=60 {
            fresh.run_cycles(1);
            late.run_cycles(1);
            earlier.push(read(&fresh));
            let (heard, images) = read(&late);
            // Three cycles of 1/30 s.
            let Some((echo, image)) = earlier.len().checked_sub(4).map(|index| &earlier[index]) else {
                assert_eq!(([heard.left, heard.right], images.cycle), ([None; 2], None));
                continue;
            };
            assert_eq!([heard.left, heard.right], [echo.left, echo.right], "cycle {cycle}");
            if heard.left.is_some() {
                echoes += 1;
                let pinged_s = echo.time_s.unwrap_or(f64::from(cycle - 4) / 30.0);
                assert!((heard.time_s.unwrap() - pinged_s).abs() < 1e-9, "cycle {cycle}: {heard:?}");
            }
            assert_eq!(images.cycle, image.cycle, "cycle {cycle}");
            assert!(images.iter().eq(image.iter()) && images.iter().all(|(_, image)| !image.is_empty()));
        }
        assert!(echoes > 20, "{echoes}");
    }
}

#[test]
fn a_head_turns_later_than_it_is_told_and_as_far() {
    let match_with = |latency: &str| {
        match_of(&format!(
            r#"{{ "latency": {latency}, "rules": "free", "ball": null, "robots": [{{ "number": 1, "head_deg": [-20, 5],
                 "behaviour": {{ "script": [{{ "from_s": 0.2, "head_deg": [60, 20] }}, {{ "from_s": 0.4, "head_deg": [0, -10] }}] }} }}] }}"#
        ))
    };
    let (mut fresh, mut late) = (match_with("{}"), match_with(r#"{ "head_s": 0.1 }"#));
    let mut earlier = vec![*fresh.robot::<HeadAngles>(blue(1)).unwrap(); 3];
    for cycle in 0..40 {
        fresh.run_cycles(1);
        late.run_cycles(1);
        earlier.push(*fresh.robot::<HeadAngles>(blue(1)).unwrap());
        assert_eq!(*late.robot::<HeadAngles>(blue(1)).unwrap(), earlier[cycle], "cycle {cycle}");
    }
    assert_eq!(fresh.robot::<HeadAngles>(blue(1)), late.robot::<HeadAngles>(blue(1)));
}

#[test]
fn built_in_players_walk_without_vibrating() {
    const SECONDS: usize = 60;
    for team in ["roles", "passers"] {
        let mut app = match_of(&format!(
            r#"{{ "realism": "realistic", "model": "nao_v6", "duration_s": {SECONDS}, "teams": {{ "blue": "{team}", "pink": "roles" }} }}"#
        ));
        let ids: Vec<RobotId> = app.world().resource::<Roster>().iter().map(|(id, _)| id).collect();
        let mut reversals = vec![0; ids.len()];
        let [mut paths, mut nets] = [vec![0.0; ids.len()], vec![0.0; ids.len()]];
        let mut last = vec![Vec2::ZERO; ids.len()];
        for _ in 0..SECONDS {
            let places = |app: &App| -> Vec<Vec2> {
                ids.iter().map(|id| app.robot_pose(*id).unwrap_or_default().position).collect()
            };
            let first = places(&app);
            for _ in 0..30 {
                let before = places(&app);
                app.run_cycles(1);
                for (index, place) in places(&app).into_iter().enumerate() {
                    let step = place - before[index];
                    // Who is carried by the referee walks nowhere.
                    if (0.0003..0.1).contains(&step.length()) {
                        reversals[index] += usize::from(step.dot(last[index]) < 0.0);
                        last[index] = step;
                        paths[index] += step.length();
                    }
                }
            }
            for (index, place) in places(&app).into_iter().enumerate() {
                nets[index] += place.distance(first[index]);
            }
        }
        for (index, id) in ids.iter().enumerate() {
            assert!(reversals[index] < SECONDS, "{team}: {id} turns back {} times", reversals[index]);
            assert!(
                paths[index] < 1.6 * nets[index] + 0.2,
                "{team}: {id} walks {} for {} m",
                paths[index],
                nets[index]
            );
        }
    }
}
