//! Controls a robot by the keyboard or a gamepad, in place of its behaviour.
//!
//! Keys and gamepads are read once per frame, and replace the commands of the behaviour once per cycle. The limits and errors of
//! walking, the duration of kicks and the rules are those of every robot.

use bevy::ecs::query::QueryData;
use bevy::prelude::*;
use bevy_egui::EguiContext;
use bevy_egui::egui::Popup;
use bevy_egui::input::EguiWantsInput;

use crate::viewer::camera::ViewerCamera;
use crate::viewer::commands::ViewPreset;
use crate::viewer::keyframes::Keyframes;
use crate::viewer::shared::{DRIVEN, KeysSystems, Notice, Selection};
use naoisis_core::behaviour::DecideSystems;
use naoisis_core::behaviour::drawings::Drawings;
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::{Cycle, CycleClock, CycleSystems};
use naoisis_core::kick_geometry::KickType;
use naoisis_core::robot::Roster;
use naoisis_core::robot::head::{HeadAngles, HeadCommand, HeadLimits};
use naoisis_core::robot::kick::{KickCommand, KickRequest, KickSettings};
use naoisis_core::robot::motion::{MotionSettings, WalkCommand};
use naoisis_core::team::RobotId;

/// The speed of the head, as a fraction of its greatest; slow enough to aim.
const HEAD_SHARE: f32 = 0.3;

/// Drives a robot.
pub(super) struct DrivingPlugin;

impl Plugin for DrivingPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Driving>()
            .add_systems(Update, (change_robot, read_driver, read_gamepads).chain().after(KeysSystems))
            .add_systems(Cycle, drive.in_set(CycleSystems::Decide).after(DecideSystems::Behave));
    }
}

/// The robot that is driven, and the state of the keys.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Default)]
pub struct Driving {
    /// The robot, if any.
    pub robot: Option<RobotId>,
    /// What the keys ask for.
    wish: Wish,
    /// The camera before driving, and the robot that was selected.
    view: Option<ViewerCamera>,
    selected: Option<RobotId>,
}

/// What the keys ask for.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
struct Wish {
    /// Forward, left, counter-clockwise: -1 to 1.
    walk: Vec3,
    /// Left, down: -1 to 1.
    head: Vec2,
    /// Whether to look straight ahead.
    look_ahead: bool,
    /// The kick to start, kept until a cycle has started it.
    kick: Option<DrivenKick>,
}

/// Returns the keys and their meanings, for the help, for a robot with so many kicks of its model.
pub fn keys(own_kicks: usize) -> impl Iterator<Item = (&'static str, &'static str)> {
    let own = ["", "5", "5 6", "5 6 7"][own_kicks.min(3)];
    let [before, after] = [&KEYS[..KEYS_OF_ROBOT], &KEYS[KEYS_OF_ROBOT..]];
    let own = (!own.is_empty()).then_some((own, "Kicks of the model"));
    before.iter().copied().chain(own).chain(after.iter().copied())
}

/// The number of keys that move a robot.
const KEYS_OF_ROBOT: usize = 6;

const KEYS: [(&str, &str); 9] = [
    ("W A S D", "Walk"),
    ("Q E", "Turn"),
    ("I J K L", "Turn the head"),
    ("U", "Look ahead"),
    ("1 2", "Kick straight, left or right foot"),
    ("3 4", "Kick to the side"),
    ("F4 F5", "From behind, through its camera"),
    ("Tab", "Another robot"),
    ("Esc", "Leave"),
];

/// A kick that a key stands for, independent of the robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum DrivenKick {
    /// One of the paper's four kicks.
    OfPaper(KickType),
    /// The kick at this index among the robot's own, sorted by name.
    Own(usize),
}

impl DrivenKick {
    /// The request for a robot with these `kicks`, with the head turned by `yaw` to the left, radians; `None` for a
    /// kick that it does not have.
    fn request(self, kicks: &KickSettings, yaw: f32) -> Option<KickRequest> {
        let kick_type = match self {
            DrivenKick::OfPaper(kick_type) => kick_type,
            DrivenKick::Own(index) => KickType::Custom((*kicks.own).get(index)?.0),
        };
        let aims = kicks.geometry(kick_type).is_some_and(|geometry| geometry.aims_within() > 0.0);
        Some(KickRequest { direction: if aims { yaw } else { 0.0 }, ..KickRequest::new(kick_type, 1.0) })
    }
}

/// The keys of kicks.
const KICKS: [(KeyCode, DrivenKick); 7] = [
    (KeyCode::Digit1, DrivenKick::OfPaper(KickType::LeftStraight)),
    (KeyCode::Digit2, DrivenKick::OfPaper(KickType::RightStraight)),
    (KeyCode::Digit3, DrivenKick::OfPaper(KickType::LeftSide)),
    (KeyCode::Digit4, DrivenKick::OfPaper(KickType::RightSide)),
    (KeyCode::Digit5, DrivenKick::Own(0)),
    (KeyCode::Digit6, DrivenKick::Own(1)),
    (KeyCode::Digit7, DrivenKick::Own(2)),
];

/// The buttons of gamepads for kicks.
const GAMEPAD_KICKS: [(GamepadButton, DrivenKick); 6] = [
    (GamepadButton::West, DrivenKick::OfPaper(KickType::LeftStraight)),
    (GamepadButton::South, DrivenKick::OfPaper(KickType::RightStraight)),
    (GamepadButton::North, DrivenKick::OfPaper(KickType::LeftSide)),
    (GamepadButton::East, DrivenKick::OfPaper(KickType::RightSide)),
    (GamepadButton::LeftTrigger, DrivenKick::Own(0)),
    (GamepadButton::RightTrigger, DrivenKick::Own(1)),
];

/// The keys that have another meaning while a robot is driven.
const TAKEN: [KeyCode; 18] = {
    use KeyCode::{
        Digit1, Digit2, Digit3, Digit4, Digit5, Digit6, Digit7, KeyA, KeyD, KeyE, KeyI, KeyJ, KeyK, KeyL, KeyQ, KeyS,
        KeyU, KeyW,
    };
    [
        KeyW, KeyA, KeyS, KeyD, KeyQ, KeyE, KeyI, KeyJ, KeyK, KeyL, KeyU, Digit1, Digit2, Digit3, Digit4, Digit5,
        Digit6, Digit7,
    ]
};

impl Driving {
    /// Returns whether the key currently drives a robot.
    pub fn takes(&self, key: KeyCode) -> bool {
        self.robot.is_some() && (TAKEN.contains(&key) || key == KeyCode::Escape)
    }
}

/// Starts driving the selected robot, through its camera, or stops it.
pub(super) fn toggle(world: &mut World) {
    if world.resource::<Driving>().robot.is_some() {
        stop(world);
        return;
    }
    let chosen = world.resource::<Selection>().0;
    let Some(robot) = chosen.or_else(|| world.resource::<Roster>().iter().next().map(|(id, _)| id)) else {
        world.resource_mut::<Notice>().tell("This scenario has no robots");
        return;
    };
    let view = world.query::<&ViewerCamera>().iter(world).next().copied();
    *world.resource_mut::<Driving>() = Driving { robot: Some(robot), wish: Wish::default(), view, selected: chosen };
    world.resource_mut::<Selection>().0 = Some(robot);
    world.write_message(ViewPreset::RobotCamera(CameraName::TOP));
}

fn stop(world: &mut World) {
    let before = core::mem::take(&mut *world.resource_mut::<Driving>());
    if let (Some(view), Some(mut camera)) = (before.view, world.query::<&mut ViewerCamera>().iter_mut(world).next()) {
        *camera = view;
    }
    // A robot that was selected for driving only is deselected: the view before fits the window without its panel.
    if before.selected.is_none() {
        world.resource_mut::<Selection>().0 = None;
    }
}

/// Stops driving when the match no longer has the robot, and follows the selection to another robot.
fn change_robot(world: &mut World) {
    let Some(robot) = world.resource::<Driving>().robot else { return };
    let leaves = world.resource::<ButtonInput<KeyCode>>().just_pressed(KeyCode::Escape);
    // The key closes a menu first.
    let has_menu =
        world.query::<&mut EguiContext>().iter_mut(world).any(|mut context| Popup::is_any_open(context.get_mut()));
    let leaves = leaves && !has_menu;
    // A click that hits no robot does not end driving.
    let selected = *world.resource_mut::<Selection>().0.get_or_insert(robot);
    if leaves || world.resource::<Roster>().get(selected).is_none() {
        stop(world);
    } else if selected != robot {
        let mut driving = world.resource_mut::<Driving>();
        (driving.robot, driving.wish) = (Some(selected), Wish::default());
    }
}

fn read_driver(keys: Res<ButtonInput<KeyCode>>, panels: Option<Res<EguiWantsInput>>, mut driving: ResMut<Driving>) {
    if driving.robot.is_none() {
        return;
    }
    // Keys typed into a panel are not for the robot: it stands meanwhile.
    if panels.is_some_and(|panels| panels.wants_any_keyboard_input()) {
        driving.wish = Wish::default();
        return;
    }
    let kick = KICKS.iter().find(|(key, _)| keys.just_pressed(*key)).map(|(_, kick)| *kick);
    driving.wish = Wish { kick: kick.or(driving.wish.kick), ..wish(|key| keys.pressed(key)) };
}

/// Adds what gamepads ask for.
fn read_gamepads(gamepads: Query<&Gamepad>, mut driving: ResMut<Driving>) {
    if driving.robot.is_none() {
        return;
    }
    for gamepad in &gamepads {
        let asked = gamepad_wish(gamepad);
        let wish = &mut driving.wish;
        wish.walk = (wish.walk + asked.walk).clamp(Vec3::NEG_ONE, Vec3::ONE);
        wish.head = (wish.head + asked.head).clamp(Vec2::NEG_ONE, Vec2::ONE);
        wish.look_ahead |= asked.look_ahead;
        wish.kick = asked.kick.or(wish.kick);
    }
}

/// What a gamepad asks for: the left stick walks, the right one turns, the directional pad turns the head.
fn gamepad_wish(gamepad: &Gamepad) -> Wish {
    let (walk, turn, head) = (gamepad.left_stick(), gamepad.right_stick(), gamepad.dpad());
    Wish {
        walk: Vec3::new(walk.y, -walk.x, -turn.x),
        head: -head,
        look_ahead: gamepad.pressed(GamepadButton::RightThumb),
        kick: GAMEPAD_KICKS.iter().find(|(button, _)| gamepad.just_pressed(*button)).map(|(_, kick)| *kick),
    }
}

/// The state of the keys, except for kicks.
fn wish(is_pressed: impl Fn(KeyCode) -> bool) -> Wish {
    let axis = |plus, minus| f32::from(u8::from(is_pressed(plus))) - f32::from(u8::from(is_pressed(minus)));
    Wish {
        walk: Vec3::new(
            axis(KeyCode::KeyW, KeyCode::KeyS),
            axis(KeyCode::KeyA, KeyCode::KeyD),
            axis(KeyCode::KeyQ, KeyCode::KeyE),
        ),
        head: Vec2::new(axis(KeyCode::KeyJ, KeyCode::KeyL), axis(KeyCode::KeyK, KeyCode::KeyI)),
        look_ahead: is_pressed(KeyCode::KeyU),
        kick: None,
    }
}

/// The components of a driven robot.
#[derive(QueryData)]
#[query_data(mutable)]
struct Driven {
    angles: &'static HeadAngles,
    head: &'static HeadLimits,
    motion: &'static MotionSettings,
    kicks: &'static KickSettings,
    walk: &'static mut WalkCommand,
    look: &'static mut HeadCommand,
    kick: &'static mut KickCommand,
    drawings: Option<&'static mut Drawings>,
}

/// Replaces the commands of the behaviour, and its plans, which the robot does not follow.
fn drive(
    clock: Res<CycleClock>,
    roster: Res<Roster>,
    keyframes: Res<Keyframes>,
    mut driving: ResMut<Driving>,
    mut robots: Query<Driven>,
    mut remarks: Query<(Entity, &mut Remarks)>,
    mut commands: Commands,
) {
    let driven = driving.robot.and_then(|robot| roster.get(robot));
    let are_left =
        |(of, remarks): &(Entity, Mut<Remarks>)| Some(*of) != driven && remarks.intention.as_deref() == Some(DRIVEN);
    remarks.iter_mut().filter(are_left).for_each(|(_, mut remarks)| remarks.intention = None);
    let Some(entity) = driven else { return };
    let Ok(mut robot) = robots.get_mut(entity) else { return };
    let intention = Some(DRIVEN.to_owned());
    match remarks.get_mut(entity) {
        Ok((_, mut remarks)) => remarks.intention = intention,
        Err(_) => drop(commands.entity(entity).insert(Remarks { intention, ..default() })),
    }
    if let Some(mut drawings) = robot.drawings {
        *drawings = Drawings::default();
    }
    // When the match is played again, nobody drives the robot, so this is noted as a change.
    keyframes.note_change();
    let wish = driving.wish;
    *robot.walk = walk_command(wish.walk, robot.motion, clock.period());
    *robot.look = head_command(&wish, *robot.angles, robot.head, clock.period());
    robot.kick.0 = wish.kick.and_then(|kick| kick.request(robot.kicks, robot.angles.yaw));
    driving.wish.kick = None;
}

/// The displacement of a cycle for what is asked for.
fn walk_command(walk: Vec3, motion: &MotionSettings, period: f32) -> WalkCommand {
    let step = motion.max_linear_mps * period * walk.truncate().clamp_length_max(1.0);
    WalkCommand::new(step.x, step.y, motion.max_angular * period * walk.z)
}

/// The command of the head in a cycle for the state of the keys.
fn head_command(wish: &Wish, angles: HeadAngles, limits: &HeadLimits, period: f32) -> HeadCommand {
    if wish.look_ahead {
        return HeadCommand::default();
    }
    let step = HEAD_SHARE * limits.max_speed * period * wish.head;
    HeadCommand { yaw: angles.yaw + step.x, pitch: angles.pitch + step.y }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use approx::assert_abs_diff_eq;
    use naoisis_sim::scenario::Scenario;

    /// Drives in an app without a window.
    pub fn add_without_panels(app: &mut App) {
        app.init_resource::<Driving>()
            .add_systems(Update, (change_robot, read_driver).chain())
            .add_systems(Cycle, drive.in_set(CycleSystems::Decide).after(DecideSystems::Behave));
    }

    #[test]
    fn keys_that_contradict_each_other_cancel_and_diagonals_are_no_faster() {
        assert_eq!(wish(|_| true).walk, Vec3::ZERO);
        let keys = [KeyCode::KeyW, KeyCode::KeyD];
        let command = walk_command(wish(|key| keys.contains(&key)).walk, &MotionSettings::default(), 0.1);
        assert_abs_diff_eq!(command.translation().length(), 0.02, epsilon = 1e-6);
        assert!(command.dx > 0.0 && command.dy < 0.0 && command.dtheta == 0.0);
    }

    #[test]
    fn a_stick_that_is_half_way_walks_at_half_the_speed() {
        let mut gamepad = Gamepad::default();
        gamepad.analog_mut().set(GamepadAxis::LeftStickY, 0.5);
        gamepad.analog_mut().set(GamepadAxis::RightStickX, 1.0);
        gamepad.analog_mut().set(GamepadButton::DPadLeft, 1.0);
        gamepad.digital_mut().press(GamepadButton::South);
        let wish = gamepad_wish(&gamepad);
        let motion = MotionSettings { max_linear_mps: 0.2, ..default() };
        let command = walk_command(wish.walk, &motion, 0.1);
        assert_abs_diff_eq!(command.dx, 0.01, epsilon = 1e-6);
        // A stick to the right turns clockwise, the pad to the left turns the head to the left.
        assert!(command.dtheta < 0.0 && wish.head.x == 1.0);
        assert_eq!(wish.kick, Some(DrivenKick::OfPaper(KickType::RightStraight)));
    }

    #[test]
    fn the_head_turns_from_where_it_is() {
        let angles = HeadAngles { yaw: 0.5, pitch: 0.1 };
        let limits = HeadLimits { max_speed: 2.0, ..default() };
        let left = head_command(&wish(|key| key == KeyCode::KeyJ), angles, &limits, 0.1);
        assert_abs_diff_eq!(left.yaw, 0.56, epsilon = 1e-6);
        assert_eq!(left.pitch, 0.1);
        assert_eq!(head_command(&wish(|key| key == KeyCode::KeyU), angles, &limits, 0.1), HeadCommand::default());
    }

    #[test]
    fn the_kicks_of_a_model_have_keys_and_go_where_the_robot_looks() {
        let aimed = r#"{ "kicks": { "own": { "visual": { "region": { "x_m": [0.1, 0.3], "y_m": [-0.1, 0.1],
            "foot_m": [0.1, 0], "best_m": [0.2, 0], "direction": { "chosen": { "most_deg": 45 } } } } } } }"#;
        let kicks = Scenario::from_json(aimed).unwrap().settings.kicks;
        let visual = DrivenKick::Own(0).request(&kicks, -0.4).unwrap();
        assert_eq!((visual.kick_type.name(), visual.direction), ("visual", -0.4));
        let straight = DrivenKick::OfPaper(KickType::LeftStraight);
        assert_eq!(straight.request(&kicks, -0.4), Some(KickRequest::new(KickType::LeftStraight, 1.0)));
        assert_eq!(DrivenKick::Own(1).request(&kicks, 0.0), None);
    }

    #[test]
    fn every_key_that_drives_is_taken() {
        for (key, _) in KICKS {
            assert!(TAKEN.contains(&key));
        }
        for key in TAKEN {
            let kicks = KICKS.iter().any(|(kick, _)| *kick == key);
            assert!(kicks || wish(|pressed| pressed == key) != Wish::default(), "{key:?} does nothing");
        }
    }
}
