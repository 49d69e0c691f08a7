//! The result of an episode of a challenge.

use base64::prelude::{BASE64_STANDARD, Engine};
use serde::{Deserialize, Serialize};

use super::challenge::SuccessRate;
use naoisis_core::statistics;

/// The result of an episode.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Attempt {
    /// Its seed.
    pub seed: u64,
    /// Whether it ended with a success.
    pub is_success: bool,
    /// Its duration, s.
    pub time_s: f64,
    /// A number that depends on where ball and robots were at its end, as sixteen hexadecimal digits.
    pub end_state: String,
    /// A byte for each step that depends on where ball and robots were after it, in base64; empty in older files.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub steps: String,
    /// The commands of the controlled robots in each cycle, if programs gave them: JSON, compressed by zstd, in base64.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub commands: Option<String>,
}

impl Attempt {
    /// Whether it came out as `written`, which has no steps if it is of an earlier version. The commands need not be the same.
    pub(super) fn is_as(&self, written: &Self) -> bool {
        *self
            == Self {
                steps: if written.steps.is_empty() { self.steps.clone() } else { written.steps.clone() },
                commands: self.commands.clone(),
                ..written.clone()
            }
    }

    /// The time of the first step after which ball or robots were elsewhere than in `other`, s. `None` if all common steps are the same.
    /// A byte differs with a probability of 255 / 256, so the time may be one of the next steps.
    pub fn first_difference_s(&self, other: &Self) -> Option<f64> {
        let [own, others] = [self, other].map(|attempt| BASE64_STANDARD.decode(&attempt.steps).unwrap_or_default());
        let step = own.iter().zip(&others).position(|(own, other)| own != other)?;
        Some(self.time_s * (step + 1) as f64 / own.len() as f64)
    }
}

/// The success rate of `attempts`.
pub fn success_rate(attempts: &[Attempt]) -> SuccessRate {
    let times: Vec<f64> = attempts.iter().filter(|attempt| attempt.is_success).map(|attempt| attempt.time_s).collect();
    let mean_time_s = statistics::mean(&times).map(|mean| mean.value);
    SuccessRate { episodes: attempts.len(), successes: times.len(), mean_time_s }
}
