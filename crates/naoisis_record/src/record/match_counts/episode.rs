//! Counts of the episodes of learning environments, by the definitions of a match.

use bevy::prelude::*;

use super::{MatchCounter, RobotCounts};
use naoisis_agents::environment::counts::EpisodeCounter;
use naoisis_core::team::{PerTeam, Team};

/// Begins to count an episode in its present state.
pub fn begin_episode(world: &mut World) -> Box<dyn EpisodeCounter> {
    Box::new(MatchCounter::begin(world))
}

impl EpisodeCounter for MatchCounter {
    fn observe(&mut self, world: &World) {
        MatchCounter::observe(self, world);
    }

    fn counts(&self) -> Vec<(&'static str, PerTeam<f64>)> {
        let counts = MatchCounter::counts(self);
        let teams = PerTeam::new(|team| counts.team(team));
        let of = |value: fn(&RobotCounts) -> f64| PerTeam::new(|team| value(&teams[team]));
        let possession = |team: Team| counts.possession(team).unwrap_or(0.0);
        vec![
            ("goals", PerTeam::new(|team| f64::from(counts.goals[team]))),
            ("shots", of(|team| f64::from(team.shots))),
            ("shots_on_target", of(|team| f64::from(team.shots_on_target))),
            ("saves", of(|team| f64::from(team.saves))),
            ("kicks", of(|team| f64::from(team.kicks))),
            ("passes", of(|team| f64::from(team.passes))),
            ("passes_completed", of(|team| f64::from(team.passes_completed))),
            ("possession", PerTeam::new(possession)),
            ("distance_m", of(|team| team.distance_m)),
            ("falls", of(|team| f64::from(team.falls))),
            ("penalties", of(|team| f64::from(team.penalties.values().sum::<u32>()))),
        ]
    }
}
