//! Changes the realism of a scenario, and describes it in words.

use serde_json::{Map, Value, json};

use super::deserialize;
use super::presets;
use super::realism::RealismSettings;
use super::robot_spec::RobotSpec;
use super::teams_spec::TeamsSpec;
use super::types::{BallSpec, Scenario};
use naoisis_core::team::Team;
use naoisis_sensing::sensing::camera::CameraSettings;
use naoisis_sensing::sensing::camera::lens::Lens;
use naoisis_sensing::sensing::fidelity::{Fidelity, SensorFidelity};
use naoisis_sensing::sensing::odometry::{OdometryNoise, OdometrySettings};
use naoisis_sensing::sensing::sonar::{SonarNoise, SonarSettings};
use naoisis_sensing::sensing::vision::{VisionNoise, VisionSettings};

impl Scenario {
    /// Returns the scenario with the settings of another realism and of its model, in place of its own. The defaults apply for an unknown
    /// model and for the paper.
    #[must_use]
    pub fn with_realism(self, realism: RealismSettings) -> Scenario {
        let mut root = Map::new();
        root.insert("model".to_owned(), json!(self.model));
        root.insert("realism".to_owned(), serde_json::to_value(realism).unwrap_or_default());
        presets::resolve(&mut root);
        let real: Scenario = deserialize::read(&Value::Object(root)).unwrap_or_default();
        let of_league = |ball: BallSpec| match real.ball {
            Some(of_league) => ball.with_physics(of_league.physics()),
            None => ball,
        };
        let mut settings = self.settings.clone();
        settings.take_realism_from(real.settings);
        // The realism changes the errors of sensors, but neither their mounts, the source of their readings nor what they look for.
        settings.cameras = with_errors_of(self.settings.cameras, settings.cameras);
        settings.vision = VisionSettings { noise: settings.vision.noise, ..self.settings.vision };
        settings.sonar.source = self.settings.sonar.source;
        settings.odometry = OdometrySettings { noise: settings.odometry.noise, ..self.settings.odometry };
        Scenario { realism, ball: self.ball.map(of_league), settings, messages: real.messages, ..self }
    }

    /// Returns a robot that has another model than the scenario's, and no own settings.
    fn robot_of_model(&self, model: &str) -> RobotSpec {
        let mut root = Map::new();
        root.insert("realism".to_owned(), serde_json::to_value(self.realism).unwrap_or_default());
        root.insert("cameras".to_owned(), serde_json::to_value(self.settings.cameras).unwrap_or_default());
        root.insert("vision".to_owned(), json!({ "source": self.settings.vision.source }));
        root.insert("robots".to_owned(), json!([{ "model": model }]));
        presets::resolve(&mut root);
        let scenario: Scenario = deserialize::read(&Value::Object(root)).unwrap_or_default();
        scenario.robots.into_iter().next().unwrap_or_default()
    }

    /// Describes the realism of the scenario: a word such as `paper`, or `realistic but for kicks` if the scenario has its own settings of
    /// a part.
    pub fn realism_in_words(&self) -> String {
        let real = self.clone().with_realism(self.realism);
        // The settings that a robot gets from its own model follow the realism.
        let mut models: Vec<(String, RobotSpec)> = Vec::new();
        let mut has_own = |robot: &RobotSpec| {
            let model = robot.model.clone().unwrap_or_default();
            if !models.iter().any(|(name, _)| *name == model) {
                let of_model = robot.model.as_ref().map_or_else(RobotSpec::default, |model| self.robot_of_model(model));
                models.push((model.clone(), of_model));
            }
            let of_model = models.iter().find(|(name, _)| *name == model).map(|(_, of_model)| of_model);
            of_model.is_some_and(|real| {
                let mut own = robot.own.clone();
                let of_real = real.own.cameras.unwrap_or(self.settings.cameras);
                if own.cameras.is_none_or(|cameras| cameras == with_errors_of(cameras, of_real)) {
                    own.cameras = real.own.cameras;
                }
                own.differs_in_realism(&real.own)
            })
        };
        let mut of_teams = self.teams.iter().flat_map(|teams| Team::BOTH.map(|team| teams.robot(team, 1)));
        let any_has_own = self.robots.iter().any(&mut has_own) || of_teams.any(|robot| has_own(&robot));
        let mut own = if self.ball == real.ball { Vec::new() } else { vec!["ball"] };
        own.extend(self.settings.real_differences(&real.settings));
        if self.messages != real.messages && !own.contains(&"messages") {
            own.push("messages");
        }
        own.extend(any_has_own.then_some("single robots"));
        let has_handicap = |teams: &TeamsSpec| Team::BOTH.iter().any(|team| teams.robots[*team].handicap > 0.0);
        own.extend(self.teams.as_ref().is_some_and(has_handicap).then_some("handicaps"));
        let words = self.realism.to_string();
        if own.is_empty() { words } else { format!("{words} but for {}", own.join(", ")) }
    }
}

impl Scenario {
    /// Changes source and noise of the sensors of all robots to those of `fidelity`. If sensors without noise are to have some, they get
    /// that of the scenario's realism.
    pub fn set_fidelity(&mut self, fidelity: Fidelity) {
        let real = self.clone().with_realism(self.realism).settings;
        let settings = &mut self.settings;
        if matches!(fidelity, Fidelity::Noisy | Fidelity::Image) {
            if settings.vision.noise == VisionNoise::none() {
                settings.vision.noise = real.vision.noise;
            }
            if settings.sonar.noise == SonarNoise::None {
                settings.sonar = SonarSettings { source: settings.sonar.source, ..real.sonar };
            }
            if settings.odometry.noise == OdometryNoise::none() {
                settings.odometry.noise = real.odometry.noise;
            }
        }
        settings.vision.set_fidelity(fidelity);
        settings.sonar.set_fidelity(fidelity);
        settings.odometry.set_fidelity(fidelity);
        let of_teams = self.teams.iter_mut().flat_map(|teams| [&mut teams.robots.blue, &mut teams.robots.pink]);
        for own in self.robots.iter_mut().map(|robot| &mut robot.own).chain(of_teams.map(|robots| &mut robots.own)) {
            own.vision.iter_mut().for_each(|vision| vision.set_fidelity(fidelity));
            own.sonar.iter_mut().for_each(|sonar| sonar.set_fidelity(fidelity));
            own.odometry.iter_mut().for_each(|odometry| odometry.set_fidelity(fidelity));
        }
    }
}

/// Returns `cameras` with the errors of `real`: noise, vignetting, exposure and readout. Distortion belongs to their optics.
fn with_errors_of(cameras: CameraSettings, real: CameraSettings) -> CameraSettings {
    let lens = Lens { distortion: cameras.lens.distortion, ..real.lens };
    CameraSettings { lens, noise: real.noise, ..cameras }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::{Realism, RobotSettings, ScenarioFile};
    use naoisis_core::ball::Rolling;

    fn read(value: Value) -> Scenario {
        Scenario::from_json(&value.to_string()).unwrap()
    }

    #[test]
    fn what_a_scenario_does_not_say_comes_of_its_realism_and_each_part_has_its_own() {
        assert_eq!(read(json!({ "realism": "paper" })), Scenario::default());
        let ideal = read(json!({ "realism": "ideal", "sonar": { "max_m": 0.5 } }));
        assert_eq!(
            (ideal.settings.vision.noise, ideal.settings.odometry.noise),
            (VisionNoise::none(), OdometryNoise::none())
        );
        assert_eq!((ideal.settings.sonar.noise, ideal.settings.sonar.max_m), (SonarNoise::None, 0.5));
        let real = read(json!({
            "realism": "realistic", "model": "nao_v6",
            "ball": { "position_m": [1, 0], "rolling": { "exponential_per_s": 1.0 } },
            "vision": { "noise": { "ball": { "pixel_sd": 2.0 } } },
            "robots": [{ "pose": [-2, 0, 0], "vision": { "noise": { "head_angle_sd_deg": 0.0 } } }, { "sonar": { "noise": "none" } }],
        }));
        let ball = real.ball.unwrap();
        assert_eq!((ball.radius_m, ball.rolling), (0.05, Rolling::ExponentialPerS(1.0)));
        assert_eq!((real.settings.motion.max_linear_mps, real.messages.loss), (0.242, 0.1));
        assert_eq!(
            (real.settings.vision.noise.ball.pixel_sd, real.settings.vision.noise.ball.miss_probability),
            (2.0, 0.1)
        );
        let own = real.robots[0].own.vision.as_ref().unwrap().noise;
        assert_eq!((own.ball, own.head_angle_sd), (real.settings.vision.noise.ball, 0.0));
        let own = real.robots[1].own.sonar.as_ref().unwrap();
        assert_eq!((own.noise, own.min_m), (SonarNoise::None, 0.2));
        let kicks = read(json!({ "realism": { "kicks": "realistic" }, "ball": null }));
        let Scenario { settings, realism, .. } = Scenario::default();
        assert_ne!(kicks.settings.kicks, settings.kicks);
        let others = RobotSettings { kicks: settings.kicks, ..kicks.settings.clone() };
        assert_eq!(
            Scenario { settings: others, realism, ball: Some(BallSpec::default()), ..kicks },
            Scenario::default()
        );
        let value = json!({ "realism": "realistic", "vision": { "noise": "none" }, "ball": "naoisis" });
        let own = read(value);
        assert_eq!((own.settings.vision.noise, own.ball), (VisionNoise::none(), Some(BallSpec::default())));
        for word in [Realism::Ideal, Realism::Realistic, Realism::Paper] {
            let built = read(json!({ "model": "nao_v6" })).with_realism(RealismSettings::all(word));
            assert_eq!(built, read(json!({ "realism": word, "model": "nao_v6" })));
        }
    }

    #[test]
    fn a_model_that_there_is_not_is_refused_with_the_names() {
        let error = Scenario::from_json(r#"{ "model": "nao_6" }"#).unwrap_err().to_string();
        assert!(error.contains("there is no model `nao_6`: did you mean `nao_v6`? expected `booster_k1`"), "{error}");
        assert!(error.ends_with("`nao`, `nao_v6` or `rover`, or the path of a `.ron` file"), "{error}");
    }

    #[test]
    fn settings_of_its_own_are_told_whatever_the_word_stands_for() {
        assert_eq!(Scenario::default().realism_in_words(), "paper");
        let real = read(json!({ "realism": "realistic", "model": "nao_v6" }));
        assert_eq!(real.realism_in_words(), "realistic");
        let own =
            read(json!({ "realism": "realistic", "kicks": { "speed_sd": 0.0 }, "robots": [{ "fidelity": "truth" }] }));
        assert_eq!(own.realism_in_words(), "realistic but for kicks, single robots");
        // A robot's own model is no change of the realism, but a change of that model is.
        let of_two = |change: Value| {
            let mut blue = json!({ "team": "roles", "model": "booster_k1" });
            if let (Some(blue), Value::Object(change)) = (blue.as_object_mut(), change) {
                blue.extend(change);
            }
            read(json!({ "league": "spl2025", "teams": { "blue": blue, "pink": "roles" } }))
        };
        let lined_up = |scenario: Scenario| {
            let robots = Team::BOTH.map(|team| scenario.robot(naoisis_core::team::RobotId::new(team, 1)));
            Scenario { teams: None, robots: robots.to_vec(), ..scenario }
        };
        for scenario in [of_two(json!({})), lined_up(of_two(json!({})))] {
            assert!(!scenario.realism_in_words().contains("single robots"), "{}", scenario.realism_in_words());
        }
        let own = of_two(json!({ "motion": { "max_linear_mps": 0.1 } }));
        for scenario in [own.clone(), lined_up(own)] {
            assert!(scenario.realism_in_words().ends_with("single robots"), "{}", scenario.realism_in_words());
        }
        // The header of a trace has all values, so another word changes only the name.
        let header = real.resolved_json().unwrap();
        let file = ScenarioFile::from_text(&header, crate::scenario::Format::Json, "header").unwrap();
        let renamed = file.with(&["realism=ideal".parse().unwrap()]).unwrap().scenario;
        assert_eq!(
            renamed.realism_in_words(),
            "ideal but for ball, cameras, motion, kicks, vision, sonar, odometry, falls, breakdowns, hearing, latency, messages"
        );
    }
}
