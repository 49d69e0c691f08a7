//! What a match's trace says is read back as it was written.

use bevy::prelude::*;
use bevy::reflect::enums::{Enum, VariantInfo};
use bevy::reflect::{TypeInfo, Typed};
use naoisis::events::*;
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::record::read::{Ending, TraceReader};
use naoisis::record::recorder::{self, EndReason};
use naoisis::record::trace::TraceRecorder;
use naoisis::scenario::LIBRARY;
use serde_json::Value;
use std::collections::BTreeSet;
use std::io::Cursor;
use std::path::Path;

use crate::support::{SharedBytes, blue, headless_app, pink};
use naoisis::game::{Evidence, Intervention, Measurement, PenaltyReason, RobotEvidence, Score, SetPlayKind};
use naoisis::kick_geometry::Side;

/// The trace of a match, to its final whistle or for so long.
fn whole_trace(scenario: &Scenario, longest_s: f64) -> Vec<u8> {
    let bytes = SharedBytes::default();
    let mut app = headless_app();
    app.add_plugins(RecordPlugin);
    app.start_match(scenario).unwrap_or_else(|fault| panic!("{}: {fault}", scenario.name));
    recorder::start(app.world_mut(), vec![Box::new(TraceRecorder::plain("trace", bytes.clone()))]);
    app.run_until((longest_s / scenario.cycle_s) as usize, |app| app.is_finished());
    recorder::finish(app.world_mut(), EndReason::FinalWhistle).into_iter().for_each(|said| assert!(said.is_ok()));
    bytes.written()
}

/// Whether two values are the same, but for the last digit of a number in single precision.
fn are_close(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Number(one), Value::Number(other)) => {
            let [one, other] = [one, other].map(|number| number.as_f64().unwrap());
            (one - other).abs() <= 1e-6 * one.abs().max(1.0)
        }
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| are_close(one, other))
        }
        (Value::Object(one), Value::Object(other)) => {
            one.len() == other.len()
                && one.iter().all(|(key, one)| other.get(key).is_some_and(|other| are_close(one, other)))
        }
        (one, other) => one == other,
    }
}

/// Reads a trace, and wants each line as it was written. The kinds of the events in it.
fn read_back(what: &str, trace: &[u8]) -> BTreeSet<String> {
    let mut lines = trace.split(|byte| *byte == b'\n').skip(1);
    let mut reader = TraceReader::new(Path::new("match.jsonl"), Cursor::new(trace.to_vec())).unwrap();
    let mut kinds = BTreeSet::new();
    loop {
        let record = reader.next_cycle().unwrap_or_else(|error| panic!("{what}: {error}"));
        let Some(record) = record else { break };
        let read = serde_json::to_value(&record).unwrap();
        let written: Value = serde_json::from_slice(lines.next().unwrap()).unwrap();
        assert!(are_close(&read, &written), "{what}: cycle {}\n{read}\n{written}", record.cycle);
        kinds.extend(record.events.iter().map(MatchEvent::kind));
    }
    assert_eq!(reader.ending(), Ending::Proper(EndReason::FinalWhistle), "{what}");
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
    for rules in ["naoisis", "spl2010", "spl2025", "extended", "free"] {
        for seed in 1..=2 {
            // Short halves, fast robots, quick penalties, and a shoot-out wherever the match is drawn.
            let text = format!(
                r#"{{ "name": "{rules}", "seed": {seed}, "teams": {{ "blue": "roles", "pink": "passers" }},
                     "ball": {{ "velocity_mps": [0.4, 2.5] }},
                     "rules": {{ "preset": "{rules}", "half_s": 12, "penalty_s": 3, "ready_s": 4, "set_s": 1, "stall_s": 2,
                                "falls": true, "fall_from_mps": 0.0, "fall_certain_mps": 0.2, "get_up_s": 1, "dives": true,
                                "shoot_out": true, "shoot_out_shots": 1, "shoot_out_s": 3 }},
                     "motion": {{ "max_linear_mps": 0.6 }}, "messages": {{ "loss": 0.1 }} }}"#
            );
            let scenario = Scenario::from_json(&text).unwrap();
            kinds.extend(read_back(rules, &whole_trace(&scenario, 80.0)));
        }
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
        MatchEvent::Fall { robot, speed_mps: 0.5, probability: 0.25 },
        MatchEvent::GotUp { robot },
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
        MatchEvent::HalfBegins { half: 2 },
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
            MatchEvent::Penalty {
                robot,
                reason: PenaltyReason::BallHolding,
                until_s: 30.5,
                evidence: evidence.clone(),
            },
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
