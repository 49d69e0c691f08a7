//! Robots that are decided for from outside: as good as behaviours, and no better.

use bevy::prelude::*;
use naoisis::agents::{self, AgentError, Perception, RobotCommand};
use naoisis::cycle::perceive;
use naoisis::interface::cycle_record::CycleRecord;
use naoisis::interface::gather::{CurrentRecord, gather_start};
use naoisis::prelude::*;
use naoisis::record::RecordPlugin;
use naoisis::scenario::BehaviourSpec;
use naoisis::simulation::Snapshot;

const SCRIPTED: &str = r#"{
    "seed": 3, "messages": { "loss": 0.3 }, "ball": { "position_m": [0.15, -0.05] },
    "robots": [
        { "team": "blue", "number": 1, "behaviour": { "script": [
            { "from_s": 0.0, "kick": { "type": "right_straight", "speed": 0.8 } },
            { "from_s": 1.5, "until_s": 4.0, "walk": [0.005, 0.001, 1.0], "head_deg": [20.0, 10.0] },
            { "from_s": 0.5, "until_s": 3.0, "say": { "ball_m": [0.1, 0.2], "intention": "pass" } },
            { "from_s": 3.0, "posture": "get_up" } ] } },
        { "team": "blue", "number": 2, "pose": [-1.0, 0.5, 0.0], "behaviour": "chaser" },
        { "team": "pink", "number": 1, "pose": [1.5, 0.0, 180.0], "behaviour": "chaser" } ] }"#;

const BLUE1: RobotId = RobotId::new(Team::Blue, 1);
const BLUE2: RobotId = RobotId::new(Team::Blue, 2);

fn app(scenario: &Scenario) -> App {
    let mut app = App::new();
    app.add_plugins((NaoisisPlugins, RecordPlugin));
    app.start_match(scenario).unwrap();
    gather_start(app.world_mut());
    app
}

fn record(app: &App) -> &CycleRecord {
    &app.world().resource::<CurrentRecord>().record
}

fn scripted() -> Scenario {
    Scenario::from_json(SCRIPTED).unwrap()
}

/// The scripted match with the first blue robot decided for from outside.
fn remote() -> Scenario {
    let mut scenario = scripted();
    scenario.robots[0].behaviour = BehaviourSpec::Named("remote".to_owned());
    scenario
}

#[test]
fn a_remote_robot_that_repeats_a_scripts_commands_plays_the_scripts_trace() {
    let (mut scripted, mut remote) = (app(&scripted()), app(&remote()));
    assert_eq!(agents::remote_robots(remote.world()), [BLUE1]);
    for cycle in 0..150 {
        // A record has the head as it was turned in the cycle.
        let head = record(&scripted).robot(BLUE1).unwrap().head;
        scripted.run_cycles(1);
        perceive(remote.world_mut());
        let expected = record(&scripted);
        let robot = expected.robot(BLUE1).unwrap();
        let perception = agents::perception(remote.world_mut(), BLUE1).unwrap();
        assert_eq!(perception, Perception { head, ..robot.perception() }, "cycle {cycle}");
        // As a program would send it.
        let text = serde_json::to_string(robot.command.as_ref().unwrap()).unwrap();
        let command = RobotCommand::from_json(text.as_bytes()).unwrap();
        agents::command(remote.world_mut(), BLUE1, command).unwrap();
        remote.run_cycles(1);
        assert_eq!(serde_json::to_string(record(&remote)).unwrap(), serde_json::to_string(expected).unwrap());
    }
    assert!(record(&remote).ball.unwrap().position_m.x > 1.0);
}

#[test]
fn a_cycle_in_two_halves_is_the_same_cycle() {
    let scenario = Scenario::named("match3v3").unwrap();
    let (mut whole, mut halves) = (app(&scenario), app(&scenario));
    for cycle in 0..200_u64 {
        whole.run_cycles(1);
        perceive(halves.world_mut());
        perceive(halves.world_mut());
        assert_eq!((halves.cycle(), record(&halves).cycle), (cycle + 1, cycle));
        halves.run_cycles(1);
        assert_eq!(record(&halves), record(&whole));
    }
}

#[test]
fn a_match_saved_in_the_middle_of_a_cycle_goes_on_there() {
    let scenario = Scenario::named("match3v3").unwrap();
    let mut app = app(&scenario);
    app.run_cycles(100);
    perceive(app.world_mut());
    let snapshot = Snapshot::take(app.world_mut()).unwrap();
    app.run_cycles(50);
    let expected = record(&app).clone();
    snapshot.restore(app.world_mut()).unwrap();
    app.run_cycles(50);
    assert_eq!(record(&app), &expected);
    // Another match begins with a whole cycle.
    perceive(app.world_mut());
    app.start_match(&scenario).unwrap();
    app.run_cycles(1);
    assert_eq!(app.cycle(), 1);
}

#[test]
fn only_remote_robots_obey_and_any_robot_of_a_team_can_become_one() {
    let mut app = app(&remote());
    let walk = || RobotCommand { walk: Some(WalkCommand::new(0.005, 0.0, 0.0)), ..default() };
    assert_eq!(agents::command(app.world_mut(), BLUE2, walk()), Err(AgentError::NotRemote(BLUE2)));
    let nobody = RobotId::new(Team::Pink, 5);
    assert_eq!(agents::command(app.world_mut(), nobody, walk()), Err(AgentError::NoSuchRobot(nobody)));
    assert!(agents::perception(app.world_mut(), nobody).is_err());

    let match3v3 = Scenario::named("match3v3").unwrap();
    let scenario = agents::with_remote_robots(app.world(), &match3v3, &[BLUE2]).unwrap();
    app.start_match(&scenario).unwrap();
    assert_eq!(agents::remote_robots(app.world()), [BLUE2]);
    let fault = agents::with_remote_robots(app.world(), &match3v3, &[nobody]).unwrap_err();
    assert!(fault.to_string().contains("blue1"), "{fault}");
}

#[test]
fn a_remote_robot_believes_what_a_behaviours_robot_believes() {
    let idle = |behaviour: &str| {
        Scenario::from_json(&format!(
            r#"{{ "rules": "free", "robots": [
                 {{ "team": "pink", "number": 3, "pose": [1.0, 0.5, -153.0], "behaviour": "{behaviour}" }} ] }}"#
        ))
        .unwrap()
    };
    let pink3 = RobotId::new(Team::Pink, 3);
    let mut app = app(&idle("remote"));
    assert_eq!(agents::belief(app.world(), pink3), Ok(None));
    agents::believe(app.world_mut(), pink3).unwrap();
    perceive(app.world_mut());
    let belief = agents::belief(app.world(), pink3).unwrap().unwrap();
    // The team of pink defends +x: its frame is turned by half a turn.
    assert!((belief.pose.position - Vec2::new(-1.0, -0.5)).length() < 0.1, "{belief:?}");
    assert!(belief.ball.is_some());
}
