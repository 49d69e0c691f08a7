//! Sweeps: a scenario with every combination of the values of some settings, and every pairing of some teams.

use std::sync::OnceLock;

use super::pairs::{Pairing, Pairs};
use super::variants::{Variants, fingerprint};
use naoisis_sim::scenario::{Scenario, ScenarioError, ScenarioFile, Setting};

/// The fields that select the teams of a pairing.
const TEAMS: [&str; 2] = ["teams.blue", "teams.pink"];

/// The number of combinations whose fingerprints are cached.
const MOST_REMEMBERED: usize = 1000;

/// Variants of a scenario: all combinations of the values of its settings, with the last setting changing fastest. If there are teams, each
/// combination is played with all their pairings.
#[derive(Clone, Debug)]
pub struct Sweep {
    /// The scenario, with the settings that all variants share.
    file: ScenarioFile,
    /// The values of each varied setting, at least one each.
    settings: Vec<Vec<Setting>>,
    pairs: Option<Pairs>,
    pairings: Vec<Pairing>,
    duration_s: Option<f32>,
    fingerprint: String,
    /// Cache of the realism in words, one entry for each of the first combinations.
    realisms: Vec<OnceLock<String>>,
}

impl Sweep {
    /// Creates the variants of a scenario. `settings` has the values of each setting. Each match stops after `duration_s`, if given.
    ///
    /// # Errors
    /// The first fault of the first variant.
    pub fn new(
        file: &ScenarioFile,
        settings: Vec<Vec<Setting>>,
        pairs: Option<Pairs>,
        duration_s: Option<f32>,
    ) -> Result<Self, ScenarioError> {
        let (fixed, swept): (Vec<_>, Vec<_>) = settings.iter().cloned().partition(|values| values.len() == 1);
        // Settings with one value are applied once, unless they are valid only together with the varied ones.
        let (file, settings) = match file.with(&fixed.concat()) {
            Ok(file) => (file, swept),
            Err(_) => (file.clone(), settings),
        };
        let pairings = pairs.as_ref().map(|pairs| pairs.pairings().collect()).unwrap_or_default();
        let sweep =
            Self { file, settings, pairs, pairings, duration_s, fingerprint: String::new(), realisms: Vec::new() };
        let first = sweep.variant(0)?.scenario;
        let remembered = sweep.combinations().unwrap_or(usize::MAX).min(MOST_REMEMBERED);
        Ok(Self { fingerprint: fingerprint(&first), realisms: vec![OnceLock::new(); remembered], ..sweep })
    }

    /// Returns the number of combinations of settings. Returns `None` if it is too large to count.
    pub fn combinations(&self) -> Option<usize> {
        self.settings.iter().try_fold(1usize, |product, values| product.checked_mul(values.len()))
    }

    /// Returns the number of variants of one combination of settings.
    pub fn variants_of_combination(&self) -> usize {
        self.pairings.len().max(1)
    }

    /// The teams that play each other.
    pub fn pairs(&self) -> Option<&Pairs> {
        self.pairs.as_ref()
    }

    /// Returns the pairing of teams in `variant`. Returns `None` if no teams were given.
    pub fn pairing(&self, variant: usize) -> Option<Pairing> {
        self.pairings.get(variant % self.variants_of_combination()).copied()
    }

    /// Returns a variant as a file, so that faults found later can be located in it.
    ///
    /// # Errors
    /// What is wrong with its settings.
    pub fn variant(&self, index: usize) -> Result<ScenarioFile, ScenarioError> {
        let mut settings: Vec<Setting> = self.settings_of(index).into_iter().cloned().collect();
        for (path, team) in TEAMS.into_iter().zip(self.teams_of(index)) {
            // A team's name is a single word, so this gives a single setting.
            settings.extend(Setting::sweep(&format!("{path}={team}")).unwrap_or_default());
        }
        let mut file = self.file.with(&settings)?;
        if self.duration_s.is_some() {
            file.scenario.duration_s = self.duration_s;
        }
        Ok(file)
    }

    /// Returns variants that together have every value of every setting, and every pairing. Their number grows with the number of values,
    /// not of combinations.
    pub fn samples(&self) -> Vec<usize> {
        let pairings = self.variants_of_combination();
        let mut samples: Vec<usize> = (0..pairings).collect();
        let mut step = pairings;
        for values in self.settings.iter().rev() {
            samples.extend((1..values.len()).map(|value| value * step));
            step = step.saturating_mul(values.len());
        }
        samples
    }

    /// Describes the settings that distinguish a variant from the others, such as `messages.loss = 0.2`.
    pub fn words(&self, variant: usize) -> String {
        let swept = self.settings_of(variant).into_iter().filter(|setting| self.is_swept(setting));
        swept.map(|setting| format!("{} = {}", setting.path(), setting.value())).collect::<Vec<String>>().join(", ")
    }

    /// Returns the settings of a variant, in their order.
    fn settings_of(&self, variant: usize) -> Vec<&Setting> {
        let mut combination = variant / self.variants_of_combination();
        let mut settings: Vec<&Setting> = self
            .settings
            .iter()
            .rev()
            .filter_map(|values| {
                let value = values.get(combination % values.len());
                combination /= values.len();
                value
            })
            .collect();
        settings.reverse();
        settings
    }

    /// Returns the names of the blue and the pink team.
    fn teams_of(&self, variant: usize) -> Vec<&str> {
        match (&self.pairs, self.pairing(variant)) {
            (Some(pairs), Some(pairing)) => pairs.names(pairing).to_vec(),
            _ => Vec::new(),
        }
    }

    fn is_swept(&self, setting: &Setting) -> bool {
        self.settings.iter().any(|values| values.len() > 1 && values.contains(setting))
    }
}

impl Variants for Sweep {
    fn count(&self) -> usize {
        self.combinations().unwrap_or(usize::MAX).saturating_mul(self.variants_of_combination())
    }

    fn scenario(&self, index: usize) -> Result<Scenario, ScenarioError> {
        self.variant(index).map(|file| file.scenario)
    }

    fn columns(&self) -> Vec<String> {
        let swept = self.settings.iter().filter(|values| values.len() > 1);
        let mut columns: Vec<String> = swept.filter_map(|values| Some(values.first()?.path().to_string())).collect();
        if self.pairs.is_some() {
            columns.extend(TEAMS.map(str::to_owned));
        }
        columns
    }

    fn values(&self, index: usize) -> Vec<String> {
        let swept = self.settings_of(index).into_iter().filter(|setting| self.is_swept(setting));
        swept.map(Setting::value).chain(self.teams_of(index).into_iter().map(str::to_owned)).collect()
    }

    fn realism(&self, index: usize) -> String {
        let combination = index / self.variants_of_combination();
        let words = || self.scenario(index).map(|scenario| scenario.realism_in_words()).unwrap_or_default();
        self.realisms.get(combination).map_or_else(words, |known| known.get_or_init(words).clone())
    }

    /// Fingerprint of the first variant: the other variants differ only in settings that have columns of their own.
    fn fingerprint(&self, _: usize) -> String {
        self.fingerprint.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep(settings: &[&str], teams: &[&str]) -> Sweep {
        let settings = settings.iter().map(|setting| Setting::sweep(setting).unwrap()).collect();
        let pairs = Pairs::of(teams.iter().map(|team| (*team).to_owned()).collect());
        let pairs = (!teams.is_empty()).then_some(pairs);
        Sweep::new(&ScenarioFile::named("match3v3").unwrap(), settings, pairs, Some(3.0)).unwrap()
    }

    #[test]
    fn variants_are_all_combinations_the_last_setting_changing_fastest() {
        let sweep = sweep(&["messages.loss=0,1", "rules.half_s=60", "messages.delay_cycles=1,2,3"], &[]);
        assert_eq!(sweep.count(), 6);
        assert_eq!(sweep.columns(), ["messages.loss", "messages.delay_cycles"]);
        let values: Vec<String> = (0..6).map(|variant| sweep.values(variant).join(" ")).collect();
        assert_eq!(values, ["0 1", "0 2", "0 3", "1 1", "1 2", "1 3"]);
        assert_eq!(sweep.words(4), "messages.loss = 1, messages.delay_cycles = 2");
        let scenario = sweep.scenario(4).unwrap();
        assert_eq!((scenario.messages.loss, scenario.messages.delay_cycles), (1.0, 2));
        assert_eq!((scenario.rules.half_s, scenario.duration_s), (60.0, Some(3.0)));
    }

    #[test]
    fn every_combination_is_played_by_every_pairing() {
        let sweep = sweep(&["messages.loss=0,1"], &["roles", "chasers"]);
        assert_eq!((sweep.count(), sweep.variants_of_combination()), (4, 2));
        let values: Vec<String> = (0..4).map(|variant| sweep.values(variant).join(" ")).collect();
        assert_eq!(values, ["0 roles chasers", "0 chasers roles", "1 roles chasers", "1 chasers roles"]);
        assert_eq!(sweep.scenario(3).unwrap().teams.unwrap().blue, "chasers");
        assert_eq!(sweep.words(3), "messages.loss = 1");
    }

    #[test]
    fn samples_have_every_value_and_a_million_combinations_are_no_more_than_their_values() {
        let hundred = |path: &str| {
            let values: Vec<String> = (1..=100).map(|value| value.to_string()).collect();
            format!("{path}={}", values.join(","))
        };
        let paths = ["rules.half_s", "rules.penalty_s", "messages.delay_cycles"].map(hundred);
        let sweep = sweep(&paths.each_ref().map(String::as_str), &["roles", "chasers"]);
        assert_eq!(sweep.count(), 2_000_000);
        let samples = sweep.samples();
        assert_eq!(samples.len(), 2 + 3 * 99);
        for column in 0..5 {
            let mut values: Vec<String> = samples.iter().map(|sample| sweep.values(*sample)[column].clone()).collect();
            values.sort();
            values.dedup();
            assert_eq!(values.len(), if column < 3 { 100 } else { 2 }, "{column}");
        }
        assert_eq!(sweep.values(1_999_999), ["100", "100", "100", "chasers", "roles"]);
    }

    #[test]
    fn settings_that_make_sense_with_others_only_are_no_mistake() {
        let sweep = sweep(&["messages.delay_cycles=2,3", "ball.position_m=[1,1]"], &[]);
        assert_eq!(sweep.scenario(1).unwrap().ball.unwrap().place_m().to_array(), [1.0, 1.0]);
        let text = r#"{ "robots": [{}], "ball": { "position_m": [1, 0] } }"#;
        let file = ScenarioFile::from_text(text, naoisis_sim::scenario::Format::Json, "one").unwrap();
        // The ball would be inside the robot where the file puts it, but not where the sweep puts it.
        let settings = ["ball.position_m=[0,0]", "robots[0].pose=[1,1,0],[2,1,0]"];
        let settings = settings.iter().map(|setting| Setting::sweep(setting).unwrap()).collect();
        let sweep = Sweep::new(&file, settings, None, None).unwrap();
        assert_eq!(sweep.columns(), ["robots[0].pose"]);
        assert_eq!(sweep.scenario(1).unwrap().robots[0].pose.position.to_array(), [2.0, 1.0]);
    }
}
