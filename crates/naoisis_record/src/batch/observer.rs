//! Observes a match of a batch and makes its row.

use bevy::prelude::*;
use serde::{Deserialize, Serialize, Serializer};
use std::collections::BTreeMap;

use super::csv_lines::as_text;
use crate::record::match_counts::MatchCounter;
use crate::record::mistakes::Mistake;
use naoisis_core::ball::Ball;
use naoisis_core::communication::MessageStatistics;
use naoisis_core::events::{CycleEvents, MatchEvent};
use naoisis_core::game::{DecidedBy, Game, Rules};
use naoisis_core::geometry::Pose;
use naoisis_core::robot::Roster;
use naoisis_core::statistics::rounded;
use naoisis_core::team::{PerTeam, Team};

/// How a match ended.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum MatchOutcome {
    /// The final whistle.
    FinalWhistle,
    /// The end of the scenario's duration.
    Duration,
    /// It was played to its end, but an invariant was broken.
    InvariantBroken,
    /// A panic, for example in a behaviour.
    Panicked,
    /// The match could not be started.
    #[default]
    Refused,
}

impl MatchOutcome {
    /// Returns whether the match is valid.
    pub fn is_valid(self) -> bool {
        matches!(self, MatchOutcome::FinalWhistle | MatchOutcome::Duration)
    }
}

/// The result of one match: a row of a batch's table. All numbers come from the [match counter](crate::record::match_counts).
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[non_exhaustive]
pub struct MatchRow {
    /// Index of the match in the batch, from 0.
    #[serde(skip)]
    pub index: usize,
    /// The variant of the scenario, from 0.
    #[serde(skip)]
    pub variant: usize,
    /// The seed.
    #[serde(skip)]
    pub seed: u64,
    /// How it ended.
    pub outcome: MatchOutcome,
    /// The winner. `None` after a draw.
    pub winner: Option<Team>,
    /// What decided the match.
    pub decided_by: DecidedBy,
    /// Goals in a shoot-out. `None` without one.
    pub shoot_out: PerTeam<Option<u32>>,
    /// Duration of the match, s of its own time.
    #[serde(serialize_with = "milliseconds")]
    pub duration_s: f64,
    /// Goals that count for the team.
    pub goals: PerTeam<u32>,
    /// Goals of the team that count for the other team.
    pub own_goals: PerTeam<u32>,
    /// Kicks that struck the ball.
    pub kicks: PerTeam<u32>,
    /// Passes completed.
    pub kept: PerTeam<u32>,
    /// Passes that an opponent touched next, or that left the pitch.
    pub given_away: PerTeam<u32>,
    /// Penalties.
    pub penalties: PerTeam<u32>,
    /// Balls that left the pitch.
    pub outs: u32,
    /// Blue's share in the possession. `None` if no robot touched the ball.
    #[serde(serialize_with = "digits")]
    pub blue_possession: Option<f64>,
    /// Share of the time in play with the ball in blue's half. `None` without a ball.
    #[serde(serialize_with = "digits")]
    pub ball_in_blue_half: Option<f64>,
    /// Share of the messages that were lost, of those that should have reached a robot. `None` if there were none.
    #[serde(serialize_with = "digits")]
    pub messages_lost: Option<f64>,
    /// The median of the robots' pose errors, m. `None` without beliefs.
    #[serde(serialize_with = "digits_of_teams")]
    pub belief_error_m: PerTeam<Option<f64>>,
    /// The share of the time in which a robot's pose error is over 0.5 m. `None` without beliefs.
    #[serde(serialize_with = "digits_of_teams")]
    pub belief_over_half_m: PerTeam<Option<f64>>,
    /// The share of the time in which a robot's pose error is over 1 m. `None` without beliefs.
    #[serde(serialize_with = "digits_of_teams")]
    pub belief_over_1_m: PerTeam<Option<f64>>,
    /// The number of the robots' mistakes. `None` unless [they are looked for](super::mistakes::FindMistakes).
    #[serde(rename = "mistakes")]
    pub mistakes_found: Option<u32>,
    /// A digest of the poses of the ball and the robots in each cycle: identical matches have the same digest.
    #[serde(with = "hexadecimal")]
    pub digest: u64,
    /// What went wrong, if anything.
    #[serde(serialize_with = "one_line")]
    pub note: String,
    /// The robots' mistakes, if [they are looked for](super::mistakes::FindMistakes). They have their own table.
    #[serde(skip)]
    pub mistakes: Vec<Mistake>,
}

impl MatchRow {
    /// Returns whether all seeds of each variant played the same match, cycle by cycle, because nothing is random. Then each variant is one
    /// sample, and intervals mean nothing. Returns false unless a variant was played twice.
    pub(super) fn are_repetitions(rows: &[&Self]) -> bool {
        let mut first_of: BTreeMap<usize, &Self> = BTreeMap::new();
        for row in rows {
            let first = first_of.entry(row.variant).or_insert(row);
            if (Self { index: first.index, seed: first.seed, ..(*row).clone() }) != **first {
                return false;
            }
        }
        first_of.len() < rows.len()
    }

    /// Returns the row of a match that was not played to its end.
    pub(super) fn failed(seed: u64, outcome: MatchOutcome, note: String) -> Self {
        Self { seed, outcome, note, ..default() }
    }
}

/// Writes a digest as `x` and sixteen hexadecimal digits, so that no reader takes it for a number.
mod hexadecimal {
    use serde::de::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(digest: &u64, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&format_args!("x{digest:016x}"))
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<u64, D::Error> {
        let digits = String::deserialize(deserializer)?;
        u64::from_str_radix(digits.trim_start_matches('x'), 16).map_err(D::Error::custom)
    }
}

/// Writes a time with three decimal places.
fn milliseconds<S: Serializer>(time_s: &f64, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(&format_args!("{time_s:.3}"))
}

/// Writes a value with four decimal places.
fn digits<S: Serializer>(value: &Option<f64>, serializer: S) -> Result<S::Ok, S::Error> {
    value.map(|value| format!("{value:.4}")).serialize(serializer)
}

/// Writes a value of each team with four decimal places.
fn digits_of_teams<S: Serializer>(values: &PerTeam<Option<f64>>, serializer: S) -> Result<S::Ok, S::Error> {
    PerTeam::new(|team| values[team].map(|value| format!("{value:.4}"))).serialize(serializer)
}

/// Writes a text in one line, in a form that no spreadsheet takes for a formula.
fn one_line<S: Serializer>(text: &str, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(&as_text(text.replace(['\n', '\r'], " ")))
}

/// First value and factor of the FNV-1a hash.
const FNV_OFFSET: u64 = 0xcbf2_9ce4_8422_2325;
const FNV_PRIME: u64 = 0x0100_0000_01b3;

/// Returns the digest after a cycle, from the digest before it and the poses of `bodies`.
fn digest_of(world: &World, bodies: &[Entity], before: u64) -> u64 {
    let poses = bodies.iter().filter_map(|entity| world.get::<Pose>(*entity));
    let numbers = poses.flat_map(|pose| [pose.position.x, pose.position.y, pose.heading]);
    numbers.fold(before, |digest, number| (digest ^ u64::from(number.to_bits())).wrapping_mul(FNV_PRIME))
}

/// Watches a match, cycle by cycle.
pub struct MatchObserver {
    counter: MatchCounter,
    /// The ball and the robots that are there at the beginning.
    bodies: Vec<Entity>,
    digest: u64,
    first_broken_invariant: Option<String>,
}

impl MatchObserver {
    /// Begins to watch the match in `world` in its present state. Earlier events do not count.
    pub fn begin(world: &mut World) -> Self {
        let robots: Vec<Entity> = world.resource::<Roster>().entities().collect();
        let ball = world.query_filtered::<Entity, With<Ball>>().iter(world).next();
        let bodies = robots.into_iter().chain(ball).collect();
        Self { counter: MatchCounter::begin(world), bodies, digest: FNV_OFFSET, first_broken_invariant: None }
    }

    /// Reads the last completed cycle.
    pub fn observe(&mut self, world: &World) {
        self.counter.observe(world);
        self.digest = digest_of(world, &self.bodies, self.digest);
        if self.first_broken_invariant.is_none() {
            self.first_broken_invariant = world.resource::<CycleEvents>().iter().find_map(|event| match event {
                MatchEvent::InvariantBroken { message } => Some(message.clone()),
                _ => None,
            });
        }
    }

    /// Returns the row of the match that was watched.
    pub(super) fn row(self, world: &World, seed: u64, outcome: MatchOutcome) -> MatchRow {
        let counts = self.counter.counts();
        let teams = PerTeam::new(|team| counts.team(team));
        let messages = world.resource::<MessageStatistics>();
        let [delivered, lost] = [&messages.blue, &messages.pink].into_iter().fold([0, 0], |[delivered, lost], team| {
            [delivered + u64::from(team.delivered), lost + u64::from(team.lost)]
        });
        // The values have the digits of the table, so that a continued batch gives exactly the same results.
        let digits = |value: Option<f64>| value.map(|value| rounded(value, 4));
        let result = world.resource::<Game>().result(world.resource::<Rules>());
        MatchRow {
            winner: result.winner,
            decided_by: result.decided_by,
            shoot_out: PerTeam::new(|team| result.shoot_out.map(|goals| goals[team])),
            duration_s: counts.duration_s,
            digest: self.digest,
            goals: counts.goals,
            own_goals: counts.own_goals,
            kicks: PerTeam::new(|team| teams[team].kicks),
            kept: PerTeam::new(|team| teams[team].passes_completed),
            given_away: PerTeam::new(|team| teams[team].passes - teams[team].passes_completed),
            penalties: PerTeam::new(|team| teams[team].penalty_count()),
            outs: counts.outs,
            blue_possession: digits(counts.possession(Team::Blue)),
            ball_in_blue_half: digits(counts.ball_in_half(Team::Blue)),
            messages_lost: digits((delivered + lost > 0).then(|| lost as f64 / (delivered + lost) as f64)),
            belief_error_m: PerTeam::new(|team| digits(counts.median_pose_error_m(team))),
            belief_over_half_m: PerTeam::new(|team| digits(teams[team].pose_errors.over_half_m())),
            belief_over_1_m: PerTeam::new(|team| digits(teams[team].pose_errors.over_1_m())),
            ..match self.first_broken_invariant {
                Some(message) => MatchRow::failed(seed, MatchOutcome::InvariantBroken, message),
                None => MatchRow::failed(seed, outcome, programs_lost(PerTeam::new(|team| teams[team].programs_lost))),
            }
        }
    }
}

fn programs_lost(lost: PerTeam<u32>) -> String {
    match lost {
        PerTeam { blue: 0, pink: 0 } => String::new(),
        PerTeam { blue, pink } => format!("programs lost: blue {blue}, pink {pink}"),
    }
}
