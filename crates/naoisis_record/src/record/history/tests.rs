//! Histories: their records, parts, and long matches.

use super::super::match_marks::MarkKind;
use super::*;
use crate::record::RecordPlugin;
use naoisis_core::events::MatchEvent;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::team::Team;
use naoisis_sensing::appearance::stride::Stride;
use naoisis_sim::interface::gather::{CurrentRecord, gather_start};
use naoisis_sim::scenario::Scenario;
use naoisis_sim::simulation::{MatchApp, NaoisisPlugins};

#[test]
fn every_record_comes_back_as_it_was() {
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, RecordPlugin));
    app.start_match(&Scenario::named("match3v3").unwrap()).unwrap();
    gather_start(app.world_mut());
    let (mut history, mut records) = (History::default(), Vec::new());
    for _ in 0..=200 {
        let record = app.world().resource::<CurrentRecord>().record.clone();
        history.push(&record).unwrap();
        records.push(record);
        app.run_cycles(1);
    }
    assert_eq!(history.cycles(), Some(0..=200));
    // Forwards and backwards, so that blocks are unpacked again.
    for cycle in (0..=200_u64).chain((0..=200).rev().step_by(7)) {
        assert_eq!(history.record(cycle).unwrap().as_ref(), Some(&records[cycle as usize]), "cycle {cycle}");
    }
    assert_eq!(history.record(201).unwrap(), None);
}

#[test]
fn a_history_of_parts_is_that_of_the_whole() {
    let mut whole = History::default();
    let mut parts = [0..=99_u64, 100..=100, 101..=300].map(|cycles| {
        let mut part = History::default();
        cycles.for_each(|cycle| part.push(&empty_record(cycle)).unwrap());
        part
    });
    (0..=300).for_each(|cycle| whole.push(&empty_record(cycle)).unwrap());
    let [joined, later @ ..] = &mut parts;
    later.iter().for_each(|part| joined.append(part.clone()).unwrap());
    joined.append(History::default()).unwrap();
    assert_eq!(joined.cycles(), Some(0..=300));
    assert_eq!(joined.last_cycle(), Some(300));
    for cycle in (0..=301).rev() {
        assert_eq!(joined.record(cycle).unwrap(), whole.record(cycle).unwrap(), "cycle {cycle}");
        assert_eq!(joined.around(cycle), whole.around(cycle), "cycle {cycle}");
    }
    // The joined history continues at its end.
    joined.push(&empty_record(301)).unwrap();
    assert_eq!(joined.cycles(), Some(0..=301));
    // Other records replace it.
    let mut other = History::default();
    other.push(&empty_record(5)).unwrap();
    joined.append(other).unwrap();
    assert_eq!(joined.cycles(), Some(5..=5));
}

#[test]
fn legs_swing_in_playback_as_they_did() {
    for (kick, wind_up_s, ball_y_m) in [
        ("left_straight", 0.0, 0.05),
        ("left_straight", 0.7, 0.05),
        ("left_side", 0.7, -0.05),
        ("left_side", 0.7, 0.05),
    ] {
        let mut app = App::new();
        app.add_plugins((NaoisisPlugins, RecordPlugin));
        let scenario = format!(
            r#"{{ "rules": "free", "ball": {{ "position_m": [0.15, {ball_y_m}] }}, "kicks": {{ "wind_up_s": {wind_up_s} }},
                 "robots": [{{ "number": 1, "behaviour": {{ "script": [{{ "from_s": 0.5, "kick": {{ "type": "{kick}" }} }}] }} }}] }}"#
        );
        app.start_match(&Scenario::from_json(&scenario).unwrap()).unwrap();
        gather_start(app.world_mut());
        let id = RobotId::new(Team::Blue, 1);
        let entity = app.world().resource::<Roster>().get(id).unwrap();
        app.world_mut().entity_mut(entity).insert(Stride::default());
        let (mut history, mut live) = (History::default(), Vec::new());
        for _ in 0..60 {
            app.run_cycles(1);
            history.push(&app.world().resource::<CurrentRecord>().record).unwrap();
            live.push(*app.robot::<Stride>(id).unwrap());
        }
        let legs = |stride: Stride| stride.joints(id, HeadAngles::default(), &Body::default()).legs[0];
        for (cycle, live) in (1..).zip(live) {
            let kick = history.swing(id, cycle, 1.0 / 30.0, app.robot::<KickSettings>(id).unwrap());
            let [was, again] = [live, Stride { kick, ..live }].map(legs);
            assert!(
                (was.hip - again.hip).abs() < 1e-3 && (was.aside - again.aside).abs() < 1e-3,
                "{scenario}: {cycle}"
            );
        }
    }
}

fn empty_record(cycle: u64) -> CycleRecord {
    CycleRecord { cycle, ..default() }
}

#[test]
fn a_jump_of_the_clock_begins_a_new_history() {
    let mut history = History::default();
    let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
    for cycle in 5..=80 {
        let events = if cycle == 7 { vec![goal.clone()] } else { Vec::new() };
        history.push(&CycleRecord { events, ..empty_record(cycle) }).unwrap();
    }
    assert_eq!(history.cycles(), Some(5..=80));
    assert_eq!(history.marks(), [Mark { cycle: 7, kind: MarkKind::Goal, team: Some(Team::Pink) }]);
    history.push(&empty_record(0)).unwrap();
    assert_eq!((history.cycles(), history.marks()), (Some(0..=0), &[][..]));
}

#[test]
fn a_long_match_loses_neither_its_beginning_nor_its_goals() {
    let mut history = History { most_bytes: 20_000, ..History::default() };
    let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
    const LAST: u64 = 20_000;
    for cycle in 0..=LAST {
        let events = if cycle % 1000 == 77 { vec![goal.clone()] } else { Vec::new() };
        history.push(&CycleRecord { events, time_s: cycle as f64 / 30.0, ..empty_record(cycle) }).unwrap();
    }
    assert!(history.packed_bytes <= history.most_bytes, "{}", history.packed_bytes);
    assert_eq!((history.cycles(), history.marks().len()), (Some(0..=LAST), 20));
    let (mut cycle, mut gaps, mut goals) = (0, Vec::new(), 0);
    while let Some(record) = history.record(cycle).unwrap() {
        goals += record.events.len();
        gaps.push(record.cycle + 1 - cycle);
        cycle = record.cycle + 1;
    }
    assert_eq!(goals, 20);
    let widest = gaps.iter().max().copied().unwrap();
    assert!(widest > 1 && widest <= history.every(), "{widest} {}", history.every());
    // The latest part is complete, and the history can be cut and continued.
    assert!(gaps[gaps.len() - 100..].iter().all(|gap| *gap == 1));
    let mut until = history.until(5000).unwrap();
    // The record of the last cycle itself may have been removed.
    until.push(&empty_record(5001)).unwrap();
    assert_eq!(until.cycles(), Some(0..=5001));
}

#[test]
fn what_was_until_a_cycle_goes_on_in_another_way() {
    let mut history = History::default();
    for cycle in 0..=200 {
        let goal = MatchEvent::Goal { team: Team::Pink, scorer: None, own_goal: false, evidence: default() };
        let events = if cycle % 100 == 50 { vec![goal] } else { Vec::new() };
        history.push(&CycleRecord { events, ..empty_record(cycle) }).unwrap();
    }
    for last in [0, 63, 64, 100, 199, 200, 500] {
        let mut until = history.until(last).unwrap();
        let last = last.min(200);
        assert_eq!(until.cycles(), Some(0..=last));
        assert_eq!(until.marks().len(), history.marks().iter().filter(|mark| mark.cycle <= last).count());
        until.push(&CycleRecord { time_s: 7.0, ..empty_record(last + 1) }).unwrap();
        assert_eq!(until.cycles(), Some(0..=last + 1));
        for cycle in 0..=last {
            assert_eq!(until.record(cycle).unwrap(), history.record(cycle).unwrap());
        }
    }
}

#[test]
fn where_only_every_so_many_cycles_have_a_record_the_next_one_is_found() {
    let mut history = History::of_every(10);
    for cycle in (0..=2000).step_by(10).chain([2003]) {
        history.push(&empty_record(cycle)).unwrap();
    }
    assert_eq!(history.cycles(), Some(0..=2003));
    for (asked, found) in [(0, 0), (1, 10), (640, 640), (641, 650), (1999, 2000), (2001, 2003)] {
        assert_eq!(history.record(asked).unwrap().map(|record| record.cycle), Some(found));
    }
    assert_eq!(history.record(2004).unwrap(), None);
}
