//! What a Booster's own software does with the requests of a program: it keeps its mode and what the program wants, answers, and moves the
//! robot.
//!
//! Modes and numbers are those of Booster's SDK 1.7. The maker documents the codes of answers, but not which request is refused in which
//! mode: these refusals are the simulator's (see [`Firmware::request`]).

use bevy::prelude::*;
use core::mem;
use serde_json::{Value, json};
use std::collections::BTreeSet;

use crate::visual_kick::{self, Aim};
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::{Pose, wrap_angle};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::head::{HeadAngles, HeadCommand};
use naoisis_core::robot::kick::{KickRequest, KickSettings};
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::robot::posture::PostureRequest;
use naoisis_sensing::sensing::buttons::ButtonReadings;
use naoisis_sensing::sensing::imu::ImuReading;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sim::interface::vocabulary::RobotCommand;

/// The speed of the head after `RotateHeadWithDirection`, rad/s. A guess: the maker does not print it.
const HEAD_RADPS: f32 = 0.5;

/// The codes of answers, named as in the SDK.
pub mod status {
    /// Done, or begun.
    pub const SUCCESS: i64 = 0;
    /// The parameters of the request are wrong.
    pub const BAD_REQUEST: i64 = 400;
    /// The state of the robot does not allow the request.
    pub const CONFLICT: i64 = 409;
    /// The simulated robot cannot do this.
    pub const SERVER_REFUSED: i64 = 501;
    /// The robot cannot change into this state.
    pub const STATE_TRANSITION_FAILED: i64 = 502;
}

/// The mode of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub enum Mode {
    /// The motors only damp. The simulated robot stands.
    Damping = 0,
    /// It stands.
    Prepare = 1,
    /// It walks as it is told to.
    #[default]
    Walking = 2,
    /// As walking, with the gait for soccer.
    Soccer = 4,
}

impl Mode {
    fn of(number: i64) -> Option<Self> {
        [Mode::Damping, Mode::Prepare, Mode::Walking, Mode::Soccer].into_iter().find(|mode| *mode as i64 == number)
    }

    fn walks(self) -> bool {
        matches!(self, Mode::Walking | Mode::Soccer)
    }
}

/// Where the head goes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) enum HeadWish {
    At(HeadAngles),
    /// In this direction of yaw and pitch, -1, 0 or 1, until told otherwise.
    Turning(Vec2),
    /// To these angles within this time, s.
    Within(HeadAngles, f32),
}

/// The software of one robot.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct Firmware {
    /// The robot's name, such as `blue1`.
    pub name: String,
    /// The name of its model, such as `booster_k1`.
    pub model: String,
    /// What it knew of its body in the last cycle.
    pub body: BodyStatus,
    /// Pose by odometry in the last cycle.
    pub odometry: Pose,
    /// Head angles in the last cycle.
    pub head_angles: HeadAngles,
    /// What its inertial unit measured in the last cycle, if it has one.
    pub imu: Option<ImuReading>,
    /// Its buttons in the last cycle.
    pub buttons: ButtonReadings,
    /// The event of the remote controller that has not been sent yet; 0 without one.
    pub remote_event: u32,
    /// The mode.
    pub mode: Mode,
    /// Where the odometer says zero.
    pub(crate) zero: Pose,
    /// Velocity forward and to the left, m/s, and of turning, rad/s.
    pub(crate) velocity: Vec3,
    pub(crate) head: Option<HeadWish>,
    pub(crate) shoot: bool,
    pub(crate) get_up: bool,
    /// The visual kick, if it is on.
    pub(crate) visual_kick: Option<Aim>,
    /// The direction and power that the program told last, for a visual kick that begins later.
    pub(crate) told_aim: Aim,
    /// Requests that were refused, with the codes of their answers, and reported.
    pub(crate) reported: BTreeSet<(i64, i64)>,
}

/// An answer: its code, and its body.
type Answer = Result<Value, i64>;

impl Firmware {
    /// Answers a request with a code and a body:
    ///
    /// | request | 400 | 409 | 501 | 502 |
    /// |---|---|---|---|---|
    /// | `ChangeMode` | there is no such mode | | custom mode (single joints) | the robot lies, gets up or dives |
    /// | `Move`, `VisualKick`, `Shoot` | parameters missing or not finite | in any mode but walking and soccer; the robot lies, gets up or dives; `Move` during a visual kick | | |
    /// | `RotateHead` and variants | parameters missing or not finite | in damping mode | | |
    /// | `GetUp`, `GetUpWithMode` | there is no such mode | | | the robot does not lie |
    /// | `GetMode`, `GetStatus`, `GetRobotInfo`, `ResetOdometry`, `SwitchGait` | parameters wrong | | | |
    /// | anything else | | | always | |
    pub fn request(&mut self, api: i64, body: &str) -> (i64, String) {
        let parameters = if body.trim().is_empty() { Ok(json!({})) } else { serde_json::from_str(body) };
        let answer = parameters.map_err(|_| status::BAD_REQUEST).and_then(|body: Value| self.answer(api, &body));
        if let Err(code) = answer
            && self.reported.insert((api, code))
        {
            warn!("{}: request {api} of a Booster program was answered by {code}: {body}", self.name);
        }
        match answer {
            Ok(Value::Null) => (status::SUCCESS, String::new()),
            Ok(body) => (status::SUCCESS, body.to_string()),
            Err(code) => (code, String::new()),
        }
    }

    fn answer(&mut self, api: i64, body: &Value) -> Answer {
        match api {
            2000 => self.change_mode(whole(body, "mode")?),
            2001 => {
                let velocity = Vec3::new(number(body, "vx")?, number(body, "vy")?, number(body, "vyaw")?);
                self.must_walk()?;
                if self.visual_kick.is_some() {
                    return Err(status::CONFLICT);
                }
                self.velocity = velocity;
                Ok(Value::Null)
            }
            2004 => self.turn_head(HeadWish::At(head(body)?)),
            2006 => {
                let direction = Vec2::new(number(body, "yaw_direction")?, number(body, "pitch_direction")?);
                self.turn_head(HeadWish::Turning(direction.clamp(Vec2::NEG_ONE, Vec2::ONE)))
            }
            2043 => self.turn_head(HeadWish::Within(head(body)?, number(body, "time_millis")?.max(0.0) / 1000.0)),
            2008 => self.rise(self.mode),
            2025 => self.rise(Mode::of(whole(body, "mode")?).ok_or(status::BAD_REQUEST)?),
            2017 => Ok(json!({ "mode": self.mode as i64 })),
            2018 => Ok(json!({
                "current_mode": self.mode as i64, "current_body_control": self.body_control(), "current_actions": [],
            })),
            2022 => Ok(json!({
                "name": self.name, "nickname": self.name, "version": "simulated", "model": self.model,
                "serial_number": self.name, "edition": "naoisis", "region": "",
            })),
            2024 => {
                self.must_walk()?;
                self.shoot = true;
                Ok(Value::Null)
            }
            2031 => {
                let coordinate = |name| if body.get(name).is_none() { Ok(0.0) } else { number(body, name) };
                let told = Pose::new(coordinate("x")?, coordinate("y")?, coordinate("theta")?);
                // The odometer's zero, from which the present pose has these coordinates.
                self.zero = self.odometry.compose(told.relative(Pose::default()));
                Ok(Value::Null)
            }
            2038 => {
                let start = body.get("start").and_then(Value::as_bool).ok_or(status::BAD_REQUEST)?;
                if start {
                    self.must_walk()?;
                }
                self.velocity = Vec3::ZERO;
                self.visual_kick = start.then(|| mem::take(&mut self.told_aim));
                Ok(Value::Null)
            }
            2042 => whole(body, "gait_type").map(|_| Value::Null),
            _ => Err(status::SERVER_REFUSED),
        }
    }
    fn change_mode(&mut self, mode: i64) -> Answer {
        /// The number of custom mode.
        const CUSTOM: i64 = 3;
        let mode = match Mode::of(mode) {
            Some(mode) => mode,
            None if mode == CUSTOM => return Err(status::SERVER_REFUSED),
            None => return Err(status::BAD_REQUEST),
        };
        if mode != Mode::Damping && !self.is_upright() {
            return Err(status::STATE_TRANSITION_FAILED);
        }
        self.mode = mode;
        self.stop();
        Ok(Value::Null)
    }

    fn turn_head(&mut self, wish: HeadWish) -> Answer {
        if self.mode == Mode::Damping {
            return Err(status::CONFLICT);
        }
        self.head = Some(wish);
        Ok(Value::Null)
    }

    fn rise(&mut self, mode: Mode) -> Answer {
        if self.body != BodyStatus::Fallen {
            return Err(status::STATE_TRANSITION_FAILED);
        }
        self.stop();
        (self.get_up, self.mode) = (true, mode);
        Ok(Value::Null)
    }

    fn must_walk(&self) -> Result<(), i64> {
        if self.mode.walks() && self.is_upright() { Ok(()) } else { Err(status::CONFLICT) }
    }

    fn is_upright(&self) -> bool {
        !matches!(self.body, BodyStatus::Fallen | BodyStatus::GettingUp | BodyStatus::Diving)
    }

    /// Forgets what the program wants of the legs.
    pub fn stop(&mut self) {
        (self.velocity, self.shoot, self.get_up, self.visual_kick) = (Vec3::ZERO, false, false, None);
    }

    /// The body control of `GetStatus`.
    pub fn body_control(&self) -> i32 {
        match (self.body, self.mode) {
            (BodyStatus::GettingUp, _) => 7,
            (BodyStatus::Fallen, _) | (_, Mode::Damping) => 1,
            (BodyStatus::Kicking | BodyStatus::Recovering, _) if self.visual_kick.is_none() => 9,
            (_, Mode::Prepare) => 2,
            _ if self.visual_kick.is_some() => 14,
            (_, Mode::Walking) => 3,
            (_, Mode::Soccer) => 5,
        }
    }

    /// The pose that the odometer shows.
    pub fn odometer(&self) -> Pose {
        self.zero.relative(self.odometry)
    }

    /// Keeps the direction in which the program wants the visual kick, radians, robot frame, and its power.
    pub fn aim(&mut self, direction: f32, power: f32) {
        if !(direction.is_finite() && power.is_finite()) {
            return;
        }
        let aim = Aim::new(wrap_angle(self.odometry.heading + direction), power);
        match &mut self.visual_kick {
            Some(kick) => kick.turn_to(aim),
            None => self.told_aim = aim,
        }
    }

    /// What the robot does in this cycle. `ball` is the ball that it sees, m, robot frame.
    pub fn command(&mut self, ball: Option<Vec2>, kicks: &KickSettings, clock: &CycleClock) -> RobotCommand {
        let mut command = RobotCommand { head: self.head_command(clock.period()), ..default() };
        if mem::take(&mut self.get_up) && self.body == BodyStatus::Fallen {
            command.posture = Some(PostureRequest::GetUp);
        }
        if !self.is_upright() || self.body == BodyStatus::Penalised || !self.mode.walks() {
            self.stop();
            return command;
        }
        if let Some(kick) = &mut self.visual_kick {
            if matches!(self.body, BodyStatus::Kicking) {
                // It goes on as it did when the kick began.
                kick.see_in_kick(ball, self.odometry);
            } else {
                let (velocity, request) = visual_kick::act(kick, ball, self.odometry, self.velocity, kicks);
                (self.velocity, command.kick) = (velocity, request.filter(|_| self.body.is_free()));
            }
        }
        let Vec3 { x, y, z } = self.velocity;
        command.walk = Some(WalkCommand::at_velocity(x, y, z, clock));
        if mem::take(&mut self.shoot) {
            let is_left = ball.is_some_and(|ball| ball.y > 0.0);
            let foot = if is_left { KickType::LeftStraight } else { KickType::RightStraight };
            command.kick = Some(KickRequest::new(foot, 1.0));
        }
        command
    }

    fn head_command(&mut self, period_s: f32) -> Option<HeadCommand> {
        let at = |angles: HeadAngles| HeadCommand { yaw: angles.yaw, pitch: angles.pitch };
        match self.head? {
            HeadWish::At(angles) => Some(at(angles)),
            HeadWish::Turning(direction) => {
                let HeadAngles { yaw, pitch } = self.head_angles;
                let step = direction * HEAD_RADPS * period_s;
                Some(HeadCommand { yaw: yaw + step.x, pitch: pitch + step.y })
            }
            HeadWish::Within(angles, left_s) if left_s <= period_s => {
                self.head = Some(HeadWish::At(angles));
                Some(at(angles))
            }
            HeadWish::Within(angles, left_s) => {
                self.head = Some(HeadWish::Within(angles, left_s - period_s));
                let share = period_s / left_s;
                let HeadAngles { yaw, pitch } = self.head_angles;
                Some(HeadCommand { yaw: yaw.lerp(angles.yaw, share), pitch: pitch.lerp(angles.pitch, share) })
            }
        }
    }
}

/// A finite number of a request.
fn number(body: &Value, name: &str) -> Result<f32, i64> {
    let number = body.get(name).and_then(Value::as_f64).ok_or(status::BAD_REQUEST)? as f32;
    if number.is_finite() { Ok(number) } else { Err(status::BAD_REQUEST) }
}

/// A whole number of a request.
fn whole(body: &Value, name: &str) -> Result<i64, i64> {
    body.get(name).and_then(Value::as_i64).ok_or(status::BAD_REQUEST)
}

/// The head angles of a request.
fn head(body: &Value) -> Result<HeadAngles, i64> {
    Ok(HeadAngles { yaw: number(body, "yaw")?, pitch: number(body, "pitch")? })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn standing() -> Firmware {
        Firmware { name: "blue1".to_owned(), ..default() }
    }

    fn walk(firmware: &mut Firmware) -> [f32; 3] {
        let walk = firmware.command(None, &KickSettings::default(), &CycleClock { cycle: 1, period_s: 0.02 }).walk;
        walk.map_or([0.0; 3], |walk| [walk.dx, walk.dy, walk.dtheta])
    }

    #[test]
    fn a_robot_walks_as_it_was_told_last_until_its_mode_changes() {
        let mut robot = standing();
        assert_eq!(robot.request(2001, r#"{"vx":0.5,"vy":-0.1,"vyaw":1.0}"#), (status::SUCCESS, String::new()));
        for _ in 0..2 {
            assert_eq!(walk(&mut robot), [0.01, -0.002, 0.02]);
        }
        assert_eq!(robot.request(2000, r#"{"mode":1}"#).0, status::SUCCESS);
        assert_eq!(walk(&mut robot), [0.0; 3]);
        assert_eq!(robot.request(2001, r#"{"vx":0.5,"vy":0,"vyaw":0}"#).0, status::CONFLICT);
        assert_eq!(robot.request(2017, ""), (status::SUCCESS, r#"{"mode":1}"#.to_owned()));
    }

    #[test]
    fn requests_that_cannot_be_done_are_answered_by_their_codes() {
        let mut robot = standing();
        for (api, body, code) in [
            (2001, r#"{"vx":1}"#, status::BAD_REQUEST),
            (2001, r#"{"vx":"fast","vy":0,"vyaw":0}"#, status::BAD_REQUEST),
            (2001, r#"{"vx":1e300,"vy":0,"vyaw":0}"#, status::BAD_REQUEST),
            (2001, "{", status::BAD_REQUEST),
            (2000, r#"{"mode":7}"#, status::BAD_REQUEST),
            (2000, r#"{"mode":3}"#, status::SERVER_REFUSED),
            (2016, r#"{"dance_id":1}"#, status::SERVER_REFUSED),
            (1, "", status::SERVER_REFUSED),
            (2008, "{}", status::STATE_TRANSITION_FAILED),
        ] {
            assert_eq!(robot.request(api, body), (code, String::new()), "{api} {body}");
        }
    }

    #[test]
    fn a_robot_that_lies_gets_up_once_and_does_nothing_else() {
        let mut robot = Firmware { body: BodyStatus::Fallen, ..standing() };
        assert_eq!(robot.request(2001, r#"{"vx":1,"vy":0,"vyaw":0}"#).0, status::CONFLICT);
        assert_eq!(robot.request(2000, r#"{"mode":2}"#).0, status::STATE_TRANSITION_FAILED);
        assert_eq!(robot.request(2008, r#"{"version":0}"#).0, status::SUCCESS);
        let mut posture = || robot.command(None, &KickSettings::default(), &CycleClock::default()).posture;
        assert_eq!([posture(), posture()], [Some(PostureRequest::GetUp), None]);
    }

    #[test]
    fn the_odometer_is_set_to_any_pose() {
        let mut robot = Firmware { odometry: Pose::new(3.0, -1.0, 2.0), ..standing() };
        for (body, shown) in [("", Pose::default()), (r#"{"x":1.0,"y":2.0,"theta":0.5}"#, Pose::new(1.0, 2.0, 0.5))] {
            assert_eq!(robot.request(2031, body).0, status::SUCCESS);
            let odometer = robot.odometer();
            assert!(odometer.position.distance(shown.position) < 1e-5, "{odometer:?}");
            assert!((odometer.heading - shown.heading).abs() < 1e-5, "{odometer:?}");
        }
    }

    #[test]
    fn the_head_turns_at_once_within_a_time_or_in_a_direction() {
        let mut robot = standing();
        let turn = |robot: &mut Firmware| {
            let head = robot.command(None, &KickSettings::default(), &CycleClock { cycle: 1, period_s: 0.1 }).head;
            let head = head.unwrap_or_default();
            robot.head_angles = HeadAngles { yaw: head.yaw, pitch: head.pitch };
            head.yaw
        };
        robot.request(2004, r#"{"pitch":0.3,"yaw":1.0}"#);
        assert_eq!(turn(&mut robot), 1.0);
        robot.request(2043, r#"{"pitch":0.3,"yaw":0.0,"time_millis":200}"#);
        assert!((turn(&mut robot) - 0.5).abs() < 1e-6);
        assert!(turn(&mut robot).abs() < 1e-6 && turn(&mut robot).abs() < 1e-6);
        robot.request(2006, r#"{"pitch_direction":0,"yaw_direction":1}"#);
        assert!((turn(&mut robot) - 0.05).abs() < 1e-6 && (turn(&mut robot) - 0.1).abs() < 1e-6);
    }
}
