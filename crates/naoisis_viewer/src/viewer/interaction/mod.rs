//! Interaction with the match: the mouse drags, turns and kicks, the keyboard drives a robot, buttons make the referee
//! whistle, penalise and end penalties.
//!
//! All of it uses the [`Intervention`]s of programs and scenarios, or the commands of behaviours, so the rules apply
//! and traces contain it. It takes effect at the end of the next cycle; while the match is paused, pending
//! interventions are drawn on the pitch.

use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;

pub mod aim;
mod asked;
pub mod driving;
pub mod keep;
mod mini_map;
mod panel;
mod referee_menu;
pub mod saved_files;
pub mod undo;

use super::camera::{CameraMouse, ViewerCamera};
use super::commands::HandAction;
use super::layout::mouse_is_for_match;
use super::overlays::{Brush, OverlaySystems};
use super::palette;
use super::pitch_frame::{pitch_from_world, pose_of, world_from_pitch};
use super::selection::{PickTarget, pointed_at};
use super::shared::{CameraSystems, KeysSystems, Notice, OVER, Playback, Selection, SelectionSystems, is_over};
use super::timeline::Timeline;
use aim::{Grip, Held, Sight};
use asked::{asked_ball, asked_pose, words_of};
use naoisis_core::ball::{Ball, BallPhysics};
use naoisis_core::game::{Intervention, Interventions, Penalty, PenaltyReason};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::Pitch;
use naoisis_core::robot::Roster;
use naoisis_core::robot::body::Body;
use naoisis_core::team::RobotId;

/// The tolerance of a click on the ball, which is small on the screen, logical pixels.
const BALL_PIXELS: f32 = 9.0;
/// The least movement of the mouse that is a drag, logical pixels. Less is a click.
const DRAG_PIXELS: f32 = 4.0;
/// The radius of the ring at the target of the ball, m.
const BALL_RING_M: f32 = 0.08;

/// Lets the user take part.
pub struct InteractionPlugin;

impl Plugin for InteractionPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<MouseDrag>()
            .init_resource::<undo::Undo>()
            .init_resource::<Notice>()
            .init_resource::<saved_files::SavedFiles>()
            .add_message::<HandAction>()
            .add_systems(Last, saved_files::tell_of_files)
            .configure_sets(Update, CameraMouse.run_if(|drag: Res<MouseDrag>| !drag.is_dragging()))
            .add_plugins((driving::DrivingPlugin, mini_map::MiniMapPlugin, panel::InteractionPanelPlugin))
            .add_systems(
                Update,
                (take_hold.run_if(mouse_is_for_match), drag_and_let_go, undo::note_marks, apply)
                    .chain()
                    .in_set(InteractionSystems)
                    .after(KeysSystems)
                    .before(SelectionSystems)
                    .before(CameraSystems),
            )
            .add_systems(PostUpdate, draw_intentions.after(OverlaySystems).before(EguiPostUpdateSet::EndPass));
    }
}

/// The systems that apply the user's actions.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct InteractionSystems;

/// The drag of the mouse.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Default)]
pub struct MouseDrag {
    grip: Option<Grip>,
    /// Where the mouse was pressed, logical pixels, and whether it has moved since.
    press: Option<(Vec2, bool)>,
    /// The intervention if the mouse is released now.
    intention: Option<Intervention>,
}

impl MouseDrag {
    /// Returns whether the mouse drags something. The camera does not move then.
    pub fn is_dragging(&self) -> bool {
        self.grip.is_some()
    }
}

/// Whether the present of a match is shown.
fn is_live(timeline: &Timeline) -> bool {
    !timeline.is_past() && !timeline.is_replay()
}

/// Why interventions are not possible now.
fn why_not(timeline: &Timeline) -> &'static str {
    if timeline.is_replay() {
        "A replay cannot be changed: branch from here first (F)"
    } else {
        "The past cannot be changed: go to the present (End), or branch from here (F)"
    }
}

/// Why nothing can be done by hand to the match that is shown, if so. A finished match takes no further cycle, in which an intervention could
/// happen.
fn refusal(world: &World) -> Option<&'static str> {
    let timeline = world.resource::<Timeline>();
    if !is_live(timeline) {
        return Some(why_not(timeline));
    }
    is_over(world.resource(), world.resource(), world.resource()).then_some(OVER)
}

fn sight(camera: (&Camera, &GlobalTransform), cursor: Vec2) -> Option<Sight> {
    let (camera, from) = camera;
    let ray = camera.viewport_to_world(from, cursor).ok()?;
    let to_pitch = pitch_from_world();
    Some(Sight { origin: to_pitch * ray.origin, direction: to_pitch * *ray.direction })
}

fn take_hold(
    buttons: Res<ButtonInput<MouseButton>>,
    keys: Res<ButtonInput<KeyCode>>,
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    (robots, interventions): (Query<(&RobotId, &Transform, &Penalty, &Body)>, Res<Interventions>),
    (balls, timeline): (Query<&Transform, With<Ball>>, Res<Timeline>),
    mut drag: ResMut<MouseDrag>,
) {
    if !buttons.just_pressed(MouseButton::Left) {
        return;
    }
    let Some(cursor) = window.cursor_position() else { return };
    let Some(sight) = sight(*camera, cursor) else { return };
    let shift = keys.any_pressed([KeyCode::ShiftLeft, KeyCode::ShiftRight]);
    let (camera, from) = *camera;
    let is_meant = |(_, centre): &(Pose, Vec3)| {
        let seen = camera.world_to_viewport(from, world_from_pitch() * *centre);
        seen.is_ok_and(|seen| seen.distance(cursor) <= BALL_PIXELS)
    };
    // What is to be put elsewhere when the match goes on is taken at its new place, which is drawn.
    let queue = if is_live(&timeline) { &interventions.queue[..] } else { &[] };
    let height_m = balls.iter().next().map_or(0.0, |ball| ball.translation.z);
    let asked = asked_ball(queue).map(|(place, _)| (Pose { position: place, heading: 0.0 }, place.extend(height_m)));
    let drawn = balls.iter().map(|ball| (pose_of(ball), ball.translation));
    let ball = asked.into_iter().chain(drawn).find(is_meant).map(|(pose, _)| {
        let held = if shift { Held::BallToKick } else { Held::Ball };
        (held, pose, 0.0)
    });
    let on_pitch: Vec<(RobotId, Pose, Body)> = robots
        .iter()
        .filter(|(_, _, penalty, _)| !penalty.is_off_pitch())
        .map(|(id, transform, _, body)| (*id, pose_of(transform), *body))
        .collect();
    let robot = || {
        let asked = on_pitch.iter().filter_map(|(id, _, body)| Some((*id, asked_pose(queue, *id)?, *body)));
        let (id, pose, body) = pointed_robot(&sight, &asked.collect::<Vec<_>>())
            .or_else(|| pointed_robot(&sight, &on_pitch))
            .map(|(id, pose, body)| (id, if shift { asked_pose(queue, id).unwrap_or(pose) } else { pose }, body))?;
        let held = if shift { Held::RobotToTurn(id) } else { Held::Robot(id) };
        Some((held, pose, body.height_m))
    };
    let Some((held, pose, height_m)) = ball.or_else(robot) else { return };
    if let Some(grip) = Grip::new(held, pose, height_m, &sight) {
        *drag = MouseDrag { grip: Some(grip), press: Some((cursor, false)), intention: None };
    }
}

/// The robot among these that the mouse points at.
fn pointed_robot(sight: &Sight, robots: &[(RobotId, Pose, Body)]) -> Option<(RobotId, Pose, Body)> {
    let targets = robots.iter().map(|(id, pose, body)| (*id, PickTarget::of(body, pose.position)));
    let pointed = pointed_at(sight.origin, sight.direction, targets)?;
    robots.iter().find(|(id, ..)| *id == pointed).copied()
}

fn drag_and_let_go(
    buttons: Res<ButtonInput<MouseButton>>,
    keys: Res<ButtonInput<KeyCode>>,
    timeline: Res<Timeline>,
    pitch: Res<Pitch>,
    window: Single<&Window>,
    camera: Single<(&Camera, &GlobalTransform), With<ViewerCamera>>,
    balls: Query<&BallPhysics, With<Ball>>,
    mut drag: ResMut<MouseDrag>,
    mut notice: ResMut<Notice>,
    mut commands: Commands,
) {
    let (Some(grip), Some((pressed_at, has_moved))) = (drag.grip, drag.press) else { return };
    if keys.just_pressed(KeyCode::Escape) {
        *drag = MouseDrag::default();
        return;
    }
    if !is_live(&timeline) {
        let cursor = window.cursor_position();
        if cursor.is_some_and(|cursor| pressed_at.distance(cursor) > DRAG_PIXELS) {
            notice.tell(why_not(&timeline));
            *drag = MouseDrag::default();
        } else if !buttons.pressed(MouseButton::Left) {
            *drag = MouseDrag::default();
        }
        return;
    }
    if let Some(cursor) = window.cursor_position() {
        let has_moved = has_moved || pressed_at.distance(cursor) > DRAG_PIXELS;
        let rolling = balls.iter().next().map(|physics| physics.rolling).unwrap_or_default();
        let intention = sight(*camera, cursor)
            .filter(|_| has_moved)
            .and_then(|sight| grip.release(&sight, pitch.carpet_half_extents(), rolling));
        drag.press = Some((pressed_at, has_moved));
        // While the mouse is over the sky, the last place on the ground counts.
        drag.intention = intention.or(drag.intention);
    }
    if !buttons.pressed(MouseButton::Left) {
        if let Some(intervention) = drag.intention {
            commands.queue(move |world: &mut World| match refusal(world) {
                Some(why) => world.resource_mut::<Notice>().tell(why),
                None => undo::act(world, intervention),
            });
        }
        *drag = MouseDrag::default();
    }
}

fn apply(world: &mut World) {
    undo::reset(world);
    let actions: Vec<HandAction> = world.resource_mut::<Messages<HandAction>>().drain().collect();
    for action in actions {
        if action == HandAction::KeepSituation && world.resource::<Timeline>().is_past() {
            keep::keep_past_situation(world);
            continue;
        }
        if action == HandAction::KeepMatch {
            saved_files::saved_files(world);
            continue;
        }
        if matches!(action, HandAction::Undo | HandAction::Redo) {
            undo::apply(world, action == HandAction::Undo);
            continue;
        }
        let stays_possible = matches!(action, HandAction::Drive | HandAction::KeepSituation);
        if let Some(why) = refusal(world).filter(|why| *why != OVER || !stays_possible) {
            world.resource_mut::<Notice>().tell(why);
            continue;
        }
        match action {
            HandAction::Whistle => intervene(world, Intervention::Whistle),
            HandAction::DropBall => intervene(world, Intervention::DropBall { position_m: Vec2::ZERO }),
            HandAction::Intervene(intervention) => intervene(world, intervention),
            HandAction::PenaliseOrReturn => penalise_or_return(world),
            HandAction::Drive => driving::toggle(world),
            HandAction::KeepSituation => keep::keep_situation(world),
            HandAction::KeepMatch | HandAction::Undo | HandAction::Redo => {}
        }
    }
}

/// Performs an intervention at the end of the next cycle, and says that it waits for one in a paused match.
fn intervene(world: &mut World, intervention: Intervention) {
    undo::act(world, intervention);
    if world.get_resource::<Playback>().is_some_and(|playback| playback.paused) {
        world.resource_mut::<Notice>().tell(format!("By hand, when the match goes on: {intervention}"));
    }
}

fn penalise_or_return(world: &mut World) {
    let Some(robot) = world.resource::<Selection>().0 else {
        let is_empty = world.resource::<Roster>().is_empty();
        let words = if is_empty { "This scenario has no robots" } else { "Select a robot first" };
        world.resource_mut::<Notice>().tell(words);
        return;
    };
    let is_of_robot = |asked: &&Intervention| match asked {
        Intervention::Penalise { robot: of, .. } | Intervention::Return { robot: of } => *of == robot,
        _ => false,
    };
    if let Some(asked) = world.resource::<Interventions>().queue.iter().find(is_of_robot) {
        let words = format!("This waits already for the match to go on: {asked}; Ctrl Z takes it back");
        world.resource_mut::<Notice>().tell(words);
        return;
    }
    let entity = world.resource::<Roster>().get(robot);
    let serves = entity.and_then(|entity| world.get::<Penalty>(entity)).is_some_and(Penalty::is_active);
    let intervention = if serves {
        Intervention::Return { robot }
    } else {
        Intervention::Penalise { robot, reason: PenaltyReason::Manual, duration_s: None }
    };
    intervene(world, intervention);
}

/// Draws the intervention of the drag, and those pending until the end of the cycle.
fn draw_intentions(
    drag: Res<MouseDrag>,
    interventions: Res<Interventions>,
    (roster, playback, timeline): (Res<Roster>, Res<Playback>, Res<Timeline>),
    (bodies, poses): (Query<&Body>, Query<&Pose>),
    balls: Query<&BallPhysics>,
    mut brush: Brush,
) {
    let rolling = balls.iter().next().map(|physics| physics.rolling).unwrap_or_default();
    // They are of the present.
    let queue = if is_live(&timeline) { &interventions.queue[..] } else { &[] };
    let place_of = |robot| Some(poses.get(roster.get(robot)?).ok()?.position);
    for (place, words) in words_of(queue, place_of).filter(|_| playback.paused) {
        brush.words(place, words, Color::WHITE);
    }
    for intention in drag.intention.iter().chain(queue) {
        match *intention {
            Intervention::PlaceRobot { robot, pose } => {
                let body = roster.get(robot).and_then(|robot| bodies.get(robot).ok()).copied().unwrap_or_default();
                let radius = PickTarget::of(&body, pose.position).reach_m;
                brush.pose(pose, radius, palette::team(robot.team));
            }
            Intervention::PlaceBall { position_m, velocity_mps } if velocity_mps != Vec2::ZERO => {
                let speed = velocity_mps.length();
                let end = position_m + velocity_mps.normalize_or_zero() * rolling.distance(speed);
                brush.arrow(position_m, end, Color::WHITE);
                brush.words(end, format!("{speed:.1} m/s"), Color::WHITE);
            }
            Intervention::PlaceBall { position_m, .. } | Intervention::DropBall { position_m } => {
                brush.circle(position_m, BALL_RING_M, Color::WHITE);
            }
            Intervention::KickOff { team } => brush.circle(Vec2::ZERO, BALL_RING_M, palette::team(team)),
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests;
