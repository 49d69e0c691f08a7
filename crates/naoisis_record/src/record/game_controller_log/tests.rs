use bevy::prelude::*;
use std::path::Path;

use super::*;
use crate::record::match_counts::MatchCounts;
use crate::record::recorder::{MatchEnd, Recorder};
use naoisis_core::communication::TeamMessage;
use naoisis_core::events::MatchEvent;
use naoisis_core::game::{Evidence, GameState, PenaltyReason, Score, SetPlayKind};
use naoisis_core::robot::body::Body;
use naoisis_core::robot::jersey::Jersey;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_sim::interface::cycle_record::{CycleRecord, GameRecord, PenaltyRecord, RobotRecord};
use naoisis_sim::interface::vocabulary::RobotCommand;
use naoisis_sim::scenario::Scenario;

const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
const PINK3: RobotId = RobotId::new(Team::Pink, 3);
const CYCLES_PER_S: u64 = 30;

/// Writes a match with one record per cycle, and counts its events. Returns the log as read, the counts, and the text.
fn written(
    league: &str,
    seconds: u64,
    change: impl Fn(u64, &mut CycleRecord),
) -> (GameControllerLog, MatchCounts, String) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.yaml");
    let scenario = Scenario { league: Some(league.to_owned()), ..default() };
    let mut counts = MatchCounts::new(&scenario);
    let mut recorder = GameControllerLogRecorder::create(&path).unwrap();
    let mut world = World::new();
    world.spawn((BLUE2, Body { jersey: Some(Jersey::Yellow), ..default() }));
    let mut last = CycleRecord::default();
    for cycle in 0..=seconds * CYCLES_PER_S {
        let mut record = CycleRecord {
            cycle,
            time_s: cycle as f64 / CYCLES_PER_S as f64,
            robots: [BLUE2, PINK3].map(RobotRecord::new).into(),
            game: GameRecord { state: GameState::Playing, half: 1, time_left_s: Some(600.0), ..default() },
            ..default()
        };
        change(cycle, &mut record);
        counts.look_at_record(&record);
        match cycle {
            0 => recorder.start(&scenario, &record, &mut world),
            _ => recorder.record(&record, &mut world),
        }
        last = record;
    }
    Box::new(recorder).finish(&MatchEnd::default(), &last).unwrap();
    let text = std::fs::read_to_string(&path).unwrap();
    (GameControllerLog::read(&path).unwrap(), counts, text)
}

fn penalty(robot: RobotId, reason: PenaltyReason) -> MatchEvent {
    MatchEvent::Penalty { robot, reason, until_s: 0.0, evidence: Evidence::default() }
}

fn free_kick(set_play: SetPlayKind, team: Team) -> MatchEvent {
    MatchEvent::FreeKick { set_play, team, position_m: Vec2::ZERO }
}

/// Changes the record of a cycle, for a match with many kinds of events.
fn eventful(cycle: u64, record: &mut CycleRecord) {
    let second = cycle / CYCLES_PER_S;
    record.game.state = match second {
        0..3 => GameState::Standby,
        3..6 | 20..25 => GameState::Ready,
        6..8 | 25..27 => GameState::Set,
        _ => GameState::Playing,
    };
    record.game.half = if second < 40 { 1 } else { 2 };
    record.game.score = Score { blue: u32::from(second >= 20), pink: u32::from(second >= 50) };
    record.game.kicking_team = Some(Team::Blue);
    let is_off = (12..18).contains(&second);
    record.robots[1].penalised = is_off.then_some(PenaltyRecord { reason: PenaltyReason::Pushing, time_left_s: 3.0 });
    if !cycle.is_multiple_of(CYCLES_PER_S) {
        return;
    }
    let goal = |team| MatchEvent::Goal { team, scorer: None, own_goal: false, evidence: Evidence::default() };
    let changed = |state| MatchEvent::StateChanged { state };
    let message = RobotCommand { say: Some(TeamMessage::default()), ..default() };
    record.robots[0].command = (8..20).contains(&second).then_some(message);
    record.events = match second {
        3 => vec![changed(GameState::Ready)],
        6 => vec![changed(GameState::Set)],
        8 => vec![changed(GameState::Playing)],
        12 => vec![penalty(PINK3, PenaltyReason::Pushing), free_kick(SetPlayKind::PushingFreeKick, Team::Blue)],
        18 => vec![MatchEvent::PenaltyOver { robot: PINK3, position_m: Vec2::ZERO }],
        19 => vec![free_kick(SetPlayKind::CornerKick, Team::Blue)],
        20 => vec![goal(Team::Blue), changed(GameState::Ready)],
        30 => vec![penalty(BLUE2, PenaltyReason::LeavingField), penalty(PINK3, PenaltyReason::Fallen)],
        40 => vec![MatchEvent::HalfBegins { half: 2 }],
        50 => vec![goal(Team::Pink)],
        55 => vec![free_kick(SetPlayKind::KickIn, Team::Pink)],
        60 => vec![MatchEvent::FinalWhistle],
        _ => Vec::new(),
    };
}

#[test]
fn what_is_written_reads_as_it_was_counted() {
    for league in ["spl2025", "hsl2026_middle"] {
        let (log, counts, _) = written(league, 60, eventful);
        assert_eq!(log.counts.goals, counts.goals, "{league}");
        assert_eq!(log.counts.goals_in_half(1), Score { blue: 1, pink: 0 });
        assert_eq!(log.counts.goals_in_half(2), Score { blue: 0, pink: 1 });
        assert_eq!(log.counts.set_plays, counts.set_plays, "{league}");
        for team in Team::BOTH {
            assert_eq!(log.counts.team(team).penalties, counts.team(team).penalties, "{league}");
            let [read, counted] = [&log.counts, &counts].map(|counts| counts.robot_and_active_s(team));
            assert!((read[0] - counted[0]).abs() < 0.2 && (read[1] - counted[1]).abs() < 0.2, "{read:?} {counted:?}");
        }
        assert!((log.counts.play_s() - counts.play_s()).abs() < 0.1 && counts.play_s() > 40.0);
        assert!((log.counts.game_s() - counts.game_s()).abs() < 0.1);
        assert_eq!((log.messages, log.is_complete), (PerTeam { blue: 12, pink: 0 }, true));
        assert_eq!((log.competition.as_str(), log.team_numbers), (league, PerTeam { blue: 1, pink: 2 }));
    }
}

#[test]
fn a_log_has_the_shape_of_the_leagues() {
    let (_, _, text) = written("spl2025", 20, eventful);
    for piece in [
        "- timestamp:\n    secs: 0\n    nanos: 0\n  entry: !metadata\n    creator: naoisis\n",
        "  entry: !action\n    source: user\n    action:\n",
        "        call: foul\n",
        "fieldPlayerColor: yellow\n",
        "goalkeeperColor: red\n",
        "  entry: !gameState\n    sides: homeDefendsLeftGoal\n    phase: firstHalf\n    state: playing\n    setPlay: noSetPlay\n",
        "    primaryTimer: !started\n      remaining:\n      - 600\n      - 0\n      runCondition: mainTimer\n      behaviorAtZero: overflow\n    secondaryTimer: stopped\n",
        "  entry: !teamMessage\n    team: 1\n    host: 10.0.1.2\n    data: ",
        "  entry: !statusMessage\n",
        "  entry: end\n",
    ] {
        assert!(text.contains(piece), "{piece}\nis not in\n{}", &text[..text.len().min(4000)]);
    }
    for state in ["ready", "set"] {
        assert!(text.contains(&format!("    state: {state}\n    setPlay: kickOff\n")), "{state}");
    }
    // Pushing and its free kick are a single call.
    assert!(!text.contains("setPlay: pushingFreeKick\n      \n") && !text.contains("call: pushing\n"));
}

/// Returns a log in the form of a real one: with a foul, a goal that is undone, a goal, a timeout and a robot that does not exist.
fn real_log() -> String {
    let players = |penalties: &[&str]| -> String {
        let rest = vec!["substitute"; 20 - penalties.len()];
        let player = |penalty: &&str| format!("        - penalty: {penalty}\n          penaltyTimer: stopped\n");
        penalties.iter().chain(&rest).map(player).collect()
    };
    let entry =
        |secs: u64, entry: &str| format!("- timestamp:\n    secs: {secs}\n    nanos: 500000000\n  entry: {entry}\n");
    let state = |secs: u64, phase: &str, state: &str, score: [u32; 2], home: &[&str]| {
        let team = |score: u32, penalties: &[&str]| {
            let players = players(penalties);
            format!(
                "        goalkeeper: 1\n        score: {score}\n        penaltyCounter: 0\n        messageBudget: 1200\n        illegalCommunication: false\n        players:\n{players}"
            )
        };
        let (home, away) = (team(score[0], home), team(score[1], &["noPenalty", "noPenalty"]));
        entry(
            secs,
            &format!(
                "!gameState\n    sides: homeDefendsLeftGoal\n    phase: {phase}\n    state: {state}\n    setPlay: noSetPlay\n    kickingSide: null\n    primaryTimer: !started\n      remaining:\n      - 600\n      - 0\n      runCondition: mainTimer\n      behaviorAtZero: !expire []\n    secondaryTimer: stopped\n    teams:\n      home:\n{home}      away:\n{away}"
            ),
        )
    };
    let action = |secs: u64, source: &str, kind: &str, arguments: &str| {
        entry(secs, &format!("!action\n    source: {source}\n    action:\n      type: {kind}\n      args:{arguments}"))
    };
    let side = |side: &str| format!("\n        side: {side}");
    let penalize = |call: &str| format!("\n        side: home\n        player: 2\n        call: {call}");
    let there = ["noPenalty", "noPenalty"];
    let off = ["noPenalty", "playerPushing"];
    [
        entry(
            0,
            "!metadata\n    creator: GameController\n    version: 1\n    timestamp: 2024-07-19T14:00:00.25+02:00\n    params:\n      competition:\n        name: Champions Cup\n        challengeMode: null\n        playersPerTeam: 2\n      game:\n        teams:\n          home:\n            number: 5\n            fieldPlayerColor: black\n          away:\n            number: 40\n            fieldPlayerColor: white\n        long: false",
        ),
        state(0, "firstHalf", "initial", [0, 0], &there),
        action(10, "user", "startSetPlay", "\n        side: home\n        setPlay: kickOff"),
        state(10, "firstHalf", "ready", [0, 0], &there),
        entry(12, "!monitorRequest\n    host: 10.0.0.7\n    data: UkdUcgA="),
        action(40, "user", "waitForSetPlay", " null"),
        state(40, "firstHalf", "set", [0, 0], &there),
        action(50, "user", "freeSetPlay", " null"),
        state(50, "firstHalf", "playing", [0, 0], &there),
        entry(55, "!teamMessage\n    team: 40\n    host: 10.0.40.2\n    data: AAAA"),
        action(60, "user", "penalize", &penalize("foul")),
        state(60, "firstHalf", "playing", [0, 0], &off),
        action(80, "user", "goal", &side("away")),
        state(80, "firstHalf", "ready", [0, 1], &off),
        action(82, "user", "undo", "\n        states: 1"),
        state(82, "firstHalf", "playing", [0, 0], &off),
        action(90, "user", "unpenalize", "\n        side: home\n        player: 2\n        force: false"),
        state(90, "firstHalf", "playing", [0, 0], &there),
        action(100, "user", "goal", &side("home")),
        state(100, "firstHalf", "ready", [1, 0], &there),
        action(110, "user", "timeout", &side("home")),
        state(110, "firstHalf", "timeout", [1, 0], &there),
        action(200, "user", "finishHalf", " null"),
        state(200, "penaltyShootout", "playing", [1, 0], &there),
        action(210, "user", "goal", &side("home")),
        state(210, "penaltyShootout", "finished", [2, 0], &there),
        entry(220, "end"),
    ]
    .concat()
}

fn read_text(text: &str) -> Result<GameControllerLog, GameControllerLogError> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("log.yaml");
    std::fs::write(&path, text).unwrap();
    GameControllerLog::read(&path)
}

#[test]
fn a_real_log_is_counted() {
    let log = read_text(&real_log()).unwrap();
    assert_eq!((log.competition.as_str(), log.team_numbers), ("Champions Cup", PerTeam { blue: 5, pink: 40 }));
    assert!(log.date.starts_with("2024-07-19") && log.is_complete);
    assert_eq!(log.counts.goals, Score { blue: 1, pink: 0 });
    assert_eq!(log.counts.team(Team::Blue).penalties, [(PenaltyReason::Pushing, 1)].into());
    assert_eq!(log.counts.set_plays.pink, [(SetPlayKind::PushingFreeKick, 1)].into());
    assert_eq!(log.messages, PerTeam { blue: 0, pink: 1 });
    // Playing from 50 to 80 and from 82 to 100. Ready and set from 10 to 50, from 80 to 82 and from 100 to 110.
    assert!((log.counts.play_s() - 48.0).abs() < 0.1 && (log.counts.game_s() - 100.0).abs() < 0.1);
    let [robots_s, active_s] = log.counts.robot_and_active_s(Team::Blue);
    assert!((robots_s - 200.0).abs() < 0.2 && (active_s - 170.0).abs() < 0.2, "{robots_s} {active_s}");
}

#[test]
fn what_is_no_log_is_refused_with_its_line() {
    let error = |text: &str| read_text(text).unwrap_err().to_string();
    assert!(error("").contains("the first entry is not `metadata`"));
    assert!(error("goals: 3\n").contains("log.yaml:1: "));
    let broken = real_log().replacen("state: set", "stat: set", 1);
    let line = broken.lines().position(|line| line.contains("stat: set")).unwrap();
    let told = error(&broken);
    let entry =
        broken.lines().take(line).collect::<Vec<_>>().iter().rposition(|line| line.starts_with("- ")).unwrap() + 1;
    assert!(told.contains(&format!("log.yaml:{entry}: ")) && told.contains("state"), "{told}");
    assert!(GameControllerLog::read(Path::new("nowhere.yaml")).unwrap_err().to_string().starts_with("nowhere.yaml: "));
}

#[test]
fn a_log_that_is_cut_off_is_counted_as_far_as_it_goes() {
    let whole = real_log();
    let cut = &whole[..whole.find("- timestamp:\n    secs: 100").unwrap()];
    let log = read_text(cut).unwrap();
    assert!(!log.is_complete && log.counts.goals == Score::default());
    // Wherever it is cut off: in an entry, and filled up by a file system that had reserved the space.
    for (length, rest) in [(90, ""), (90, "\0\0\0\0"), (0, "\0\0"), (4, "")] {
        let torn = format!("{cut}{}{rest}", &whole[cut.len()..cut.len() + length]);
        let read = read_text(&torn).unwrap_or_else(|error| panic!("{length}, {rest:?}: {error}"));
        assert_eq!(format!("{:?}", read.counts), format!("{:?}", log.counts), "{length}, {rest:?}");
        assert!(!read.is_complete);
    }
}

#[test]
fn entries_of_later_versions_and_of_other_editors_are_read() {
    let whole = read_text(&real_log()).unwrap();
    let robots = "- timestamp:\n    secs: 3\n    nanos: 0\n  entry: !robotsSeen\n    count: 4\n";
    let other =
        real_log().replacen("- timestamp:\n    secs: 10\n", &format!("{robots}- timestamp:\n    secs: 10\n"), 1);
    assert_ne!(other, real_log());
    for text in [other, format!("\u{feff}{}", real_log()), real_log().replace('\n', "\r\n")] {
        assert_eq!(format!("{:?}", read_text(&text).unwrap().counts), format!("{:?}", whole.counts));
    }
}

#[test]
fn a_match_is_whole_when_its_last_half_is_over() {
    assert!(read_text(&real_log()).unwrap().is_whole_match);
    let first_half_only = real_log().replace("penaltyShootout", "firstHalf");
    assert!(!read_text(&first_half_only).unwrap().is_whole_match);
}

/// Changes the record of a cycle, for a match with two halves of five seconds and two of extra time.
fn with_extra_time(cycle: u64, record: &mut CycleRecord) {
    record.game.half = 1 + (cycle / (5 * CYCLES_PER_S)) as u32;
    record.events.clear();
    if cycle > 0 && cycle.is_multiple_of(5 * CYCLES_PER_S) {
        record.events.push(MatchEvent::HalfBegins { half: record.game.half });
    }
}

#[test]
fn halves_of_extra_time_have_their_names() {
    let (log, _, text) = written("hsl2026_middle", 19, with_extra_time);
    let phases = ["phase: firstHalf", "phase: secondHalf", "phase: firstExtraHalf", "phase: secondExtraHalf"];
    let places = phases.map(|phase| text.find(phase).unwrap_or_else(|| panic!("no {phase}")));
    assert!(places.is_sorted(), "{places:?}");
    assert!(text.contains("startExtraTime") && log.is_complete);
}
