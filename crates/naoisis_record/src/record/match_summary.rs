//! A match in numbers: its [counts](MatchCounts), its goals, its mistakes, and heat maps of the ball and the robots.

use bevy::prelude::*;

use super::match_counts::MatchCounts;
use super::mistakes::{Mistake, MistakeFinder};
use naoisis_core::events::MatchEvent;
use naoisis_core::game::Score;
use naoisis_core::pitch::{End, Pitch};
use naoisis_core::team::PerTeam;
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Cells of a heat map along the pitch.
pub const CELLS_ALONG: usize = 28;

/// The time that an object spent in each cell of the pitch, s: rows from -y, and in each row from -x. Blue defends -x: halves that are
/// played the other way are turned around.
#[derive(Clone, PartialEq, Debug)]
pub struct HeatMap {
    /// Number of rows, across the pitch.
    pub rows: usize,
    /// Time in each cell, s.
    pub time_s: Vec<f32>,
    half_m: Vec2,
}

impl HeatMap {
    fn new(pitch: &Pitch) -> Self {
        let half_m = Vec2::new(pitch.half_length(), pitch.half_width());
        let rows = ((CELLS_ALONG as f32 * half_m.y / half_m.x).round() as usize).clamp(1, 4 * CELLS_ALONG);
        Self { rows, time_s: vec![0.0; CELLS_ALONG * rows], half_m }
    }

    /// Adds `time_s` at `place`. Places beside the pitch count for the nearest cell.
    fn add(&mut self, place: Vec2, time_s: f32) {
        let share = ((place + self.half_m) / (2.0 * self.half_m)).clamp(Vec2::ZERO, Vec2::splat(0.999_99));
        let (column, row) = ((share.x * CELLS_ALONG as f32) as usize, (share.y * self.rows as f32) as usize);
        if let Some(cell) = self.time_s.get_mut(row * CELLS_ALONG + column) {
            *cell += time_s;
        }
    }

    /// Returns the longest time in a cell, s.
    pub fn most_s(&self) -> f32 {
        self.time_s.iter().copied().fold(0.0, f32::max)
    }
}

/// A match in numbers, up to the last cycle played.
#[derive(Clone, Debug)]
pub struct MatchSummary {
    /// The scenario's name.
    pub name: String,
    /// The seed.
    pub seed: u64,
    /// The match's level of realism, in words.
    pub realism: String,
    /// The names of the teams.
    pub teams: Option<PerTeam<String>>,
    /// The pitch.
    pub pitch: Pitch,
    /// The score.
    pub score: Score,
    /// How the result came about, if the score does not say.
    pub how: Option<String>,
    /// The time at the end, s since the start of the match.
    pub duration_s: f64,
    /// The goals: time (s), and team and scorer in words.
    pub goals: Vec<(f64, String)>,
    /// What was counted.
    pub counts: MatchCounts,
    /// Heat map of the ball.
    pub ball: HeatMap,
    /// Heat map of each team's robots.
    pub places: PerTeam<HeatMap>,
    mistakes: MistakeFinder,
}

impl MatchSummary {
    /// Creates an empty summary for a match of `scenario`.
    pub fn new(scenario: &Scenario) -> Self {
        let heat = || HeatMap::new(&scenario.field);
        let teams = scenario.teams.as_ref();
        Self {
            name: scenario.name.clone(),
            seed: scenario.seed,
            realism: scenario.realism_in_words(),
            teams: teams.map(|teams| PerTeam::new(|team| teams.name(team).to_owned())),
            pitch: scenario.field.clone(),
            score: Score::default(),
            how: None,
            duration_s: 0.0,
            goals: Vec::new(),
            counts: MatchCounts::new(scenario),
            ball: heat(),
            places: PerTeam::new(|_| heat()),
            mistakes: MistakeFinder::new(scenario),
        }
    }

    /// Adds the next cycle. The match begins with the first one.
    pub fn look(&mut self, record: &CycleRecord) {
        self.mistakes.look(record);
        self.score = record.game.score;
        self.duration_s = record.time_s;
        self.goals.extend(record.events.iter().filter_map(goal_in_words).map(|words| (record.time_s, words)));
        let play_s = self.counts.look_at_record(record) as f32;
        if play_s == 0.0 {
            return;
        }
        let first_way = |place: Vec2| if record.game.blue_end == End::NegativeX { place } else { -place };
        if let Some(ball) = record.ball {
            self.ball.add(first_way(ball.position_m.truncate()), play_s);
        }
        for robot in record.robots.iter().filter(|robot| robot.penalised.is_none()) {
            self.places[robot.id.team].add(first_way(robot.pose.position), play_s);
        }
    }

    /// Returns the mistakes up to now.
    pub fn mistakes(&self) -> Vec<Mistake> {
        self.mistakes.mistakes()
    }
}

/// Describes the team and the scorer of a goal. Returns `None` for other events.
fn goal_in_words(event: &MatchEvent) -> Option<String> {
    let MatchEvent::Goal { team, scorer, own_goal, .. } = event else { return None };
    Some(match scorer {
        Some(scorer) if *own_goal => format!("{team}, own goal by {scorer}"),
        Some(scorer) => format!("{team}, by {scorer}"),
        None => team.to_string(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::game::GameState;
    use naoisis_core::team::{RobotId, Team};
    use naoisis_sim::interface::cycle_record::{BallRecord, GameRecord, RobotRecord};

    #[test]
    fn halves_that_are_played_the_other_way_are_turned_around() {
        let mut summary = MatchSummary::new(&Scenario::default());
        for (cycle, blue_end) in
            [End::NegativeX, End::NegativeX, End::PositiveX, End::PositiveX].into_iter().enumerate()
        {
            // The ball is always in blue's half.
            let position_m = Vec3::X * 2.0 * blue_end.sign();
            summary.look(&CycleRecord {
                cycle: cycle as u64,
                time_s: cycle as f64 / 30.0,
                ball: Some(BallRecord { position_m, velocity_mps: Vec3::ZERO }),
                game: GameRecord { state: GameState::Playing, blue_end, ..default() },
                ..default()
            });
        }
        let left_s: f32 = summary.ball.time_s.chunks(CELLS_ALONG).flat_map(|row| &row[..CELLS_ALONG / 2]).sum();
        assert!((left_s - 0.1).abs() < 1e-6, "{left_s}");
    }

    #[test]
    fn heat_maps_have_the_time_in_play() {
        let mut summary = MatchSummary::new(&Scenario::default());
        for cycle in 0..4 {
            let robots = [(Team::Blue, 2), (Team::Blue, 3), (Team::Pink, 1)].map(|(team, id)| RobotId::new(team, id));
            summary.look(&CycleRecord {
                cycle,
                time_s: cycle as f64 / 30.0,
                ball: Some(BallRecord { position_m: Vec3::ZERO, velocity_mps: Vec3::ZERO }),
                robots: robots.map(RobotRecord::new).into(),
                game: GameRecord { state: GameState::Playing, ..default() },
                ..default()
            });
        }
        assert!((summary.ball.most_s() - 0.1).abs() < 1e-6);
        // Two robots, three cycles.
        let all_s: f32 = summary.places.blue.time_s.iter().sum();
        assert!((all_s - 0.2).abs() < 1e-6);
    }
}
