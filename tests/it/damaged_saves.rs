//! Saved matches whose files were changed by hand, or damaged: each is refused in words, or plays on.
//!
//! The file of a real match is taken apart, and everything in it is changed in turn: numbers, lists, entities. By default some
//! of the places in the file get one other value each; `NAOISIS_ALL_DAMAGES=1` tries all values at all places.

use bevy::prelude::App;
use core::fmt;
use naoisis::cycle::try_run_cycle;
use naoisis::prelude::*;
use naoisis::simulation::Snapshot;
use serde::de::{MapAccess, SeqAccess, Visitor};
use serde::ser::{SerializeMap, SerializeSeq};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::collections::BTreeSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::support::{headless_app, match_of};

/// Without being asked for more, one of so many places is changed.
const ONE_OF: usize = 5;
/// Cycles that a damaged match is played for.
const CYCLES: usize = 30;

/// MessagePack as it is, whatever it means.
#[derive(Clone, PartialEq, Debug)]
enum Value {
    Nothing,
    Bool(bool),
    Count(u64),
    Integer(i64),
    Single(f32),
    Double(f64),
    Text(String),
    List(Vec<Value>),
    Map(Vec<(String, Value)>),
}

impl Serialize for Value {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Value::Nothing => serializer.serialize_none(),
            Value::Bool(value) => serializer.serialize_bool(*value),
            Value::Count(count) => serializer.serialize_u64(*count),
            Value::Integer(integer) => serializer.serialize_i64(*integer),
            Value::Single(number) => serializer.serialize_f32(*number),
            Value::Double(number) => serializer.serialize_f64(*number),
            Value::Text(text) => serializer.serialize_str(text),
            Value::List(values) => {
                let mut list = serializer.serialize_seq(Some(values.len()))?;
                values.iter().try_for_each(|value| list.serialize_element(value))?;
                list.end()
            }
            Value::Map(entries) => {
                let mut map = serializer.serialize_map(Some(entries.len()))?;
                entries.iter().try_for_each(|(key, value)| map.serialize_entry(key, value))?;
                map.end()
            }
        }
    }
}

impl<'de> Deserialize<'de> for Value {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct AnyValue;

        impl<'de> Visitor<'de> for AnyValue {
            type Value = Value;

            fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
                formatter.write_str("anything")
            }

            fn visit_unit<E>(self) -> Result<Value, E> {
                Ok(Value::Nothing)
            }

            fn visit_bool<E>(self, value: bool) -> Result<Value, E> {
                Ok(Value::Bool(value))
            }

            fn visit_u64<E>(self, count: u64) -> Result<Value, E> {
                Ok(Value::Count(count))
            }

            fn visit_i64<E>(self, integer: i64) -> Result<Value, E> {
                Ok(Value::Integer(integer))
            }

            fn visit_f32<E>(self, number: f32) -> Result<Value, E> {
                Ok(Value::Single(number))
            }

            fn visit_f64<E>(self, number: f64) -> Result<Value, E> {
                Ok(Value::Double(number))
            }

            fn visit_str<E>(self, text: &str) -> Result<Value, E> {
                Ok(Value::Text(text.to_owned()))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Value, A::Error> {
                let mut values = Vec::new();
                while let Some(value) = list.next_element()? {
                    values.push(value);
                }
                Ok(Value::List(values))
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Value, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Value::Map(entries))
            }
        }

        deserializer.deserialize_any(AnyValue)
    }
}

/// The way to a value: indices of lists and of maps' entries.
type Steps = Vec<usize>;

impl Value {
    fn at(&mut self, steps: &[usize]) -> &mut Value {
        steps.iter().fold(self, |value, step| match value {
            Value::List(values) => &mut values[*step],
            Value::Map(entries) => &mut entries[*step].1,
            other => other,
        })
    }

    /// Calls `visit` with every value, the way to it, and that in words without the indices of lists.
    fn visit(&self, steps: &mut Steps, words: &str, visit: &mut impl FnMut(&Value, &Steps, &str)) {
        visit(self, steps, words);
        let mut inside = |index: usize, value: &Value, words: &str, visit: &mut _| {
            steps.push(index);
            value.visit(steps, words, visit);
            steps.pop();
        };
        match self {
            Value::List(values) => {
                for (index, value) in values.iter().enumerate() {
                    // A few numbers in a list mean something each, as in a matrix; many are alike.
                    let place = if values.len() <= 4 { format!("{words}[{index}]") } else { format!("{words}[]") };
                    inside(index, value, &place, visit);
                }
            }
            Value::Map(entries) => {
                for (index, (key, value)) in entries.iter().enumerate() {
                    inside(index, value, &format!("{words}.{key}"), visit);
                }
            }
            _ => {}
        }
    }

    /// What it could be instead.
    fn others(&self) -> Vec<Value> {
        match self {
            Value::Single(_) => [f32::NAN, f32::INFINITY, -1e30, 0.0, f32::MAX, 1e6, -1.0].map(Value::Single).to_vec(),
            Value::Double(_) => [f64::NAN, f64::INFINITY, -1e30, 0.0, f64::MAX, 1e6].map(Value::Double).to_vec(),
            Value::Count(_) | Value::Integer(_) => {
                let counts = [0, 255, u64::from(u32::MAX), u64::MAX].map(Value::Count);
                [counts.to_vec(), vec![Value::Integer(-1), Value::Single(f32::NAN)]].concat()
            }
            Value::List(values) => {
                vec![Value::List(Vec::new()), Value::List([values.clone(), values.clone()].concat())]
            }
            Value::Map(entries) if entries.is_empty() => Vec::new(),
            Value::Map(entries) => {
                vec![Value::Map(entries[1..].to_vec()), Value::Map([entries.clone(), entries.clone()].concat())]
            }
            Value::Text(_) => vec![Value::Text(String::new())],
            Value::Bool(value) => vec![Value::Bool(!value)],
            Value::Nothing => Vec::new(),
        }
    }
}

/// A match in which there is something of everything: a Kalman and a particle filter, a script that talks, one that is
/// penalised, one that has fallen, a post.
fn lively_match() -> App {
    let mut app = match_of(
        r#"{ "rules": { "preset": "extended", "half_s": 300 }, "seed": 5, "ball": { "position_m": [-0.6, 0.1], "velocity_mps": [0.2, 0.0] },
             "messages": { "delay_cycles": 5 }, "posts": [{ "position_m": [1.0, 1.5] }],
             "interventions": [{ "at_s": 0.5, "do": { "penalise": { "robot": "pink3", "reason": "manual" } } },
                               { "at_s": 9.0, "do": "whistle" }],
             "robots": [
               { "number": 1, "pose": [-2.8, 0, 0], "behaviour": "passing_keeper" },
               { "number": 2, "pose": [-1.0, 0.1, 0], "behaviour": "striker" },
               { "team": "pink", "number": 2, "pose": [0.5, 0.2, 180], "behaviour": "passer", "localisation": "particles" },
               { "team": "pink", "number": 1, "pose": [2.8, 0, 180], "behaviour": { "script": [
                 { "from_s": 0.2, "posture": { "dive": "left" } }, { "until_s": 9, "say": { "ball_m": [1, 0] } } ] } },
               { "team": "pink", "number": 3, "pose": [2, 1, 180], "behaviour": { "script": [
                 { "until_s": 9, "walk": [0.01, 0, 3], "head_deg": [20, 5], "kick": { "type": "left_side" } }] } }] }"#,
    );
    app.run_cycles(45);
    app
}

/// Puts a damaged match into the app and plays it. What it was refused for, if it was.
fn play(app: &mut App, damaged: &Value) -> Result<Option<String>, String> {
    let bytes = rmp_serde::to_vec(damaged).unwrap();
    let snapshot = match Snapshot::from_bytes(&bytes, app.world()) {
        Ok(snapshot) => snapshot,
        Err(error) => return Ok(Some(error.to_string())),
    };
    if let Err(error) = snapshot.restore(app.world_mut()) {
        return Ok(Some(error.to_string()));
    }
    for cycle in 1..=CYCLES {
        try_run_cycle(app.world_mut()).map_err(|panic| format!("in cycle {cycle}: {panic}"))?;
        if let Some(broken) = app.events().iter().find(|event| matches!(event, MatchEvent::InvariantBroken { .. })) {
            return Err(format!("in cycle {cycle}: {broken:?}"));
        }
    }
    Ok(None)
}

#[test]
fn whatever_is_changed_in_a_saved_match_is_refused_or_plays_on() {
    let try_all = std::env::var_os("NAOISIS_ALL_DAMAGES").is_some();
    let mut app = lively_match();
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    let saved: Value = rmp_serde::from_slice(&saved).unwrap();
    assert_eq!(play(&mut app, &saved), Ok(None), "unchanged, it plays on");

    let (mut places, mut known) = (Vec::new(), BTreeSet::new());
    saved.visit(&mut Vec::new(), "", &mut |value, steps, words| {
        if known.insert(words.to_owned()) {
            places.push((value.clone(), steps.clone(), words.to_owned()));
        }
    });
    let damages: Vec<(&Steps, Value, String)> = places
        .iter()
        .enumerate()
        .filter(|(index, _)| try_all || index % ONE_OF == 0)
        .flat_map(|(index, (value, steps, words))| {
            let others = value.others();
            let chosen = (index / ONE_OF) % others.len().max(1);
            let is_chosen = move |other: usize| try_all || other == chosen;
            let others = others.into_iter().enumerate().filter(move |(other, _)| is_chosen(*other));
            others.map(move |(_, other)| (steps, other, words.clone()))
        })
        .collect();
    let (next, results) = (AtomicUsize::new(0), Mutex::new((Vec::new(), 0, 0)));
    std::thread::scope(|scope| {
        for _ in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            scope.spawn(|| {
                let mut app = headless_app();
                while let Some((steps, other, words)) = damages.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let mut damaged = saved.clone();
                    *damaged.at(steps) = other.clone();
                    let outcome = play(&mut app, &damaged);
                    let (failures, played, refused) = &mut *results.lock().unwrap();
                    match outcome {
                        Ok(None) => *played += 1,
                        Ok(Some(message)) => {
                            assert!(!message.is_empty());
                            *refused += 1;
                        }
                        Err(failure) => {
                            failures.push(format!("{words} = {other:?}: {failure}"));
                            app = headless_app();
                        }
                    }
                }
            });
        }
    });
    let (failures, played, refused) = results.into_inner().unwrap();
    assert!(failures.is_empty(), "{} of {}:\n{}", failures.len(), damages.len(), failures.join("\n"));
    assert!(played > 50 && refused > 50, "{played} played on, {refused} were refused");
}

#[test]
fn what_no_match_can_be_without_or_have_twice_is_named() {
    let mut app = lively_match();
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    let saved: Value = rmp_serde::from_slice(&saved).unwrap();
    let Value::Map(parts) = &saved else { panic!("{saved:?}") };
    let part = |name: &str| parts.iter().position(|(key, _)| key == name).unwrap();
    let refusal = |change: &dyn Fn(&mut Vec<(String, Value)>, &mut Vec<Value>)| {
        let mut damaged = saved.clone();
        let Value::Map(mut resources) = damaged.at(&[part("resources")]).clone() else { panic!() };
        let Value::List(mut entities) = damaged.at(&[part("entities")]).clone() else { panic!() };
        change(&mut resources, &mut entities);
        *damaged.at(&[part("resources")]) = Value::Map(resources);
        *damaged.at(&[part("entities")]) = Value::List(entities);
        let mut app = headless_app();
        play(&mut app, &damaged).unwrap()
    };
    let without = |name: &'static str| {
        move |resources: &mut Vec<(String, Value)>, _: &mut Vec<Value>| {
            let before = resources.len();
            resources.retain(|(path, _)| !path.ends_with(&format!("::{name}")));
            assert_eq!(resources.len(), before - 1, "{name}");
        }
    };
    assert_eq!(refusal(&|_, _| {}), None);
    for name in ["Scenario", "CycleClock", "Game", "Rules", "Pitch"] {
        let message = refusal(&without(name)).unwrap();
        assert!(message.contains(&format!("the match: it has no `{name}`")), "{message}");
    }
    // Robots, ball and posts: each twice is refused, but for posts, which may stand in one place.
    let Value::List(entities) = saved.clone().at(&[part("entities")]).clone() else { panic!() };
    let mut messages: BTreeSet<String> = BTreeSet::new();
    for index in 0..entities.len() {
        messages.extend(refusal(&move |_, entities| entities.push(entities[index].clone())));
    }
    for who in ["blue1", "blue2", "pink1", "pink2", "pink3", "the ball"] {
        assert!(
            messages.iter().any(|message| message.starts_with(&format!("{who}: it is there twice"))),
            "{messages:?}"
        );
    }
    // Without a robot or the ball it is not its scenario's match; a post may be missing.
    let mut messages: BTreeSet<String> = BTreeSet::new();
    for index in 0..entities.len() {
        messages.extend(refusal(&move |_, entities| drop(entities.remove(index))));
    }
    let missing = ["blue1", "blue2", "pink1", "pink2", "pink3", "ball"];
    let expected = missing.map(|who| format!("the match: it has no {who}, and its scenario has one; expected"));
    assert_eq!(messages.len(), expected.len(), "{messages:?}");
    for expected in expected {
        assert!(messages.iter().any(|message| message.starts_with(&expected)), "{expected}: {messages:?}");
    }
    assert!(refusal(&|_, entities| entities.clear()).unwrap().contains("it has no blue1"));
    let many_in_scenario = refusal(&|resources, _| {
        let (_, scenario) = resources.iter_mut().find(|(name, _)| name.ends_with("::Scenario")).unwrap();
        let Value::Map(fields) = scenario else { panic!() };
        let (_, Value::List(posts)) = fields.iter_mut().find(|(name, _)| name == "posts").unwrap() else { panic!() };
        posts.extend(core::iter::repeat_n(posts[0].clone(), 1000));
    });
    assert!(many_in_scenario.unwrap().contains("`posts` is a list of 1001; expected at most 1000"));
    let nothing = refusal(&|_, entities| entities.push(Value::Map(Vec::new()))).unwrap();
    assert!(nothing.contains("an entity of nothing"), "{nothing}");
}

/// Each place where a list could begin says that it has billions of elements: room is made for none of them.
#[test]
fn a_list_that_promises_more_than_there_is_takes_no_memory() {
    let mut app = lively_match();
    let saved = Snapshot::take(app.world_mut()).unwrap().to_bytes(app.world()).unwrap();
    let lists = (0..saved.len()).filter(|&at| (0x90..=0x9f).contains(&saved[at]));
    let mut refused = 0;
    for at in lists.step_by(7) {
        let damaged = [&saved[..at], &[0xdd, 0xff, 0xff, 0xff, 0xff], &saved[at + 1..]].concat();
        refused += usize::from(Snapshot::from_bytes(&damaged, app.world()).is_err());
    }
    assert!(refused > 50, "{refused}");
}
