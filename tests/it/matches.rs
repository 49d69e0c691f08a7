//! Whole matches between the built-in teams.

use bevy::prelude::App;
use naoisis::belief::Belief;
use naoisis::game::{GameState, Penalty};
use naoisis::prelude::*;

use crate::support::{blue, headless_app, pink};

/// A match of two halves of `half_s` seconds, played to its end. Returns the goals in the order of scoring.
fn play(name: &str, seed: u64, half_s: f32) -> (naoisis::game::Score, Vec<MatchEvent>) {
    let mut scenario = Scenario::named(name).unwrap();
    scenario.seed = seed;
    scenario.rules.half_s = half_s;
    let mut app = headless_app();
    app.start_match(&scenario).unwrap();
    let mut events = Vec::new();
    // Twice the time of play, and a shoot-out for a draw.
    let ended = app.run_until((half_s * 2.0 * 30.0) as usize * 2 + 600 * 30, |app| {
        events.extend(app.events().iter().cloned());
        app.is_finished()
    });
    assert!(ended, "{name} with seed {seed} does not end");
    (app.game().score, events)
}

#[test]
fn a_match_ends_keeps_its_invariants_and_its_score_is_that_of_its_goals() {
    let mut goals = 0;
    for seed in 1..=3 {
        let (score, events) = play("match3v3", seed, 300.0);
        for event in &events {
            assert!(!matches!(event, MatchEvent::InvariantBroken { .. }), "{event:?}");
        }
        for team in Team::BOTH {
            let scored = events
                .iter()
                .filter(|event| matches!(event, MatchEvent::Goal { team: scorer, .. } if *scorer == team))
                .count();
            assert_eq!(score[team] as usize, scored);
        }
        goals += score.blue + score.pink;
        assert_eq!(events.iter().filter(|event| **event == MatchEvent::FinalWhistle).count(), 1);
    }
    assert!(goals > 0, "no goal in three matches of ten minutes");
}

#[test]
fn in_a_shoot_out_who_shoots_and_who_keeps_know_where_they_are_put() {
    let mut scenario = Scenario::named("match7v7").unwrap();
    let rules = &mut scenario.rules;
    (rules.half_s, rules.standby_s, rules.ready_s, rules.ready_delay_s) = (1.0, 0.5, 1.0, 0.0);
    let mut app = headless_app();
    app.start_match(&scenario).unwrap();
    for shot in 1..=3 {
        let is_prepared = |app: &App| app.game().shoot_out.is_some() && app.game().state == GameState::Set;
        assert!(app.run_until(9_000, is_prepared), "no shot {shot}");
        app.run_cycles(10);
        let everybody = Team::BOTH.into_iter().flat_map(|team| (1..=7).map(move |number| RobotId::new(team, number)));
        let active: Vec<RobotId> =
            everybody.filter(|id| !app.robot::<Penalty>(*id).is_some_and(Penalty::is_active)).collect();
        assert_eq!(active.len(), 2, "{active:?}");
        for id in active {
            let believed = app.robot::<Belief>(id).unwrap().pose;
            // They shoot at, and keep, the goal at negative x, which is the keeper's own.
            let is_keeper = app.game().shoot_out.unwrap().team != id.team;
            let believed = if is_keeper { believed } else { believed.turned_half() };
            let error_m = believed.position.distance(app.robot_pose(id).unwrap().position);
            assert!(error_m < 0.3, "{id} errs by {error_m} m at shot {shot}");
        }
        assert!(app.run_until(9_000, |app| app.game().state == GameState::Playing));
    }
}

#[test]
fn sides_are_changed_at_half_time() {
    let mut scenario = Scenario::named("match3v3").unwrap();
    scenario.rules.half_s = 5.0;
    let mut app = headless_app();
    app.start_match(&scenario).unwrap();
    app.run_cycles(10);
    assert!(app.robot_pose(pink(1)).unwrap().position.x > 0.0);
    assert!(app.run_until(600, |app| app.game().half == 2));
    app.run_cycles(2);
    assert!(app.robot_pose(pink(1)).unwrap().position.x < 0.0);
}

#[test]
fn seven_against_seven_play_on_the_large_pitch() {
    let (_, events) = play("match7v7", 1, 40.0);
    for event in &events {
        assert!(!matches!(event, MatchEvent::InvariantBroken { .. }), "{event:?}");
    }
    assert!(events.iter().any(|event| matches!(event, MatchEvent::Kick { .. } | MatchEvent::Collision { .. })));
}

#[test]
fn a_team_that_hears_nobody_still_plays_and_scores() {
    let mut goals = 0;
    for seed in 1..=2 {
        let mut scenario = Scenario::named("match3v3").unwrap();
        scenario.seed = seed;
        scenario.rules.half_s = 300.0;
        scenario.messages.loss = 1.0;
        let mut app = headless_app();
        app.start_match(&scenario).unwrap();
        let ended = app.run_until(30_000, |app| {
            for id in [blue(2), pink(3)] {
                assert!(app.robot::<Inbox>(id).unwrap().0.is_empty());
            }
            app.is_finished()
        });
        assert!(ended);
        goals += app.game().score.blue + app.game().score.pink;
    }
    assert!(goals > 0, "no goal in two matches of ten minutes");
}
