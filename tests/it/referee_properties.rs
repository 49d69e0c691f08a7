//! What must hold in every match, whatever happens in it: two hundred seeded matches of every rules preset.
//!
//! The matches are short, a few seconds a half, and full of trouble: fast robots on a small part of the pitch, falls,
//! lost messages, kicks that go astray. Ten whole matches of every league are for a release build.

use bevy::math::{Vec2, ops};
use naoisis::prelude::*;
use naoisis::scenario::{LEAGUES, RULES_PRESETS, rules_preset};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::support::headless_app;
use naoisis::game::{Intervention, Penalty, Rules, SetPlayKind, TimedIntervention};

/// Matches of each preset.
const MATCHES: u64 = 200;
/// Cycles a second: few, so that much happens in few of them.
const CYCLES_PER_S: f32 = 10.0;
/// Half of the time, s.
const HALF_S: f32 = 5.0;
/// Whole matches of each league.
const WHOLE_MATCHES: u64 = 10;

/// A short and wild match by these rules.
fn scenario(preset: &str, seed: u64) -> Scenario {
    let mut scenario = Scenario::from_json(r#"{ "teams": { "blue": "roles", "pink": "chasers" } }"#).unwrap();
    scenario.seed = seed;
    scenario.cycle_s = 1.0 / f64::from(CYCLES_PER_S);
    scenario.rules = Rules {
        half_s: HALF_S,
        team_size: 3 + (seed % 2) as u8,
        ready_s: 3.0,
        set_s: 0.5,
        penalty_s: 2.0,
        free_kick_s: 2.0,
        free_kick_leave_s: 0.5,
        stall_s: 2.0,
        game_stuck_s: 2.0,
        inactive_s: 2.0,
        falls: preset != "free",
        fall_from_mps: 0.05,
        fall_certain_mps: 0.8,
        get_up_s: 1.0,
        shoot_out_shots: 1,
        shoot_out_s: 1.0,
        ..rules_preset(preset).unwrap()
    };
    scenario.rules.standby_s = scenario.rules.standby_s.min(0.5);
    scenario.duration_s = (!scenario.rules.clock).then_some(2.0 * HALF_S);
    scenario.messages.loss = 0.3;
    scenario.settings.motion.max_linear_mps = 0.6;
    scenario.settings.motion.error_sd.dtheta = 0.02;
    scenario.settings.kicks.direction_sd = 0.3;
    scenario.settings.kicks.recovery_s = 0.3;
    // In every match the ball is thrown somewhere else, at the start and twice more: sometimes into a goal.
    for throw in 0..2_u64 {
        let turn = (seed * 3 + throw) as f32 * 2.399_963;
        let goal = if (seed + throw).is_multiple_of(2) { 1.0 } else { -1.0 };
        let intervention = Intervention::PlaceBall {
            position_m: Vec2::new(goal * 2.3, (seed % 5) as f32 * 0.6 - 1.2),
            velocity_mps: Vec2::new(goal * 2.0, 0.3 * ops::sin(turn)),
        };
        scenario.interventions.push(TimedIntervention { at_s: 4.0 + 5.0 * throw as f64, intervention });
    }
    if let Some(ball) = &mut scenario.ball {
        let turn = seed as f32 * 2.399_963;
        ball.velocity_mps = (Vec2::new(ops::cos(turn), ops::sin(turn)) * (0.5 + (seed % 7) as f32 * 0.3)).extend(0.0);
    }
    scenario
}

/// Plays a match and checks it. What happened in it, by kind.
fn check(name: &str, scenario: &Scenario) -> BTreeMap<String, u64> {
    let (rules, seed) = (scenario.rules.clone(), scenario.seed);
    let (cycles_per_s, half_s) = ((1.0 / scenario.cycle_s) as f32, rules.half_s);
    let mut app = headless_app();
    app.start_match(scenario).unwrap();
    let mut kinds: BTreeMap<String, u64> = BTreeMap::new();
    let mut goals = [0_u32; 2];
    let mut played: u64 = 0;
    let mut stopped: u64 = 0;
    let limit = (cycles_per_s * (600.0 + 3.0 * rules.longest_s())) as u64;
    let mut removed: Vec<RobotId> = Vec::new();
    while !app.is_finished() && scenario.last_cycle().is_none_or(|last| app.cycle() < last) {
        let before = app.game().clone();
        app.run_cycles(1);
        let at = format!("{name}, seed {seed}, cycle {}", app.cycle());
        assert!(app.cycle() < limit, "{at}: the match hangs in {:?}", app.game());
        for event in app.events() {
            *kinds.entry(kind_of(event)).or_default() += 1;
            match event {
                MatchEvent::InvariantBroken { message } => panic!("{at}: {message}"),
                MatchEvent::CommandRefused { robot, command, reason } => {
                    // A dive or a kick may come too late; nothing else is refused to honest players.
                    assert!(
                        matches!(command, naoisis::events::CommandKind::Posture),
                        "{at}: {robot} {command:?} {reason:?}"
                    );
                }
                MatchEvent::Goal { team, .. } => goals[*team as usize] += 1,
                MatchEvent::Penalty { robot, .. } => removed.push(*robot),
                MatchEvent::PenaltyOver { robot, .. } => removed.retain(|other| other != robot),
                MatchEvent::Kick { robot, result, .. } => {
                    let acts = *result != naoisis::events::KickResult::Missed;
                    // A robot that was penalised before this cycle does not act in it.
                    assert!(!acts || !was_away(&app, *robot), "{at}: {robot} kicks while it is away");
                }
                _ => {}
            }
        }
        // The score is that of the goals.
        let score = app.game().score;
        assert_eq!([score.blue, score.pink], goals, "{at}");
        // Penalised robots are off the pitch, stand still, and are not more than those that were sent off.
        for team in Team::BOTH {
            let mut present = 0;
            for number in 1..=rules.team_size {
                let id = RobotId::new(team, number);
                let away = app.robot::<Penalty>(id).unwrap().is_active();
                present += u8::from(!away);
                if away && app.game().shoot_out.is_none() {
                    assert!(removed.contains(&id), "{at}: {id} is away and was never penalised");
                    let velocity = app.robot::<naoisis::robot::Velocity>(id).unwrap();
                    assert_eq!(velocity.linear, Vec2::ZERO, "{at}: {id} walks while it is away");
                }
            }
            assert!(present <= rules.team_size, "{at}");
            if app.game().shoot_out.is_some() && !app.is_finished() {
                assert!(present <= 1, "{at}: {present} of {team} in a shoot-out");
            }
        }
        // The clock runs in play, and by some rules in stoppages; play comes back after every stoppage.
        if let (Some(then), Some(now)) = (before.cycles_left, app.game().cycles_left)
            && before.half == app.game().half
            && before.shoot_out.is_none()
        {
            let runs = matches!(before.state, GameState::Initial | GameState::Playing)
                && !matches!(app.game().state, GameState::Initial | GameState::Standby | GameState::Ready)
                || before.state == GameState::Playing
                || rules.clock_runs_in_stoppages && then < (half_s * cycles_per_s).round() as u64;
            // The clock stands in a stop. A half goes on after its time while a shot rolls.
            let runs = runs && before.stop.is_none() && before.state != GameState::Finished && then > 0;
            assert_eq!(then - now, u64::from(runs), "{at}: {before:?}");
            played += then - now;
        }
        if before.half != app.game().half {
            // The half ended in a stoppage; the next one begins with its own.
            stopped = 0;
        }
        if matches!(app.game().state, GameState::Ready | GameState::Set) {
            stopped += 1;
            let longest = cycles_per_s * (rules.ready_s + rules.set_s) + 2.0;
            assert!(stopped as f32 <= longest, "{at}: no play for {stopped} cycles: {:?}", app.game());
        } else {
            stopped = 0;
        }
        if let Some(set_play) = app.game().set_play
            && set_play.kind != SetPlayKind::KickOff
        {
            let longest_s = match set_play.kind {
                SetPlayKind::PenaltyKick => rules.penalty_kick_ready_s + rules.set_s + rules.penalty_kick_s,
                _ => rules.free_kick_s,
            };
            assert!(set_play.cycles as f32 <= cycles_per_s * longest_s + 2.0, "{at}: {set_play:?} without end");
        }
    }
    if rules.clock && rules.mercy_goals.is_none_or(|most| goals[0].abs_diff(goals[1]) < most) {
        let whole = rules.halves as f32 * half_s * cycles_per_s;
        // The last cycle of a half is that in which its clock reaches zero, and the next half's is set.
        assert!((played as f32 - whole).abs() <= 2.0, "{name}, seed {seed}: {played} of {whole} cycles");
    }
    kinds
}

/// Whether a robot was away when the cycle began: it is now, and its penalty is not of this cycle.
fn was_away(app: &bevy::prelude::App, robot: RobotId) -> bool {
    let of_this_cycle =
        app.events().iter().any(|event| matches!(event, MatchEvent::Penalty { robot: sent, .. } if *sent == robot));
    app.robot::<Penalty>(robot).unwrap().is_active() && !of_this_cycle && app.game().shoot_out.is_none()
}

fn kind_of(event: &MatchEvent) -> String {
    serde_json::to_value(event).unwrap()["kind"].as_str().unwrap().to_owned()
}

/// All matches of a preset, on all cores. What happened in them.
fn check_all(preset: &str) -> BTreeMap<String, u64> {
    check_seeds(preset, MATCHES, |seed| scenario(preset, seed))
}

/// Matches of seeds from 1 on, on all cores. What happened in them.
fn check_seeds(name: &str, matches: u64, scenario: impl Fn(u64) -> Scenario + Sync) -> BTreeMap<String, u64> {
    let next = AtomicU64::new(1);
    let mut all: BTreeMap<String, u64> = BTreeMap::new();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..2)
            .map(|_| {
                scope.spawn(|| {
                    let mut kinds: BTreeMap<String, u64> = BTreeMap::new();
                    loop {
                        let seed = next.fetch_add(1, Ordering::Relaxed);
                        if seed > matches {
                            break kinds;
                        }
                        for (kind, count) in check(name, &scenario(seed)) {
                            *kinds.entry(kind).or_default() += count;
                        }
                    }
                })
            })
            .collect();
        for thread in threads {
            for (kind, count) in thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)) {
                *all.entry(kind).or_default() += count;
            }
        }
    });
    all
}

/// That these things happened in the matches at all: nothing was proved by their absence.
fn assert_happened(kinds: &BTreeMap<String, u64>, expected: &[&str]) {
    for kind in expected {
        assert!(kinds.get(*kind).is_some_and(|count| *count > 0), "never a {kind}: {kinds:?}");
    }
}

#[test]
fn matches_by_the_papers_rules() {
    let kinds = check_all("naoisis");
    assert_happened(&kinds, &["goal", "ball_out", "kick_off", "penalty", "penalty_over", "fall", "got_up"]);
}

#[test]
fn matches_by_the_extended_rules() {
    let kinds = check_all("extended");
    assert_happened(&kinds, &["goal", "ball_out", "penalty", "fall", "got_up", "shoot_out_begins", "shoot_out_won"]);
}

#[test]
fn matches_by_the_rule_book_of_2010() {
    let kinds = check_all("spl2010");
    assert_happened(&kinds, &["goal", "ball_out", "throw_in", "penalty", "penalty_over", "placed_by_hand", "fall"]);
}

#[test]
fn matches_by_the_rule_book_of_2025() {
    let kinds = check_all("spl2025");
    let expected = ["goal_disallowed", "ball_out", "free_kick", "free_kick_over", "penalty", "penalty_over", "fall"];
    assert_happened(&kinds, &expected);
}

#[test]
fn matches_by_the_rules_of_the_humanoid_league() {
    let kinds = check_all("hsl2026");
    assert_happened(&kinds, &["ball_out", "free_kick", "penalty", "penalty_over", "fall"]);
}

#[test]
fn matches_without_a_referee() {
    let kinds = check_all("free");
    assert!(kinds.keys().all(|kind| ["kick", "collision", "intervention"].contains(&kind.as_str())), "{kinds:?}");
}

#[test]
#[ignore = "for a release build: .ci/statistics"]
fn whole_matches_of_every_league() {
    for league in LEAGUES {
        let text = format!(r#"{{ "league": "{}", "teams": {{ "blue": "roles", "pink": "passers" }} }}"#, league.name);
        let scenario = Scenario::from_json(&text).unwrap();
        let kinds = check_seeds(league.name, WHOLE_MATCHES, |seed| Scenario { seed, ..scenario.clone() });
        println!("{}: {kinds:?}", league.name);
        assert_happened(&kinds, &["kick", "ball_out", "final_whistle"]);
    }
}

#[test]
fn no_preset_is_forgotten() {
    let names: Vec<&str> = RULES_PRESETS.iter().map(|preset| preset.name).collect();
    assert_eq!(names, ["naoisis", "spl2010", "spl2025", "hsl2026", "hsl2026_german_open", "extended", "free"]);
}
