//! The activities of robots over the whole match as spans and marks, read from the records.

use bevy::prelude::*;
use std::collections::BTreeMap;

use naoisis_core::events::{KickResult, MatchEvent};
use naoisis_core::robot::posture::Posture;
use naoisis_core::team::RobotId;
use naoisis_record::record::mistakes::{Mistake, MistakeFinder};
use naoisis_sim::interface::cycle_record::{CycleRecord, RobotRecord};
use naoisis_sim::scenario::Scenario;

/// The source of a robot's ball estimate.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum BallSource {
    /// The robot sees the ball.
    Seen,
    /// The robot saw the ball recently.
    Remembered,
    /// A team-mate reported the ball.
    Told,
    /// The robot does not know where the ball is.
    Lost,
}

/// The condition of a robot.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Condition {
    /// Standing and in play.
    Up,
    /// Lying or getting up.
    Down,
    /// Penalised.
    Penalised,
}

/// A time in which a value stayed the same.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Span<T> {
    /// The first cycle.
    pub first: u64,
    /// The last cycle.
    pub last: u64,
    /// The value.
    pub what: T,
}

/// The activities of a robot over the match.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct LaneTrack {
    /// The intentions that it announced, as indices of [words](Tracks::words).
    pub intentions: Vec<Span<usize>>,
    /// The sources of its ball estimate.
    pub ball: Vec<Span<BallSource>>,
    /// Its conditions.
    pub conditions: Vec<Span<Condition>>,
    /// The cycles of its kicks, and whether they struck the ball.
    pub kicks: Vec<(u64, bool)>,
    /// The last cycle in which it announced an intention.
    announced: Option<u64>,
}

/// The number of cycles for which an intention stays without a new message.
const STAYS: u64 = 90;

impl LaneTrack {
    /// The last intention if it was announced shortly before a cycle, as an index of [words](Tracks::words).
    fn intention_until(&self, cycle: u64) -> Option<usize> {
        let is_recent = self.announced.is_some_and(|announced| cycle - announced <= STAYS);
        self.intentions.last().filter(|_| is_recent).map(|span| span.what)
    }
}

/// The number of cycles after which mistakes are searched for again.
const MISTAKES_EVERY: usize = 30;

/// The activities of all robots, as far as records have been read.
#[derive(Clone, Debug, Default)]
pub struct Tracks {
    /// The cycles that have been read.
    cycles: Vec<u64>,
    robots: BTreeMap<RobotId, LaneTrack>,
    words: Vec<String>,
    finder: Option<MistakeFinder>,
    mistakes: Vec<Mistake>,
}

impl Tracks {
    /// Creates tracks for a match of a scenario.
    pub fn new(scenario: &Scenario) -> Self {
        Self { finder: Some(MistakeFinder::new(scenario)), ..default() }
    }

    /// Returns the mistakes, in the order of their starts; may lag some cycles behind.
    pub fn mistakes(&self) -> &[Mistake] {
        &self.mistakes
    }

    /// Searches for mistakes until now.
    pub fn gather_mistakes(&mut self) {
        self.mistakes = self.finder.as_ref().map(MistakeFinder::mistakes).unwrap_or_default();
    }

    /// Returns the last cycle that has been read.
    pub fn last_cycle(&self) -> Option<u64> {
        self.cycles.last().copied()
    }

    /// Returns the robots, sorted by id.
    pub fn robots(&self) -> impl Iterator<Item = (RobotId, &LaneTrack)> {
        self.robots.iter().map(|(id, track)| (*id, track))
    }

    /// Returns the intentions of robots, in the order of their first use.
    pub fn words(&self) -> &[String] {
        &self.words
    }

    /// Adds the record of a cycle, which must be after all others.
    pub fn note(&mut self, record: &CycleRecord) {
        let cycle = record.cycle;
        if self.last_cycle().is_some_and(|last| last >= cycle) {
            return;
        }
        self.cycles.push(cycle);
        if let Some(finder) = &mut self.finder {
            finder.look(record);
        }
        for robot in &record.robots {
            let track = self.robots.entry(robot.id).or_default();
            // Robots announce it in some cycles only: it stays until the next message.
            let held = || track.intention_until(cycle).map(|word| self.words[word].as_str());
            let intention = robot.intention().or_else(held).unwrap_or_default().to_owned();
            track.announced = robot.intention().map(|_| cycle).or(track.announced);
            let word = self.words.iter().position(|word| *word == intention).unwrap_or_else(|| {
                self.words.push(intention);
                self.words.len() - 1
            });
            extend(&mut track.intentions, cycle, word);
            extend(&mut track.ball, cycle, ball_source(robot));
            extend(&mut track.conditions, cycle, condition(robot));
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

/// Extends the last span, or starts a new one.
fn extend<T: PartialEq>(spans: &mut Vec<Span<T>>, cycle: u64, what: T) {
    match spans.last_mut() {
        Some(span) if span.what == what => span.last = cycle,
        // The span has no gaps, even if only every few cycles have a record.
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
    use naoisis_core::communication::TeamMessage;
    use naoisis_core::robot::Velocity;
    use naoisis_core::team::Team;
    use naoisis_sim::interface::vocabulary::RobotCommand;

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
        let track = &tracks.robots[&BLUE];
        let word = |span: &Span<usize>| (span.first, span.last, tracks.words()[span.what].clone());
        let spans: Vec<_> = track.intentions.iter().map(word).collect();
        assert_eq!(spans, [(0, 20, "support".to_owned()), (20, 30, "attack".to_owned())]);
        assert_eq!(track.ball, [Span { first: 0, last: 30, what: BallSource::Lost }]);
        // An intention stays between two messages, and not much longer.
        for (cycle, expected) in [(40, "attack"), (30 + STAYS + 1, "")] {
            tracks.note(&CycleRecord { cycle, robots: vec![RobotRecord::new(BLUE)], ..default() });
            let track = &tracks.robots[&BLUE];
            assert_eq!(tracks.words()[track.intentions.last().unwrap().what], expected, "{cycle}");
        }
        // A record that is already known is not added again.
        tracks.note(&record(20, "support", 0.1));
        assert_eq!(tracks.last_cycle(), Some(30 + STAYS + 1));
    }
}
