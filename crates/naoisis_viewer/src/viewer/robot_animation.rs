//! Motion of the robots' limbs: steps, kicks, heads, falls.
//!
//! It follows the [appearance](naoisis_sensing::appearance::stride), but at the displayed time, which runs smoothly
//! between the cycles.

use bevy::prelude::*;

use super::robot_model::RobotLimbs;
use super::shared::DisplayFraction;
use naoisis_core::cycle::CycleClock;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Velocity;
use naoisis_core::robot::body::Body;
use naoisis_core::robot::head::HeadAngles;
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;
use naoisis_sensing::appearance::scene::world_from_body;
use naoisis_sensing::appearance::stride::Stride;

/// Moves the limbs of the robots' models.
pub struct RobotAnimationPlugin;

impl Plugin for RobotAnimationPlugin {
    fn build(&self, app: &mut App) {
        app.add_observer(start_stride).add_systems(Update, move_limbs).add_systems(PostUpdate, move_ghosts);
    }
}

/// The stride at the displayed time. The robot's own stride changes once per cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default)]
struct DisplayedStride(Stride);

fn start_stride(added: On<Add, RobotId>, mut commands: Commands) {
    commands.entity(added.entity).insert(DisplayedStride::default());
}

fn move_limbs(
    clock: Res<CycleClock>,
    fraction: Res<DisplayFraction>,
    mut robots: Query<(
        (&RobotId, &Pose, &Velocity),
        (&HeadAngles, &Posture, &Body),
        (&Stride, &RobotLimbs, &mut DisplayedStride),
    )>,
    mut transforms: Query<&mut Transform>,
) {
    let now_s = clock.start_time_s() + f64::from(fraction.0) * clock.period_s;
    for ((id, pose, velocity), (head, posture, body), (stride, robot_limbs, mut displayed)) in &mut robots {
        displayed.0.kick = stride.kick;
        displayed.0.follow(*pose, *velocity, now_s);
        // The place on the pitch is in the robot's own transform.
        let limbs = displayed
            .0
            .joints(*id, *head, body)
            .world_from_limbs(body, world_from_body(Pose::default(), *posture, body));
        for (limb, place) in robot_limbs.limbs.into_iter().zip(limbs) {
            if let Ok(mut transform) = transforms.get_mut(limb) {
                transform.set_if_neq(Transform::from_matrix(place.into()));
            }
        }
    }
}

/// The state from which the limbs of a ghost are posed.
#[derive(Component, Clone, Copy, PartialEq, Debug)]
pub struct GhostBody {
    id: RobotId,
    pose: Pose,
    velocity: Velocity,
    head: HeadAngles,
    posture: Posture,
    body: Body,
    stride: Stride,
}

impl GhostBody {
    /// The state of a robot from a record, with the default body.
    pub fn new(id: RobotId, pose: Pose, velocity: Velocity, head: HeadAngles, posture: Posture) -> Self {
        Self { id, pose, velocity, head, posture, body: Body::default(), stride: Stride::default() }
    }

    /// Sets the body.
    pub fn with_body(self, body: Body) -> Self {
        Self { body, ..self }
    }

    /// Returns the robot and its body.
    pub fn robot(&self) -> (RobotId, Body) {
        (self.id, self.body)
    }

    /// Updates the state from another cycle, and keeps the stride.
    pub fn update(&mut self, new: GhostBody) {
        *self = GhostBody { body: self.body, stride: self.stride, ..new };
    }
}

fn move_ghosts(
    clock: Res<CycleClock>,
    fraction: Res<DisplayFraction>,
    mut ghosts: Query<(&mut GhostBody, &RobotLimbs)>,
    mut transforms: Query<&mut Transform>,
) {
    let now_s = clock.start_time_s() + f64::from(fraction.0) * clock.period_s;
    for (mut ghost, robot_limbs) in &mut ghosts {
        let GhostBody { id, pose, velocity, head, posture, body, .. } = *ghost;
        ghost.stride.follow(pose, velocity, now_s);
        let joints = ghost.stride.joints(id, head, &body);
        let limbs = joints.world_from_limbs(&body, world_from_body(Pose::default(), posture, &body));
        for (limb, place) in robot_limbs.limbs.into_iter().zip(limbs) {
            if let Ok(mut transform) = transforms.get_mut(limb) {
                transform.set_if_neq(Transform::from_matrix(place.into()));
            }
        }
    }
}
