//! What an agent's observations need of earlier cycles: odometry, the messages of team-mates, and which robots it follows.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::heard::{Heard, keep_newest};
use super::kind::{ObservationForm, ObservationKind};
use super::tracks::{Track, follow};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::belief::{Belief, RobotBelief};
use naoisis_sensing::sensing::odometry::Odometry;
use naoisis_sensing::sensing::vision::Percepts;

/// The past values of an agent that its observations use.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[serde(default)]
pub(crate) struct Memory {
    /// Its odometry at its last observation.
    pub odometry: Pose,
    /// The last message of each team-mate, if messages are observed.
    #[reflect(default)]
    pub(super) heard: Vec<Heard>,
    /// The team-mates that are followed, if the order of robots is stable.
    #[reflect(default)]
    pub(super) team_mates: Vec<Track>,
    /// The opponents that are followed, like `team_mates`.
    #[reflect(default)]
    pub(super) opponents: Vec<Track>,
}

impl Memory {
    /// Creates the memory of a robot at the start of an episode.
    pub fn at(odometry: Pose) -> Self {
        Self { odometry, ..default() }
    }

    /// Keeps the messages that arrived in this cycle.
    pub fn listen(&mut self, world: &World, robot: Entity) {
        keep_newest(&mut self.heard, world, robot);
    }

    /// Follows the other robots that the robot `id` knows of now, as many as are observed.
    pub fn follow(&mut self, observed: ObservationForm, world: &World, id: RobotId) {
        let roster = world.resource::<Roster>();
        let Some(robot) = roster.get(id).and_then(|entity| world.get_entity(entity).ok()) else { return };
        let others = observed.others_of(roster, id.team);
        let [team_mates, opponents] = places_of_others(observed.kind, &robot, id);
        follow(&mut self.team_mates, &team_mates, others.team_mates);
        follow(&mut self.opponents, &opponents, others.opponents);
    }
}

/// The places of other robots that `robot` knows of, in the order of its lists, team-mates and opponents: in the team frame for beliefs, in the
/// frame of its odometry for detections, m. The truth has a stable order of its own.
fn places_of_others(kind: ObservationKind, robot: &EntityRef, id: RobotId) -> [Vec<Vec2>; 2] {
    match (kind, robot.get::<Belief>(), robot.get::<Percepts>()) {
        (ObservationKind::Belief, Some(belief), _) => [&belief.team_mates, &belief.opponents]
            .map(|robots| robots.iter().map(|robot: &RobotBelief| robot.position_m).collect()),
        (ObservationKind::Perception, _, Some(percepts)) => {
            let odometry = robot.get::<Odometry>().map(|odometry| odometry.0).unwrap_or_default();
            [id.team, id.team.opponent()].map(|team| {
                let places = of_team(percepts, team).into_iter();
                places.map(|place| odometry.transform_point(place)).collect()
            })
        }
        _ => [Vec::new(), Vec::new()],
    }
}

/// The places of the robots of `team` that are detected, m, robot frame.
pub(super) fn of_team(percepts: &Percepts, team: Team) -> Vec<Vec2> {
    percepts.robots.iter().filter(|robot| robot.team == team).map(|robot| robot.position_m).collect()
}

/// The index in `places` of each of `count` robots: as they are followed in `tracks`, or else the nearest first.
pub(super) fn order_of(places: &[Vec2], count: u8, tracks: Option<&[Track]>) -> Vec<Option<usize>> {
    let mut order: Vec<Option<usize>> = match tracks {
        Some(tracks) => tracks.iter().map(|track| track.index).collect(),
        None => {
            let mut indices: Vec<usize> = (0..places.len()).collect();
            indices.sort_by(|a, b| places[*a].length_squared().total_cmp(&places[*b].length_squared()));
            indices.into_iter().map(Some).collect()
        }
    };
    order.resize(usize::from(count), None);
    order
}
