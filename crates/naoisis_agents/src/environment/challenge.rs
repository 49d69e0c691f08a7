//! Named tasks, as data: what happens in an episode, who is controlled, when it is over, and what is a success.

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

/// A task.
#[derive(Clone, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Challenge {
    /// Its name, such as `ScoreEmptyGoal`.
    pub name: String,
    /// Counted up when what it asks for changes.
    pub version: u32,
    /// What is to be done, in a sentence or two.
    pub description: String,
    /// The scenario, as files have it, in which episodes are played.
    scenario: Value,
    /// The robots that are controlled.
    pub control: Vec<RobotId>,
    /// The one of them that is controlled where there is one agent only.
    pub solo: RobotId,
    /// Where the ball and robots stand at the start.
    #[serde(default)]
    pub situation: Situation,
    /// What ends an episode well, and badly.
    #[serde(default)]
    pub end: EndConditions,
    /// When an episode ends at the latest, s; none where the final whistle ends it.
    #[serde(default)]
    pub limit_s: Option<f32>,
    /// Cycles that an action lasts.
    pub cycles_per_step: u32,
    /// What is rewarded.
    pub reward: RewardWeights,
    /// How often it succeeds with some [players](super::attempts::ChallengePlayer), as `naoisis challenge` measured it.
    pub success_rates: BTreeMap<String, SuccessRate>,
}

/// How often a player succeeded.
#[derive(Clone, Copy, PartialEq, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SuccessRate {
    /// Episodes that were played.
    pub episodes: usize,
    /// Those of them that were a success.
    pub successes: usize,
    /// How long a success took on average, s; none where there was none.
    pub mean_time_s: Option<f64>,
}

impl SuccessRate {
    /// The share, with its interval. None without episodes.
    pub fn share(&self) -> Option<Estimate> {
        statistics::share(self.successes, self.episodes)
    }
}

/// What ends an episode, besides its time and the final whistle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct EndConditions {
    /// A goal for this team is a success, and one for the other a failure.
    pub goal_for: Option<Team>,
    /// At the final whistle it is a success when this team has won.
    pub win_for: Option<Team>,
    /// It is a success when the first of the controlled robots sees the ball.
    pub ball_seen: bool,
    /// It is a failure when the ball leaves the pitch.
    pub ball_out: bool,
}

impl EndConditions {
    /// Whether a success is one of this team's robots.
    pub(super) fn is_for(&self, team: Team) -> bool {
        self.goal_for.or(self.win_for).is_none_or(|of| of == team)
    }

    /// Whether what happened ends the episode, and if so whether that is a success.
    pub(super) fn of_events<'a>(&self, events: impl Iterator<Item = &'a MatchEvent>) -> Option<bool> {
        let mut ended = None;
        for event in events {
            match (event, self.goal_for) {
                (MatchEvent::Goal { team, .. }, Some(for_team)) => return Some(*team == for_team),
                (MatchEvent::BallOut { .. }, _) if self.ball_out => ended = Some(false),
                _ => {}
            }
        }
        ended
    }
}

/// A range, from the least to the greatest value.
type Range = [f32; 2];

/// Where things stand at the start of episodes: drawn from these, and else as the scenario has it.
#[derive(Clone, PartialEq, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Situation {
    /// The ball's place, pitch frame.
    pub ball: Option<Area>,
    /// The robots' places.
    pub robots: BTreeMap<RobotId, StartArea>,
}

/// Where something may be, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Area {
    /// Along the pitch, m.
    x_m: Range,
    /// Across it, m.
    y_m: Range,
}

/// Where a robot may stand, pitch frame.
#[derive(Clone, Copy, PartialEq, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartArea {
    /// Along the pitch, m.
    x_m: Range,
    /// Across it, m.
    y_m: Range,
    /// Its heading, deg.
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

    /// The scenario with everything where it stands in the episode of its seed.
    pub(super) fn drawn(&self, scenario: Scenario) -> Scenario {
        /// So often robots that stand in each other are placed anew.
        const MOST_TRIES: usize = 100;

        let mut stream = RandomStream::for_match(scenario.seed, "situation");
        for _ in 0..MOST_TRIES {
            let mut tried = scenario.clone();
            if let (Some(area), Some(ball)) = (self.ball, &mut tried.ball) {
                ball.position_m = Vec2::new(draw(area.x_m, &mut stream), draw(area.y_m, &mut stream));
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
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChallengeError {
    /// There is none of this name.
    #[error("there is no challenge `{name}`{meant}; expected one of {known}")]
    NoSuch {
        /// The name.
        name: String,
        /// What was probably meant, in words.
        meant: String,
        /// All that there are.
        known: String,
    },
    /// It is no JSON of a challenge.
    #[error("the challenge `{name}`: {error}")]
    Malformed {
        /// Its name.
        name: String,
        /// What is wrong.
        error: serde_json::Error,
    },
    /// Its scenario is wrong.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
}

macro_rules! embedded {
    ($($name:literal)*) => {
        /// The challenges that come with the program, by name: `assets/challenges`.
        pub const CHALLENGES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("NAOISIS_ASSETS"), "/challenges/", $name, ".json")))),*];
    };
}

embedded! { "FindBall" "ScoreEmptyGoal" "ScoreAgainstKeeper" "TwoOnTwo" "FirstGoal" "Match3v3" }

impl Challenge {
    /// The challenge of this name.
    ///
    /// # Errors
    /// When there is none.
    pub fn named(name: &str) -> Result<Self, ChallengeError> {
        let Some((_, text)) = CHALLENGES.iter().find(|(known, _)| *known == name) else {
            let known: Vec<&str> = CHALLENGES.iter().map(|(name, _)| *name).collect();
            let meant = did_you_mean(name, known.iter().copied());
            return Err(ChallengeError::NoSuch { name: name.to_owned(), meant, known: known.join(", ") });
        };
        serde_json::from_str(text).map_err(|error| ChallengeError::Malformed { name: name.to_owned(), error })
    }

    /// The scenario in which its episodes are played, until its time is over.
    ///
    /// # Errors
    /// When it is wrong, which a test rules out for those of the program.
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
        let folder = Path::new(env!("NAOISIS_ASSETS")).join("challenges");
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
