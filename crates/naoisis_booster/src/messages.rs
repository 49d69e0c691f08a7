//! The messages of Booster's SDK and of the ROS 2 interfaces of its demo, as DDS transports them.
//!
//! The fields and their order are those of the `.msg` files; a ROS type `package/Name` is called `package::msg::dds_::Name_` on DDS.

use serde::{Deserialize, Serialize};

/// A message with its name on DDS.
pub trait Message: Serialize + Send + Sync + 'static {
    /// The name of its type on DDS.
    const TYPE: &'static str;
}

macro_rules! messages {
    ($($(#[$doc:meta])* $name:ident as $type:literal { $($field:ident: $kind:ty),* $(,)? })*) => {$(
        $(#[$doc])*
        #[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
        #[expect(missing_docs, reason = "the fields are those of the `.msg` file")]
        pub struct $name {
            $(pub $field: $kind),*
        }

        impl Message for $name {
            const TYPE: &'static str = $type;
        }
    )*};
}

messages! {
    /// A request: the header has the API's number, the body its parameters, both as JSON.
    RpcReqMsg as "booster_msgs::msg::dds_::RpcReqMsg_" { uuid: String, header: String, body: String }
    /// The answer to the request with the same `uuid`: the header has the status.
    RpcRespMsg as "booster_msgs::msg::dds_::RpcRespMsg_" { uuid: String, header: String, body: String }
    /// Pose by odometry, m and radians.
    Odometer as "booster_interface::msg::dds_::Odometer_" { x: f32, y: f32, theta: f32 }
    /// Roll, pitch and yaw, turn rates and acceleration.
    ImuState as "booster_interface::msg::dds_::ImuState_" { rpy: [f32; 3], gyro: [f32; 3], acc: [f32; 3] }
    /// A joint.
    MotorState as "booster_interface::msg::dds_::MotorState_" {
        mode: i8, q: f32, dq: f32, ddq: f32, tau_est: f32, temperature: i8, lost: u32, reserve: [u32; 2],
    }
    /// Inertial unit and joints.
    LowState as "booster_interface::msg::dds_::LowState_" {
        imu_state: ImuState, motor_state_parallel: Vec<MotorState>, motor_state_serial: Vec<MotorState>,
    }
    /// Whether the robot has fallen: 0 ready, 1 falling, 2 fallen, 3 getting up.
    FallDownState as "booster_interface::msg::dds_::FallDownState_" { fall_down_state: u32, is_recovery_available: bool }
    /// Bytes, whose meaning depends on the topic.
    RawBytesMsg as "booster_interface::msg::dds_::RawBytesMsg_" { msg: Vec<u8> }
    /// Charge of the battery.
    BatteryState as "booster_interface::msg::dds_::BatteryState_" {
        voltage: f32, current: f32, soc: f32, average_voltage: f32,
    }
    /// Mode, body control and actions.
    RobotStatesMsg as "booster_interface::msg::dds_::RobotStatesMsg_" {
        current_mode: i32, current_body_control: i32, current_actions: Vec<i32>,
    }
    /// A time.
    Time as "builtin_interfaces::msg::dds_::Time_" { sec: i32, nanosec: u32 }
    /// The time of a simulation.
    Clock as "rosgraph_msgs::msg::dds_::Clock_" { clock: Time }
    /// Time and frame of a message.
    Header as "std_msgs::msg::dds_::Header_" { stamp: Time, frame_id: String }
    /// A point, m.
    Point as "geometry_msgs::msg::dds_::Point_" { x: f64, y: f64, z: f64 }
    /// A rotation.
    Quaternion as "geometry_msgs::msg::dds_::Quaternion_" { x: f64, y: f64, z: f64, w: f64 }
    /// Position and orientation.
    Pose as "geometry_msgs::msg::dds_::Pose_" { position: Point, orientation: Quaternion }
    /// An object that vision has found.
    DetectedObject as "vision_interface::msg::dds_::DetectedObject_" {
        label: String, color: String, confidence: f64, xmin: i64, ymin: i64, xmax: i64, ymax: i64,
        target_uv: Vec<f32>, received_pos: Vec<f32>, position: Vec<f32>, position_projection: Vec<f32>,
        position_cam: Vec<f32>, position_confidence: i32,
    }
    /// The objects of an image.
    Detections as "vision_interface::msg::dds_::Detections_" {
        header: Header, detected_objects: Vec<DetectedObject>, radar_x: Vec<f32>, radar_y: Vec<f32>, corner_pos: Vec<f32>,
    }
    /// The lines of an image: four numbers for each, on the ground and in the image.
    LineSegments as "vision_interface::msg::dds_::LineSegments_" {
        header: Header, coordinates: Vec<f32>, coordinates_uv: Vec<f32>,
    }
    /// What the program tells the visual kick: the ball and the direction in which it shall leave, robot frame, m and radians.
    Kick as "brain::msg::dds_::Kick_" {
        header: Header, x: f64, y: f64, dir: f64, goal_x: f64, goal_y: f64, robot_theta_to_field: f64, power: f64,
    }
    /// A part of an image.
    RegionOfInterest as "sensor_msgs::msg::dds_::RegionOfInterest_" {
        x_offset: u32, y_offset: u32, height: u32, width: u32, do_rectify: bool,
    }
    /// The calibration of a camera.
    CameraInfo as "sensor_msgs::msg::dds_::CameraInfo_" {
        header: Header, height: u32, width: u32, distortion_model: String, d: Vec<f64>, k: [f64; 9], r: [f64; 9],
        p: [f64; 12], binning_x: u32, binning_y: u32, roi: RegionOfInterest,
    }
    /// An event of a button: 0 pressed, 1 released. Its layout is that which the maker's SDK 1.6.3 reads.
    ButtonEventMsg as "booster_interface::msg::dds_::ButtonEventMsg_" { button: i32, event: i32 }
    /// Sticks and buttons of the remote controller, and its last event by the codes of SDL: 0x603 a button pressed, 0x604 released.
    RemoteControllerState as "booster_interface::msg::dds_::RemoteControllerState_" {
        event: u32, lx: f32, ly: f32, rx: f32, ry: f32, a: bool, b: bool, x: bool, y: bool, lb: bool, rb: bool,
        lt: bool, rt: bool, ls: bool, rs: bool, back: bool, start: bool, hat_c: bool, hat_u: bool, hat_d: bool,
        hat_l: bool, hat_r: bool, hat_lu: bool, hat_ld: bool, hat_ru: bool, hat_rd: bool, reserved: u8,
    }
    /// An image.
    Image as "sensor_msgs::msg::dds_::Image_" {
        header: Header, height: u32, width: u32, encoding: String, is_bigendian: u8, step: u32, data: Vec<u8>,
    }
}

impl Time {
    /// The time `time_s`, s.
    pub fn of(time_s: f64) -> Self {
        let nanoseconds = (time_s.max(0.0) * 1e9).round() as u64;
        Self { sec: (nanoseconds / 1_000_000_000) as i32, nanosec: (nanoseconds % 1_000_000_000) as u32 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustdds::CDRSerializerAdapter;
    use rustdds::no_key::SerializerAdapter;
    use std::path::Path;

    /// Writes a message into `folder`, as DDS transports it and as JSON.
    fn write<T: Message>(folder: &Path, message: &T) {
        let bytes = CDRSerializerAdapter::<T>::to_bytes(message).unwrap();
        // Little-endian, as the header says.
        let whole = [&[0, 1, 0, 0][..], &bytes].concat();
        std::fs::write(folder.join(format!("{}.cdr", T::TYPE)), whole).unwrap();
        std::fs::write(folder.join(format!("{}.json", T::TYPE)), serde_json::to_string(message).unwrap()).unwrap();
    }

    fn stamped() -> Header {
        Header { stamp: Time { sec: 7, nanosec: 5 }, frame_id: "cam".to_owned() }
    }

    /// Writes one of each kind, with a different number in each field, into the folder `NAOISIS_CDR_FOLDER`, for `tests/booster/decode.py`.
    #[test]
    fn every_kind_of_message_is_written() {
        let Ok(folder) = std::env::var("NAOISIS_CDR_FOLDER") else { return };
        let folder = Path::new(&folder);
        let text = |word: &str| word.to_owned();
        write(folder, &RpcReqMsg { uuid: text("1"), header: text("23"), body: text("456") });
        write(folder, &RpcRespMsg { uuid: text("12345"), header: text(""), body: text("{}") });
        write(folder, &Odometer { x: 1.5, y: -2.25, theta: 0.5 });
        let imu_state = ImuState { rpy: [0.1, 0.2, 0.3], gyro: [1.0, 2.0, 3.0], acc: [4.0, 5.0, 9.81] };
        let motor = |mode| MotorState {
            mode,
            q: 0.5,
            dq: 1.5,
            ddq: 2.5,
            tau_est: 3.5,
            temperature: -4,
            lost: 9,
            reserve: [10, 500],
        };
        write(
            folder,
            &LowState { imu_state, motor_state_parallel: vec![motor(1)], motor_state_serial: vec![motor(2), motor(3)] },
        );
        write(folder, &FallDownState { fall_down_state: 2, is_recovery_available: true });
        write(folder, &RawBytesMsg { msg: vec![2, 1, 8] });
        write(folder, &BatteryState { voltage: 52.0, current: 5.0, soc: 99.0, average_voltage: 51.0 });
        write(folder, &RobotStatesMsg { current_mode: 2, current_body_control: 3, current_actions: vec![1, 5] });
        write(folder, &Clock { clock: Time::of(12.25) });
        let position = Point { x: 1.0, y: 2.0, z: 3.0 };
        write(folder, &Pose { position, orientation: Quaternion { x: 0.1, y: 0.2, z: 0.3, w: 0.9 } });
        let object = DetectedObject {
            label: text("Ball"),
            color: text("white"),
            confidence: 99.0,
            xmin: 1,
            ymin: 2,
            xmax: 3,
            ymax: 4,
            target_uv: vec![5.0, 6.0],
            received_pos: vec![],
            position: vec![1.0, 2.0, 0.0],
            position_projection: vec![1.5, 2.5, 0.0],
            position_cam: vec![0.5],
            position_confidence: 1,
        };
        let detected_objects = vec![object.clone(), DetectedObject { label: text("LCross"), ..object }];
        let (radar_x, radar_y) = (vec![1.0], vec![2.0, 3.0]);
        write(folder, &Detections { header: stamped(), detected_objects, radar_x, radar_y, corner_pos: vec![0.0; 10] });
        write(
            folder,
            &LineSegments { header: stamped(), coordinates: vec![1.0, 2.0, 3.0, 4.0], coordinates_uv: vec![5.0; 4] },
        );
        let (x, y, dir, goal_x) = (1.0, 2.0, 0.5, 6.0);
        write(
            folder,
            &Kick { header: stamped(), x, y, dir, goal_x, goal_y: -1.0, robot_theta_to_field: 0.25, power: 1.5 },
        );
        write(
            folder,
            &CameraInfo {
                header: stamped(),
                height: 360,
                width: 640,
                distortion_model: text("plumb_bob"),
                d: vec![0.1, 0.2, 0.3, 0.4, 0.5],
                k: [300.0, 0.0, 320.0, 0.0, 301.0, 180.0, 0.0, 0.0, 1.0],
                p: [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0],
                roi: RegionOfInterest { x_offset: 1, y_offset: 2, height: 3, width: 4, do_rectify: true },
                ..CameraInfo::default()
            },
        );
        write(folder, &ButtonEventMsg { button: 2, event: 1 });
        let (event, [lx, ly, rx, ry]) = (0x603, [0.1, 0.2, 0.3, 0.4]);
        let remote = RemoteControllerState { event, lx, ly, rx, ry, b: true, start: true, ..Default::default() };
        write(folder, &RemoteControllerState { hat_c: true, reserved: 7, ..remote });
        let data = vec![1, 2, 3, 4, 5, 6];
        write(
            folder,
            &Image { header: stamped(), height: 1, width: 2, encoding: text("rgb8"), is_bigendian: 0, step: 6, data },
        );
    }

    #[test]
    fn times_have_whole_seconds_and_nanoseconds() {
        assert_eq!(Time::of(12.25), Time { sec: 12, nanosec: 250_000_000 });
        assert_eq!(Time::of(0.999_999_999_9), Time { sec: 1, nanosec: 0 });
    }
}
