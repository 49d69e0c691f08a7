//! The rules, case by case: each is a small scenario in `tests/rule_cases`, whose README says how one reads.

use bevy::reflect::{TypeInfo, Typed};
use heck::ToSnakeCase;
use naoisis::game::{Intervention, PenaltyReason};
use naoisis::prelude::*;
use naoisis::simulation::RuleRegistry;
use serde_json::Value;
use std::num::NonZero;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use crate::support::headless_app;

/// Numbers within this are equal.
const TOLERANCE: f64 = 0.1;

#[test]
fn every_case_ends_as_its_file_says() {
    play_all(|_, _| {});
}

#[test]
fn every_case_ends_alike_with_the_colours_changed_and_the_pitch_turned() {
    play_all(|case, scenario| {
        for (_, pattern) in &mut case.expected {
            pattern.change_colours();
        }
        change_colours(scenario);
    });
}

/// Exchanges the teams, and turns the pitch by half a turn.
fn change_colours(scenario: &mut Scenario) {
    scenario.rules.first_kick_off = scenario.rules.first_kick_off.opponent();
    for robot in &mut scenario.robots {
        (robot.team, robot.pose) = (robot.team.opponent(), robot.pose.turned_half());
    }
    if let Some(teams) = &mut scenario.teams {
        core::mem::swap(&mut teams.blue, &mut teams.pink);
    }
    if let Some(ball) = &mut scenario.ball {
        (ball.position_m, ball.velocity_mps) = (-ball.position_m, -ball.velocity_mps);
    }
    for post in &mut scenario.posts {
        post.position_m = -post.position_m;
    }
    for timed in &mut scenario.interventions {
        let other = |robot: RobotId| RobotId::new(robot.team.opponent(), robot.number);
        match &mut timed.intervention {
            Intervention::PlaceBall { position_m, velocity_mps } => {
                (*position_m, *velocity_mps) = (-*position_m, -*velocity_mps);
            }
            Intervention::PlaceRobot { robot, pose } => (*robot, *pose) = (other(*robot), pose.turned_half()),
            Intervention::SetScore { blue, pink } => core::mem::swap(blue, pink),
            Intervention::Penalise { robot, .. } | Intervention::PickUp { robot } | Intervention::Return { robot } => {
                *robot = other(*robot);
            }
            Intervention::Whistle | Intervention::Stop | Intervention::Resume => {}
            Intervention::DropBall { position_m } => *position_m = -*position_m,
            Intervention::KickOff { team } => *team = team.opponent(),
            Intervention::Timeout { team, .. } => *team = team.map(Team::opponent),
            Intervention::Substitute { robot, by } => (*robot, *by) = (other(*robot), other(*by)),
        }
    }
}

/// Plays all cases, each changed by `change`.
fn play_all(change: impl Fn(&mut Case, &mut Scenario) + Sync) {
    let cases = cases();
    assert!(cases.len() > 100, "the folder has the cases of all rules");
    let next = AtomicUsize::new(0);
    let wrong: Mutex<Vec<String>> = Mutex::default();
    let threads = thread::available_parallelism().map_or(1, NonZero::get);
    thread::scope(|scope| {
        for _ in 0..threads {
            scope.spawn(|| {
                while let Some(case) = cases.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let difference = play(case, &change).err().map(|difference| format!("{}: {difference}", case.name));
                    wrong.lock().unwrap().extend(difference);
                }
            });
        }
    });
    let wrong = wrong.into_inner().unwrap();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// What the referee may find, by the kind of its event and one of its fields: of a penalty, what it is for.
fn verdicts() -> Vec<(String, Option<String>)> {
    let TypeInfo::Enum(events) = MatchEvent::type_info() else { panic!("events are an enum") };
    let with_evidence = events
        .iter()
        .filter(|variant| variant.as_struct_variant().is_ok_and(|variant| variant.field_names().contains(&"evidence")));
    let mut kinds: Vec<String> = with_evidence.map(|variant| variant.name().to_snake_case()).collect();
    kinds.retain(|kind| kind != "penalty");
    let app = headless_app();
    let own = app.world().resource::<RuleRegistry>().names().map(str::to_owned);
    // Of what is not for something that the robot did there are no cases.
    let is_of_a_rule = |reason: &PenaltyReason| {
        !matches!(reason, PenaltyReason::ShootOut | PenaltyReason::Substitute | PenaltyReason::Manual)
    };
    let built_in = PenaltyReason::built_in().filter(is_of_a_rule).map(|reason| reason.name().to_owned());
    let penalties = built_in.chain(own).map(|reason| ("penalty".to_owned(), Some(reason)));
    kinds.into_iter().map(|kind| (kind, None)).chain(penalties).collect()
}

#[test]
fn every_verdict_has_a_case_just_inside_and_one_just_outside() {
    let cases = cases();
    let finds = |case: &Case, must: bool, kind: &str, reason: Option<&str>| {
        case.expected.iter().any(|(happens, pattern)| {
            let is_for = |reason| pattern.fields.iter().any(|(name, value)| name == "reason" && value == reason);
            *happens == must && pattern.kind == kind && reason.is_none_or(is_for)
        })
    };
    for (kind, reason) in verdicts() {
        let has_both = cases.iter().filter(|case| finds(case, true, &kind, reason.as_deref())).any(|inside| {
            let mut same_section = cases.iter().filter(|case| case.section == inside.section);
            same_section.any(|case| finds(case, false, &kind, None))
        });
        let what = reason.map_or(kind.clone(), |reason| format!("{kind} reason={reason}"));
        assert!(
            has_both,
            "a rule needs two cases in tests/rule_cases: one that expects `{what}`, and in the same section one that expects \
             no `{kind}`"
        );
    }
}

/// A case, as its file begins.
#[derive(Clone)]
struct Case {
    name: String,
    /// What it is about: the rule or the family of rules.
    section: String,
    /// Events that must happen, and those that must not.
    expected: Vec<(bool, Pattern)>,
}

/// An event's kind, and values of some of its fields.
#[derive(Clone)]
struct Pattern {
    text: String,
    kind: String,
    fields: Vec<(String, String)>,
}

impl Pattern {
    /// Names the other team, and the place on the other side of the pitch.
    fn change_colours(&mut self) {
        for (name, value) in &mut self.fields {
            *value = value.replace("blue", "BLUE").replace("pink", "blue").replace("BLUE", "pink");
            if let Ok(Value::Array(place)) = serde_json::from_str(value)
                && name == "position_m"
            {
                let turned: Vec<f64> = place.iter().filter_map(Value::as_f64).map(|number| -number).collect();
                *value = serde_json::to_string(&turned).unwrap();
            }
        }
    }

    fn matches(&self, event: &Value) -> bool {
        // Of two robots that collide, blue's is named first.
        let mut turned = event.clone();
        if self.kind == "collision" {
            (turned["robot"], turned["with"]) = (event["with"].clone(), event["robot"].clone());
        }
        let fits = |event: &Value| self.fields.iter().all(|(name, value)| is(&event[name], value));
        event["kind"] == self.kind.as_str() && (fits(event) || fits(&turned))
    }
}

/// Whether a value of an event is what the file says.
fn is(found: &Value, expected: &str) -> bool {
    match (found, serde_json::from_str::<Value>(expected)) {
        (Value::String(text), _) => text == expected,
        (found, Ok(expected)) => equal(found, &expected),
        (_, Err(_)) => false,
    }
}

fn equal(one: &Value, other: &Value) -> bool {
    match (one, other) {
        (Value::Array(one), Value::Array(other)) => {
            one.len() == other.len() && one.iter().zip(other).all(|(one, other)| equal(one, other))
        }
        _ => match (one.as_f64(), other.as_f64()) {
            (Some(one), Some(other)) => (one - other).abs() < TOLERANCE,
            _ => one == other,
        },
    }
}

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/rule_cases")
}

/// All cases, by name.
fn cases() -> Vec<Case> {
    let entries = std::fs::read_dir(folder()).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.filter(|path| path.extension().is_some_and(|extension| extension == "ron"));
    let mut cases: Vec<Case> = files.map(|path| case(&path)).collect();
    cases.sort_by(|one, other| one.name.cmp(&other.name));
    cases
}

fn case(path: &Path) -> Case {
    let text = std::fs::read_to_string(path).unwrap();
    let mut comments = text.lines().map_while(|line| line.strip_prefix("// "));
    let expectation = comments.find_map(|line| line.split_once(": expected "));
    let Some((section, expected)) = expectation else {
        panic!("{}: expected a comment `// SECTION: expected ...` at its beginning", path.display());
    };
    let expected = expected.split("`, ").map(pattern).collect();
    let name = path.file_stem().unwrap().to_string_lossy().into_owned();
    Case { name, section: section.to_owned(), expected }
}

/// An event as the file has it, and whether it must happen.
fn pattern(text: &str) -> (bool, Pattern) {
    let must_not = text.starts_with("no ");
    let text = text.trim_start_matches("no ").trim_matches('`').to_owned();
    let mut words = text.split_whitespace();
    let kind = words.next().unwrap().to_owned();
    let fields = words.map(|word| {
        let (name, value) = word.split_once('=').unwrap();
        (name.to_owned(), value.to_owned())
    });
    (!must_not, Pattern { kind, fields: fields.collect(), text })
}

/// Plays a case.
///
/// # Errors
/// What it did not lead to, or should not have.
fn play(case: &Case, change: impl Fn(&mut Case, &mut Scenario)) -> Result<(), String> {
    let mut scenario =
        Scenario::load(folder().join(format!("{}.ron", case.name))).map_err(|error| error.to_string())?;
    let mut case = case.clone();
    change(&mut case, &mut scenario);
    let mut app = headless_app();
    app.start_match(&scenario).map_err(|error| error.to_string())?;
    let last = scenario.last_cycle().ok_or("it has no end: expected `duration_s`")?;
    let mut events: Vec<(u64, Value)> = Vec::new();
    while app.cycle() < last && !app.is_finished() {
        app.run_cycles(1);
        let cycle = app.cycle();
        events.extend(app.events().iter().map(|event| (cycle, serde_json::to_value(event).unwrap())));
    }
    if let Some(broken) = events.iter().find(|(_, event)| event["kind"] == "invariant_broken") {
        return Err(format!("{broken:?}"));
    }
    for (must, pattern) in &case.expected {
        let found = events.iter().any(|(_, event)| pattern.matches(event));
        if found != *must {
            let what = if *must { "did not happen" } else { "happened" };
            let events: String = events.iter().map(|(cycle, event)| format!("{cycle}: {event}\n")).collect();
            return Err(format!("`{}` {what}\n{events}", pattern.text));
        }
    }
    Ok(())
}
