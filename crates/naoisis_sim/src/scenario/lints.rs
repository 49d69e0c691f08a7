//! Notes on valid scenarios: settings that do not affect robots with their own model, and deprecated words.

use serde_json::Value;

use super::fidelity;
use super::read::read;
use super::robot_settings::RobotSettings;
use super::text::ScenarioFile;
use super::wording::all_of;
use naoisis_core::team::Team;

/// Settings of a scenario that do not reach some of its robots.
struct Unreached {
    /// Names of the settings in files.
    settings: Vec<&'static str>,
    /// The teams (`blue`) and robots (`blue1`) that are not affected.
    whom: Vec<String>,
    /// The model of these robots.
    model: String,
}

/// A robot, or all robots of a team, with its own model.
struct Holder<'a> {
    name: String,
    model: &'a str,
    /// Its settings in the file.
    said: Option<&'a Value>,
    /// Its settings in the scenario.
    has: &'a Value,
}

impl ScenarioFile {
    /// Returns the common settings of the file that do not reach some robots. A robot with its own model takes all settings from that
    /// model, so that a scenario's `motion`, `kicks` and so on apply only to robots without one.
    ///
    /// Settings of the match reach all robots: how images are made, whether robots see by images, what messages cost.
    fn unreached(&self) -> Vec<Unreached> {
        let Some(said) = self.values() else { return Vec::new() };
        let Ok(has) = serde_json::to_value(&self.scenario) else { return Vec::new() };
        let given: Vec<&'static str> = RobotSettings::OF_MODEL
            .iter()
            .copied()
            .filter(|field| *field != "messages" && said.get(field).is_some())
            .collect();
        let mut unreached: Vec<Unreached> = Vec::new();
        for holder in self.holders(&said, &has) {
            let settings: Vec<&'static str> =
                given.iter().copied().filter(|field| holder.lacks(field, &said, &has)).collect();
            if settings.is_empty() {
                continue;
            }
            match unreached.iter_mut().find(|one| one.model == holder.model && one.settings == settings) {
                Some(one) => one.whom.push(holder.name),
                None => {
                    unreached.push(Unreached { settings, whom: vec![holder.name], model: holder.model.to_owned() });
                }
            }
        }
        unreached
    }

    /// Returns notes on the scenario, a sentence each: which settings do not reach which robots with their own model, and which words are
    /// deprecated.
    pub fn notes(&self) -> Vec<String> {
        /// Number of robots that are named, at most.
        const MOST_NAMED: usize = 6;
        let note = |Unreached { settings, whom, model }: Unreached| {
            let [verb, them] = if settings.len() == 1 { ["does", "it"] } else { ["do", "them"] };
            let (named, others) = whom.split_at(whom.len().min(MOST_NAMED));
            let others = if others.is_empty() { String::new() } else { format!(" and {} more", others.len()) };
            format!(
                "{} of the scenario {verb} not reach {}{others}, whose model is `{model}`: say {them} beside that `model`, or in it",
                all_of(settings),
                named.join(", ")
            )
        };
        self.unreached().into_iter().map(note).chain(self.old_word()).collect()
    }

    /// Returns a note if the file uses `fidelity`.
    fn old_word(&self) -> Option<String> {
        let said = self.values()?;
        let of_teams = Team::BOTH.into_iter().filter_map(|team| said.get("teams")?.get(team.name()));
        let of_robots = said.get("robots").and_then(Value::as_array).into_iter().flatten();
        let says = of_teams.chain(of_robots).chain([&said]).any(|holder| holder.get(fidelity::FIELD).is_some());
        let note = "`fidelity` is an old word: say where percepts come from by the `source` of `vision`, `sonar` and `odometry`, and how noisy \
                    they are by `realism` or the sensor's `noise`";
        says.then(|| note.to_owned())
    }

    /// Returns the values of the text, with the settings laid over it.
    fn values(&self) -> Option<Value> {
        let mut values = read(&self.source.text, self.source.format).ok()?;
        for setting in &self.source.settings {
            // The settings have been applied before, so this does not fail.
            setting.lay_over(&mut values).ok()?;
        }
        Some(values)
    }

    /// Returns the teams and robots with their own model.
    fn holders<'a>(&self, said: &'a Value, has: &'a Value) -> Vec<Holder<'a>> {
        let place = |values: &'a Value, place: [&str; 2]| values.get(place[0])?.get(place[1]);
        let teams = Team::BOTH.map(|team| {
            let at = ["teams", team.name()];
            (team.name().to_owned(), place(said, at), place(has, at))
        });
        let of_robots = |values: &'a Value| values.get("robots").and_then(Value::as_array);
        let robots = self.scenario.robots.iter().enumerate().map(|(index, robot)| {
            let at = |values: &'a Value| of_robots(values)?.get(index);
            (robot.id().to_string(), at(said), at(has))
        });
        let holder = |(name, said, has): (String, Option<&'a Value>, Option<&'a Value>)| {
            let model = has?.get("model")?.as_str()?;
            Some(Holder { name, model, said, has: has? })
        };
        teams.into_iter().chain(robots).filter_map(holder).collect()
    }
}

impl Holder<'_> {
    /// Returns whether `field` differs from the scenario's value although the robot or team does not set it.
    fn lacks(&self, field: &str, said: &Value, of_all: &Value) -> bool {
        let model = self.said.and_then(|said| said.get("model"));
        let says = [self.said, model].into_iter().flatten().any(|said| said.get(field).is_some());
        let (Some(common), Some(own)) = (of_all.get(field), self.has.get(field)) else { return false };
        match said.get(field) {
            _ if says => false,
            Some(Value::Object(given)) => given.keys().any(|name| common.get(name) != own.get(name)),
            _ => common != own,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Format;

    fn notes(text: &str) -> Vec<String> {
        ScenarioFile::from_text(text, Format::Json, "scenario").unwrap().notes()
    }

    #[test]
    fn settings_that_do_not_reach_a_team_are_named_with_its_model() {
        let text = |own: &str| {
            format!(
                r#"{{ "league": "spl2025", "motion": {{ "max_linear_mps": 0.1 }}, "kicks": {{ "wind_up_s": 0.9 }},
                      "teams": {{ "blue": {{ "team": "roles", "model": "booster_k1" {own} }}, "pink": "roles" }} }}"#
            )
        };
        assert_eq!(
            notes(&text("")),
            [
                "`motion` and `kicks` of the scenario do not reach blue, whose model is `booster_k1`: say them beside that `model`, or in it"
            ]
        );
        // A robot's own settings are intended.
        assert_eq!(
            notes(&text(r#", "kicks": { "wind_up_s": 0.8 }"#)),
            [
                "`motion` of the scenario does not reach blue, whose model is `booster_k1`: say it beside that `model`, or in it"
            ]
        );
        let file = ScenarioFile::from_text(&text(""), Format::Json, "scenario").unwrap();
        let header = file.scenario.resolved_json().unwrap();
        assert_eq!(notes(&header), [""; 0]);
        let changed = file.with(&["head.max_degps=10".parse().unwrap()]).unwrap();
        assert_eq!(changed.unreached()[0].settings, ["head", "motion", "kicks"]);
    }

    #[test]
    fn settings_of_the_match_reach_everybody_and_so_do_equal_ones() {
        let text = |own: &str| {
            format!(
                r#"{{ "rules": "free", {own}, "robots": [{{}}, {{ "pose": [1, 1, 0], "model": "booster_k1" }}, {{ "pose": [-1, 1, 0], "model": "booster_k1" }}] }}"#
            )
        };
        for own in [
            r#""cameras": { "render": "software" }, "vision": { "source": "image" }"#,
            r#""messages": { "loss": 0.5 }"#,
            r#""sonar": { "fitted": false }"#,
            r#""field": "spl2025""#,
        ] {
            assert_eq!(notes(&text(own)), [""; 0], "{own}");
        }
        let words = "`cameras` of the scenario does not reach blue2, blue3, whose model";
        assert!(notes(&text(r#""cameras": { "width": 64 }"#))[0].starts_with(words));
    }

    #[test]
    fn an_old_word_is_named_wherever_it_stands_and_says_what_it_said() {
        let robots = |own: &str| format!(r#"{{ "rules": "free", "robots": [{{ "number": 1 {own} }}] }}"#);
        assert_eq!(notes(&robots("")), [""; 0]);
        let old = robots(r#", "fidelity": "ideal""#);
        assert!(notes(&old)[0].starts_with("`fidelity` is an old word"), "{:?}", notes(&old));
        let new =
            robots(r#", "vision": { "noise": "none" }, "odometry": { "noise": "none" }, "sonar": { "noise": "none" }"#);
        let [old, new] =
            [old, new].map(|text| ScenarioFile::from_text(&text, Format::Json, "scenario").unwrap().scenario);
        assert_eq!(old, new);
    }
}
