//! Commands that change a running match.

use bevy::math::Vec2;
use naoisis::prelude::*;

use crate::support::{blue, match_of, pink};
use naoisis::events::{CommandKind, KickMiss, Refusal};
use naoisis::game::{Intervention, Penalty, PenaltyReason, Score};
use naoisis::kick_geometry::KickType;
use naoisis::robot::Roster;
use naoisis::robot::kick::{KickCommand, KickRequest};
use naoisis::robot::request::{RequestCommand, TeamRequest};

/// Two robots that stand, and a ball, with nobody to judge them.
const SCENE: &str = r#"{ "rules": "free", "ball": { "position_m": [0, 1] },
    "robots": [{ "number": 2, "pose": [-1, 0, 0] }, { "team": "pink", "number": 2, "pose": [1, 0, 180] }] }"#;

/// A match in which this is done, a cycle later, and what was said of it.
fn after(intervention: Intervention) -> (bevy::prelude::App, Vec<MatchEvent>) {
    let mut app = match_of(SCENE);
    app.run_cycles(3);
    app.world_mut().commands().queue(intervention);
    app.world_mut().flush();
    app.run_cycles(1);
    let events = app.events().to_vec();
    (app, events)
}

#[test]
fn the_ball_is_placed_and_rolls_off() {
    let (position_m, velocity_mps) = (Vec2::new(-2.0, -1.0), Vec2::new(0.5, 0.0));
    let (mut app, events) = after(Intervention::PlaceBall { position_m, velocity_mps });
    assert!(matches!(events[..], [MatchEvent::Intervention { .. }]));
    assert_eq!((app.ball().unwrap().position, app.ball_velocity()), (position_m, Some(velocity_mps)));
    // 0.5 m/s with a drag of 0.5 /s: x = x0 + (1 - exp(-0.5 t)) after t s.
    let rolled = app.run_cycles(30).ball().unwrap().position.x - position_m.x;
    assert!((rolled - (1.0 - bevy::math::ops::exp(-0.5))).abs() < 1e-3, "{rolled}");
}

#[test]
fn a_robot_is_placed_and_stands_there() {
    let pose = Pose::new(2.0, -1.5, 0.5);
    let (mut app, _) = after(Intervention::PlaceRobot { robot: pink(2), pose });
    assert_eq!(app.robot_pose(pink(2)), Some(pose));
    assert_eq!(app.run_cycles(10).robot_pose(pink(2)), Some(pose));
}

#[test]
fn the_score_is_set() {
    let (app, _) = after(Intervention::SetScore { blue: 2, pink: 7 });
    assert_eq!(app.game().score, Score { blue: 2, pink: 7 });
}

#[test]
fn a_robot_is_penalised_for_a_time_or_until_it_is_brought_back() {
    let penalise = Intervention::Penalise { robot: blue(2), reason: PenaltyReason::Manual, duration_s: Some(1.0) };
    let away = |app: &bevy::prelude::App| app.robot::<Penalty>(blue(2)).unwrap().is_active();
    let (mut app, events) = after(penalise);
    assert!(events.iter().any(|event| matches!(event, MatchEvent::Penalty { robot, .. } if *robot == blue(2))));
    assert!(away(&app) && app.robot_pose(blue(2)).unwrap().position.y.abs() > 2.0);
    // It hears of it, and in 30 cycles of 1/30 s it is over.
    app.run_cycles(1);
    assert!(app.robot::<GameStatus>(blue(2)).unwrap().penalised);
    assert!(away(app.run_cycles(28)));
    assert!(!away(app.run_cycles(2)));
    let (mut app, _) = after(penalise);
    app.world_mut().commands().queue(Intervention::Return { robot: blue(2) });
    app.world_mut().flush();
    assert!(!away(app.run_cycles(1)));
}

#[test]
fn whistle_drop_ball_and_kick_off() {
    let (app, _) = after(Intervention::Whistle);
    assert_eq!(app.game().whistles, 1);
    let (app, events) = after(Intervention::DropBall { position_m: Vec2::new(1.0, 1.0) });
    assert!(events.contains(&MatchEvent::DropBall { position_m: Vec2::new(1.0, 1.0) }));
    assert!(app.game().drop_ball && app.ball().unwrap().position == Vec2::new(1.0, 1.0));
    let (app, events) = after(Intervention::KickOff { team: Team::Pink });
    assert!(events.contains(&MatchEvent::KickOff { team: Team::Pink }));
    assert_eq!((app.ball().unwrap().position, app.game().kick_off_team), (Vec2::ZERO, Team::Pink));
}

#[test]
fn what_cannot_be_done_is_refused_by_name_and_nothing_is_lost() {
    let nobody = pink(9);
    for (intervention, message) in [
        (Intervention::PlaceRobot { robot: nobody, pose: Pose::default() }, "there is no robot pink9"),
        (
            Intervention::Penalise { robot: nobody, reason: PenaltyReason::Manual, duration_s: None },
            "there is no robot pink9",
        ),
        (Intervention::Return { robot: nobody }, "there is no robot pink9"),
        (Intervention::Return { robot: blue(2) }, "blue2 serves no penalty"),
        (
            Intervention::PlaceBall { position_m: Vec2::new(9.0, 0.0), velocity_mps: Vec2::ZERO },
            "(9, 0) is not on the carpet, which ends at ±3.7 m and ±2.7 m",
        ),
    ] {
        let (app, events) = after(intervention);
        assert_eq!(events, [MatchEvent::InterventionRefused { intervention, message: message.to_owned() }]);
        let mut undisturbed = match_of(SCENE);
        undisturbed.run_cycles(4);
        assert_eq!(app.game(), undisturbed.game());
        assert_eq!(app.ball(), undisturbed.ball());
        for robot in [blue(2), pink(2)] {
            assert_eq!(app.robot_pose(robot), undisturbed.robot_pose(robot));
        }
    }
    // The match goes on, and what can be done is.
    let mut app = match_of(SCENE);
    for intervention in [Intervention::Return { robot: nobody }, Intervention::SetScore { blue: 1, pink: 0 }] {
        app.world_mut().commands().queue(intervention);
    }
    app.world_mut().flush();
    assert_eq!(app.run_cycles(1).game().score, Score { blue: 1, pink: 0 });
}

#[test]
fn a_robot_is_told_that_its_request_or_a_kick_it_does_not_have_was_refused() {
    let scene = r#"{ "league": "hsl2026_middle", "rules": { "preset": "free" }, "robots": [
        { "number": 2, "pose": [0, 0, 0], "behaviour": "idle" }, { "number": 3, "pose": [3, 0, 0], "behaviour": "idle" }] }"#;
    let refused = |request: Option<TeamRequest>, kick: Option<KickType>| {
        let mut app = match_of(scene);
        let robot = app.world().resource::<Roster>().get(blue(2)).unwrap();
        app.world_mut().get_mut::<RequestCommand>(robot).unwrap().0 = request;
        app.world_mut().get_mut::<KickCommand>(robot).unwrap().0 = kick.map(|kick| KickRequest::new(kick, 1.0));
        // Commands take some cycles to the motors.
        (0..30).find_map(|_| {
            app.run_cycles(1).events().iter().find_map(|event| match event {
                MatchEvent::CommandRefused { robot, command, reason } => Some((*robot, *command, *reason)),
                MatchEvent::Kick { robot, reason: Some(KickMiss::NoSuchKick), .. } => {
                    Some((*robot, CommandKind::Kick, Refusal::NotAllowed))
                }
                _ => None,
            })
        })
    };
    let of = |command| Some((blue(2), command, Refusal::NotAllowed));
    // There is no substitute 7, and these rules have no time-outs.
    assert_eq!(refused(Some(TeamRequest::Substitute(7)), None), of(CommandKind::Request));
    assert_eq!(refused(Some(TeamRequest::Timeout), None), of(CommandKind::Request));
    assert_eq!(refused(Some(TeamRequest::PickUp), None), None);
    // A Booster has no side kicks.
    assert_eq!(refused(None, Some(KickType::LeftSide)), of(CommandKind::Kick));
    assert_eq!(refused(None, Some(KickType::LeftStraight)), None);
}
