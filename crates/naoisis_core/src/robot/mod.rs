//! Robots: their bodies, heads, walking and kicks, and the roster of all robots.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use crate::knowledge::Knowledge;

pub mod body;
pub mod breakdowns;
pub mod condition;
pub mod falls;
pub mod gait;
pub mod head;
pub mod jersey;
pub mod kick;
pub mod latency;
pub mod look;
pub mod motion;
pub mod motion_settings;
pub mod posture;
pub mod request;
pub mod walk_command;

use crate::cycle::{BeginCycle, Cycle, CycleSystems};
use crate::geometry::Pose;
use crate::team::RobotId;

/// Robots with bodies, heads, walking, kicks and falls. Adds the plugins of the submodules.
pub struct RobotPlugin;

impl Plugin for RobotPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<Roster>()
            .register_type::<RobotId>()
            .register_type::<Velocity>()
            .register_type::<Pose>()
            .register_type::<PreviousPose>()
            .register_type::<Roster>()
            .register_type::<body::Body>()
            .register_required_components::<RobotId, body::Body>()
            .add_observer(enter_roster)
            .add_observer(leave_roster)
            .add_systems(Cycle, remember_poses.in_set(CycleSystems::First).after(BeginCycle))
            .add_plugins((
                head::HeadPlugin,
                motion::MotionPlugin,
                kick::KickPlugin,
                latency::LatencyPlugin,
                falls::FallsPlugin,
                breakdowns::BreakdownsPlugin,
            ));
    }
}

/// True linear and angular velocity over the last cycle, pitch frame, after limits, error and collisions.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Velocity {
    /// Metres per second.
    pub linear: Vec2,
    /// Radians per second, counter-clockwise.
    pub angular: f32,
}

/// The pose of a robot or the ball at the start of the current cycle.
#[derive(Component, Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Truth)]
pub struct PreviousPose(pub Pose);

/// All robots, ordered by [`RobotId`]. Systems whose result depends on an order iterate in this one.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default, Reflect)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct Roster(Vec<(RobotId, Entity)>);

impl Roster {
    /// The robots' entities in the order of their ids.
    pub fn entities(&self) -> impl ExactSizeIterator<Item = Entity> + '_ {
        self.0.iter().map(|(_, entity)| *entity)
    }

    /// Ids and entities, in the order of the ids.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = (RobotId, Entity)> + '_ {
        self.0.iter().copied()
    }

    /// The entity of a robot.
    pub fn get(&self, id: RobotId) -> Option<Entity> {
        // For so few robots, a binary search would take longer.
        self.0.iter().find(|(other, _)| *other == id).map(|(_, entity)| *entity)
    }

    /// The number of robots.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there is no robot.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

fn enter_roster(added: On<Add, RobotId>, ids: Query<&RobotId>, mut roster: ResMut<Roster>) {
    if let Ok(id) = ids.get(added.entity) {
        let place = roster.0.partition_point(|(other, _)| other < id);
        roster.0.insert(place, (*id, added.entity));
    }
}

fn leave_roster(removed: On<Remove, RobotId>, mut roster: ResMut<Roster>) {
    roster.0.retain(|(_, entity)| *entity != removed.entity);
}

fn remember_poses(mut poses: Query<(&Pose, &mut PreviousPose)>) {
    for (pose, mut previous) in &mut poses {
        previous.0 = *pose;
    }
}
