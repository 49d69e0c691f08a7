//! Actions of agents as arrays, and their translation to commands.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::gaze;
use super::state::ball_of;
use crate::agents::RobotCommand;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::kick_geometry::{KickType, Side};
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::robot::head::{HeadCommand, HeadLimits};
use naoisis_core::robot::kick::{KickRequest, KickSettings};
use naoisis_core::robot::motion::{MotionSettings, WalkCommand};
use naoisis_core::robot::posture::PostureRequest;
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::Belief;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::field_of_view::FieldOfView;
use naoisis_sensing::sensing::scene::SensesNothing;
use naoisis_sensing::sensing::status::BodyStatus;
use naoisis_sensing::sensing::vision::Percepts;
use naoisis_sim::teams::Head;

/// The kinds of actions.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ActionKind {
    /// Eight numbers from -1 to 1: see [`CONTINUOUS`].
    #[default]
    Continuous,
    /// Three choices: a walk, a direction to look, and a kick: see [`WALKS`], [`LOOKS`] and [`KICKS`].
    MultiDiscrete,
    /// One choice: a walk or a kick. The head looks at the ball, and searches for it while it is not seen. Without vision, the head looks at
    /// the true ball.
    Discrete,
    /// Four choices: speed forwards, sideways, of turning, and a kick: see [`AHEAD`], [`ASIDE`], [`TURNS`] and
    /// [`KICKS`]. The head looks at the ball, and at the goals when the robot needs landmarks. Without vision, the head looks at the true
    /// ball.
    Velocities,
}

/// The numbers of a continuous action, each from -1 to 1, with their meaning.
pub const CONTINUOUS: [(&str, &str); 8] = [
    ("walk.forward", "fraction of the greatest speed, forward"),
    ("walk.left", "fraction of the greatest speed, to the left"),
    ("walk.turn", "fraction of the greatest turning speed, counter-clockwise"),
    ("head.yaw", "target of the head: from its greatest yaw to the right to its greatest yaw to the left"),
    ("head.pitch", "target of the head: from its uppermost to its lowest pitch"),
    ("kick.speed", "above 0.5 the robot kicks, with a speed from 0 at 0.5 to 1 at 1"),
    ("kick.foot", "the foot that kicks: below 0 the right one, else the left one"),
    ("kick.side", "the kick: above 0 to the side, else straight"),
];

/// Walks by name, as fractions of the greatest speeds: forward, to the left, turning.
pub const WALKS: [(&str, [f32; 3]); 9] = [
    ("stand", [0.0, 0.0, 0.0]),
    ("forward", [1.0, 0.0, 0.0]),
    ("backward", [-1.0, 0.0, 0.0]),
    ("left", [0.0, 1.0, 0.0]),
    ("right", [0.0, -1.0, 0.0]),
    ("turn_left", [0.0, 0.0, 1.0]),
    ("turn_right", [0.0, 0.0, -1.0]),
    ("forward_turn_left", [1.0, 0.0, 0.5]),
    ("forward_turn_right", [1.0, 0.0, -0.5]),
];

/// The fraction of the greatest speed for slow motions.
const SLOWLY: f32 = 0.3;

/// Forward speeds by name, as fractions of the greatest one.
pub const AHEAD: [(&str, f32); 5] =
    [("stay", 0.0), ("forward", 1.0), ("backward", -1.0), ("slowly_forward", SLOWLY), ("slowly_backward", -SLOWLY)];

/// Speeds to the left by name, as fractions of the greatest one.
pub const ASIDE: [(&str, f32); 5] =
    [("stay", 0.0), ("left", 1.0), ("right", -1.0), ("slowly_left", SLOWLY), ("slowly_right", -SLOWLY)];

/// Turning speeds by name, counter-clockwise, as fractions of the greatest one.
pub const TURNS: [(&str, f32); 5] = [
    ("straight", 0.0),
    ("turn_left", 1.0),
    ("turn_right", -1.0),
    ("turn_slowly_left", SLOWLY),
    ("turn_slowly_right", -SLOWLY),
];

/// Directions of the head by name: yaw and pitch, deg. `None` keeps the current direction.
pub const LOOKS: [(&str, Option<[f32; 2]>); 5] = [
    ("stay", None),
    ("ahead", Some([0.0, 0.0])),
    ("left", Some([60.0, 0.0])),
    ("right", Some([-60.0, 0.0])),
    ("down", Some([0.0, 25.0])),
];

/// Kicks by name.
pub const KICKS: [(&str, Option<KickType>); 5] = [
    ("no_kick", None),
    ("left_straight", Some(KickType::LeftStraight)),
    ("right_straight", Some(KickType::RightStraight)),
    ("left_side", Some(KickType::LeftSide)),
    ("right_side", Some(KickType::RightSide)),
];

/// The error that a number is not valid in an action.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("the action has {value} for {name}; expected {expected}")]
pub struct NotAnAction {
    /// The name of the number.
    name: String,
    /// Its value.
    value: f32,
    /// The valid values.
    expected: String,
}

naoisis_core::debug_as_displayed!(NotAnAction);

impl NotAnAction {
    pub(super) fn new(name: &str, value: f32, expected: String) -> Self {
        Self { name: name.to_owned(), value, expected }
    }
}

impl ActionKind {
    /// The number of values of an action.
    pub fn len(self) -> usize {
        match self {
            ActionKind::Continuous => CONTINUOUS.len(),
            ActionKind::MultiDiscrete => 3,
            ActionKind::Velocities => 4,
            ActionKind::Discrete => 1,
        }
    }

    /// Whether an action has no values; always false.
    pub fn is_empty(self) -> bool {
        self.len() == 0
    }

    /// The names of the values of a continuous action, or of the choices, one list per choice.
    pub fn names(self) -> Vec<Vec<&'static str>> {
        let kicks = || KICKS.iter().map(|(name, _)| *name);
        let speeds = |speeds: &[(&'static str, f32)]| speeds.iter().map(|(name, _)| *name).collect();
        match self {
            ActionKind::Continuous => vec![CONTINUOUS.iter().map(|(name, _)| *name).collect()],
            ActionKind::MultiDiscrete => vec![
                WALKS.iter().map(|(name, _)| *name).collect(),
                LOOKS.iter().map(|(name, _)| *name).collect(),
                kicks().collect(),
            ],
            ActionKind::Discrete => vec![WALKS.iter().map(|(name, _)| *name).chain(kicks().skip(1)).collect()],
            ActionKind::Velocities => vec![speeds(&AHEAD), speeds(&ASIDE), speeds(&TURNS), kicks().collect()],
        }
    }

    /// Checks that `action` is valid.
    ///
    /// # Errors
    /// The first value that is not valid.
    pub fn check(self, action: &[f32]) -> Result<(), NotAnAction> {
        if self == ActionKind::Continuous {
            // A number beyond the range is clamped to its end.
            let fault = action.iter().zip(CONTINUOUS.iter().cycle()).find(|(value, _)| !value.is_finite());
            return fault.map_or(Ok(()), |(value, (name, _))| {
                Err(NotAnAction::new(name, *value, "a number from -1 to 1".to_owned()))
            });
        }
        for (index, (&value, choices)) in action.iter().zip(self.names().iter().cycle()).enumerate() {
            if !(0.0..choices.len() as f32).contains(&value) || value.fract() != 0.0 {
                let expected = format!("a whole number from 0 to {}", choices.len().saturating_sub(1));
                return Err(NotAnAction::new(&format!("choice {}", index % self.len() + 1), value, expected));
            }
        }
        Ok(())
    }
}

/// The kick that a robot uses for one of the paper's four kicks: a robot without a straight kick uses its kick with the longest range.
pub(super) fn available_kick(kick_type: KickType, kicks: &KickSettings) -> KickType {
    match kicks.get(kick_type) {
        None if !kick_type.is_side_kick() => kicks.strongest().unwrap_or(kick_type),
        _ => kick_type,
    }
}

/// The command of a [checked](ActionKind::check) action for a robot.
pub(crate) fn command(kind: ActionKind, action: &[f32], world: &World, id: RobotId) -> RobotCommand {
    let robot = world.resource::<Roster>().get(id).and_then(|entity| world.get_entity(entity).ok());
    let Some(robot) = robot else { return RobotCommand::default() };
    let clock = world.resource::<CycleClock>();
    if robot.get::<BodyStatus>() == Some(&BodyStatus::Fallen) {
        // The robot can do nothing else, and there is nothing to learn in getting up.
        return RobotCommand { posture: Some(PostureRequest::GetUp), ..default() };
    }
    let motion = robot.get::<MotionSettings>().copied().unwrap_or_default();
    let head = robot.get::<HeadLimits>().copied().unwrap_or_default();
    let walk = |[forward, left, turn]: [f32; 3]| {
        let [forward, left] = [forward, left].map(|share| share * motion.max_linear_mps);
        Some(WalkCommand::at_velocity(forward, left, turn * motion.max_angular, clock))
    };
    let kick = |kick_type, speed| {
        let available = robot.get::<KickSettings>().map(|kicks| available_kick(kick_type, kicks));
        Some(KickRequest::new(available.unwrap_or(kick_type), speed))
    };
    let choice = |index: usize| action.get(index).map_or(0, |value| *value as usize);
    match kind {
        ActionKind::Continuous => {
            let &[forward, left, turn, yaw, pitch, speed, foot, side] = action else { return RobotCommand::default() };
            let [forward, left, turn, yaw, pitch, speed] =
                [forward, left, turn, yaw, pitch, speed].map(|number| number.clamp(-1.0, 1.0));
            let within = |[low, high]: [f32; 2], share: f32| low + (high - low) * (share + 1.0) / 2.0;
            let kick_type = match (foot < 0.0, side > 0.0) {
                (true, false) => KickType::RightStraight,
                (false, false) => KickType::LeftStraight,
                (true, true) => KickType::RightSide,
                (false, true) => KickType::LeftSide,
            };
            RobotCommand {
                walk: walk([forward, left, turn]),
                head: Some(HeadCommand { yaw: within(head.yaw, yaw), pitch: within(head.pitch, pitch) }),
                kick: if speed > 0.5 { kick(kick_type, 2.0 * speed - 1.0) } else { None },
                ..default()
            }
        }
        ActionKind::MultiDiscrete => {
            let look = LOOKS.get(choice(1)).and_then(|(_, angles)| *angles);
            RobotCommand {
                walk: WALKS.get(choice(0)).and_then(|(_, shares)| walk(*shares)),
                head: look.map(|angles| angles.map(f32::to_radians)).map(|[yaw, pitch]| HeadCommand { yaw, pitch }),
                kick: KICKS.get(choice(2)).and_then(|(_, kind)| kick((*kind)?, 1.0)),
                ..default()
            }
        }
        ActionKind::Discrete => {
            let (ball, now_s) = (known_ball(&robot, world), clock.start_time_s() as f32);
            let kicked = choice(0).checked_sub(WALKS.len()).and_then(|index| KICKS.get(index + 1));
            RobotCommand {
                walk: WALKS.get(choice(0)).and_then(|(_, shares)| walk(*shares)),
                head: Some(gaze::at_what_is_seen(&head_of(&robot), ball, now_s)),
                kick: kicked.and_then(|(_, kind)| kick((*kind)?, 1.0)),
                ..default()
            }
        }
        ActionKind::Velocities => {
            let share = |speeds: &[(&str, f32)], index| speeds.get(choice(index)).map_or(0.0, |(_, share)| *share);
            let now_s = clock.start_time_s() as f32;
            let head = match robot.get::<Belief>() {
                Some(belief) => gaze::at_what_is_believed(&head_of(&robot), belief, world.resource::<Pitch>(), now_s),
                None => gaze::at_what_is_seen(&head_of(&robot), known_ball(&robot, world), now_s),
            };
            RobotCommand {
                walk: walk([share(&AHEAD, 0), share(&ASIDE, 1), share(&TURNS, 2)]),
                head: Some(head),
                kick: KICKS.get(choice(3)).and_then(|(_, kind)| kick((*kind)?, 1.0)),
                ..default()
            }
        }
    }
}

/// The continuous action that is nearest to a command of a robot. Its kick is one of the paper's four kicks: any other kick, and one in
/// walking, is the straight kick of the same foot.
pub(super) fn continuous(command: &RobotCommand, world: &World, id: RobotId) -> [f32; CONTINUOUS.len()] {
    let robot = world.resource::<Roster>().get(id).and_then(|entity| world.get_entity(entity).ok());
    let motion = robot.and_then(|robot| robot.get::<MotionSettings>().copied()).unwrap_or_default();
    let head_limits = robot.and_then(|robot| robot.get::<HeadLimits>().copied()).unwrap_or_default();
    let period_s = world.resource::<CycleClock>().period();
    let share = |step: f32, greatest: f32| (step / (greatest * period_s)).clamp(-1.0, 1.0);
    let walk = command.walk.unwrap_or_default();
    let target = |[low, high]: [f32; 2], angle: f32| (2.0 * (angle - low) / (high - low) - 1.0).clamp(-1.0, 1.0);
    let head = command.head.unwrap_or_default();
    let [speed, foot, side] = command.kick.map_or([0.0; 3], |kick| {
        let sign = |is: bool| if is { 1.0 } else { -1.0 };
        let KickRequest { kick_type, speed, .. } = kick;
        [(1.0 + speed.clamp(0.01, 1.0)) / 2.0, sign(kick_type.foot() == Side::Left), sign(kick_type.is_side_kick())]
    });
    [
        share(walk.dx, motion.max_linear_mps),
        share(walk.dy, motion.max_linear_mps),
        share(walk.dtheta, motion.max_angular),
        target(head_limits.yaw, head.yaw),
        target(head_limits.pitch, head.pitch),
        speed,
        foot,
        side,
    ]
}

/// The head of a robot, for the functions that aim it.
fn head_of(robot: &EntityRef) -> Head {
    let limits = robot.get::<HeadLimits>().copied().unwrap_or_default();
    Head::new(&limits, robot.get::<CameraSettings>().map_or_else(FieldOfView::default, FieldOfView::of))
}

/// The position at which a robot sees the ball, robot frame, m; the true position if the robot senses nothing.
fn known_ball(robot: &EntityRef, world: &World) -> Option<Vec2> {
    if robot.contains::<SensesNothing>() {
        return Some(robot.get::<Pose>()?.inverse_transform_point(ball_of(world)?.0));
    }
    robot.get::<Percepts>().and_then(|percepts| percepts.ball).map(|ball| ball.position_m)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_action_has_a_name_for_each_number_and_each_choice() {
        for kind in [ActionKind::Continuous, ActionKind::MultiDiscrete, ActionKind::Discrete, ActionKind::Velocities] {
            let names = kind.names();
            assert_eq!(if kind == ActionKind::Continuous { names[0].len() } else { names.len() }, kind.len());
            assert_eq!(kind.check(&vec![0.0; kind.len()]), Ok(()));
        }
        assert_eq!(ActionKind::Discrete.names()[0].len(), 13);
        assert_eq!(ActionKind::Velocities.names().iter().map(Vec::len).collect::<Vec<_>>(), [5; 4]);
    }

    #[test]
    fn what_is_no_action_is_refused_by_name() {
        let error = ActionKind::Continuous.check(&[0.0, 0.0, 0.0, 0.0, f32::NAN, 0.0, 0.0, 0.0]).unwrap_err();
        assert_eq!(error.to_string(), "the action has NaN for head.pitch; expected a number from -1 to 1");
        assert!(ActionKind::Discrete.check(&[13.0]).is_err() && ActionKind::Discrete.check(&[12.0]).is_ok());
        assert!(ActionKind::MultiDiscrete.check(&[0.5, 0.0, 0.0]).is_err());
        assert!(ActionKind::MultiDiscrete.check(&[8.0, 4.0, 4.0]).is_ok());
        assert!(ActionKind::MultiDiscrete.check(&[0.0, 5.0, 0.0]).is_err());
        assert!(ActionKind::Velocities.check(&[4.0; 4]).is_ok() && ActionKind::Velocities.check(&[5.0; 4]).is_err());
    }
}
