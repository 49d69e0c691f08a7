//! A program for the SDK in Rust (crate `booster_sdk`), which knows nothing of naoisis: it walks, turns its head, looks for the ball and scores. It
//! ends with an error if something was not as on a robot.

use booster_sdk::client::BoosterClient;
use booster_sdk::client::vision::VisionClient;
use booster_sdk::dds::{DdsSubscription, TopicSpec, battery_state_topic};
use booster_sdk::types::{BodyControl, BoosterError, DanceId, RobotMode, RpcError};
use std::error::Error;
use std::time::{Duration, Instant};
use tokio::time::{sleep, timeout};

const CALLS: u32 = 200;
/// Velocity ahead and to the left: until the ball is straight ahead.
const VELOCITY_MPS: [f32; 2] = [0.3, 0.1];
const WALK_S: f32 = 3.0;

/// A motor of `low_state`: mode, angle, its two derivatives, torque, temperature, lost and reserved numbers.
type Motor = (i8, f32, f32, f32, f32, i8, u32, [u32; 2]);
/// The message of `low_state`: inertial unit, parallel and serial motors.
type LowState = ([[f32; 3]; 3], Vec<Motor>, Vec<Motor>);

fn expect(what: &str, holds: bool) -> Result<(), String> {
    println!("{} {what}", if holds { "ok     " } else { "FAILED " });
    if holds { Ok(()) } else { Err(format!("not so: {what}")) }
}

/// A topic for which the crate has no name, with the quality of service of the battery's.
fn topic(name: &str, type_name: &'static str) -> TopicSpec {
    TopicSpec { name: format!("rt/{name}"), type_name, ..battery_state_topic() }
}

/// A message that was sent after this call: fewer than five are kept on the way.
async fn fresh<T>(topic: &mut DdsSubscription<T>) -> Result<T, Box<dyn Error>> {
    const PATIENCE: Duration = Duration::from_secs(1);
    for _ in 0..4 {
        timeout(PATIENCE, topic.recv()).await?;
    }
    timeout(PATIENCE, topic.recv()).await?.ok_or_else(|| "the topic is closed".into())
}

#[tokio::main(flavor = "current_thread")]
async fn main() -> Result<(), Box<dyn Error>> {
    // The first call of a client waits three seconds for its service. That of the second client is found by then.
    let (robot, vision) = (BoosterClient::new()?, VisionClient::with_startup_wait(Duration::ZERO)?);
    let odometer = topic("odometer_state", "booster_interface::msg::dds_::Odometer_");
    let mut odometer = robot.node().subscribe::<[f32; 3]>(&odometer, 1)?;
    let low_state = topic("low_state", "booster_interface::msg::dds_::LowState_");
    let mut low_state = robot.node().subscribe::<LowState>(&low_state, 1)?;
    let fall_down = topic("fall_down", "booster_interface::msg::dds_::FallDownState_");
    let mut fall_down = robot.node().subscribe::<(u32, bool)>(&fall_down, 1)?;

    let mut calls = 1;
    while robot.get_mode().await.is_err() {
        calls += 1;
        expect("the robot's service is found", calls < 5)?;
    }
    robot.change_mode(RobotMode::Prepare).await?;
    let [forward_mps, left_mps] = VELOCITY_MPS;
    let refused = robot.move_robot(forward_mps, left_mps, 0.0).await;
    expect("it does not walk while prepared", matches!(refused, Err(BoosterError::Rpc(RpcError::Conflict(_)))))?;
    let refused = robot.dance(DanceId::NewYear).await;
    expect("it does not dance", matches!(refused, Err(BoosterError::Rpc(RpcError::ServerRefused(_)))))?;
    robot.change_mode(RobotMode::Walking).await?;
    expect("it says its mode", robot.get_mode().await?.mode_enum() == Some(RobotMode::Walking))?;
    let status = robot.get_status().await?;
    expect("it says its gait", status.current_body_control_enum() == Some(BodyControl::HumanlikeGait))?;
    expect("it says its model", robot.get_robot_info().await?.model == "booster_k1")?;

    let start = Instant::now();
    for _ in 0..CALLS {
        robot.move_robot(0.0, 0.0, 0.0).await?;
    }
    println!("        {CALLS} calls, none lost, {:.2} ms each", start.elapsed().as_secs_f32() * 1000.0 / CALLS as f32);

    robot.rotate_head(0.5, 0.3).await?;
    robot.reset_odometry().await?;
    robot.move_robot(forward_mps, left_mps, 0.0).await?;
    sleep(Duration::from_secs_f32(WALK_S)).await;
    robot.move_robot(0.0, 0.0, 0.0).await?;
    let [x, y, _] = fresh(&mut odometer).await?;
    let shares = [x / (forward_mps * WALK_S), y / (left_mps * WALK_S)];
    let walked = shares.iter().all(|share| (0.5..1.3).contains(share));
    expect(&format!("it has walked {x:.2} m ahead and {y:.2} m aside by odometry"), walked)?;
    let (_, _, motors) = fresh(&mut low_state).await?;
    expect("the head is in two of 22 motors", motors.len() == 22)?;
    let (yaw, pitch) = (motors[0].1, motors[1].1);
    let turned = (yaw - 0.3).abs() < 0.05 && (pitch - 0.5).abs() < 0.05;
    expect(&format!("the head turns: yaw {yaw:.2}, pitch {pitch:.2}"), turned)?;
    expect("it has not fallen", fresh(&mut fall_down).await? == (0, false))?;

    robot.rotate_head(0.3, 0.0).await?;
    vision.start_vision_service(true, false, false).await?;
    let start = Instant::now();
    let ball = loop {
        let seen = vision.get_detection_object_with_ratio(1.0).await?;
        match seen.into_iter().find(|object| object.tag == "Ball") {
            Some(ball) => break ball.position,
            None => expect("the ball is found", start.elapsed().as_secs() < 5)?,
        }
        sleep(Duration::from_millis(50)).await;
    };
    println!("        the ball is {:.2} m ahead and {:.2} m aside", ball[0], ball[1]);
    robot.visual_kick(true).await?;
    sleep(Duration::from_secs(6)).await;
    Ok(())
}
