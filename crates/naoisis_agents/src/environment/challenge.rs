//! Named learning tasks as data: the scenario of an episode, the controlled robots, its end, and the condition of success.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};
use std::collections::BTreeMap;

pub use super::ending::EndConditions;
use super::reward::RewardWeights;
pub use super::situation::{Area, Shot, Situation, SituationError, StartArea};
use naoisis_core::statistics::{self, Estimate};
use naoisis_core::team::RobotId;
use naoisis_sim::scenario::wording::did_you_mean;
use naoisis_sim::scenario::{Format, Realism, Scenario, ScenarioError, ScenarioFile, Setting};

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
    /// What makes the task hard.
    pub hard: String,
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
    /// What differs for robots that are taller than [`TALL_M`].
    #[serde(default)]
    tall_robots: TallRobots,
    /// Situation and end for all other robots.
    #[serde(skip)]
    usual: (Situation, EndConditions),
    /// Success rates of some [players](super::attempts::ChallengePlayer) in each realism, as measured by `naoisis challenge`.
    pub success_rates: BTreeMap<String, BTreeMap<String, SuccessRate>>,
    /// Settings laid over the scenario, see [`with`](Self::with).
    #[serde(skip)]
    settings: Vec<Setting>,
}

/// The parts of a challenge that differ for tall robots, which are faster and see further. Parts without a value stay.
#[derive(Clone, PartialEq, Debug, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
struct TallRobots {
    /// The areas in which ball and robots start.
    situation: Option<Situation>,
    /// What ends an episode.
    end: Option<EndConditions>,
}

/// The height of robots above which challenges have their form for tall robots, m: NAOs are 0.57 m tall, K1 and T1 0.95 m and 1.18 m.
pub const TALL_M: f32 = 0.8;

/// The seed of the first episode while players are developed.
pub const DEVELOPMENT_SEED: u64 = 1;

/// The seed of the first episode of results that are published. Players must not be developed with the seeds from here on.
pub const RECORD_SEED: u64 = 1_000_000_001;

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

/// The suffix of the name of a challenge against opponents and with a robot that are held out.
pub const UNSEEN: &str = "_unseen";
/// The suffix of the name of a challenge in which robots see by camera images alone.
pub const IMAGES: &str = "_images";
/// The held-out robot, team, and players.
const UNSEEN_ROBOT: &str = "booster_t1";
const UNSEEN_TEAM: &str = "passers";
const UNSEEN_KEEPER: &str = "passing_keeper";
const UNSEEN_PLAYER: &str = "passer";

macro_rules! embedded {
    ($($name:literal)*) => {
        /// The built-in challenges by name, from `assets/challenges`.
        pub const CHALLENGES: &[(&str, &str)] =
            &[$(($name, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/", env!("NAOISIS_ASSETS"), "/challenges/", $name, ".json")))),*];
    };
}

embedded! { "FindBall" "ScoreEmptyGoal" "ScoreAgainstKeeper" "TwoOnTwo" "FirstGoal" "Match3v3"
"GoToBall" "GetUp" "WalkAcross" "KickAccuracy" "InterceptBall" "KeepGoal" "Localise" "PassAndScore" "OneOnOne" "Match5v5" }

/// The parts of the name of a form of a challenge.
struct Form<'a> {
    task: &'a str,
    is_unseen: bool,
    is_from_images: bool,
}

impl<'a> Form<'a> {
    /// Splits a name with each suffix at most once, in any order.
    fn of(name: &'a str) -> Self {
        let without = |name: &'a str, suffix| name.strip_suffix(suffix).map_or((name, false), |name| (name, true));
        let (inner, is_last) = without(name, UNSEEN);
        let (inner, is_from_images) = without(inner, IMAGES);
        let (task, is_first) = if is_last { (inner, false) } else { without(inner, UNSEEN) };
        Self { task, is_unseen: is_last || is_first, is_from_images }
    }
}

impl Challenge {
    /// Whether there is a built-in challenge `name`.
    pub fn exists(name: &str) -> bool {
        CHALLENGES.iter().any(|(known, _)| *known == Form::of(name).task)
    }

    /// The built-in challenge `name`. With [`UNSEEN`] after its name it is the held-out form, with [`IMAGES`] the form in which robots
    /// see by camera images alone.
    ///
    /// # Errors
    /// If there is no challenge with this name.
    pub fn named(name: &str) -> Result<Self, ChallengeError> {
        let Form { task, is_unseen, is_from_images } = Form::of(name);
        let Some((_, text)) = CHALLENGES.iter().find(|(known, _)| *known == task) else {
            let known: Vec<&str> = CHALLENGES.iter().map(|(name, _)| *name).collect();
            let meant = did_you_mean(name, known.iter().copied());
            return Err(ChallengeError::NoSuch { name: name.to_owned(), meant, known: known.join(", ") });
        };
        let read: Result<Self, _> = serde_json::from_str(text);
        let read = read.map_err(|error| ChallengeError::Malformed { name: name.to_owned(), error })?;
        let read = Self { usual: (read.situation.clone(), read.end), ..read };
        let read = if is_from_images { read.perceived_in_images() } else { read };
        Ok(if is_unseen { read.held_out() } else { read })
    }

    /// Appends a suffix to the name, and removes the rates, whose players stay. Returns the scenario.
    fn form(&mut self, suffix: &str) -> Option<&mut serde_json::Map<String, Value>> {
        self.name.push_str(suffix);
        self.success_rates.values_mut().flat_map(BTreeMap::values_mut).for_each(|rate| *rate = SuccessRate::default());
        let scenario = self.scenario.as_object_mut()?;
        scenario.insert("name".to_owned(), self.name.clone().into());
        Some(scenario)
    }

    /// The challenge in which detections come from the images of the robots' cameras.
    fn perceived_in_images(mut self) -> Self {
        if let Some(scenario) = self.form(IMAGES) {
            let vision = scenario.entry("vision").or_insert_with(|| json!({}));
            vision["source"] = "image".into();
        }
        self
    }

    /// The challenge against opponents and with a robot that are held out: for measuring what was learned without them.
    fn held_out(mut self) -> Self {
        let Some(scenario) = self.form(UNSEEN) else { return self };
        scenario.insert("model".to_owned(), UNSEEN_ROBOT.into());
        if let Some(teams) = scenario.get_mut("teams") {
            teams["pink"] = UNSEEN_TEAM.into();
        }
        for robot in scenario.get_mut("robots").and_then(Value::as_array_mut).into_iter().flatten() {
            let unseen = if robot["behaviour"] == "keeper" { UNSEEN_KEEPER } else { UNSEEN_PLAYER };
            if robot["team"] == "pink" {
                robot["behaviour"] = unseen.into();
            }
        }
        self
    }

    /// The challenge as it is laid out for the robots of `scenario`: in its form for tall robots, if the first controlled robot is taller
    /// than [`TALL_M`].
    pub fn laid_out_for(self, scenario: &Scenario) -> Self {
        let is_tall = self.control.first().is_some_and(|id| scenario.body_of(&scenario.robot(*id)).height_m > TALL_M);
        let TallRobots { situation, end } = if is_tall { self.tall_robots.clone() } else { TallRobots::default() };
        let (usual_situation, usual_end) = self.usual.clone();
        Self { situation: situation.unwrap_or(usual_situation), end: end.unwrap_or(usual_end), ..self }
    }

    /// The challenge in another `realism`, and with another `model` of the robots if there is one, [laid out](Self::laid_out_for) for them.
    ///
    /// Without a `model`, `realistic` has the NAO V6 in the place of the paper's NAO, for which there are no figures of a real robot.
    ///
    /// # Errors
    /// If the scenario is invalid then, for example because there is no such model.
    pub fn with(mut self, realism: Realism, model: Option<&str>) -> Result<Self, ChallengeError> {
        let is_paper = self.scenario()?.scenario.model == "nao";
        let model = model.or((realism == Realism::Realistic && is_paper).then_some("nao_v6"));
        let words = [Some(format!("realism={realism}")), model.map(|model| format!("model={model}"))];
        self.settings = words.into_iter().flatten().filter_map(|words| words.parse().ok()).collect();
        let scenario = self.scenario()?.scenario;
        Ok(self.laid_out_for(&scenario))
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
        let file = ScenarioFile::from_text(&format!("{scenario:#}"), Format::Json, &self.name)?;
        let changed = file.check_with(&self.settings);
        changed.or_else(|errors| errors.into_iter().next().map_or(Ok(file), Err))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;
    use naoisis_sensing::sensing::fidelity::Fidelity;
    use naoisis_sim::scenario::RealismSettings;
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
            assert!(!challenge.hard.is_empty() && challenge.description.ends_with('.'), "{name}");
            let rates = challenge.success_rates.iter();
            assert!(rates.clone().all(|(realism, _)| Realism::NAMES.contains(&realism.as_str())), "{name}");
            for realism in [Realism::Ideal, Realism::Realistic] {
                let with = |robot| challenge.clone().with(realism, robot).unwrap().scenario().unwrap().scenario;
                assert_eq!(with(Some("booster_k1")).model, "booster_k1");
                assert_eq!(with(None).realism, RealismSettings::all(realism));
                assert!(realism == Realism::Ideal || with(None).model != "nao", "{name}");
            }
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
        for (name, _) in CHALLENGES {
            let unseen = Challenge::named(&format!("{name}_unseen")).unwrap();
            assert!(unseen.name == format!("{name}_unseen") && Challenge::exists(&unseen.name));
            for realism in [Realism::Ideal, Realism::Realistic] {
                let scenario = unseen.clone().with(realism, None).unwrap().scenario().unwrap().scenario;
                assert_eq!(scenario.model, "booster_t1", "{name}");
                let of_pink = scenario.robots.iter().filter(|robot| robot.team == Team::Pink);
                let behaviours = of_pink.map(|robot| serde_json::to_value(&robot.behaviour).unwrap());
                assert!(behaviours.into_iter().all(|behaviour| behaviour == "passer" || behaviour == "passing_keeper"));
                assert!(scenario.teams.is_none_or(|teams| teams.pink == "passers"), "{name}");
            }
        }
        for name in ["FindBall", "GoToBall", "GetUp", "InterceptBall", "KeepGoal"] {
            let of_nao = Challenge::named(name).unwrap().with(Realism::Realistic, None).unwrap();
            let of_k1 = Challenge::named(name).unwrap().with(Realism::Realistic, Some("booster_k1")).unwrap();
            let unseen =
                |model| Challenge::named(&format!("{name}_unseen")).unwrap().with(Realism::Ideal, model).unwrap();
            let layout = |challenge: &Challenge| (challenge.situation.clone(), challenge.end);
            assert!(layout(&of_nao) != layout(&of_k1) && layout(&of_k1) == layout(&unseen(None)), "{name}");
            assert_eq!(layout(&of_nao), layout(&unseen(Some("nao_v6"))), "{name}");
            for seed in 0..50 {
                let scenario = of_k1.scenario().unwrap().scenario;
                assert!(of_k1.situation.drawn(Scenario { seed, ..scenario }).validate().is_ok(), "{name} {seed}");
            }
        }
        for name in ["FindBall_images", "TwoOnTwo_images_unseen", "Match3v3_unseen_images"] {
            let challenge = Challenge::named(name).unwrap();
            // Both orders are one form.
            assert!(challenge.name == name.replace("_unseen_images", "_images_unseen") && Challenge::exists(name));
            for realism in [Realism::Paper, Realism::Ideal, Realism::Realistic] {
                let scenario = challenge.clone().with(realism, None).unwrap().scenario().unwrap().scenario;
                assert_eq!(scenario.settings.vision.fidelity(), Fidelity::Image, "{name} {realism}");
            }
        }
        for nothing in
            ["Nothing_unseen", "GoToBall_unseen_unseen", "GoToBall_images_images", "GoToBall_unseen_images_unseen"]
        {
            assert!(Challenge::named(nothing).is_err() && !Challenge::exists(nothing), "{nothing}");
        }
        assert!(Challenge::named("ScoreGoal").unwrap_err().to_string().contains("expected one of FindBall"));
        let error = Challenge::named("findball").unwrap_err().to_string();
        assert!(error.starts_with("there is no challenge `findball`: did you mean `FindBall`?; expected"), "{error}");
    }
}
