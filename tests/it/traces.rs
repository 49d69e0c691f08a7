//! What a match's trace says is read back as it was written.

use bevy::prelude::*;
use bevy::reflect::enums::{Enum, VariantInfo};
use bevy::reflect::{TypeInfo, Typed};
use naoisis::behaviour::reasons::ask_for_reasons;
use naoisis::behaviour::remarks::Remarks;
use naoisis::communication::StatusReport;
use naoisis::events::*;
use naoisis::interface::cycle_record::CycleRecord;
use naoisis::interface::fields::Fields;
use naoisis::interface::trace_fields::TRACE_FIELDS;
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::record::read::{Ending, TraceError, TraceReader};
use naoisis::record::recorder::{self, EndReason, Recorder};
use naoisis::record::trace::TraceRecorder;
use naoisis::robot::Roster;
use naoisis::scenario::LIBRARY;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;

use crate::support::{SharedBytes, begin_trace, blue, headless_app, pink};
use naoisis::game::{Evidence, Intervention, Measurement, PenaltyReason, RobotEvidence, Score, SetPlayKind};
use naoisis::kick_geometry::Side;

/// The trace of a match, to its final whistle or for so long.
fn whole_trace(scenario: &Scenario, longest_s: f64) -> Vec<u8> {
    let mut app = headless_app();
    app.start_match(scenario).unwrap_or_else(|fault| panic!("{}: {fault}", scenario.name));
    let bytes = begin_trace(&mut app);
    app.run_until((longest_s / scenario.cycle_s) as usize, |app| app.is_finished());
    recorder::finish(app.world_mut(), EndReason::FinalWhistle).into_iter().for_each(|said| assert!(said.is_ok()));
    bytes.written()
}

fn reader(trace: &[u8]) -> Result<TraceReader, TraceError> {
    TraceReader::new(Path::new("match.jsonl"), Cursor::new(trace.to_vec()))
}

fn records(trace: &[u8]) -> Vec<CycleRecord> {
    let mut reader = reader(trace).unwrap();
    core::iter::from_fn(|| reader.next_cycle().unwrap_or_else(|error| panic!("{error}"))).collect()
}

/// Reads a trace, and wants it to be the same when it is written again. The kinds of the events in it.
fn read_back(what: &str, trace: &[u8]) -> BTreeSet<String> {
    let mut reader = reader(trace).unwrap();
    let (again, mut world) = (SharedBytes::default(), World::new());
    let mut recorder = TraceRecorder::plain("again", again.clone());
    let (mut kinds, mut is_begun) = (BTreeSet::new(), false);
    loop {
        let record = reader.next_cycle().unwrap_or_else(|error| panic!("{what}: {error}"));
        let Some(record) = record else { break };
        if is_begun {
            recorder.record(&record, &mut world);
        } else {
            recorder.start(reader.scenario(), &record, &mut world);
            is_begun = true;
        }
        kinds.extend(record.events.iter().map(MatchEvent::kind));
    }
    assert_eq!(reader.ending(), Ending::Proper(EndReason::FinalWhistle), "{what}");
    let again = again.written();
    let differing = again.split(|byte| *byte == b'\n').zip(trace.split(|byte| *byte == b'\n')).find(|(one, other)| {
        // The last line is not written again.
        !one.is_empty() && one != other
    });
    let differing = differing.map(|(one, other)| [one, other].map(String::from_utf8_lossy));
    assert!(differing.is_none(), "{what}: {differing:?}");
    assert_eq!(
        again.iter().filter(|byte| **byte == b'\n').count() + 1,
        trace.iter().filter(|byte| **byte == b'\n').count()
    );
    kinds
}

#[test]
fn traces_of_the_built_in_scenarios_are_read_back() {
    for entry in LIBRARY {
        let scenario = Scenario::named(entry.name).unwrap();
        let longest_s = if scenario.name.contains("images") { 0.5 } else { 8.0 };
        for seed in 1..=2 {
            let scenario = Scenario { seed, ..scenario.clone() };
            read_back(entry.name, &whole_trace(&scenario, longest_s));
        }
    }
}

#[test]
fn traces_of_whole_matches_are_read_back_whatever_the_rules() {
    let mut kinds = BTreeSet::new();
    for (rules, seed) in ["naoisis", "spl2010", "spl2025", "extended", "free"].into_iter().zip(1..) {
        // Short halves, fast robots, quick penalties, and a shoot-out wherever the match is drawn.
        let text = format!(
            r#"{{ "name": "{rules}", "seed": {seed}, "teams": {{ "blue": "roles", "pink": "passers" }},
                 "ball": {{ "velocity_mps": [0.4, 2.5] }},
                 "rules": {{ "preset": "{rules}", "half_s": 12, "penalty_s": 3, "standby_s": 0, "ready_s": 4, "set_s": 1, "stall_s": 2,
                            "falls": true, "fall_from_mps": 0.0, "fall_certain_mps": 0.2, "get_up_s": 1, "dives": true,
                            "shoot_out": true, "shoot_out_shots": 1, "shoot_out_s": 3 }},
                 "motion": {{ "max_linear_mps": 0.6 }}, "messages": {{ "loss": 0.1 }} }}"#
        );
        let scenario = Scenario::from_json(&text).unwrap();
        kinds.extend(read_back(rules, &whole_trace(&scenario, 80.0)));
    }
    for wanted in ["kick", "collision", "fall", "got_up", "ball_out", "penalty pushing", "shot", "final_whistle"] {
        assert!(kinds.contains(wanted), "no {wanted} in {kinds:?}");
    }
}

/// Evidence with everything, and with as little as there can be.
fn evidence() -> [Evidence; 2] {
    let robot = RobotEvidence { robot: pink(2), position_m: Vec2::new(0.25, -1.0), speed_mps: 0.125 };
    let least = Evidence { rule: "A rule.".into(), position_m: Vec2::X, otherwise: "Otherwise.".into(), ..default() };
    let most = Evidence {
        ball_m: Some(Vec2::new(1.5, 0.5)),
        robots: vec![robot, RobotEvidence { robot: blue(1), ..robot }],
        measured: Some(Measurement { what: "m/s".into(), value: 0.5, limit: 0.25 }),
        ..least.clone()
    };
    [most, least]
}

/// Every kind of event, with whatever it may lack, and without.
fn examples() -> Vec<MatchEvent> {
    let (robot, team, position_m, score) = (blue(2), Team::Pink, Vec2::new(-1.5, 0.75), Score { blue: 1, pink: 2 });
    let mut events = vec![
        MatchEvent::Kick {
            robot,
            kick_type: KickType::LeftSide,
            speed: Some(0.5),
            result: KickResult::Kicked,
            reason: None,
            direction: Some(core::f32::consts::FRAC_PI_2),
            launch_speed_mps: Some(1.25),
        },
        MatchEvent::Kick {
            robot,
            kick_type: KickType::RightStraight,
            speed: None,
            result: KickResult::Missed,
            reason: Some(KickMiss::NotANumber),
            direction: None,
            launch_speed_mps: None,
        },
        MatchEvent::Fall { robot, cause: FallCause::Walking, speed_mps: 0.5, probability: 0.25 },
        MatchEvent::GotUp { robot },
        MatchEvent::ProgramRestarts { robot, duration_s: 30.0 },
        MatchEvent::Dive { robot, side: Side::Left },
        MatchEvent::CommandRefused { robot, command: CommandKind::Walk, reason: Refusal::NotFinite },
        MatchEvent::StateChanged { state: GameState::Set },
        MatchEvent::KickOff { team },
        MatchEvent::ThrowIn { team, position_m },
        MatchEvent::DropBall { position_m },
        MatchEvent::FreeKick { set_play: SetPlayKind::CornerKick, team, position_m },
        MatchEvent::FreeKickOver { team, taken: true },
        MatchEvent::Intervention { intervention: Intervention::SetScore { blue: 1, pink: 0 } },
        MatchEvent::InterventionRefused { intervention: Intervention::Return { robot }, message: "no".to_owned() },
        MatchEvent::PenaltyOver { robot, position_m },
        MatchEvent::MovedAside { robot, position_m },
        MatchEvent::GameController { message: "a second one".to_owned() },
        MatchEvent::HalfBegins { half: 2 },
        MatchEvent::Timeout { team: Some(team), duration_s: 300.0 },
        MatchEvent::Timeout { team: None, duration_s: 60.5 },
        MatchEvent::Substitution { robot, replaced: blue(3) },
        MatchEvent::AgentLost { robot, reason: AgentLoss::TimedOut, message: "it says nothing".to_owned() },
        MatchEvent::FinalWhistle,
        MatchEvent::ShootOutBegins,
        MatchEvent::ShootOutWon { team },
        MatchEvent::InvariantBroken { message: "the ball is \"lost\"\n".to_owned() },
    ];
    for (robot, with) in [
        (Some(robot), CollisionPartner::Robot(pink(1))),
        (Some(robot), CollisionPartner::Ball),
        (None, CollisionPartner::Post),
    ] {
        let collision_type = CollisionType::BallAndPost;
        events.push(MatchEvent::Collision { robot, with, collision_type, speed_mps: 0.125, position_m });
    }
    let interventions = [
        Intervention::PlaceBall { position_m, velocity_mps: Vec2::X },
        Intervention::PlaceRobot { robot, pose: Pose::new(1.0, -1.0, core::f32::consts::FRAC_PI_2) },
        Intervention::Penalise { robot, reason: PenaltyReason::Manual, duration_s: None },
        Intervention::Penalise { robot, reason: PenaltyReason::Manual, duration_s: Some(4.5) },
        Intervention::Whistle,
        Intervention::DropBall { position_m },
        Intervention::KickOff { team },
        Intervention::Timeout { team: Some(team), duration_s: None },
        Intervention::Timeout { team: None, duration_s: Some(30.0) },
        Intervention::Substitute { robot, by: blue(6) },
    ];
    events.extend(interventions.map(|intervention| MatchEvent::Intervention { intervention }));
    for evidence in evidence() {
        let present = evidence.ball_m.is_some();
        let who = present.then_some(robot);
        events.extend([
            MatchEvent::Goal { team, scorer: who, own_goal: present, evidence: evidence.clone() },
            MatchEvent::BallOut {
                line: BoundaryLine::Goal,
                position_m,
                last_touch: present.then_some(team),
                evidence: evidence.clone(),
            },
            MatchEvent::GoalDisallowed { team, reason: DisallowedGoal::NotIndirect, evidence: evidence.clone() },
            MatchEvent::GameStuck { robot: who, evidence: evidence.clone() },
            MatchEvent::PlacedByHand { robot, position_m, evidence: evidence.clone() },
            MatchEvent::Caution { robot, cautions: 2, evidence: evidence.clone() },
            MatchEvent::DoubleTouch { robot, evidence: evidence.clone() },
            MatchEvent::Penalty {
                robot,
                reason: PenaltyReason::BallHolding,
                until_s: 30.5,
                evidence: evidence.clone(),
            },
            MatchEvent::TooManyMessages { team, evidence: evidence.clone() },
            MatchEvent::Shot { team, scored: present, goals: score, evidence },
        ]);
    }
    events
}

#[test]
fn every_kind_of_event_is_read_back_with_whatever_it_may_lack() {
    let mut seen = BTreeSet::new();
    for event in examples() {
        let text = serde_json::to_string(&event).unwrap();
        let read: MatchEvent = serde_json::from_str(&text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(read, event, "{text}");
        assert_eq!(serde_json::to_string(&read).unwrap(), text);
        seen.extend((0..event.field_len()).map(|index| {
            let value = event.field_at(index).unwrap().reflect_ref();
            let presence = value.as_enum().map(|value| value.variant_name().to_owned()).unwrap_or_default();
            (event.variant_name().to_owned(), event.name_at(index).unwrap_or_default().to_owned(), presence)
        }));
        seen.insert((event.variant_name().to_owned(), String::new(), String::new()));
    }
    // A new kind of event, and a new part of one that may be absent, wants its example above.
    let TypeInfo::Enum(kinds) = MatchEvent::type_info() else { panic!("events are an enum") };
    for kind in kinds.iter() {
        let has = |field: &str, presence: &str| {
            seen.contains(&(kind.name().to_owned(), field.to_owned(), presence.to_owned()))
        };
        assert!(has("", ""), "no example of {}", kind.name());
        let VariantInfo::Struct(fields) = kind else { continue };
        for field in fields.iter().filter(|field| field.type_path().starts_with("core::option::Option")) {
            assert!(has(field.name(), "Some") && has(field.name(), "None"), "{}: {}", kind.name(), field.name());
        }
    }
}

#[test]
fn a_trace_of_every_few_cycles_has_all_events_and_its_last_cycle() {
    let scenario = Scenario { seed: 3, ..Scenario::named("match3v3").unwrap() };
    let sparse = SharedBytes::default();
    let mut app = headless_app();
    app.start_match(&scenario).unwrap();
    app.add_plugins(RecordPlugin);
    let whole = SharedBytes::default();
    let fields: Fields = "ball, robots.pose,robots.belief.ball, game, events".parse().unwrap();
    recorder::start(
        app.world_mut(),
        vec![
            Box::new(TraceRecorder::plain("whole", whole.clone())),
            Box::new(TraceRecorder::plain("sparse", sparse.clone()).every(7).with_fields(fields.clone())),
        ],
    );
    app.run_cycles(1000);
    recorder::finish(app.world_mut(), EndReason::Duration).into_iter().for_each(|said| assert!(said.is_ok()));
    let (whole, few) = (records(&whole.written()), records(&sparse.written()));
    let cycles: Vec<u64> = few.iter().map(|record| record.cycle).collect();
    assert_eq!(cycles, (0..1000).step_by(7).chain([1000]).collect::<Vec<u64>>());
    let events = |records: &[CycleRecord]| records.iter().flat_map(|record| record.events.clone()).collect::<Vec<_>>();
    assert!(!events(&whole).is_empty());
    assert_eq!(events(&whole), events(&few));
    for record in &few {
        let all = &whole[record.cycle as usize];
        assert_eq!((record.ball, record.game, record.time_s), (all.ball, all.game, all.time_s));
        for (few, all) in record.robots.iter().zip(&all.robots) {
            assert_eq!((few.id, few.pose), (all.id, all.pose));
            assert_eq!(few.belief.as_ref().map(|belief| belief.ball), all.belief.as_ref().map(|belief| belief.ball));
            assert!(few.command.is_none() && few.percepts == Percepts::default());
        }
    }
    let reader = reader(&sparse.written()).unwrap();
    assert_eq!((reader.every(), reader.fields()), (7, &fields));
    assert!(
        fields.has("robots")
            && fields.has("robots.belief")
            && !fields.has("robots.belief.pose")
            && !fields.has("robots.body")
    );
    let line = String::from_utf8(sparse.written()).unwrap().lines().nth(2).unwrap().to_owned();
    assert!(line.starts_with(r#"{"type":"cycle","cycle":7,"time_s":0.23333,"ball":{"#), "{line}");
}

#[test]
fn fields_are_named_as_traces_have_them() {
    for (list, words) in [
        ("robots.poes", "`robots.poes` in a trace: did you mean `robots.pose`?"),
        ("pose", "`pose` in a trace: did you mean `robots.pose`?"),
        ("evnts", "`evnts` in a trace: did you mean `events`?"),
        ("", "`` in a trace;"),
        ("ball,,x", "`x` in a trace;"),
        ("robots.", "`robots.` in a trace: did you mean `robots`?"),
    ] {
        let error = list.parse::<Fields>().unwrap_err().to_string();
        let expected =
            "expected `ball`, `balls`, `events`, `game` or `robots`, or a part of one, such as `robots.pose`";
        assert_eq!(error, format!("there is no field {words} {expected}"));
    }
    for always in ["type", "cycle", "time_s", "robots.id", "time_s,ball"] {
        assert!(always.parse::<Fields>().is_ok(), "{always} is in every line");
    }
    assert!("robots,robots.pose".parse::<Fields>().unwrap().has("robots.belief"), "all of the robots");
    assert!("robots.sensors.ear".parse::<Fields>().is_ok(), "a sensor of a program's own");
}

/// The names of all fields in a value, but for those within parts that have their own description.
fn names_in(value: &Value, path: &str, names: &mut BTreeSet<String>) {
    const DESCRIBED_ELSEWHERE: [&str; 8] = [
        "events", "robots.inbox.say", "robots.command.say", "robots.command.posture", "robots.drawings",
        "robots.sensors", "robots.values", "robots.posture",
    ];
    let of_teams = ["blue", "pink"];
    match value {
        Value::Object(fields) if !DESCRIBED_ELSEWHERE.contains(&path) => {
            for (name, value) in fields.iter().filter(|(name, _)| !of_teams.contains(&name.as_str())) {
                let path = if path.is_empty() { name.clone() } else { format!("{path}.{name}") };
                names.insert(path.clone());
                names_in(value, &path, names);
            }
        }
        Value::Array(values) => values.iter().for_each(|value| names_in(value, path, names)),
        _ => {}
    }
}

#[test]
fn the_guide_describes_every_field_of_a_trace() {
    let guide = include_str!("../../src/guide/traces.md");
    let documented: BTreeSet<String> = TRACE_FIELDS.keys().cloned().collect();
    for (name, says) in TRACE_FIELDS.iter() {
        let row = format!("| `{name}` | {says} |");
        assert!(guide.contains(&row), "the guide lacks: {row}");
    }
    let mut written = BTreeSet::new();
    let mut look_at = |trace: &[u8]| {
        for line in trace.split(|byte| *byte == b'\n').filter(|line| line.starts_with(br#"{"type":"cycle""#)) {
            names_in(&serde_json::from_slice(line).unwrap(), "", &mut written);
        }
    };
    // Robots that fall, dive and hear, kick-ins, and a shoot-out.
    let eventful = r#"{ "teams": { "blue": "passers", "pink": "roles" }, "sonar": { "rate_hz": 10 }, "motion": { "max_linear_mps": 0.8 },
        "ball": { "velocity_mps": [0.4, 2.5] },
        "rules": { "preset": "spl2025", "half_s": 8, "halves": 1, "standby_s": 0.5, "ready_s": 1, "set_s": 0.5, "penalty_s": 1, "falls": true,
                   "fall_from_mps": 0, "fall_certain_mps": 0.2, "get_up_s": 1, "shoot_out": true, "shoot_out_s": 1, "status_delay_s": 0 } }"#;
    look_at(&whole_trace(&Scenario::from_json(eventful).unwrap(), 25.0));
    let faces = r#"{ "rules": "free", "ball": { "position_m": [1, -0.2] }, "body": { "jersey": "team" },
        "vision": { "points": true, "noise": { "confidence": true, "jerseys": { "number_m": 3, "heading_m": 3, "colour_m": 3 } } },
        "robots": [{ "number": 1 }, { "number": 2, "pose": [1.5, 0.2, 180] }] }"#;
    look_at(&whole_trace(&Scenario::from_json(faces).unwrap(), 2.0));
    let several_balls = r#"{ "rules": "free", "robots": [{ "number": 1 }], "vision": { "noise": { "preset": "none", "confidence": true } },
        "balls": [{ "position_m": [2, 0.2] }, { "position_m": [2, -0.2] }] }"#;
    look_at(&whole_trace(&Scenario::from_json(several_balls).unwrap(), 0.1));
    let other_keeper = r#"{ "rules": { "preset": "spl2025", "substitutes": 1, "clock": false }, "teams": { "blue": "roles", "pink": "roles" },
        "interventions": [{ "at_s": 0, "do": { "substitute": { "robot": "blue1", "by": "blue8" } } }, { "at_s": 0.1, "do": "stop" }],
        "field": "spl2025" }"#;
    look_at(&whole_trace(&Scenario::from_json(other_keeper).unwrap(), 0.2));
    let mut app = headless_app();
    app.add_sensor::<Clock, Time, _>("clock", || {});
    let commanding = r#"{ "rules": { "preset": "extended", "clock": false }, "robots": [{ "behaviour": { "script": [
        { "from_s": 0, "walk": [0.01, 0, 1], "head_deg": [10, 20], "kick": { "type": "left_side", "speed": 0.5, "direction_deg": 20 },
          "posture": { "dive": "left" }, "request": "pick_up", "say": { "intention": "dive" } }] } }] }"#;
    app.start_match(&Scenario::from_json(commanding).unwrap()).unwrap();
    let bytes = begin_trace(&mut app);
    // What a robot reports to a GameController, and what its program says about itself, come from outside.
    let robot = app.world().resource::<Roster>().get(blue(1)).unwrap();
    let values = [("speed".to_owned(), 0.5)].into();
    let remarks = Remarks { intention: Some("wait".to_owned()), values };
    app.world_mut().entity_mut(robot).insert((StatusReport::default(), remarks));
    app.run_cycles(5);
    look_at(&bytes.written());
    // Reasons are for who asks for them.
    let mut app = headless_app();
    let players = r#"{ "rules": "free", "teams": { "blue": "passers", "pink": "roles" } }"#;
    app.start_match(&Scenario::from_json(players).unwrap()).unwrap();
    ask_for_reasons(app.world_mut());
    let bytes = begin_trace(&mut app);
    app.run_cycles(5);
    look_at(&bytes.written());
    let forgotten: Vec<_> = written.difference(&documented).collect();
    assert!(forgotten.is_empty(), "not in TRACE_FIELDS and the guide: {forgotten:?}");
    let unseen: Vec<_> = documented.difference(&written).collect();
    assert!(unseen.is_empty(), "in no trace: {unseen:?}");
}

/// The settings of a sensor of the test's own, and its reading.
#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Public)]
struct Clock;

#[derive(Component, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Sensor)]
struct Time(f32);

#[test]
fn a_record_has_what_robots_wanted_and_were_told() {
    let scenario = r#"{ "rules": "free", "ball": { "position_m": [0.15, -0.05] }, "robots": [
        { "number": 1, "behaviour": { "script": [
            { "from_s": 0.1, "until_s": 0.2, "walk": [0.004, 0, 3] }, { "from_s": 0.1, "head_deg": [20, 10] },
            { "from_s": 0.2, "kick": { "type": "right_straight" } },
            { "from_s": 0.3, "say": { "ball_m": [1, 2], "payload": "hello" } },
            { "from_s": 0.4, "walk": [1e9, 0, 0] }] } },
        { "number": 2, "pose": [-1, 1, 0] }] }"#;
    let trace = whole_trace(&Scenario::from_json(scenario).unwrap(), 0.5);
    let commands: Vec<Value> =
        records(&trace).iter().map(|record| serde_json::to_value(record.robots[0].command.as_ref()).unwrap()).collect();
    assert_eq!(commands[0], Value::Null, "nobody has wanted anything yet");
    // The cycle that begins at 0.1 s is the fourth.
    assert_eq!(commands[4], serde_json::json!({ "walk": [0.004_f32, 0.0, 3.0], "head_deg": [20.0, 10.0] }));
    assert_eq!(commands[5], serde_json::json!({ "walk": [0.004_f32, 0.0, 3.0] }));
    assert_eq!(commands[7], serde_json::json!({ "kick": { "type": "right_straight", "speed": 1.0 } }));
    assert_eq!(commands[10], serde_json::json!({ "say": { "ball_m": [1.0, 2.0], "payload": "hello" } }));
    assert_eq!(commands[13], serde_json::json!({}), "what was refused is among the events");
    let records = records(&trace);
    assert_eq!(records[13].events.len(), 1);
    assert_eq!(records[7].robots[0].body, Some(BodyStatus::Walking));
    assert_eq!(records[8].robots[0].body, Some(BodyStatus::Recovering));
    assert_eq!(records[11].robots[1].inbox[0].say.payload.as_deref(), Some("hello"));
    assert_eq!(records[1].robots[1].game.map(|told| told.state), Some(GameState::Playing));
}

#[test]
fn a_small_file_cannot_take_much_memory() {
    let header = format!(r#"{{"type":"header","format":"naoisis-trace","version":1,"scenario":{{}}}}{}"#, '\n');
    let cycle = |inside: &str| format!(r#"{{"type":"cycle","cycle":0,"time_s":0{inside}}}{}"#, '\n');
    let long = format!(r#","x":"{}""#, "x".repeat(17 << 20));
    let deep = format!(r#","x":{}"#, "[".repeat(100_000));
    for (inside, message) in [
        (long, "match.jsonl:2:1: the line has more than 16 MiB; expected a line of a trace"),
        (deep, "expected value; expected a cycle of a trace"),
    ] {
        let mut reader = reader((header.clone() + &cycle(&inside)).as_bytes()).unwrap();
        let error = reader.next_cycle().unwrap_err().to_string();
        assert!(error.contains(message), "{error}");
    }
}
