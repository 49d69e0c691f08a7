//! Named learning tasks as data: the scenario of an episode, the controlled robots, its end, and the condition of success.

use bevy::prelude::*;
use rand::RngExt;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::collections::BTreeMap;

use super::reward::RewardWeights;
use naoisis_core::events::MatchEvent;
use naoisis_core::geometry::{Pose, to_radians, wrap_angle};
use naoisis_core::random::RandomStream;
use naoisis_core::statistics::{self, Estimate};
use naoisis_core::team::{RobotId, Team};
use naoisis_sim::scenario::wording::did_you_mean;
use naoisis_sim::scenario::{Format, Scenario, ScenarioError, ScenarioFile};

/// A named learning task.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Challenge {
    /// Its name, such as `ScoreEmptyGoal`.
    pub name: String,
    /// Increased when the task changes.
    pub version: u32,
    /// A description in one or two sentences.
    pub description: String,
    /// The scenario of the episodes, as in a file.
    scenario: Value,
    /// The robots that are controlled.
    pub control: Vec<RobotId>,
    /// The robot that is controlled if there is only one agent.
    pub solo: RobotId,
    /// The areas in which ball and robots start.
    #[serde(default)]
    pub situation: Situation,
    /// What ends an episode, with success or failure.
    #[serde(default)]
    pub end: EndConditions,
    /// The longest duration of an episode, s; `None` if only the final whistle ends it.
    #[serde(default)]
    pub limit_s: Option<f32>,
    /// The number of cycles for which an action is held.
    pub cycles_per_step: u32,
    /// The weights of the reward.
    pub reward: RewardWeights,
    /// Success rates of some [players](super::attempts::ChallengePlayer), as measured by `naoisis challenge`.
    pub success_rates: BTreeMap<String, SuccessRate>,
}

/// The success rate of a player.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuccessRate {
    /// Episodes that were played.
    pub episodes: usize,
    /// Successful episodes.
    pub successes: usize,
    /// The mean duration of successful episodes, s; `None` if there were none.
    pub mean_time_s: Option<f64>,
}

impl SuccessRate {
    /// The success rate with its confidence interval; `None` without episodes.
    pub fn share(&self) -> Option<Estimate> {
        statistics::share(self.successes, self.episodes)
    }
}

/// What ends an episode, besides its time limit and the final whistle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EndConditions {
    /// A goal for this team is a success, a goal for the other team a failure.
    pub goal_for: Option<Team>,
    /// The final whistle is a success if this team has won.
    pub win_for: Option<Team>,
    /// The episode succeeds when the first controlled robot sees the ball.
    pub ball_seen: bool,
    /// The episode fails when the ball leaves the pitch.
    pub ball_out: bool,
}

impl EndConditions {
    /// Whether `events` end the episode: the team that scored, or `None` inside if nobody did.
    pub(super) fn of_events<'a>(&self, events: impl Iterator<Item = &'a MatchEvent>) -> Option<Option<Team>> {
        let mut ended = None;
        for event in events {
            match (event, self.goal_for) {
                (MatchEvent::Goal { team, .. }, Some(_)) => return Some(Some(*team)),
                (MatchEvent::BallOut { .. }, _) if self.ball_out => ended = Some(None),
                _ => {}
            }
        }
        ended
    }
}

/// A range: the least and the greatest value.
type Range = [f32; 2];

/// The areas from which start positions are drawn. Everything else starts as in the scenario.
#[derive(Clone, PartialEq, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Situation {
    /// The area of the ball, pitch frame.
    pub ball: Option<Area>,
    /// The areas of robots.
    pub robots: BTreeMap<RobotId, StartArea>,
}

/// An area on the pitch, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// The range along the pitch, m.
    x_m: Range,
    /// The range across the pitch, m.
    y_m: Range,
}

/// The area in which a robot may start, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartArea {
    /// The range along the pitch, m.
    x_m: Range,
    /// The range across the pitch, m.
    y_m: Range,
    /// The range of its heading, deg.
    heading_deg: Range,
}

fn draw([low, high]: Range, stream: &mut RandomStream) -> f32 {
    low + (high - low) * stream.random::<f32>()
}

impl Situation {
    /// Whether nothing is drawn.
    pub fn is_empty(&self) -> bool {
        self.ball.is_none() && self.robots.is_empty()
    }

    /// The scenario with start positions drawn by its seed.
    pub(super) fn drawn(&self, scenario: Scenario) -> Scenario {
        /// The greatest number of draws of the positions, which are repeated if robots overlap.
        const MOST_TRIES: usize = 100;

        let mut stream = RandomStream::for_match(scenario.seed, "situation");
        for _ in 0..MOST_TRIES {
            let mut tried = scenario.clone();
            if let (Some(area), Some(ball)) = (self.ball, &mut tried.ball) {
                ball.position_m = Vec2::new(draw(area.x_m, &mut stream), draw(area.y_m, &mut stream)).extend(0.0);
            }
            for robot in &mut tried.robots {
                let Some(place) = self.robots.get(&robot.id()) else { continue };
                let [x, y] = [place.x_m, place.y_m].map(|range| draw(range, &mut stream));
                robot.pose = Pose::new(x, y, wrap_angle(to_radians(draw(place.heading_deg, &mut stream))));
            }
            if tried.validate().is_ok() {
                return tried;
            }
        }
        scenario
    }
}

/// Why a challenge cannot be read.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum ChallengeError {
    /// No challenge has this name.
    #[error("there is no challenge `{name}`{meant}; expected one of {known}")]
    NoSuch {
        /// The name.
        name: String,
        /// A suggestion, in words.
        meant: String,
        /// All names of challenges.
        known: String,
    },
    /// The text is not a valid challenge in JSON.
    #[error("the challenge `{name}`: {error}")]
    Malformed {
        /// The name of the challenge.
        name: String,
        /// The error in the text.
        error: serde_json::Error,
    },
    /// The scenario is invalid.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
}

naoisis_core::debug_as_displayed!(ChallengeError);

macro_rules! embedded {
    ($($name:literal)*) => {
        /// The built-in challenges by name, from `assets/challenges`.
        pub const CHALLENGES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/challenges/", $name, ".json")))),*];
    };
}

embedded! { "FindBall" "ScoreEmptyGoal" "ScoreAgainstKeeper" "TwoOnTwo" "FirstGoal" "Match3v3" }

impl Challenge {
    /// The built-in challenge `name`.
    ///
    /// # Errors
    /// If there is no challenge with this name.
    pub fn named(name: &str) -> Result<Self, ChallengeError> {
        let Some((_, text)) = CHALLENGES.iter().find(|(known, _)| *known == name) else {
            let known: Vec<&str> = CHALLENGES.iter().map(|(name, _)| *name).collect();
            let meant = did_you_mean(name, known.iter().copied());
            return Err(ChallengeError::NoSuch { name: name.to_owned(), meant, known: known.join(", ") });
        };
        serde_json::from_str(text).map_err(|error| ChallengeError::Malformed { name: name.to_owned(), error })
    }

    /// The scenario of the episodes, with the time limit as its duration.
    ///
    /// # Errors
    /// If the scenario is invalid; a test rules this out for built-in challenges.
    pub fn scenario(&self) -> Result<ScenarioFile, ScenarioError> {
        let mut scenario = self.scenario.clone();
        if let (Some(limit_s), Some(fields)) = (self.limit_s, scenario.as_object_mut()) {
            fields.insert("duration_s".to_owned(), limit_s.into());
        }
        ScenarioFile::from_text(&format!("{scenario:#}"), Format::Json, &self.name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn all_challenges_of_the_folder_are_there_and_can_be_started_in_many_ways() {
        let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"))).join("challenges");
        let mut files: Vec<String> = folder
            .read_dir()
            .unwrap()
            .map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
            .collect();
        let mut names: Vec<&str> = CHALLENGES.iter().map(|(name, _)| *name).collect();
        files.sort();
        names.sort_unstable();
        assert_eq!(files, names);
        for name in names {
            let challenge = Challenge::named(name).unwrap();
            assert_eq!(challenge.name, name);
            let scenario = challenge.scenario().unwrap().scenario;
            assert!(challenge.control.iter().all(|id| scenario.has_robot(*id)), "{name}");
            assert!(challenge.control.contains(&challenge.solo), "{name}");
            for seed in 0..50 {
                let drawn = challenge.situation.drawn(Scenario { seed, ..scenario.clone() });
                assert!(drawn.validate().is_ok());
                let again = challenge.situation.drawn(Scenario { seed, ..scenario.clone() });
                assert_eq!(drawn, again);
                assert_eq!(drawn.ball == scenario.ball, challenge.situation.ball.is_none(), "{name} {seed}");
            }
        }
        assert!(Challenge::named("ScoreGoal").unwrap_err().to_string().contains("expected one of FindBall"));
        let error = Challenge::named("findball").unwrap_err().to_string();
        assert!(error.starts_with("there is no challenge `findball`: did you mean `FindBall`?; expected"), "{error}");
    }
}
