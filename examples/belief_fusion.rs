//! Where is the opponent? Fusing observations of a camera, a sonar and a team-mate (paper, Fig. 7).
//!
//! A robot looks past an opponent that it cannot see, then at it, then away again. Meanwhile the opponent walks away.
//! The camera gave its position; the sonar, which only measures the distance, follows its motion; a Kalman filter
//! weights each measurement by its accuracy. Then the ball: two team-mates see it from different sides, and a third,
//! which does not see it, fuses their messages.
//!
//! ```sh
//! cargo run --release --no-default-features --example belief_fusion
//! ```
#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::belief::ball::{BallEstimate, BallModel};
use naoisis::belief::robots::{RobotTrack, SonarModel, TrackModel, advance_tracks, hear_robot, see_robot};
use naoisis::belief::sighting::Sighting;
use naoisis::belief::team_ball::{HeardBall, TeamBallModel, team_ball};
use naoisis::prelude::*;
use naoisis::sensing::sonar::{SonarReading, SonarSettings};

const WATCHER: RobotId = RobotId::new(Team::Blue, 2);
const OPPONENT: RobotId = RobotId::new(Team::Pink, 2);

/// 0.55 m ahead to the left, where the left sonar points. The head looks straight away from it, then at it, then away
/// again. After 1.5 s the opponent walks backwards for 1.5 s, by 0.18 m.
const OPPONENT_AT_THE_SIDE: &str = r#"{ "rules": "free", "ball": null,
    "vision": { "noise": { "robots": { "false_positive_probability": 0 } } },
    "robots": [
      { "team": "blue", "number": 2, "pose": [0, 0, 0], "behaviour": { "script": [
        { "from_s": 0.0, "head_deg": [-80, 0] }, { "from_s": 0.5, "head_deg": [19, 10] },
        { "from_s": 1.1, "head_deg": [-80, 0] } ] } },
      { "team": "pink", "number": 2, "pose": [0.52, 0.18, 180], "behaviour": { "script": [
        { "from_s": 1.5, "until_s": 3.0, "walk": [-0.004, 0, 0] } ] } } ] }"#;
/// The duration of a cycle, s.
const PERIOD: f32 = 1.0 / 30.0;

fn main() -> Result<(), Box<dyn core::error::Error>> {
    if common::view(OPPONENT_AT_THE_SIDE, |_| {}, |_| {})? {
        return Ok(());
    }
    find_the_opponent()?;
    find_the_ball_together()
}

/// Repeats the stages of Fig. 7 many times, because a single one may be lucky.
fn find_the_opponent() -> Result<(), Box<dyn core::error::Error>> {
    const RUNS: u64 = 200;
    let [mut seen, mut remembered, mut heard] = [(0.0, 0.0); 3];
    let mut runs = 0;
    for seed in 1..=RUNS {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app.start_match(&Scenario { seed, ..Scenario::from_json(OPPONENT_AT_THE_SIDE)? })?;
        let mut tracks: Vec<RobotTrack> = Vec::new();
        app.run_cycles(12);
        watch(&app, &mut tracks);
        assert!(tracks.is_empty(), "no robot is in view yet");
        // The robot looks at the opponent, and away again.
        for _ in 12..45 {
            pass_a_cycle(&mut app, [&mut tracks]);
            watch(&app, &mut tracks);
        }
        let Some(track) = tracks.first() else { continue };
        runs += 1;
        let truth = |app: &App| app.robot_pose(OPPONENT).unwrap_or_default().position;
        seen = added(seen, track, truth(&app));
        // The opponent walks away. One estimate uses the camera only, the other the sonar, too.
        let mut with_sonar = tracks.clone();
        for _ in 45..90 {
            pass_a_cycle(&mut app, [&mut tracks, &mut with_sonar]);
            listen(&app, &mut with_sonar);
        }
        remembered = added(remembered, &tracks[0], truth(&app));
        heard = added(heard, &with_sonar[0], truth(&app));
    }
    println!("position of the opponent     mean error    standard deviation");
    println!("  not seen yet               unknown");
    for (name, (error, doubt)) in
        [("seen", seen), ("1.5 s later, remembered", remembered), ("1.5 s later, and heard", heard)]
    {
        println!("  {name:24} {:>7.1} cm   {:>7.1} cm", 100.0 * error / runs as f32, 100.0 * doubt / runs as f32);
    }
    Ok(())
}

/// Runs a cycle, and updates the robot's estimates.
fn pass_a_cycle<const N: usize>(app: &mut App, memories: [&mut Vec<RobotTrack>; N]) {
    app.run_cycles(1);
    for tracks in memories {
        advance_tracks(tracks, Pose::default(), PERIOD, &TrackModel::default());
    }
}

/// The detections of robots by the cameras.
fn watch(app: &App, tracks: &mut Vec<RobotTrack>) {
    let percepts = app.robot::<Percepts>(WATCHER).map_or(&[][..], |percepts| &percepts.robots);
    for seen in percepts {
        see_robot(tracks, seen.team, &Sighting::new(seen.position_m, 0.01), &TrackModel::default());
    }
}

/// The detections of robots by the sonars.
fn listen(app: &App, tracks: &mut [RobotTrack]) {
    let (Some(reading), Some(sonar)) = (app.robot::<SonarReading>(WATCHER), app.robot::<SonarSettings>(WATCHER)) else {
        return;
    };
    for (distance, heading) in [(reading.left, sonar.heading), (reading.right, -sonar.heading)] {
        if let Some(distance) = distance {
            hear_robot(tracks, distance, heading, sonar.half_angle, &SonarModel::default());
        }
    }
}

/// Adds an error and a standard deviation to the sums, m.
fn added((error, doubt): (f32, f32), track: &RobotTrack, truth: Vec2) -> (f32, f32) {
    let variance = track.covariance.x_axis.x + track.covariance.y_axis.y;
    (error + track.position.distance(truth), doubt + variance.sqrt())
}

/// Two observers 3 m from the ball, at a right angle to each other.
fn find_the_ball_together() -> Result<(), Box<dyn core::error::Error>> {
    const RUNS: u64 = 200;
    let witnesses = [
        (RobotId::new(Team::Blue, 2), Pose::new(-3.0, 0.0, 0.0)),
        (RobotId::new(Team::Blue, 3), Pose::new(0.0, -1.9, core::f32::consts::FRAC_PI_2)),
    ];
    let mut errors = [0.0; 3];
    let mut seen_by_both = 0;
    for seed in 1..=RUNS {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app.start_match(&Scenario {
            seed,
            ..Scenario::from_json(
                r#"{ "rules": "free", "robots": [ { "number": 2, "pose": [-3, 0, 0] }, { "number": 3, "pose": [0, -1.9, 90] } ] }"#,
            )?
        })?;
        app.run_cycles(2);
        let heard = witnesses.map(|(from, pose)| {
            let percept = app.robot::<Percepts>(from)?.ball?;
            // The message has the estimate of a filter from one look.
            let seen = BallEstimate::first_seen(&Sighting::new(percept.position_m, 0.005), &BallModel::default());
            Some(HeardBall {
                from,
                seen_from: pose.position,
                place: pose.transform_point(seen.position),
                age_s: 0.0,
                moved_mps: None,
            })
        });
        let [Some(first), Some(second)] = heard else { continue };
        seen_by_both += 1;
        let model = TeamBallModel { pose_sd: 0.02, ..default() };
        for (error, told) in errors.iter_mut().zip([vec![first], vec![second], vec![first, second]]) {
            *error += team_ball(told.into_iter(), &model).map_or(0.0, |ball| ball.position_m.length());
        }
    }
    println!("position of the ball         mean error");
    for (name, error) in ["reported by 2, 3 m away", "reported by 3, 1.9 m away", "reported by both"].iter().zip(errors)
    {
        println!("  {name:24} {:>7.1} cm", 100.0 * error / seen_by_both as f32);
    }
    Ok(())
}
