//! Handicaps: teams that are slower, lie longer and see less than their settings say.

use bevy::math::ops;

use super::robot_settings::RobotSettings;
use naoisis_sensing::sensing::vision::ClassNoise;

impl RobotSettings {
    /// Returns the settings of a robot with a `handicap` between 0 (none) and 0.9. Walking and turning are slower by this share, falls in
    /// walking are as frequent on the same way, a fall in a kick and a failure to get up are as probable as in 1 / (1 - `handicap`) tries,
    /// and the share 1 - `handicap` of all detections is left.
    #[must_use]
    pub(super) fn with_handicap(mut self, handicap: f32) -> RobotSettings {
        if handicap <= 0.0 {
            return self;
        }
        let left = 1.0 - handicap.min(0.9);
        let motion = &mut self.motion;
        motion.max_linear_mps *= left;
        motion.max_angular *= left;
        if let Some(gait) = &mut motion.gait {
            gait.backward_mps *= left;
            gait.sideways_mps *= left;
            gait.least_mps *= left;
            gait.least_angular *= left;
        }
        let falls = &mut self.falls;
        falls.falls_per_min *= left;
        for probability in
            [&mut falls.kick_probability, &mut falls.get_up_failure, &mut falls.get_up_failure_in_contact]
        {
            *probability = within_tries(*probability, 1.0 / left);
        }
        if let Some(probability) = &mut falls.trip_probability {
            *probability = within_tries(*probability, 1.0 / left);
        }
        let noise = &mut self.vision.noise;
        let classes: [&mut ClassNoise; 7] = [
            &mut noise.ball, &mut noise.goal_posts, &mut noise.robots, &mut noise.lines, &mut noise.junctions,
            &mut noise.penalty_crosses, &mut noise.centre_circle,
        ];
        for class in classes {
            class.miss_probability = 1.0 - (1.0 - class.miss_probability) * left;
        }
        self
    }
}

/// The probability that an event with this `probability` in each try happens within `tries`.
fn within_tries(probability: f32, tries: f32) -> f32 {
    1.0 - ops::powf(1.0 - probability, tries)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenario::Scenario;
    use approx::assert_abs_diff_eq;
    use naoisis_core::team::{RobotId, Team};

    fn teams(blue: &str) -> Result<Scenario, String> {
        let text = format!(r#"{{ "league": "spl2025", "teams": {{ "blue": {blue}, "pink": "roles" }} }}"#);
        Scenario::from_json(&text).map_err(|error| error.to_string())
    }

    #[test]
    fn a_team_with_a_handicap_is_slower_gets_up_less_often_and_sees_less() {
        let scenario = teams(r#"{ "team": "roles", "handicap": 0.25 }"#).unwrap();
        let [blue, pink] = Team::BOTH.map(|team| scenario.settings_of(&scenario.robot(RobotId::new(team, 2))));
        assert_abs_diff_eq!(blue.motion.max_linear_mps, 0.75 * pink.motion.max_linear_mps, epsilon = 1e-6);
        // At this speed as many falls a metre.
        assert_abs_diff_eq!(blue.falls.falls_per_min, 0.75 * pink.falls.falls_per_min, epsilon = 1e-4);
        // As in 1 / 0.75 tries.
        assert_abs_diff_eq!(
            ops::powf(1.0 - blue.falls.get_up_failure, 0.75),
            1.0 - pink.falls.get_up_failure,
            epsilon = 1e-4
        );
        assert_abs_diff_eq!(within_tries(0.5, 2.0), 0.75, epsilon = 1e-6);
        assert_eq!([within_tries(0.0, 4.0), within_tries(1.0, 4.0)], [0.0, 1.0]);
        let [few, many] = [&blue, &pink].map(|settings| 1.0 - settings.vision.noise.ball.miss_probability);
        assert_abs_diff_eq!(few, 0.75 * many, epsilon = 1e-6);
        // The realism of the scenario mentions handicaps.
        assert!(scenario.realism_in_words().ends_with("but for handicaps"), "{}", scenario.realism_in_words());
        // The handicap is written as it was read, and the default is left out.
        let written = serde_json::to_string(&scenario).unwrap();
        assert!(written.contains(r#""handicap":0.25"#), "{written}");
        assert_eq!(Scenario::from_json(&written).unwrap(), scenario);
        assert!(!serde_json::to_string(&teams(r#""roles""#).unwrap()).unwrap().contains("handicap"));
    }

    #[test]
    fn a_handicap_beyond_its_range_is_refused() {
        for wrong in ["-0.1", "0.95", "1"] {
            let problem = teams(&format!(r#"{{ "team": "roles", "handicap": {wrong} }}"#)).unwrap_err();
            assert!(problem.contains("handicap") && problem.contains("0.9"), "{problem}");
        }
    }
}
