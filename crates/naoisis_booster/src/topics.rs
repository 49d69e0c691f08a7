//! What a robot perceives, as the messages of Booster's topics.

use bevy::prelude::*;
use core::f32::consts::FRAC_PI_2;

use crate::firmware::{Firmware, Mode};
use crate::messages::{
    BatteryState, CameraInfo, DetectedObject, Detections, FallDownState, Header, Image as ImageMessage, ImuState,
    LineSegments, LowState, MotorState, Odometer, Point, Pose as PoseMessage, Quaternion, RawBytesMsg, RobotStatesMsg,
    Time,
};
use naoisis_core::camera_model::{CameraIntrinsics, CameraView};
use naoisis_core::geometry::{Pose, to_radians, wrap_angle};
use naoisis_core::pitch::JunctionShape;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::jersey::Jersey;
use naoisis_sensing::sensing::camera::image::Image;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::{LandmarkKind, Percepts};

/// The joints of a K1, in the order of its motors; the first two are the head's yaw and pitch.
const JOINTS: usize = 22;
/// Acceleration of a robot at rest, m/s².
const GRAVITY_MPS2: f32 = 9.81;
/// The confidence of percepts that have none, %.
const CONFIDENCE: f64 = 99.0;

/// The sizes of what a robot sees, for the boxes in its image, m.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Sizes {
    /// The radius of the ball.
    pub ball_radius_m: f32,
    /// The height of the goal.
    pub goal_height_m: f32,
}

/// The odometer.
pub fn odometer(firmware: &Firmware) -> Odometer {
    let Pose { position, heading } = firmware.odometer();
    Odometer { x: position.x, y: position.y, theta: heading }
}

/// Inertial unit and joints. `turn_radps` is the speed of turning by odometry.
///
/// The robot knows that it has fallen, but not to which side: a lying robot is said to lie on its face. The joints of arms and legs are said to
/// be at rest.
pub fn low_state(firmware: &Firmware, turn_radps: f32) -> LowState {
    if let Some(imu) = &firmware.imu {
        let [roll, pitch] = imu.tilt_deg.map(to_radians);
        let [turn, acceleration] = [imu.turn_degps.map(to_radians), imu.acceleration_mps2];
        let rpy = [roll, pitch, wrap_angle(firmware.odometry.heading)];
        return joints(firmware, ImuState { rpy, gyro: turn, acc: acceleration });
    }
    let lies = firmware.body == BodyStatus::Fallen;
    let pitch = if lies { FRAC_PI_2 } else { 0.0 };
    let acceleration = if lies { [-GRAVITY_MPS2, 0.0, 0.0] } else { [0.0, 0.0, GRAVITY_MPS2] };
    let imu = ImuState {
        rpy: [0.0, pitch, wrap_angle(firmware.odometry.heading)],
        gyro: [0.0, 0.0, turn_radps],
        acc: acceleration,
    };
    joints(firmware, imu)
}

/// An inertial unit, and the joints: those of the head, and others at rest.
fn joints(firmware: &Firmware, imu: ImuState) -> LowState {
    let mut motors = vec![MotorState { mode: 1, temperature: 40, reserve: [0, 500], ..default() }; JOINTS];
    (motors[0].q, motors[1].q) = (firmware.head_angles.yaw, firmware.head_angles.pitch);
    LowState { imu_state: imu, motor_state_parallel: motors.clone(), motor_state_serial: motors }
}

/// Whether the robot has fallen.
pub fn fall_down(firmware: &Firmware) -> FallDownState {
    let state = match firmware.body {
        BodyStatus::Diving => 1,
        BodyStatus::Fallen => 2,
        BodyStatus::GettingUp => 3,
        _ => 0,
    };
    FallDownState { fall_down_state: state, is_recovery_available: state == 2 }
}

/// The same, and what moves the robot, in the three bytes that the demo's brain reads. Which number stands for what is taken from its use there:
/// 1 damping, 2 prepare, 8 walking, 20 visual kick.
pub fn recovery(firmware: &Firmware) -> RawBytesMsg {
    let FallDownState { fall_down_state, is_recovery_available } = fall_down(firmware);
    let planner = match (firmware.body_control(), firmware.mode) {
        (14, _) => 20,
        (1, _) | (_, Mode::Damping) => 1,
        (_, Mode::Prepare) => 2,
        (7, _) => 9,
        _ => 8,
    };
    RawBytesMsg { msg: vec![fall_down_state as u8, u8::from(is_recovery_available), planner] }
}

/// A full battery.
pub fn battery() -> BatteryState {
    BatteryState { voltage: 52.0, current: 5.0, soc: 100.0, average_voltage: 52.0 }
}

/// Mode and body control.
pub fn robot_states(firmware: &Firmware) -> RobotStatesMsg {
    RobotStatesMsg {
        current_mode: firmware.mode as i32,
        current_body_control: firmware.body_control(),
        current_actions: Vec::new(),
    }
}

/// The pose of the head in the robot frame: the point about which it turns, and its rotation.
pub fn head_pose(body: &Body, HeadAngles { yaw, pitch }: HeadAngles) -> PoseMessage {
    let rotation = Quat::from_rotation_z(yaw) * Quat::from_rotation_y(pitch);
    let [x, y, z, w] = rotation.to_array().map(f64::from);
    let position = body.neck_m.as_dvec3();
    PoseMessage {
        position: Point { x: position.x, y: position.y, z: position.z },
        orientation: Quaternion { x, y, z, w },
    }
}

fn header(time_s: f64) -> Header {
    Header { stamp: Time::of(time_s), frame_id: "camera".to_owned() }
}

/// The objects in the images of a camera.
pub fn detections(percepts: &Percepts, view: &CameraView, body: &Body, sizes: Sizes) -> Detections {
    let object = |label: &str, place: Vec2, confidence: Option<f32>, width_m: f32, height_m: f32| {
        let corner = |side: f32, height: f32| {
            let aside = place.perp().normalize_or_zero() * side * width_m / 2.0;
            let pixel = view.project_anywhere((place + aside).extend(height));
            pixel.clamp(Vec2::ZERO, view.intrinsics.size)
        };
        let corners = [corner(1.0, height_m), corner(1.0, 0.0), corner(-1.0, height_m), corner(-1.0, 0.0)];
        let least = corners.into_iter().fold(Vec2::MAX, Vec2::min);
        let most = corners.into_iter().fold(Vec2::ZERO, Vec2::max);
        let in_camera = view.camera_from_robot(place.extend(height_m / 2.0));
        DetectedObject {
            label: label.to_owned(),
            confidence: confidence.map_or(CONFIDENCE, |confidence| 100.0 * f64::from(confidence)),
            xmin: least.x as i64,
            ymin: least.y as i64,
            xmax: most.x as i64,
            ymax: most.y as i64,
            position: vec![place.x, place.y, 0.0],
            position_projection: vec![place.x, place.y, 0.0],
            position_cam: in_camera.to_array().to_vec(),
            position_confidence: 1,
            ..default()
        }
    };
    let ball_m = 2.0 * sizes.ball_radius_m;
    let balls = percepts.all_balls().map(|ball| object("Ball", ball.position_m, ball.confidence, ball_m, ball_m));
    let posts = percepts
        .goal_posts
        .iter()
        .map(|post| object("Goalpost", post.position_m, post.confidence, 0.1, sizes.goal_height_m));
    let robots = percepts.robots.iter().map(|robot| DetectedObject {
        color: robot.colour.and_then(Jersey::name).unwrap_or(robot.team.name()).to_owned(),
        ..object("Opponent", robot.position_m, robot.confidence, 2.0 * body.torso.half_width_m, body.height_m)
    });
    let marks = percepts.landmarks.iter().filter_map(|mark| {
        let label = match mark.kind {
            LandmarkKind::Junction { shape: JunctionShape::L } => "LCross",
            LandmarkKind::Junction { shape: JunctionShape::T } => "TCross",
            LandmarkKind::Junction { shape: JunctionShape::X } => "XCross",
            LandmarkKind::PenaltyCross => "PenaltyPoint",
            _ => return None,
        };
        let seen = object(label, mark.position_m, mark.confidence, 0.1, 0.0);
        Some(DetectedObject { target_uv: mark.pixel.to_array().to_vec(), ..seen })
    });
    Detections {
        header: header(percepts.time_s),
        detected_objects: balls.chain(posts).chain(robots).chain(marks).collect(),
        // The demo reads five points of two numbers.
        corner_pos: vec![0.0; 10],
        ..default()
    }
}

/// The lines in the images of a camera.
pub fn line_segments(percepts: &Percepts) -> LineSegments {
    let mut segments = LineSegments { header: header(percepts.time_s), ..default() };
    for mark in &percepts.landmarks {
        if let LandmarkKind::Line { end_pixel, end_position_m } = mark.kind {
            segments
                .coordinates
                .extend([mark.position_m, end_position_m].into_iter().flat_map(|place| place.to_array()));
            segments.coordinates_uv.extend([mark.pixel, end_pixel].into_iter().flat_map(|pixel| pixel.to_array()));
        }
    }
    segments
}

/// The calibration of a camera.
pub fn camera_info(intrinsics: &CameraIntrinsics, time_s: f64) -> CameraInfo {
    // In ROS the middle of the first pixel is at (0, 0).
    let (focal, centre) = (intrinsics.focal.as_dvec2(), intrinsics.centre.as_dvec2() - 0.5);
    let (fx, fy, cx, cy) = (focal.x, focal.y, centre.x, centre.y);
    CameraInfo {
        header: header(time_s),
        height: intrinsics.size.y as u32,
        width: intrinsics.size.x as u32,
        distortion_model: intrinsics.distortion.model().to_owned(),
        d: intrinsics.distortion.coefficients().into_iter().map(f64::from).collect(),
        k: [fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0],
        r: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        p: [fx, 0.0, cx, 0.0, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0],
        ..default()
    }
}

/// An image.
pub fn image(image: &Image, time_s: f64) -> ImageMessage {
    ImageMessage {
        header: header(time_s),
        height: image.height,
        width: image.width,
        encoding: "rgb8".to_owned(),
        step: 3 * image.width,
        data: image.rgb.clone(),
        ..default()
    }
}

/// The depth of an image in millimetres; `None` if it has none.
pub fn depth_image(image: &Image, time_s: f64) -> Option<ImageMessage> {
    (!image.depth_m.is_empty()).then(|| ImageMessage {
        header: header(time_s),
        height: image.height,
        width: image.width,
        encoding: "16UC1".to_owned(),
        step: 2 * image.width,
        data: image.depth_mm(),
        ..default()
    })
}

/// The number of messages of a topic with 50 messages a second that are due in the cycle from `start_s` to `end_s`.
pub fn due(start_s: f64, end_s: f64) -> u64 {
    /// Messages a second.
    const RATE: f64 = 50.0;
    // A thousandth of a message for rounding.
    let number = |time_s: f64| (time_s * RATE + 1e-3).floor() as u64;
    number(end_s) - number(start_s)
}

/// The speed of turning between two poses by odometry, rad/s.
pub fn turn_radps(before: Pose, now: Pose, period_s: f32) -> f32 {
    wrap_angle(now.heading - before.heading) / period_s
}

#[cfg(test)]
mod tests {
    use super::*;
    use bevy::math::ops;
    use naoisis_sensing::sensing::imu::ImuReading;

    #[test]
    fn fifty_messages_a_second_are_due_whatever_the_duration_of_a_cycle() {
        for (period_s, cycles) in [(1.0 / 30.0, 300), (0.02, 500), (0.01, 1000), (0.1, 100)] {
            let due = |cycle: u32| due(f64::from(cycle) * period_s, f64::from(cycle + 1) * period_s);
            assert_eq!((0..cycles).map(due).sum::<u64>(), 500, "{period_s}");
        }
    }

    #[test]
    fn a_lying_robot_says_so_everywhere() {
        let robot = Firmware { body: BodyStatus::Fallen, ..default() };
        assert_eq!(fall_down(&robot), FallDownState { fall_down_state: 2, is_recovery_available: true });
        assert_eq!(recovery(&robot).msg, [2, 1, 1]);
        assert_eq!(low_state(&robot, 0.0).imu_state.rpy[1], FRAC_PI_2);
        let upright = Firmware::default();
        assert_eq!(recovery(&upright).msg, [0, 0, 8]);
        assert_eq!(low_state(&upright, 0.0).imu_state.acc, [0.0, 0.0, GRAVITY_MPS2]);
    }

    #[test]
    fn a_robot_with_an_inertial_unit_tells_what_it_measures() {
        let imu = ImuReading { tilt_deg: [90.0, -45.0], turn_degps: [0.0, 0.0, 180.0], ..default() };
        let state = low_state(&Firmware { imu: Some(imu), ..default() }, 9.0).imu_state;
        assert_eq!((state.rpy[0], state.rpy[1], state.gyro[2]), (FRAC_PI_2, -FRAC_PI_2 / 2.0, 2.0 * FRAC_PI_2));
    }

    #[test]
    fn the_head_is_in_its_two_motors_and_in_its_pose() {
        let head = HeadAngles { yaw: 0.5, pitch: 0.2 };
        let state = low_state(&Firmware { head_angles: head, ..default() }, 0.0);
        assert_eq!(state.motor_state_serial.len(), 22);
        assert_eq!([state.motor_state_serial[0].q, state.motor_state_serial[1].q], [0.5, 0.2]);
        let body = Body::default();
        let Quaternion { x, y, z, w } = head_pose(&body, head).orientation;
        let looks = Quat::from_xyzw(x as f32, y as f32, z as f32, w as f32) * Vec3::X;
        // Downwards and to the left.
        let [down, left] = [ops::asin(-looks.z), ops::atan2(looks.y, looks.x)];
        assert!((down - 0.2).abs() < 1e-5 && (left - 0.5).abs() < 1e-5, "{looks}");
    }
}
