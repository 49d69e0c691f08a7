//! The kinds of observations.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::extras::Extras;
use naoisis_core::robot::Roster;
use naoisis_core::team::Team;

/// The kinds of observations.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ObservationKind {
    /// Sensor readings, and the state of the game that the robot received.
    #[default]
    Perception,
    /// The belief of the built-in estimator.
    Belief,
    /// The true state.
    Truth,
    /// Everything except vision, for agents that observe camera images.
    Body,
}

/// What an agent observes: the kind of observation, with its extras.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct ObservationForm {
    /// The kind.
    pub kind: ObservationKind,
    /// The extras.
    pub extras: Extras,
    /// The number of other robots in it: the nearest ones if the match has more of them; those that it lacks are unknown. `None` for
    /// those of the match.
    pub others: Option<Others>,
}

impl ObservationForm {
    /// Returns the number of other robots in the observation of a robot of `team`.
    pub(crate) fn others_of(&self, roster: &Roster, team: Team) -> Others {
        self.others.unwrap_or_else(|| Others::of(roster, team))
    }
}

impl From<ObservationKind> for ObservationForm {
    fn from(kind: ObservationKind) -> Self {
        Self { kind, ..Self::default() }
    }
}

/// The number of other robots in an observation.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Others {
    /// Other robots of its team.
    pub team_mates: u8,
    /// Robots of the other team.
    pub opponents: u8,
}

impl Others {
    /// The other robots in a match with a robot of `team`.
    fn of(roster: &Roster, team: Team) -> Self {
        let count = |of: Team| roster.iter().filter(|(id, _)| id.team == of).count().min(usize::from(u8::MAX)) as u8;
        Self { team_mates: count(team).saturating_sub(1), opponents: count(team.opponent()) }
    }
}
