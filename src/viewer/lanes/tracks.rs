//! What robots did over the whole match, as spans and marks: from its records.

use bevy::prelude::*;
use std::collections::BTreeMap;

use crate::events::{KickResult, MatchEvent};
use crate::record::beliefs::Sensed;
use crate::record::cycle_record::{CycleRecord, RobotRecord};
use crate::record::mistakes::{Mistake, MistakeFinder};
use crate::robot::posture::Posture;
use crate::scenario::Scenario;
use crate::team::RobotId;
use crate::viewer::cycle_samples::{CycleSample, RobotSample};

/// From what a robot knows where the ball is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BallSource {
    /// It sees it.
    Seen,
    /// It has seen it not long ago.
    Remembered,
    /// A team-mate told it.
    Told,
    /// It does not know.
    Lost,
}

/// How a robot is.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// On its feet and in play.
    Up,
    /// It lies, or gets up.
    Down,
    /// Off the pitch.
    Penalised,
}

/// A time over which something stayed the same.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Span<T> {
    /// The first cycle.
    pub first: u64,
    /// The last cycle.
    pub last: u64,
    /// What it was.
    pub what: T,
}

/// A robot over the match.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct RobotTrack {
    /// What it said that it meant to do: which of the [words](Tracks::words).
    pub intentions: Vec<Span<usize>>,
    /// From what it knew of the ball.
    pub ball: Vec<Span<BallSource>>,
    /// How it was.
    pub conditions: Vec<Span<Condition>>,
    /// The cycles in which it kicked, and whether it struck the ball.
    pub kicks: Vec<(u64, bool)>,
    /// Numbers, one list for each [`Number`].
    numbers: [Vec<f32>; Number::ALL.len()],
}

/// A number of a robot that can be plotted.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Number {
    /// How far its belief of its own place is from the truth, m.
    OwnPlaceError,
    /// How far its belief of the ball is from the truth, m.
    BallError,
    /// How far away the ball is, m.
    BallDistance,
    /// How fast it is, m/s.
    Speed,
    /// The yaw of its head, degrees.
    HeadYaw,
    /// The pitch of its head, degrees.
    HeadPitch,
    /// What its left sonar measures, m.
    LeftSonar,
    /// What its right sonar measures, m.
    RightSonar,
}

impl Number {
    /// All of them.
    pub const ALL: [Number; 8] = [
        Number::OwnPlaceError,
        Number::BallError,
        Number::BallDistance,
        Number::Speed,
        Number::HeadYaw,
        Number::HeadPitch,
        Number::LeftSonar,
        Number::RightSonar,
    ];

    /// Its name and unit, for people.
    pub fn name(self) -> &'static str {
        match self {
            Number::OwnPlaceError => "error of its own place, m",
            Number::BallError => "error of the ball, m",
            Number::BallDistance => "distance to the ball, m",
            Number::Speed => "speed, m/s",
            Number::HeadYaw => "head yaw, °",
            Number::HeadPitch => "head pitch, °",
            Number::LeftSonar => "left sonar, m",
            Number::RightSonar => "right sonar, m",
        }
    }

    fn of(self, robot: &RobotSample) -> Option<f32> {
        match self {
            Number::OwnPlaceError => Some(robot.error?.position_m),
            Number::BallError => Some(robot.error?.ball?.position_m),
            Number::BallDistance => robot.ball_m.filter(|_| !robot.penalised),
            Number::Speed => Some(robot.speed_mps),
            Number::HeadYaw => Some(crate::geometry::to_degrees(robot.head.yaw)),
            Number::HeadPitch => Some(crate::geometry::to_degrees(robot.head.pitch)),
            Number::LeftSonar => robot.sonar.left,
            Number::RightSonar => robot.sonar.right,
        }
    }
}

/// Mistakes are gathered anew after so many cycles.
const MISTAKES_EVERY: usize = 30;

/// All robots over the match, as far as its records have been read.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    /// The cycles that have been read.
    cycles: Vec<u64>,
    robots: BTreeMap<RobotId, RobotTrack>,
    words: Vec<String>,
    finder: Option<MistakeFinder>,
    mistakes: Vec<Mistake>,
    /// What was true at the end of the last one.
    before: Option<(u64, Sensed)>,
}

impl Tracks {
    /// Of a match of a scenario, of which nothing has been read yet.
    pub fn new(scenario: &Scenario) -> Self {
        Self { finder: Some(MistakeFinder::new(scenario)), ..default() }
    }

    /// What went wrong, in the order in which it began: as of some cycles ago.
    pub fn mistakes(&self) -> &[Mistake] {
        &self.mistakes
    }

    /// Gathers what went wrong until now.
    pub fn gather_mistakes(&mut self) {
        self.mistakes = self.finder.as_ref().map(MistakeFinder::mistakes).unwrap_or_default();
    }

    /// The last cycle that has been read.
    pub fn last_cycle(&self) -> Option<u64> {
        self.cycles.last().copied()
    }

    /// The robots, in the order of their ids.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, &RobotTrack)> {
        self.robots.iter().map(|(id, track)| (*id, track))
    }

    /// What robots said that they meant to do, in the order in which it was said for the first time.
    pub fn words(&self) -> &[String] {
        &self.words
    }

    /// A robot, if it is in the match.
    pub fn robot(&self, id: RobotId) -> Option<&RobotTrack> {
        self.robots.get(&id)
    }

    /// A number of a robot over the cycles from one to another: cycle and value, at most about `most` of them. Where many fall
    /// together, the smallest and the largest stay.
    pub fn values(&self, id: RobotId, number: Number, [first, last]: [u64; 2], most: usize) -> Vec<[f64; 2]> {
        let Some(track) = self.robots.get(&id) else { return Vec::new() };
        let [from, to] = [first, last + 1].map(|cycle| self.cycles.partition_point(|other| *other < cycle));
        let values = &track.numbers[number as usize];
        let present = (from..to).filter_map(|index| {
            let value = values.get(index).copied().filter(|value| !value.is_nan())?;
            Some([self.cycles[index] as f64, f64::from(value)])
        });
        let present: Vec<[f64; 2]> = present.collect();
        let group = (2 * present.len()).div_ceil(most.max(2)).max(1);
        if group < 3 {
            return present;
        }
        let extremes = |points: &[[f64; 2]]| {
            let by_value = |one: &&[f64; 2], other: &&[f64; 2]| one[1].total_cmp(&other[1]);
            let ends = [points.iter().min_by(by_value), points.iter().max_by(by_value)];
            let mut ends: Vec<[f64; 2]> = ends.into_iter().flatten().copied().collect();
            ends.sort_by(|one, other| one[0].total_cmp(&other[0]));
            ends
        };
        present.chunks(group).flat_map(extremes).collect()
    }

    /// Takes in the record of a cycle that is after all others.
    pub fn note(&mut self, record: &CycleRecord) {
        let cycle = record.cycle;
        if self.last_cycle().is_some_and(|last| last >= cycle) {
            return;
        }
        let sensed = self.before.take().filter(|(before, _)| before + 1 == cycle).map(|(_, sensed)| sensed);
        let sample = CycleSample::of(record, sensed.as_ref());
        self.before = Some((cycle, Sensed::of(record)));
        self.cycles.push(cycle);
        if let Some(finder) = &mut self.finder {
            finder.look(record);
        }
        for robot in &record.robots {
            let track = self.robots.entry(robot.id).or_default();
            let intention = robot.command.as_ref().and_then(|command| command.say.as_ref()?.intention.as_deref());
            let intention = intention.unwrap_or_default();
            let word = self.words.iter().position(|word| word == intention).unwrap_or_else(|| {
                self.words.push(intention.to_owned());
                self.words.len() - 1
            });
            extend(&mut track.intentions, cycle, word);
            extend(&mut track.ball, cycle, ball_source(robot));
            extend(&mut track.conditions, cycle, condition(robot));
            if let Some(sample) = sample.robots.get(&robot.id) {
                for (number, values) in Number::ALL.into_iter().zip(&mut track.numbers) {
                    // A robot that came later has none of before.
                    values.resize(self.cycles.len() - 1, f32::NAN);
                    values.push(number.of(sample).unwrap_or(f32::NAN));
                }
            }
        }
        for event in &record.events {
            if let MatchEvent::Kick { robot, result, reason, .. } = event
                && result.swings(*reason)
                && let Some(track) = self.robots.get_mut(robot)
            {
                track.kicks.push((cycle, *result != KickResult::Missed));
            }
        }
        if self.cycles.len().is_multiple_of(MISTAKES_EVERY) {
            self.gather_mistakes();
        }
    }
}

/// Prolongs the last span, or begins another.
fn extend<T: PartialEq>(spans: &mut Vec<Span<T>>, cycle: u64, what: T) {
    match spans.last_mut() {
        Some(span) if span.what == what => span.last = cycle,
        // Without gaps, where only every so many cycles have a record.
        Some(span) => {
            span.last = cycle;
            spans.push(Span { first: cycle, last: cycle, what });
        }
        None => spans.push(Span { first: cycle, last: cycle, what }),
    }
}

fn ball_source(robot: &RobotRecord) -> BallSource {
    if robot.percepts.ball.is_some() {
        return BallSource::Seen;
    }
    match robot.belief.as_ref().and_then(|belief| belief.ball.as_ref()) {
        Some(ball) if ball.heard_from.is_some() => BallSource::Told,
        Some(_) => BallSource::Remembered,
        None => BallSource::Lost,
    }
}

fn condition(robot: &RobotRecord) -> Condition {
    match robot.posture {
        _ if robot.penalised.is_some() => Condition::Penalised,
        Posture::Upright => Condition::Up,
        _ => Condition::Down,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::communication::TeamMessage;
    use crate::record::vocabulary::RobotCommand;
    use crate::robot::Velocity;
    use crate::team::Team;

    const BLUE: RobotId = RobotId::new(Team::Blue, 1);

    fn record(cycle: u64, intention: &'static str, speed: f32) -> CycleRecord {
        let say = TeamMessage { intention: Some(intention.into()), ..default() };
        let command = Some(RobotCommand { say: Some(say), ..default() });
        let velocity = Velocity { linear: Vec2::new(speed, 0.0), angular: 0.0 };
        CycleRecord { cycle, robots: vec![RobotRecord { command, velocity, ..RobotRecord::new(BLUE) }], ..default() }
    }

    #[test]
    fn what_stays_the_same_is_one_span_and_spans_have_no_gaps() {
        let mut tracks = Tracks::default();
        for (cycle, intention) in [(0, "support"), (10, "support"), (20, "attack"), (30, "attack")] {
            tracks.note(&record(cycle, intention, 0.1));
        }
        let track = tracks.robot(BLUE).unwrap();
        let word = |span: &Span<usize>| (span.first, span.last, tracks.words()[span.what].clone());
        let spans: Vec<_> = track.intentions.iter().map(word).collect();
        assert_eq!(spans, [(0, 20, "support".to_owned()), (20, 30, "attack".to_owned())]);
        assert_eq!(track.ball, [Span { first: 0, last: 30, what: BallSource::Lost }]);
        // What is known already is not taken in again.
        tracks.note(&record(20, "support", 0.1));
        assert_eq!(tracks.last_cycle(), Some(30));
    }

    #[test]
    fn of_many_values_the_smallest_and_the_largest_stay() {
        let mut tracks = Tracks::default();
        for cycle in 0..10_000 {
            tracks.note(&record(cycle, "", if cycle == 5_003 { 9.0 } else { 0.1 }));
        }
        let values = tracks.values(BLUE, Number::Speed, [0, 20_000], 200);
        assert!(values.len() <= 202, "{}", values.len());
        assert!(values.contains(&[5_003.0, 9.0]));
        assert_eq!(tracks.values(BLUE, Number::Speed, [10, 12], 200).len(), 3);
        assert!(tracks.values(BLUE, Number::LeftSonar, [0, 20_000], 200).is_empty());
    }
}
