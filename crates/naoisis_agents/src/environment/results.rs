//! Results of challenges as files: written by one program, verified by another.

use bevy::prelude::*;
use core::fmt;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};

use super::attempts::{Attempt, AttemptError, Attempts, ChallengePlayer, play_attempts, play_recorded, success_rate};
use super::challenge::{Challenge, ChallengeError, SuccessRate};
use naoisis_core::statistics::{Estimate, bootstrap, interquartile_mean, mean};
use naoisis_sim::scenario::{Realism, TeamsSpec};

/// A file of results.
#[derive(Clone, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ResultFile {
    /// The results.
    pub results: Vec<ChallengeResult>,
}

/// What plays the episodes of a result again.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum PlayedBy {
    /// The player. Programs are started.
    Player,
    /// The commands of programs that are recorded in the result.
    Commands,
}

/// The result of one player in one challenge.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct ChallengeResult {
    /// The version of naoisis that played it.
    pub naoisis: String,
    /// The name of the challenge.
    pub challenge: String,
    /// The version of the challenge.
    pub version: u32,
    /// The realism.
    pub realism: Realism,
    /// The model of the robots, if it is another than the challenge's.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// The [player](ChallengePlayer), in words.
    pub player: String,
    /// The number of interactions that the player was trained with, if it is a learned policy whose layout tells it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interactions: Option<u64>,
    /// The success rate.
    pub rate: SuccessRate,
    /// The episodes, in the order of their seeds.
    pub episodes: Vec<Attempt>,
}

/// The most interactions of the small and of the large budget, in which learned players are compared.
const BUDGETS: [(u64, &str); 2] = [(1_000_000, "small"), (100_000_000, "large")];

/// Returns a number of interactions with the smallest budget in which it is.
pub fn interactions_in_words(interactions: u64) -> String {
    let budget = BUDGETS.into_iter().find(|(most, _)| interactions <= *most).map_or("over both", |(_, name)| name);
    format!("{interactions}, {budget}")
}

/// Why a result is refused.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum ResultError {
    /// The text is no file of results.
    #[error("this is no file of results: {0}")]
    Malformed(#[from] serde_json::Error),
    /// The challenge does not exist, or not with this robot.
    #[error(transparent)]
    Challenge(#[from] ChallengeError),
    /// The challenge has changed since.
    #[error("{challenge} is of version {found}; expected {expected}")]
    Version {
        /// The name of the challenge.
        challenge: String,
        /// The version in the file.
        found: u32,
        /// The version of this program.
        expected: u32,
    },
    /// Rate and episodes contradict each other.
    #[error("{challenge}, {player}: {message}")]
    Inconsistent {
        /// The name of the challenge.
        challenge: String,
        /// The player.
        player: String,
        /// The contradiction.
        message: &'static str,
    },
}

naoisis_core::debug_as_displayed!(ResultError);

impl ResultFile {
    /// Reads a file of results and checks that each result is possible. That it is true is checked by [`ChallengeResult::verify`].
    ///
    /// # Errors
    /// The first fault.
    pub fn from_text(text: &str) -> Result<Self, ResultError> {
        let file: ResultFile = serde_json::from_str(text)?;
        file.results.iter().try_for_each(|result| result.check())?;
        Ok(file)
    }
}

/// The success of a training method: of its policies, which were trained with different seeds, in one or several challenges.
///
/// Intervals are those of a bootstrap over the policies within each challenge (Agarwal and others 2021, "Deep Reinforcement Learning at the
/// Edge of the Statistical Precipice").
#[derive(Clone, Copy, PartialEq, Debug, Serialize)]
pub struct MethodScore {
    /// The number of policies in each challenge: the least.
    pub policies: usize,
    /// The mean of the success rates of all policies in all challenges.
    pub mean: Estimate,
    /// The interquartile mean of these success rates.
    pub interquartile_mean: Estimate,
}

impl MethodScore {
    /// The score of the policies among the players of `results`; `None` if there are not at least two in each challenge.
    pub fn of<'a>(results: impl IntoIterator<Item = &'a ChallengeResult>) -> Option<Self> {
        let mut groups: BTreeMap<_, Vec<f64>> = BTreeMap::new();
        for result in results.into_iter().filter(|result| TeamsSpec::policy(&result.player).is_some()) {
            let group = (&result.challenge, result.realism.name(), &result.robot);
            groups.entry(group).or_default().push(result.rate.share()?.value);
        }
        let groups: Vec<Vec<f64>> = groups.into_values().collect();
        let policies = groups.iter().map(Vec::len).min().filter(|policies| *policies > 1)?;
        let scores = |groups: &[Vec<f64>]| {
            let all = groups.concat();
            Some(vec![mean(&all)?.value, interquartile_mean(all)?])
        };
        let [mean, interquartile_mean] = bootstrap(&groups, scores)?[..] else { return None };
        Some(Self { policies, mean, interquartile_mean })
    }
}

impl fmt::Display for MethodScore {
    fn fmt(&self, text: &mut fmt::Formatter<'_>) -> fmt::Result {
        let in_percent = |estimate: Estimate| {
            let [value, low, high] = [estimate.value, estimate.low, estimate.high].map(|share| 100.0 * share);
            format!("{value:.1} % ({low:.1} to {high:.1})")
        };
        let [mean, middle] = [self.mean, self.interquartile_mean].map(in_percent);
        write!(text, "{} policies: mean {mean}, interquartile mean {middle}", self.policies)
    }
}

impl ChallengeResult {
    /// The result of `episodes`, without a number of interactions.
    pub fn new(
        challenge: &Challenge,
        (realism, robot): (Realism, Option<&str>),
        player: &ChallengePlayer,
        episodes: Vec<Attempt>,
    ) -> Self {
        Self {
            naoisis: env!("CARGO_PKG_VERSION").to_owned(),
            challenge: challenge.name.clone(),
            version: challenge.version,
            realism,
            robot: robot.map(str::to_owned),
            player: player.to_string(),
            interactions: None,
            rate: success_rate(&episodes),
            episodes,
        }
    }

    fn check(&self) -> Result<(), ResultError> {
        self.challenge()?;
        let inconsistent = |message| {
            let (challenge, player) = (self.challenge.clone(), self.player.clone());
            Err(ResultError::Inconsistent { challenge, player, message })
        };
        let follows = |pair: &[Attempt]| pair[0].seed.checked_add(1) == Some(pair[1].seed);
        let expected = success_rate(&self.episodes);
        let difference_s = self.rate.mean_time_s.unwrap_or(0.0) - expected.mean_time_s.unwrap_or(0.0);
        match () {
            () if self.episodes.is_empty() => inconsistent("there are no episodes"),
            () if !self.episodes.windows(2).all(follows) => inconsistent("the seeds of its episodes are no sequence"),
            () if (self.rate.episodes, self.rate.successes) != (expected.episodes, expected.successes) => {
                inconsistent("its rate is not that of its episodes")
            }
            () if difference_s.abs() > 1e-6 => inconsistent("its mean time is not that of its episodes"),
            () => Ok(()),
        }
    }

    /// The challenge in the realism and with the robot of this result.
    ///
    /// # Errors
    /// If this program does not have it.
    pub fn challenge(&self) -> Result<Challenge, ResultError> {
        let challenge = Challenge::named(&self.challenge)?;
        if challenge.version != self.version {
            let (found, expected) = (self.version, challenge.version);
            return Err(ResultError::Version { challenge: challenge.name, found, expected });
        }
        Ok(challenge.with(self.realism, self.robot.as_deref())?)
    }

    /// Whether the commands of programs were recorded in all episodes.
    pub fn has_commands(&self) -> bool {
        self.episodes.iter().all(|attempt| attempt.commands.is_some())
    }

    /// Plays the episodes again, with one call of `played` after each, and returns the first that came out otherwise, as it was now.
    /// If `stop` is set meanwhile, the remaining episodes are not played.
    ///
    /// # Errors
    /// If an episode cannot start, or has no commands that can be read.
    pub fn verify(
        &self,
        challenge: &Challenge,
        by: PlayedBy,
        threads: usize,
        simulator: impl Fn() -> App + Sync,
        stop: &AtomicBool,
        mut played: impl FnMut(),
    ) -> Result<Option<Attempt>, AttemptError> {
        let Ok(player) = self.player.parse::<ChallengePlayer>();
        let first_seed = self.episodes.first().map_or(0, |attempt| attempt.seed);
        let attempts = Attempts { episodes: self.episodes.len(), first_seed, threads };
        let found_one = AtomicBool::new(false);
        let mut different = None;
        let mut written = self.episodes.iter();
        let compare = |attempt: Attempt| {
            played();
            if written.next().is_none_or(|written| !attempt.is_as(written)) && different.is_none() {
                different = Some(attempt);
            }
            found_one.store(different.is_some() || stop.load(Ordering::Relaxed), Ordering::Relaxed);
        };
        match by {
            PlayedBy::Player => play_attempts(challenge, &player, &attempts, simulator, &found_one, compare)?,
            PlayedBy::Commands => {
                play_recorded(challenge, &self.episodes, threads, simulator, &found_one, compare)?;
            }
        }
        Ok(different)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base64::prelude::{BASE64_STANDARD, Engine};
    use naoisis_sim::simulation::NaoisisPlugins;

    fn simulator() -> App {
        let mut app = App::new();
        app.add_plugins(NaoisisPlugins);
        app
    }

    fn found_ball() -> (Challenge, ChallengeResult) {
        let challenge = Challenge::named("FindBall").unwrap().with(Realism::Realistic, None).unwrap();
        let player = ChallengePlayer::Behaviour("chaser".to_owned());
        let attempts = Attempts { episodes: 5, first_seed: 7, threads: 2 };
        let mut episodes = Vec::new();
        let go_on = AtomicBool::new(false);
        play_attempts(&challenge, &player, &attempts, simulator, &go_on, |attempt| episodes.push(attempt)).unwrap();
        let result = ChallengeResult::new(&challenge, (Realism::Realistic, None), &player, episodes);
        (challenge, result)
    }

    #[test]
    fn a_result_comes_out_the_same_and_a_changed_one_differs_at_its_episode() {
        let (challenge, result) = found_ball();
        let text = serde_json::to_string(&ResultFile { results: vec![result.clone()] }).unwrap();
        assert_eq!(ResultFile::from_text(&text).unwrap().results, core::slice::from_ref(&result));
        let go_on = AtomicBool::new(false);
        let verify = |result: &ChallengeResult| {
            result.verify(&challenge, PlayedBy::Player, 2, simulator, &go_on, || ()).unwrap()
        };
        assert_eq!(verify(&result), None);
        let moved = |attempt: &mut Attempt| attempt.end_state = "0123456789abcdef".to_owned();
        let changes: [fn(&mut Attempt); 2] = [moved, |attempt| attempt.is_success = !attempt.is_success];
        for (index, change) in changes.into_iter().enumerate() {
            let mut changed = result.clone();
            change(&mut changed.episodes[2 + index]);
            assert_eq!(verify(&changed), Some(result.episodes[2 + index].clone()));
        }
        // A file of an earlier version has no steps.
        let mut older = result.clone();
        older.episodes.iter_mut().for_each(|attempt| attempt.steps.clear());
        assert_eq!(verify(&older), None);
    }

    #[test]
    fn the_time_of_the_first_difference_is_that_of_its_step() {
        let (_, result) = found_ball();
        let one = &result.episodes[0];
        assert_eq!(one.first_difference_s(one), None);
        let mut other = one.clone();
        // Four characters have the bytes of three steps: the tenth character is in those of the seventh and of the eighth.
        let character = if other.steps.as_bytes()[9] == b'A' { "B" } else { "A" };
        other.steps.replace_range(9..10, character);
        let step_s = one.time_s / BASE64_STANDARD.decode(&one.steps).unwrap().len() as f64;
        let steps = one.first_difference_s(&other).unwrap() / step_s;
        assert!((6.9..8.1).contains(&steps), "{steps}");
    }

    #[test]
    fn the_score_of_a_method_is_that_of_its_policies_in_all_challenges() {
        let result = |challenge: &str, player: &str, successes: usize| ChallengeResult {
            naoisis: String::new(),
            challenge: challenge.to_owned(),
            version: 0,
            realism: Realism::Ideal,
            robot: None,
            player: player.to_owned(),
            interactions: None,
            rate: SuccessRate { episodes: 100, successes, mean_time_s: None },
            episodes: Vec::new(),
        };
        let rates = [60, 10, 50, 40, 90].into_iter().enumerate();
        let of_one: Vec<_> =
            rates.map(|(seed, rate)| result("GoToBall", &format!("policy:{seed}.onnx"), rate)).collect();
        let score = MethodScore::of(&of_one).unwrap();
        assert_eq!((score.policies, score.mean.value, score.interquartile_mean.value), (5, 0.5, 0.5));
        assert!(score.mean.low > 0.1 && score.mean.low < 0.4 && score.mean.high > 0.6, "{score}");
        let others = (0..5).map(|seed| result("FindBall", &format!("policy:{seed}.onnx"), 100));
        let of_two: Vec<_> = of_one.iter().cloned().chain(others).collect();
        let both = MethodScore::of(&of_two).unwrap();
        // Challenges are not drawn, so one in which all policies succeed adds no spread.
        assert!((both.mean.value - 0.75).abs() < 1e-9 && both.mean.margin() < 0.6 * score.mean.margin(), "{both}");
        let behaviours = [result("GoToBall", "chaser", 100), result("GoToBall", "policy:1.onnx", 50)];
        assert_eq!(MethodScore::of(&behaviours), None, "one policy");
    }

    #[test]
    fn interactions_are_told_with_their_budget() {
        let words = [0, 1_000_000, 1_000_001, 100_000_000, 100_000_001].map(interactions_in_words);
        let expected = ["0, small", "1000000, small", "1000001, large", "100000000, large", "100000001, over both"];
        assert_eq!(words, expected);
    }

    #[test]
    fn what_contradicts_itself_is_refused() {
        let (_, result) = found_ball();
        let refused = |change: fn(&mut ChallengeResult)| {
            let mut changed = result.clone();
            change(&mut changed);
            let text = serde_json::to_string(&ResultFile { results: vec![changed] }).unwrap();
            ResultFile::from_text(&text).unwrap_err().to_string()
        };
        assert_eq!(refused(|result| result.version = 0), "FindBall is of version 0; expected 2");
        assert!(refused(|result| result.challenge = "FindBal".to_owned()).contains("did you mean `FindBall`?"));
        let chaser = "FindBall, chaser: ";
        for (words, change) in [
            ("there are no episodes", (|result| result.episodes.clear()) as fn(&mut ChallengeResult)),
            ("the seeds of its episodes are no sequence", |result| result.episodes[1].seed = 3),
            ("its rate is not that of its episodes", |result| result.rate.successes = 9),
            ("its mean time is not that of its episodes", |result| result.rate.mean_time_s = Some(1.0)),
        ] {
            assert_eq!(refused(change), format!("{chaser}{words}"));
        }
    }
}
