//! Choices about a match before it begins: league, realism, robot models.
//!
//! A choice is merged into the text of the match's scenario, as by `--set`: values in the text stay, and the rest is
//! resolved again.

use serde_json::{Value, json};
use std::sync::OnceLock;

use naoisis_core::team::Team;
use naoisis_sim::scenario::{
    Format, LEAGUES, League, MODELS, Realism, RobotModel, Scenario, ScenarioError, ScenarioFile, Setting, TeamsSpec,
};

/// A choice.
#[derive(Clone, PartialEq, Eq, Debug)]
pub enum MatchChoice {
    /// A league by name: a new match of the current teams, with nothing else from the current match.
    League(String),
    /// The same match with another realism.
    Realism(Realism),
    /// Another robot model of a team, by name; `None` for the scenario's.
    Model(Team, Option<String>),
}

impl MatchChoice {
    /// Returns the scenario after the choice, from the current one and, if known, its text.
    ///
    /// # Errors
    /// A message about the resulting scenario if it is invalid.
    pub fn applied(&self, present: &Scenario, file: Option<&ScenarioFile>) -> Result<ScenarioFile, String> {
        let in_words = |error: ScenarioError| error.to_string();
        let mut chosen = match self {
            MatchChoice::League(league) => {
                let teams = present.teams.clone().unwrap_or_default();
                let teams = json!({ "blue": teams.blue, "pink": teams.pink });
                let text = json!({ "name": league, "league": league, "teams": teams }).to_string();
                ScenarioFile::from_text(&text, Format::Json, league).map_err(in_words)?
            }
            MatchChoice::Realism(_) | MatchChoice::Model(..) => {
                let file = match file {
                    Some(file) => file.clone(),
                    None => {
                        let text = present.resolved_json().map_err(|error| error.to_string())?;
                        ScenarioFile::from_text(&text, Format::Json, "the match").map_err(in_words)?
                    }
                };
                file.with(&self.settings(present, &file.scenario)?).map_err(in_words)?
            }
        };
        chosen.scenario.seed = present.seed;
        Ok(chosen)
    }

    /// The settings to merge into the text: the choice, and the teams that were chosen before.
    fn settings(&self, present: &Scenario, of_text: &Scenario) -> Result<Vec<Setting>, String> {
        let mut settings = Vec::new();
        let mut set = |path: &str, value: &Value| {
            let setting = format!("{path}={value}").parse::<Setting>().map_err(|error| error.to_string());
            setting.map(|setting| settings.push(setting))
        };
        if let MatchChoice::Realism(realism) = self {
            set("realism", &json!(realism.name()))?;
        }
        let name = |teams: Option<&TeamsSpec>, team| teams.map(|teams| teams.name(team).to_owned());
        for team in Team::BOTH {
            let Some(teams) = &present.teams else { continue };
            let path = format!("teams.{}", team.name());
            match self {
                MatchChoice::Model(side, model) if *side == team => {
                    set(&path, &json!({ "team": teams.name(team), "model": model }))?;
                }
                _ if name(of_text.teams.as_ref(), team).as_deref() != Some(teams.name(team)) => {
                    set(&path, &json!({ "team": teams.name(team), "model": teams.robots[team].model }))?;
                }
                _ => {}
            }
        }
        Ok(settings)
    }
}

/// The levels of realism, with descriptions.
pub const REALISMS: [(Realism, &str); 3] = [
    (Realism::Paper, "The settings of the paper"),
    (Realism::Ideal, "The paper's models without noise"),
    (Realism::Realistic, "The figures of real robots"),
];

/// Returns the leagues, with descriptions.
pub fn leagues() -> &'static [(String, String)] {
    static ENTRIES: OnceLock<Vec<(String, String)>> = OnceLock::new();
    ENTRIES.get_or_init(|| {
        let leagues = LEAGUES.iter().filter_map(|preset| League::named(preset.name));
        leagues.map(|league| (league.name, league.description)).collect()
    })
}

/// Returns the robot models, with descriptions.
pub fn models() -> &'static [(String, String)] {
    static ENTRIES: OnceLock<Vec<(String, String)>> = OnceLock::new();
    ENTRIES.get_or_init(|| {
        let models = MODELS.iter().filter_map(|preset| RobotModel::find(preset.name).ok());
        models.map(|model| (model.name, model.description)).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_match_can_be_had_of_every_league_and_every_model() {
        let present = Scenario::named("match3v3").unwrap();
        assert_eq!((leagues().len(), models().len()), (LEAGUES.len(), MODELS.len()));
        for (name, _) in leagues() {
            let file = MatchChoice::League(name.clone()).applied(&present, None).unwrap();
            assert_eq!(file.scenario.league.as_ref(), Some(name));
        }
        let file = ScenarioFile::named("spl2025").unwrap();
        for (name, _) in models() {
            let chosen =
                MatchChoice::Model(Team::Blue, Some(name.clone())).applied(&file.scenario, Some(&file)).unwrap();
            let teams = chosen.scenario.teams.unwrap();
            assert_eq!((teams.robots.blue.model.as_ref(), &teams.robots.pink.model), (Some(name), &None));
        }
    }

    #[test]
    fn what_was_chosen_before_stays() {
        let file = ScenarioFile::named("match3v3").unwrap();
        let present = Scenario { teams: Some(TeamsSpec::new("passers", "chasers")), seed: 42, ..file.scenario.clone() };
        let real = MatchChoice::Realism(Realism::Realistic).applied(&present, Some(&file)).unwrap();
        assert_eq!(real.scenario.realism_in_words(), "realistic");
        assert_eq!((real.scenario.seed, real.scenario.teams.as_ref().unwrap().blue.as_str()), (42, "passers"));
        let k1 =
            MatchChoice::Model(Team::Pink, Some("booster_k1".to_owned())).applied(&real.scenario, Some(&real)).unwrap();
        assert_eq!(k1.scenario.realism_in_words(), real.scenario.realism_in_words());
        assert_eq!(k1.scenario.teams.unwrap().name(Team::Blue), "passers");
    }
}
