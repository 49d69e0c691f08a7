//! Localisation from camera images alone: rendered in software, searched for goal posts and lines by their colours, and
//! fused with odometry by a Kalman filter.
//!
//! A robot walks in a circle and looks around. The example prints its errors with images, and with odometry alone.
//! After a minute the robot is carried elsewhere without notice.
//!
//! Run with `cargo run --release --no-default-features --example localisation_from_images`; with `--view`, and without
//! `--no-default-features`, to watch it.

#![expect(clippy::print_stdout, reason = "an example says what it finds")]

mod common;

use bevy::prelude::*;
use naoisis::prelude::*;
use naoisis::statistics::median;

const ROBOT: RobotId = RobotId::new(Team::Blue, 2);
/// The start pose, and the pose to which it is carried.
const START: Pose = Pose { position: Vec2::new(0.0, -1.0), heading: 0.0 };
const ELSEWHERE: Pose = Pose { position: Vec2::new(-1.5, 0.8), heading: -2.84 };
/// When it is carried, and when the match ends, s.
const CARRIED_S: usize = 60;
const END_S: usize = 80;
const SCENARIO: &str = r#"{ "rules": "free", "ball": null, "vision": { "source": "image" },
    "cameras": { "render": "software", "noise": { "pixel_sd": 4 } },
    "robots": [{ "number": 2, "pose": [0, -1, 0], "behaviour": "walker" }] }"#;

/// A robot that walks in a circle. It requires the built-in estimator, which uses only the robot's sensors.
#[derive(Component, Default)]
#[require(SimpleBelief, Belief)]
struct Walker;

fn walk_around(clock: Res<CycleClock>, mut robots: Query<(&mut WalkCommand, &mut HeadCommand), With<Walker>>) {
    for (mut walk, mut head) in &mut robots {
        // 0.15 m/s on a circle with a radius of 1 m.
        *walk = WalkCommand::at_velocity(0.15, 0.0, 0.15, &clock);
        // From side to side in four seconds.
        let phase = (clock.cycle % 120) as f32 / 120.0;
        *head = HeadCommand { yaw: 1.6 * (1.0 - 4.0 * (phase - 0.5).abs()), pitch: 0.0 };
    }
}

/// The error of a pose, m and degrees.
fn error(app: &App, pose: Pose) -> [f32; 2] {
    let truth = app.robot_pose(ROBOT).unwrap_or_default();
    let turned = naoisis::geometry::wrap_angle(truth.heading - pose.heading).abs();
    [truth.position.distance(pose.position), turned.to_degrees()]
}

fn main() -> Result<(), Box<dyn core::error::Error>> {
    let walker = |app: &mut App| {
        app.add_behaviour::<Walker, _>("walker", walk_around);
    };
    if common::view(SCENARIO, walker, |_| {})? {
        return Ok(());
    }
    let mut app = App::new();
    app.add_plugins(NaoisisPlugins);
    walker(&mut app);
    app.start_match(&Scenario::from_json(SCENARIO)?)?;
    println!("           error by images   error by odometry only  posts and marks in the images");
    let mut places = Vec::new();
    let mut headings = Vec::new();
    for second in 1..=END_S {
        app.run_cycles(30);
        // Blue defends the negative end in the first half, so its frame is the pitch frame.
        let by_images = error(&app, app.robot::<Belief>(ROBOT).map(|belief| belief.pose).unwrap_or_default());
        let by_odometry =
            error(&app, START.compose(app.robot::<Odometry>(ROBOT).map(|walked| walked.0).unwrap_or_default()));
        if second <= CARRIED_S {
            places.push(f64::from(by_images[0]));
            headings.push(f64::from(by_images[1]));
        }
        if second % 5 == 0 || (CARRIED_S..CARRIED_S + 5).contains(&second) {
            let seen = app.robot::<Percepts>(ROBOT).map_or(0, |seen| seen.goal_posts.len() + seen.landmarks.len());
            println!(
                "{second:4} s   {:6.2} m {:5.1} deg     {:6.2} m {:5.1} deg   {seen:12}",
                by_images[0], by_images[1], by_odometry[0], by_odometry[1]
            );
        }
        if second == CARRIED_S {
            println!("         now the robot is carried to the other side");
            app.world_mut().commands().queue(Intervention::PlaceRobot { robot: ROBOT, pose: ELSEWHERE });
            app.world_mut().flush();
        }
    }
    if let (Some(place), Some(heading)) = (median(places), median(headings)) {
        println!("median over the first {CARRIED_S} s: {place:.3} m, {heading:.2} deg");
    }
    Ok(())
}
