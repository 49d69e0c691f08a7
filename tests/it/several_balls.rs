//! Several balls in a training: they roll, meet and are kicked each by itself, are seen and recorded, and only the first is judged.

use approx::assert_abs_diff_eq;
use bevy::prelude::*;
use naoisis::events::MatchEvent;
use naoisis::interface::cycle_record::CycleRecord;
use naoisis::interface::gather::{gather_on_demand, record_now};
use naoisis::prelude::*;
use naoisis::sensing::vision::Percepts;
use naoisis::simulation::{Snapshot, situation};

use crate::support::{collect_events, match_of};

fn record(app: &mut App) -> CycleRecord {
    gather_on_demand(app.world_mut());
    record_now(app.world_mut()).clone()
}

/// Places and velocities of all balls, m and m/s.
fn balls(app: &mut App) -> Vec<(Vec2, Vec2)> {
    let balls = record(app).balls;
    balls.iter().map(|ball| (ball.position_m.truncate(), ball.velocity_mps.truncate())).collect()
}

#[test]
fn a_ball_that_meets_another_shares_its_motion() {
    for order in [[[0.0, 0.0], [1.0, 0.0]], [[1.0, 0.0], [0.0, 0.0]]] {
        let of = |place: [f32; 2]| {
            let speed = if place[0] == 0.0 { 1.0 } else { 0.0 };
            format!(r#"{{ "position_m": {place:?}, "velocity_mps": [{speed}, 0] }}"#)
        };
        let [first, second] = order.map(of);
        let mut app = match_of(&format!(
            r#"{{ "rules": "free", "ball": {{ "rolling": {{ "constant_mps2": 0.000001 }} }}, "balls": [{first}, {second}], "robots": [] }}"#
        ));
        app.run_cycles(45);
        let mut balls = balls(&mut app);
        balls.sort_by(|a, b| a.0.x.total_cmp(&b.0.x));
        // They meet after 0.94 m. With the restitution 0.4 one goes on with (1 - 0.4) / 2, the other with (1 + 0.4) / 2 of the speed.
        assert_abs_diff_eq!(balls[0].1, Vec2::new(0.3, 0.0), epsilon = 2e-3);
        assert_abs_diff_eq!(balls[1].1, Vec2::new(0.7, 0.0), epsilon = 2e-3);
        // 1.5 s after the start, right to the way of a cycle.
        assert_abs_diff_eq!(balls[0].0.x, 0.94 + 0.56 * 0.3, epsilon = 0.04);
        assert_abs_diff_eq!(balls[1].0.x, 1.0 + 0.56 * 0.7, epsilon = 0.04);
    }
}

#[test]
fn a_start_in_ball_beside_balls_is_refused() {
    let read = |ball: &str| {
        Scenario::from_json(&format!(
            r#"{{ "rules": "free", "robots": [], "ball": {ball}, "balls": [{{ "position_m": [1, 0] }}, {{ "position_m": [2, 0] }}] }}"#
        ))
    };
    let problem = read(r#"{ "position_m": [3, 0] }"#).unwrap_err().to_string();
    assert!(
        problem.contains("beside `balls`; expected it in `balls`") && problem.contains("balls[0].position_m"),
        "{problem}"
    );
    assert!(read(r#"{ "velocity_mps": [1, 0] }"#).unwrap_err().to_string().contains("velocity_mps"));
    // The same start twice is in files that the program writes.
    assert!(read(r#"{ "position_m": [1.0, 0.0], "radius_m": 0.04 }"#).is_ok());
}

#[test]
fn balls_do_not_pass_through_each_other_and_keep_their_momentum() {
    let mut app = match_of(
        r#"{ "rules": "free", "robots": [], "ball": { "rolling": { "constant_mps2": 0.000001 } },
             "balls": [{ "position_m": [-1, 0], "velocity_mps": [9, 0.02] }, { "position_m": [0.5, 0.02], "velocity_mps": [-7, 0] },
                       { "position_m": [0, 0.6], "velocity_mps": [0, -4] }, { "position_m": [1.2, 0] }] }"#,
    );
    let sum = |balls: &[(Vec2, Vec2)]| balls.iter().map(|ball| ball.1).sum::<Vec2>();
    let before = sum(&balls(&mut app));
    for _ in 0..12 {
        app.run_cycles(1);
        let balls = balls(&mut app);
        for (index, ball) in balls.iter().enumerate() {
            for other in &balls[..index] {
                assert!(ball.0.distance(other.0) > 2.0 * 0.03 - 1e-3, "{balls:?}");
            }
        }
        assert_abs_diff_eq!(sum(&balls), before, epsilon = 1e-2);
    }
}

#[test]
fn the_nearest_ball_in_reach_is_kicked_and_the_others_stay() {
    let mut app = match_of(
        r#"{ "rules": "free", "balls": [{ "position_m": [0.2, -0.05] }, { "position_m": [0.14, -0.05] }, { "position_m": [1, 1] }],
             "robots": [{ "number": 1, "behaviour": { "script": [{ "from_s": 0, "kick": { "type": "right_straight", "speed": 0.1 } }] } }] }"#,
    );
    let events = collect_events(&mut app, 2);
    assert!(events.iter().any(|(_, event)| matches!(event, MatchEvent::Kick { direction: Some(_), .. })));
    let balls = balls(&mut app);
    assert!(balls[1].1.x > 0.0 || balls[0].1.x > 0.0);
    assert_eq!(balls[2], (Vec2::ONE, Vec2::ZERO));
    app.run_cycles(60);
    assert!(self::balls(&mut app)[0].0.x > 0.25, "the kicked ball pushes the one before it");
}

#[test]
fn robots_that_walk_through_many_balls_break_nothing() {
    let places = (0..24).map(|index| {
        let (column, row) = (index % 6, index / 6);
        format!(r#"{{ "position_m": [{}, {}] }}"#, 0.3 + 0.062 * column as f32, -0.1 + 0.062 * row as f32)
    });
    let mut app = match_of(&format!(
        r#"{{ "rules": "free", "balls": [{}], "robots": [
             {{ "number": 1, "behaviour": {{ "script": [{{ "until_s": 99, "walk": [0.006, 0, 0.5] }}] }} }},
             {{ "number": 2, "pose": [1.2, 0, 180], "behaviour": {{ "script": [{{ "until_s": 99, "walk": [0.006, 0.001, 0] }}] }} }},
             {{ "number": 3, "pose": [0.4, -0.8, 90], "behaviour": "chaser" }}] }}"#,
        places.collect::<Vec<_>>().join(", ")
    ));
    let broken = |event: &MatchEvent| match event {
        MatchEvent::InvariantBroken { message } => Some(message.clone()),
        _ => None,
    };
    let events = collect_events(&mut app, 300);
    assert_eq!(events.iter().find_map(|(cycle, event)| Some((cycle, broken(event)?))), None);
    let balls = balls(&mut app);
    assert_eq!(balls.len(), 24);
    assert!(balls.iter().all(|ball| ball.1.length() < 1.5), "nobody kicked: {balls:?}");
}

#[test]
fn a_robot_sees_all_and_takes_the_nearest_for_the_ball() {
    let text = r#"{ "rules": "free", "vision": { "source": "SOURCE", "noise": "none" }, "robots": [{ "number": 1 }],
        "balls": [{ "position_m": [2.4, 0.4] }, { "position_m": [1.8, -0.2] }, { "position_m": [-1, 0] }] }"#;
    for (source, expected) in [("geometric", 2), ("truth", 3)] {
        let mut app = match_of(&text.replace("SOURCE", source));
        app.run_cycles(1);
        let percepts = app.world_mut().query::<&Percepts>().single(app.world()).unwrap().clone();
        assert_eq!(percepts.balls.len(), expected, "{source}");
        assert_eq!(percepts.ball, percepts.balls.first().copied());
        let nearest = if source == "truth" { Vec2::new(-1.0, 0.0) } else { Vec2::new(1.8, -0.2) };
        assert_abs_diff_eq!(percepts.ball.unwrap().position_m, nearest, epsilon = 0.01);
    }
    // Of one ball in view there is no list.
    let mut app = match_of(&text.replace("SOURCE", "geometric").replace("[2.4, 0.4]", "[-2.4, 0.4]"));
    app.run_cycles(1);
    let percepts = app.world_mut().query::<&Percepts>().single(app.world()).unwrap().clone();
    assert!(percepts.ball.is_some() && percepts.balls.is_empty());
}

#[test]
fn a_referee_needs_exactly_one_ball() {
    let read = |rules: &str, balls: &str| {
        Scenario::from_json(&format!(r#"{{ "rules": "{rules}", "balls": {balls}, "robots": [] }}"#))
    };
    let two = r#"[{ "position_m": [1, 0] }, { "position_m": [2, 0.5] }]"#;
    for rules in ["naoisis", "spl2010", "spl2025", "hsl2026"] {
        let problem = read(rules, two).unwrap_err().to_string();
        assert!(problem.contains("2 balls") && problem.contains("`free`"), "{problem}");
    }
    assert_eq!(read("naoisis", r#"[{ "position_m": [1, 0] }]"#).unwrap().ball.unwrap().place_m(), Vec2::X);
    for (wrong, said) in [
        (r#"[{ "position_m": [1, 0] }, { "position_m": [99, 0] }]"#, "outside the carpet"),
        (r#"[{ "position_m": [1, 0] }, { "position_m": [1.01, 0] }]"#, "two balls"),
        (r#"[{ "position_m": [1, 0] }, { "radius_m": 1 }]"#, "radius_m"),
        (r#"[{}, { "position_m": [1, 0], "velocity_mps": [200, 0] }]"#, "200 m/s"),
    ] {
        let problem = read("free", wrong).unwrap_err().to_string();
        assert!(problem.contains(said), "{problem}");
    }
}

#[test]
fn all_balls_are_in_files_saved_matches_and_situations() {
    let text = r#"{ "rules": "free", "robots": [{ "number": 1, "behaviour": "chaser" }],
        "balls": [{ "position_m": [1, 0] }, { "position_m": [2, 0.5], "velocity_mps": [-0.5, 0] }] }"#;
    let scenario = Scenario::from_json(text).unwrap();
    let written = serde_json::to_string(&scenario).unwrap();
    assert_eq!(Scenario::from_json(&written).unwrap(), scenario);
    assert_eq!(scenario.balls().count(), 2);
    let one = serde_json::to_string(&Scenario::from_json(r#"{ "rules": "free", "robots": [] }"#).unwrap()).unwrap();
    assert!(!one.contains("\"balls\""));

    let mut app = match_of(text);
    app.run_cycles(40);
    let snapshot = Snapshot::take(app.world_mut()).unwrap();
    let now = balls(&mut app);
    assert_eq!(now.len(), 2);
    app.run_cycles(60);
    let expected = balls(&mut app);
    snapshot.restore(app.world_mut()).unwrap();
    let again = situation(app.world_mut()).unwrap();
    assert_eq!(again.balls().map(|ball| ball.place_m()).collect::<Vec<_>>(), [now[0].0, now[1].0]);
    app.run_cycles(60);
    assert_eq!(balls(&mut app), expected);

    let mut app = match_of(r#"{ "rules": "free", "robots": [] }"#);
    let record = record(&mut app);
    assert!(record.ball.is_some() && record.balls.is_empty());
    assert!(!serde_json::to_string(&record).unwrap().contains("balls"));
}
