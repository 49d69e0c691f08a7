//! The memory of the referee from one cycle to the next, besides the state of the match.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

use super::custom_rules::MOST_CUSTOM_RULES;
use super::fallen::GetUp;
use super::game_stuck::{Progress, Stuck};
use super::indirect_goal::Plays;
use super::kick_off_shot::KickOffPlay;
use super::snapshot::{MatchSnapshot, RobotSnapshot};
use super::stalling::Stall;
use super::status::Announcement;
use super::touch::Touch;
use crate::knowledge::Knowledge;
use crate::random::RandomStream;
use crate::robot::head::HeadAngles;
use crate::team::{PerTeam, RobotId};

/// The referee's memory.
#[derive(Resource, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Resource, @Knowledge::Truth)]
pub struct RefereeMemory {
    /// The last touch of the ball since it was last placed, if any.
    pub last_touch: Option<Touch>,
    /// The kick-off, while its shot is under way.
    pub kick_off: Option<KickOffPlay>,
    /// The robot that must take the kick-off, because it stood outside its own half.
    pub kick_off_player: Option<RobotId>,
    /// Messages of each team in the match, up to the last cycle.
    pub messages_sent: PerTeam<u32>,
    /// The robots that have played the ball since the last restart.
    pub plays: Plays,
    /// The state of a ball that does not move.
    pub stuck: Stuck,
    /// Duration of the current or last `standby`, cycles.
    pub standby_cycles: u64,
    /// Cycles for which all robots have stood at legal places in `ready`.
    pub cycles_lined_up: u64,
    /// Penalties for pushing of each team in this half.
    pub pushes: PerTeam<u32>,
    /// Infractions of each team, which make later penalties longer.
    pub infractions: PerTeam<u32>,
    /// The random numbers for undecided shoot-outs and for the duration of `standby`.
    pub coin: Option<RandomStream>,
    /// The delayed information of the robots.
    pub announcement: Announcement,
    /// The time left in the half when the current stoppage of play began, cycles: a time-out sets the clock back to it.
    pub clock_at_stoppage: Option<u64>,
    /// The duration of the time-out that each team has requested, cycles.
    pub timeout_requests: PerTeam<Option<u64>>,
    /// The requested substitutions: a player and its substitute each.
    pub substitution_requests: Vec<[RobotId; 2]>,
    /// The memory of each robot, ordered by id.
    pub robots: Vec<RobotMemory>,
}

/// The referee's memory of a robot.
#[derive(Clone, Copy, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
pub struct RobotMemory {
    /// Team and number.
    pub id: RobotId,
    /// Number of times that it was placed for a kick-off, in its team's formation.
    pub restarts: u32,
    /// Number of times that it was placed by hand, because it was at an illegal position or for a shot of a shoot-out.
    pub hand_placements: u32,
    /// Number of its cautions in this match.
    pub cautions: u32,
    /// Its stay near the ball, if it stands there.
    pub stall: Option<Stall>,
    /// Cycles for which it has covered the ball.
    pub cycles_holding: u64,
    /// Cycles for which it has been in a goal.
    pub cycles_in_goal: u64,
    /// Cycles for which it has been in the area with limited defenders.
    pub cycles_in_area: u64,
    /// Cycles for which it has encroached in a free kick.
    pub cycles_encroaching: u64,
    /// Whether it has kept away from the ball in the free kick under way.
    #[reflect(default)]
    pub has_kept_away: bool,
    /// Cycles for which it has stepped into an opponent's way to the ball.
    pub cycles_obstructing: u64,
    /// Its progress while the ball does not move.
    pub progress: Option<Progress>,
    /// Whether it is returning from a penalty, and has not been on the pitch since.
    pub returns: bool,
    /// Cycles for which it has stood since `set` or `standby` began.
    pub cycles_standing: u64,
    /// Cycles for which it has done nothing.
    pub cycles_inactive: u64,
    /// The opponent that it touches, and the number of cycles of contact.
    pub contact: Option<(RobotId, u64)>,
    /// Its attempts to get up.
    pub get_up: GetUp,
    /// The cycle counts of custom rules.
    pub own_cycles: [u64; MOST_CUSTOM_RULES],
    /// Angles of its head in the last cycle.
    pub head: HeadAngles,
}

impl RobotMemory {
    /// An empty memory of the robot `id`.
    fn clean(id: RobotId) -> Self {
        Self { id, ..default() }
    }

    /// Updates the contact with an opponent: the same opponent as long as that contact lasts. `index` is the robot's index in the snapshot.
    pub(super) fn note_contact(&mut self, snapshot: &MatchSnapshot, index: usize) {
        let partner = |pair: &[usize; 2]| pair.iter().position(|one| *one == index).map(|side| pair[1 - side]);
        let touched = snapshot.contacts.iter().filter_map(partner).map(|other| snapshot.robots[other].id);
        let mut opponents = touched.filter(|other| other.team != self.id.team);
        self.contact = match self.contact {
            Some((other, cycles)) if opponents.clone().any(|touched| touched == other) => Some((other, cycles + 1)),
            _ => opponents.next().map(|other| (other, 1)),
        };
    }

    /// Clears everything that could count against the robot: it was placed, or play was stopped.
    pub(super) fn forgive(&mut self) {
        let RobotMemory { id, restarts, hand_placements, cautions, head, returns, .. } = *self;
        *self = RobotMemory { restarts, hand_placements, cautions, head, returns, ..RobotMemory::clean(id) };
    }
}

impl RefereeMemory {
    /// The record of a robot.
    pub fn record(&self, id: RobotId) -> Option<&RobotMemory> {
        self.robots.binary_search_by_key(&id, |record| record.id).ok().map(|index| &self.robots[index])
    }

    /// Adapts the records to the list of robots.
    pub(super) fn match_robots(&mut self, robots: &[RobotSnapshot]) {
        let same = self.robots.len() == robots.len()
            && self.robots.iter().zip(robots).all(|(record, robot)| record.id == robot.id);
        if !same {
            let old = core::mem::take(&mut self.robots);
            self.robots.extend(robots.iter().map(|robot| {
                old.iter().find(|record| record.id == robot.id).copied().unwrap_or(RobotMemory::clean(robot.id))
            }));
        }
    }

    /// Records the touches of a cycle.
    pub(super) fn note_touches(&mut self, snapshot: &MatchSnapshot) {
        for &(robot, kick) in snapshot.touches {
            let Some(index) = snapshot.robot_index(robot) else { continue };
            let robot_position = snapshot.robots[index].pose.position;
            self.last_touch = Some(Touch { robot, cycle: snapshot.clock.cycle, robot_position, kick });
        }
    }
}
