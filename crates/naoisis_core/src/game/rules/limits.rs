//! Valid ranges of the rules.

use core::fmt::Display;
use core::ops::RangeInclusive;

use super::Rules;

/// Error of [`Rules::validate`]: a field is out of range.
#[derive(Clone, PartialEq, thiserror::Error)]
#[error("{message}: expected {expected}")]
pub struct RulesError {
    /// The field of [`Rules`].
    pub field: &'static str,
    /// The field and its value.
    pub message: String,
    /// The valid range.
    pub expected: String,
}

debug_as_displayed!(RulesError);

/// Longest duration in the rules, s.
const LONGEST_S: f32 = 1e5;

impl Rules {
    /// Checks that all fields are in range.
    ///
    /// # Errors
    /// The first of the [errors](Rules::errors).
    pub fn validate(&self) -> Result<(), RulesError> {
        self.errors().into_iter().next().map_or(Ok(()), Err)
    }

    /// All fields that are out of range.
    pub fn errors(&self) -> Vec<RulesError> {
        let mut limits = Limits::default();
        limits.range("halves", self.halves, 1..=10, "");
        limits.range("extra_time_halves", self.extra_time_halves, 0..=10, "");
        limits.range("team_size", self.team_size, 1..=11, " robots");
        limits.range("substitutes", self.substitutes, 0..=11, " robots");
        limits.range("timeouts", self.timeouts, 0..=100, "");
        limits.range("mercy_goals", self.mercy_goals.unwrap_or(1), 1..=1000, " goals");
        limits.range("pushing_limit", self.pushing_limit.unwrap_or(1), 1..=1000, " collisions");
        limits.range("cautions_to_send_off", self.cautions_to_send_off.unwrap_or(1), 1..=100, " cautions");
        limits.range("get_up_attempts", self.get_up_attempts.unwrap_or(1), 1..=100, " attempts");
        limits.range("offence_free_kick_m", self.offence_free_kick_m.unwrap_or(0.0), 0.0..=100.0, " m");
        limits.range("collision_speed_mps", self.collision_speed_mps, 0.0..=10.0, " m/s");
        limits.range("free_kick_distance_m", self.free_kick_distance_m.unwrap_or(0.0), 0.0..=100.0, " m");
        limits.range("fall_from_mps", self.fall_from_mps, 0.0..=100.0, " m/s");
        limits.range("fall_certain_mps", self.fall_certain_mps, self.fall_from_mps..=100.0, " m/s");
        limits.range("dive_down_s", self.dive_down_s, 0.0..=self.dive_s, " s");
        limits.range("dive_reach_m", self.dive_reach_m, 0.0..=2.0, " m");
        limits.range("shoot_out_shots", self.shoot_out_shots, 1..=100, " shots");
        limits.range("sudden_death_shots", self.sudden_death_shots, 1..=100, " shots");
        limits.positive("stall_radius_m", self.stall_radius_m, 100.0, " m");
        limits.positive("global_stuck_m", self.global_stuck_m.unwrap_or(1.0), 100.0, " m");
        let positive_durations = [
            ("half_s", self.half_s),
            ("extra_half_s", self.extra_half_s),
            ("timeout_s", self.timeout_s),
            ("referee_timeout_s", self.referee_timeout_s),
            ("stall_s", self.stall_s),
            ("free_kick_s", self.free_kick_s),
            ("penalty_kick_ready_s", self.penalty_kick_ready_s),
            ("penalty_kick_s", self.penalty_kick_s),
            ("ball_holding_s", self.ball_holding_s),
            ("keeper_ball_holding_s", self.keeper_ball_holding_s),
            ("in_goal_s", self.in_goal_s),
            ("obstruction_s", self.obstruction_s),
            ("inactive_s", self.inactive_s),
            ("game_stuck_s", self.game_stuck_s),
            ("fallen_s", self.fallen_s),
            ("get_up_limit_s", self.get_up_limit_s),
            ("shoot_out_s", self.shoot_out_s),
            ("local_stuck_s", self.local_stuck_s.unwrap_or(1.0)),
            ("push_contact_s", self.push_contact_s.unwrap_or(1.0)),
            ("sudden_death_s", self.sudden_death_s.unwrap_or(1.0)),
        ];
        for (field, value) in positive_durations {
            limits.positive(field, value, LONGEST_S, " s");
        }
        let durations = [
            ("penalty_s", self.penalty_s),
            ("penalty_increase_s", self.penalty_increase_s),
            ("free_kick_leave_s", self.free_kick_leave_s),
            ("initial_s", self.initial_s),
            ("free_kick_stop_s", self.free_kick_stop_s),
            ("standby_s", self.standby_s),
            ("standby_random_s", self.standby_random_s),
            ("motion_in_set_s", self.motion_in_set_s.unwrap_or(0.0)),
            ("ready_s", self.ready_s),
            ("set_s", self.set_s),
            ("illegal_position_s", self.illegal_position_s.unwrap_or(0.0)),
            ("kick_off_free_s", self.kick_off_free_s.unwrap_or(0.0)),
            ("illegal_defender_s", self.illegal_defender_s),
            ("get_up_s", self.get_up_s),
            ("dive_s", self.dive_s),
            ("status_delay_s", self.status_delay_s),
            ("ready_delay_s", self.ready_delay_s),
            ("goal_delay_s", self.goal_delay_s),
            ("free_kick_signal_s", self.free_kick_signal_s),
        ];
        for (field, value) in durations {
            limits.range(field, value, 0.0..=LONGEST_S, " s");
        }
        limits.errors
    }
}

/// Collects the fields that are out of range, including all that are NaN.
#[derive(Default)]
struct Limits {
    errors: Vec<RulesError>,
}

impl Limits {
    fn range<T: PartialOrd + Display>(&mut self, field: &'static str, value: T, range: RangeInclusive<T>, unit: &str) {
        if !range.contains(&value) {
            self.error(field, value, format!("{} to {}{unit}", range.start(), range.end()));
        }
    }

    fn positive(&mut self, field: &'static str, value: f32, most: f32, unit: &str) {
        if !(value > 0.0 && value <= most) {
            self.error(field, value, format!("more than 0, at most {most}{unit}"));
        }
    }

    fn error(&mut self, field: &'static str, value: impl Display, expected: String) {
        self.errors.push(RulesError { field, message: format!("`{field}` is {value}"), expected });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_that_contradict_themselves_name_the_field() {
        assert_eq!(Rules::default().validate(), Ok(()));
        let wrong = [
            ("halves", Rules { halves: 0, ..Rules::default() }),
            ("team_size", Rules { team_size: 0, ..Rules::default() }),
            ("half_s", Rules { half_s: 0.0, ..Rules::default() }),
            ("half_s", Rules { half_s: -1.0, ..Rules::default() }),
            ("half_s", Rules { half_s: f32::NAN, ..Rules::default() }),
            ("penalty_s", Rules { penalty_s: -0.1, ..Rules::default() }),
            ("illegal_position_s", Rules { illegal_position_s: Some(-1.0), ..Rules::default() }),
            ("pushing_limit", Rules { pushing_limit: Some(0), ..Rules::default() }),
            ("stall_radius_m", Rules { stall_radius_m: 0.0, ..Rules::default() }),
            ("fall_certain_mps", Rules { fall_from_mps: 0.5, fall_certain_mps: 0.4, ..Rules::default() }),
            ("status_delay_s", Rules { status_delay_s: f32::INFINITY, ..Rules::default() }),
        ];
        for (field, rules) in wrong {
            assert_eq!(rules.validate().map_err(|error| error.field), Err(field));
        }
    }
}
