//! Scripts: commands at given times, from a scenario file.

use bevy::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::communication::{Outbox, TeamMessage};
use crate::cycle::CycleClock;
use crate::geometry::file_units;
use crate::knowledge::Knowledge;
use crate::robot::head::HeadCommand;
use crate::robot::kick::{KickCommand, KickRequest};
use crate::robot::motion::WalkCommand;
use crate::robot::posture::{PostureCommand, PostureRequest};
use crate::robot::request::{RequestCommand, TeamRequest};

/// A script that controls a robot instead of a behaviour.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Command)]
pub struct Script(pub Vec<ScriptEntry>);

/// An entry of a script: the commands for every cycle with `from_s <= t < until_s`; without `until_s`, for the first cycle at or after
/// `from_s`.
#[derive(Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct ScriptEntry {
    /// Start, s.
    #[schemars(range(min = 0.0))]
    pub from_s: f64,
    /// End, s; if absent, the entry is for a single cycle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub until_s: Option<f64>,
    /// Displacement in each of these cycles: dx m, dy m, dθ radians (degrees in files).
    #[serde(with = "file_units::optional_step", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 3]>")]
    pub walk: Option<[f32; 3]>,
    /// A kick.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kick: Option<KickRequest>,
    /// Yaw and pitch for the head, radians (degrees in files).
    #[serde(rename = "head_deg", with = "file_units::optional_degree_pair", skip_serializing_if = "Option::is_none")]
    #[schemars(with = "Option<[f32; 2]>")]
    pub head: Option<[f32; 2]>,
    /// Getting up, or a dive.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub posture: Option<PostureRequest>,
    /// A request to the referee: `timeout`, `pick_up`, or `{ "substitute": 6 }`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub request: Option<TeamRequest>,
    /// A message for the team-mates.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub say: Option<TeamMessage>,
}

pub(super) fn run_scripts(
    clock: Res<CycleClock>,
    mut robots: Query<(
        &Script,
        &mut WalkCommand,
        &mut HeadCommand,
        &mut KickCommand,
        &mut PostureCommand,
        &mut Outbox,
        &mut RequestCommand,
    )>,
) {
    for (script, mut walk, mut head, mut kick, mut posture, mut outbox, mut request) in &mut robots {
        for entry in script.0.iter().filter(|entry| is_active(entry, &clock)) {
            if let Some([dx, dy, dtheta]) = entry.walk {
                *walk = WalkCommand { dx, dy, dtheta };
            }
            if let Some([yaw, pitch]) = entry.head {
                *head = HeadCommand { yaw, pitch };
            }
            if entry.kick.is_some() {
                kick.0 = entry.kick;
            }
            if entry.posture.is_some() {
                posture.0 = entry.posture;
            }
            if entry.request.is_some() {
                request.0 = entry.request;
            }
            if entry.say.is_some() {
                outbox.0.clone_from(&entry.say);
            }
        }
    }
}

/// Whether `entry` is active in the current cycle of `clock`. Times that differ by less than a thousandth of a cycle are equal.
pub fn is_active(entry: &ScriptEntry, clock: &CycleClock) -> bool {
    let now = clock.start_time_s() + clock.period_s / 1000.0;
    let until = entry.until_s.unwrap_or(entry.from_s + clock.period_s);
    entry.from_s <= now && now < until
}

#[cfg(test)]
mod tests {
    use super::*;

    fn active_cycles(from_s: f64, until_s: Option<f64>) -> Vec<u64> {
        let entry = ScriptEntry { from_s, until_s, ..ScriptEntry::default() };
        (1..100).filter(|cycle| is_active(&entry, &CycleClock { cycle: *cycle, ..CycleClock::default() })).collect()
    }

    #[test]
    fn entries_act_from_their_start_until_just_before_their_end() {
        // Cycle n starts at (n - 1) / 30 s.
        assert_eq!(active_cycles(0.0, None), [1]);
        assert_eq!(active_cycles(1.0, None), [31]);
        assert_eq!(active_cycles(0.99, None), [31]);
        assert_eq!(active_cycles(1.0, Some(1.1)), [31, 32, 33]);
        assert_eq!(active_cycles(2.0, Some(3.0)).len(), 30);
    }
}
