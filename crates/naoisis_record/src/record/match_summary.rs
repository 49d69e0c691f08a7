//! A match in numbers: shots, saves, possession, passes, distances, where everybody was, penalties.

use bevy::prelude::*;
use std::collections::BTreeMap;

use super::kick_outcomes::{KickEnd, KickFollower, StruckKick};
use super::mistakes::{Mistake, MistakeFinder};
use naoisis_core::events::{CollisionPartner, KickResult, MatchEvent};
use naoisis_core::game::{GameState, PenaltyReason, Score};
use naoisis_core::pitch::Pitch;
use naoisis_core::team::{PerTeam, RobotId};
use naoisis_sim::interface::cycle_record::CycleRecord;
use naoisis_sim::scenario::Scenario;

/// Who moves further in a cycle was carried, m.
const CARRIED_M: f32 = 0.2;
/// Cells of a heat map along the pitch.
pub const CELLS_ALONG: usize = 28;

/// What a team did.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct TeamNumbers {
    /// Kicks that struck the ball.
    pub kicks: u32,
    /// Those of them after which the ball would have got between the opponents' posts.
    pub shots: u32,
    /// Shots of the opponents that its keeper touched.
    pub saves: u32,
    /// Kicks that were no shots and after which another robot touched the ball, or it was out: balls played on.
    pub passes: u32,
    /// Those of them that a team-mate got.
    pub passes_arrived: u32,
    /// Time of play in which it had touched the ball last, s.
    pub possession_s: f64,
    /// The way that its robots walked in play, m.
    pub distance_m: f32,
}

/// What a robot did.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RobotNumbers {
    /// Kicks that struck the ball.
    pub kicks: u32,
    /// Those of them that were shots.
    pub shots: u32,
    /// Goals.
    pub goals: u32,
    /// Passes that arrived.
    pub passes_arrived: u32,
    /// The way that it walked in play, m.
    pub distance_m: f32,
    /// Falls.
    pub falls: u32,
    /// Its penalties, by reason.
    pub penalties: BTreeMap<PenaltyReason, u32>,
}

/// How long something was in each cell of the pitch, s: rows from -y, in each from -x.
#[derive(Clone, PartialEq, Debug)]
pub struct HeatMap {
    /// Cells across.
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

    /// Something was at a place for so long. What is beside the pitch counts for its edge.
    fn add(&mut self, place: Vec2, time_s: f32) {
        let share = ((place + self.half_m) / (2.0 * self.half_m)).clamp(Vec2::ZERO, Vec2::splat(0.999_99));
        let (column, row) = ((share.x * CELLS_ALONG as f32) as usize, (share.y * self.rows as f32) as usize);
        if let Some(cell) = self.time_s.get_mut(row * CELLS_ALONG + column) {
            *cell += time_s;
        }
    }

    /// The longest time in a cell, s.
    pub fn most_s(&self) -> f32 {
        self.time_s.iter().copied().fold(0.0, f32::max)
    }
}

/// A match in numbers, as far as it was played.
#[derive(Clone, Debug)]
pub struct MatchSummary {
    /// The scenario's name.
    pub name: String,
    /// The seed.
    pub seed: u64,
    /// How much of a real robot there was, in words.
    pub realism: String,
    /// What the teams are called.
    pub teams: Option<PerTeam<String>>,
    /// The pitch.
    pub pitch: Pitch,
    /// Goals.
    pub score: Score,
    /// Time of the match, s.
    pub duration_s: f64,
    /// Time of play, s.
    pub play_s: f64,
    /// When goals were scored, s, in words.
    pub goals: Vec<(f64, String)>,
    /// What the teams did.
    pub numbers: PerTeam<TeamNumbers>,
    /// What the robots did.
    pub robots: BTreeMap<RobotId, RobotNumbers>,
    /// Where the ball was.
    pub ball: HeatMap,
    /// Where the robots of the teams were.
    pub places: PerTeam<HeatMap>,
    kicks: KickFollower,
    mistakes: MistakeFinder,
    last_touch: Option<RobotId>,
    before: BTreeMap<RobotId, Vec2>,
    period_s: f64,
}

impl MatchSummary {
    /// The summary of a match of this scenario that has not begun.
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
            duration_s: 0.0,
            play_s: 0.0,
            goals: Vec::new(),
            numbers: PerTeam::default(),
            robots: BTreeMap::new(),
            ball: heat(),
            places: PerTeam::new(|_| heat()),
            kicks: KickFollower::new(scenario),
            mistakes: MistakeFinder::new(scenario),
            last_touch: None,
            before: BTreeMap::new(),
            period_s: scenario.cycle_s,
        }
    }

    /// Looks at the next cycle.
    pub fn look(&mut self, record: &CycleRecord) {
        self.mistakes.look(record);
        self.score = record.game.score;
        self.duration_s = record.time_s;
        for event in &record.events {
            self.count(record, event);
        }
        for (kick, end) in self.kicks.look(record) {
            self.judge_kick(kick, end);
        }
        let is_play = record.game.state == GameState::Playing;
        if is_play {
            self.play_s += self.period_s;
            if let Some(robot) = self.last_touch {
                self.numbers[robot.team].possession_s += self.period_s;
            }
            if let Some(ball) = record.ball {
                self.ball.add(ball.position_m.truncate(), self.period_s as f32);
            }
        }
        for robot in &record.robots {
            let numbers = self.robots.entry(robot.id).or_default();
            let place = robot.pose.position;
            let before = self.before.insert(robot.id, place);
            if is_play && robot.penalised.is_none() {
                let way_m = before.map_or(0.0, |before| before.distance(place));
                if way_m < CARRIED_M {
                    numbers.distance_m += way_m;
                    self.numbers[robot.id.team].distance_m += way_m;
                }
                self.places[robot.id.team].add(place, self.period_s as f32);
            }
        }
    }

    /// What went wrong.
    pub fn mistakes(&self) -> Vec<Mistake> {
        self.mistakes.mistakes()
    }

    fn count(&mut self, record: &CycleRecord, event: &MatchEvent) {
        match event {
            MatchEvent::Kick { robot, result: KickResult::Kicked | KickResult::Reduced, .. } => {
                self.last_touch = Some(*robot);
                self.numbers[robot.team].kicks += 1;
                self.robots.entry(*robot).or_default().kicks += 1;
            }
            MatchEvent::Collision { robot: Some(robot), with: CollisionPartner::Ball, .. } => {
                self.last_touch = Some(*robot);
            }
            MatchEvent::Goal { team, scorer, own_goal, .. } => {
                let by = match scorer {
                    Some(scorer) if *own_goal => format!("{team}, own goal by {scorer}"),
                    Some(scorer) => format!("{team}, by {scorer}"),
                    None => team.to_string(),
                };
                self.goals.push((record.time_s, by));
                if let Some(scorer) = scorer.filter(|_| !own_goal) {
                    self.robots.entry(scorer).or_default().goals += 1;
                }
            }
            MatchEvent::Fall { robot, .. } => self.robots.entry(*robot).or_default().falls += 1,
            MatchEvent::Penalty { robot, reason, .. } => {
                *self.robots.entry(*robot).or_default().penalties.entry(*reason).or_default() += 1;
            }
            _ => {}
        }
    }

    /// Takes note of a kick, now that it is known what became of it.
    fn judge_kick(&mut self, kick: StruckKick, end: KickEnd) {
        let team = kick.robot.team;
        if kick.is_at_goal(&self.pitch, 0.0) || end == KickEnd::Goal(team) {
            self.numbers[team].shots += 1;
            self.robots.entry(kick.robot).or_default().shots += 1;
            if let KickEnd::Touched(robot) = end
                && robot.team != team
                && robot.is_goalkeeper()
            {
                self.numbers[robot.team].saves += 1;
            }
            return;
        }
        match end {
            KickEnd::Touched(robot) if robot == kick.robot => {}
            KickEnd::Touched(robot) => {
                self.numbers[team].passes += 1;
                if robot.team == team {
                    self.numbers[team].passes_arrived += 1;
                    self.robots.entry(kick.robot).or_default().passes_arrived += 1;
                }
            }
            KickEnd::Out => self.numbers[team].passes += 1,
            KickEnd::Goal(_) | KickEnd::Stopped => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::kick_outcomes::kick;
    use super::*;
    use core::f32::consts::FRAC_PI_2;
    use naoisis_core::geometry::Pose;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::cycle_record::{BallRecord, GameRecord, RobotRecord};

    const BLUE2: RobotId = RobotId::new(Team::Blue, 2);
    const BLUE3: RobotId = RobotId::new(Team::Blue, 3);
    const PINK1: RobotId = RobotId::new(Team::Pink, 1);

    /// The summary of three cycles of play with these events in each.
    fn summary(events: [Vec<MatchEvent>; 3]) -> MatchSummary {
        let mut summary = MatchSummary::new(&Scenario::default());
        for (cycle, events) in (1..).zip(events) {
            let mut robots: Vec<RobotRecord> = [BLUE2, BLUE3, PINK1].map(RobotRecord::new).into();
            // Blue 2 walks 1 cm in a cycle; blue 3 is carried 1 m.
            robots[0].pose = Pose::new(0.01 * cycle as f32, 0.0, 0.0);
            robots[1].pose = Pose::new(cycle as f32 - 2.0, 1.0, 0.0);
            summary.look(&CycleRecord {
                cycle,
                time_s: cycle as f64 / 30.0,
                ball: Some(BallRecord { position_m: Vec3::ZERO, velocity_mps: Vec3::ZERO }),
                robots,
                game: GameRecord { state: GameState::Playing, ..default() },
                events,
            });
        }
        summary
    }

    #[test]
    fn kicks_are_shots_that_are_saved_and_passes_that_arrive() {
        // Blue attacks +x.
        let saved = summary([vec![kick(BLUE2, 0.0)], vec![kick(PINK1, FRAC_PI_2)], vec![]]);
        assert_eq!((saved.numbers.blue.shots, saved.numbers.pink.saves, saved.numbers.blue.passes), (1, 1, 0));
        let passed = summary([vec![kick(BLUE2, FRAC_PI_2)], vec![kick(BLUE3, FRAC_PI_2)], vec![kick(PINK1, 0.0)]]);
        let blue = passed.numbers.blue;
        assert_eq!((blue.kicks, blue.passes, blue.passes_arrived, blue.shots), (2, 2, 1, 0));
        assert_eq!(passed.robots[&BLUE2].passes_arrived, 1);
        // Two cycles of three.
        assert!((blue.possession_s - 2.0 / 30.0).abs() < 1e-9);
    }

    #[test]
    fn ways_are_walked_and_places_counted_in_play() {
        let summary = summary([vec![], vec![], vec![]]);
        assert!((summary.robots[&BLUE2].distance_m - 0.02).abs() < 1e-6);
        assert_eq!(summary.robots[&BLUE3].distance_m, 0.0);
        assert!((summary.ball.most_s() - 0.1).abs() < 1e-6);
        // Two robots, three cycles.
        let all_s: f32 = summary.places.blue.time_s.iter().sum();
        assert!((all_s - 0.2).abs() < 1e-6);
    }
}
