//! Makes the page of a match from its records, part by part.

use serde_json::{Value, json};
use std::collections::BTreeMap;

use super::TEMPLATE;
use super::block::block;
use super::columns::{About, Columns};
use super::described::{end_of, event_of, match_of};
use super::robot_columns::{POSE_M, Thinning, add_belief, add_percepts, add_truth, add_wish};
use super::strings::Strings;
use crate::record::match_counts::Observed;
use crate::record::match_counts::kicks::{KickEnd, KickFollower, KickOutcome, StruckKick};
use crate::record::match_summary::MatchSummary;
use crate::record::recorder::MatchEnd;
use crate::record::summary_page::minutes;
use naoisis_core::game::PenaltyReason;
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::End;
use naoisis_core::team::RobotId;
use naoisis_sim::interface::cycle_record::{CycleRecord, PenaltyRecord, RobotRecord, ShootOutRecord};
use naoisis_sim::interface::fields::Fields;
use naoisis_sim::scenario::Scenario;

/// Samples per second: of the truth, and of everything else.
const TRUTH_HZ: f64 = 30.0;
const SENSE_HZ: f64 = 10.0;
/// Length of a part, s of the match: at most this much is lost if the program is killed. Each part is twice as long as the one before, from
/// the shortest to the longest.
const FIRST_PART_S: f64 = 7.5;
const LONGEST_PART_S: f64 = 120.0;
/// Intended maximum size of the page, bytes.
const BUDGET_BYTES: f64 = 2.9e6;
/// Interval at which the reasons of an unchanged decision are written again, s.
const REASONS_EVERY_S: f64 = 2.0;
/// Greatest score that is shown: the numbers of a page have 29 bits.
const MOST_GOALS: u32 = 1 << 28;
/// Assumed length of a match without a clock, s.
const UNKNOWN_LENGTH_S: f64 = 1200.0;

/// Makes the page of a match that is under way.
#[derive(Clone)]
pub struct PageWriter {
    cycle_s: f64,
    robots: Vec<RobotId>,
    /// The fields that records have.
    fields: Fields,
    summary: MatchSummary,
    kick_follower: KickFollower,
    columns: Columns,
    strings: Strings,
    events: Vec<Value>,
    kicks: Vec<Value>,
    reasons: Vec<Value>,
    /// The choice and the time (s) of the reasons of each robot that were written last.
    decided: BTreeMap<RobotId, (Option<usize>, f64)>,
    /// The robots' true poses at the end of the previous cycle, when they sensed.
    sensed: BTreeMap<RobotId, Pose>,
    /// The cycles from which on the next samples of the truth and of everything else are due.
    due: [u64; 2],
    last_cycle: Option<u64>,
    /// The number of parts up to now.
    parts: u32,
    part_begins_s: f64,
    part_length_s: f64,
    thinning: Thinning,
    written_bytes: usize,
    /// The thinning of which the page says what it leaves out.
    said: Thinning,
    began_s: f64,
    /// The length of the match, s, unless its clock tells the time that is left.
    length_s: f64,
    /// The length of a half, s, and the number of halves, if the match ends by its clock.
    halves: Option<[f64; 2]>,
}

impl PageWriter {
    /// Begins the page of a match of `scenario`, whose present state is `record`. Its records have these `fields`. Returns the writer and the
    /// beginning of the page.
    pub fn begin(scenario: &Scenario, record: &CycleRecord, fields: Fields) -> (Self, String) {
        let robots: Vec<RobotId> = record.robots.iter().map(|robot| robot.id).collect();
        let text = format!("{TEMPLATE}{}", block(&match_of(scenario, &robots, &fields), &Columns::default()));
        let rules = &scenario.rules;
        let halves = rules.clock.then(|| [f64::from(rules.half_s), f64::from(rules.halves)]);
        let length_s = scenario.duration_s.map(f64::from);
        let mut writer = Self {
            cycle_s: scenario.cycle_s,
            robots,
            fields,
            summary: MatchSummary::new(scenario),
            kick_follower: KickFollower::new(scenario),
            columns: Columns::default(),
            strings: Strings::default(),
            events: Vec::new(),
            kicks: Vec::new(),
            reasons: Vec::new(),
            decided: BTreeMap::new(),
            sensed: BTreeMap::new(),
            due: [0; 2],
            last_cycle: None,
            parts: 0,
            part_begins_s: record.time_s,
            part_length_s: FIRST_PART_S,
            thinning: Thinning::default(),
            written_bytes: text.len(),
            began_s: record.time_s,
            said: Thinning::default(),
            halves: halves.filter(|_| length_s.is_none()),
            length_s: length_s.or(halves.map(|[half_s, count]| half_s * count)).unwrap_or(UNKNOWN_LENGTH_S),
        };
        writer.add(record);
        (writer, text)
    }

    /// Adds the next cycle. Returns a part of the page when one is full.
    pub fn record(&mut self, record: &CycleRecord) -> Option<String> {
        let is_full = record.time_s - self.part_begins_s >= self.part_length_s;
        let part = is_full.then(|| self.part());
        if let Some(part) = &part {
            self.thin(record, part.len());
            self.part_begins_s = record.time_s;
            self.part_length_s = (2.0 * self.part_length_s).min(LONGEST_PART_S);
        }
        self.add(record);
        part
    }

    /// Returns the rest of the page, with the end of the match after its `last` cycle.
    pub fn finish(mut self, end: &MatchEnd, last: &CycleRecord) -> String {
        if self.last_cycle.is_some_and(|written| written < last.cycle) {
            self.add_truth(last);
        }
        let open = self.kick_follower.finish();
        self.add_kicks(open, last);
        let part = self.part();
        let mut end = end_of(end, &self.summary, &self.fields);
        end["parts"] = json!(self.parts);
        part + &block(&end, &Columns::default())
    }

    /// Returns the rest of the page of a match whose end is not known.
    pub fn break_off(mut self) -> String {
        self.part()
    }

    fn add(&mut self, record: &CycleRecord) {
        self.summary.look(record);
        self.events.extend(record.events.iter().filter_map(|event| event_of(record.cycle, record.time_s, event)));
        let kicks = self.kick_follower.look(&Observed::from(record));
        self.add_kicks(kicks, record);
        if self.is_due(0, record.cycle, TRUTH_HZ) {
            self.add_truth(record);
        }
        if self.is_due(1, record.cycle, SENSE_HZ) {
            self.add_senses(record);
        }
        self.sensed = record.robots.iter().map(|robot| (robot.id, robot.pose)).collect();
    }

    /// Returns whether a sample is due in this cycle.
    fn is_due(&mut self, which: usize, cycle: u64, rate_hz: f64) -> bool {
        let every = (1.0 / (rate_hz * self.cycle_s)).round().max(1.0) as u64;
        let is_due = self.last_cycle.is_none() || cycle >= self.due[which];
        if is_due {
            self.due[which] = (cycle / every + 1) * every;
        }
        is_due
    }

    fn add_truth(&mut self, record: &CycleRecord) {
        self.last_cycle = Some(record.cycle);
        let CycleRecord { cycle, ball, game, .. } = record;
        let Self { columns, fields, .. } = self;
        // The clock shows seconds that are whole, the secondary clock those that have begun. Times of cycles may be less
        // than the second by rounding.
        let tenths = |time_s: Option<f64>, whole: fn(f64) -> f64| {
            time_s.map_or(-1, |time_s| whole((1000.0 * time_s).round() / 100.0) as i32)
        };
        columns.push(About::Match, "cycle", i32::try_from(*cycle).unwrap_or(i32::MAX));
        let mut add = |field, quantity, value: i32| {
            if fields.has(field) {
                columns.push(About::Match, quantity, value);
            }
        };
        add("game.state", "state", game.state as i32);
        add("game.half", "half", game.half as i32);
        add("game.score", "blue", game.score.blue.min(MOST_GOALS) as i32);
        add("game.score", "pink", game.score.pink.min(MOST_GOALS) as i32);
        add("game.time_left_s", "left", tenths(game.time_left_s, f64::floor));
        add("game.secondary_time_left_s", "second", tenths(game.secondary_time_left_s, f64::ceil));
        add("game.shoot_out", "shots", shoot_out_number(game.shoot_out.as_ref()));
        add("game.blue_end", "blue_end", i32::from(game.blue_end == End::PositiveX));
        let place = ball.map(|ball| ball.position_m).unwrap_or_default();
        columns.push(About::Ball, "in", i32::from(ball.is_some()));
        let more_balls = (2..).map(About::MoreBall).zip(record.more_balls().iter().map(|ball| ball.position_m));
        for (about, place) in core::iter::once((About::Ball, place)).chain(more_balls) {
            for (quantity, value) in ["x", "y", "z"].into_iter().zip(place.to_array()) {
                columns.add(about, quantity, f64::from(value), POSE_M);
            }
        }
        for id in &self.robots {
            add_truth(&mut self.columns, &robot_in(record, *id));
        }
    }

    fn add_senses(&mut self, record: &CycleRecord) {
        let sample = i32::try_from(record.cycle).unwrap_or(i32::MAX);
        self.columns.push(About::Match, "sense", sample);
        let every = (1.0 / (SENSE_HZ * self.cycle_s)).round().max(1.0) as u64;
        let sample_number = record.cycle / every;
        for (index, id) in self.robots.iter().enumerate() {
            let robot = robot_in(record, *id);
            let own_end = record.game.own_end(id.team);
            let sensed = self.sensed.get(id).copied().unwrap_or(robot.pose);
            add_percepts(&mut self.columns, &robot, sensed, self.thinning, sample_number);
            add_belief(&mut self.columns, &robot, own_end, self.thinning, sample_number);
            add_wish(&mut self.columns, &mut self.strings, &robot, own_end, self.cycle_s);
            let Some(reasons) = robot.reasons.as_ref().filter(|reasons| !reasons.options.is_empty()) else { continue };
            let is_old = |&(chosen, at_s): &(Option<usize>, f64)| {
                chosen != reasons.chosen || record.time_s - at_s >= REASONS_EVERY_S
            };
            if self.decided.get(id).is_none_or(is_old) {
                self.decided.insert(*id, (reasons.chosen, record.time_s));
                let hundredths = |value: f32| (100.0 * f64::from(value)).round() / 100.0;
                let options: Vec<_> = reasons
                    .options
                    .iter()
                    .map(|option| (&option.name, hundredths(option.value), &option.why))
                    .collect();
                self.reasons.push(json!([record.cycle, index, reasons.chosen, options]));
            }
        }
    }

    fn add_kicks(&mut self, ended: impl IntoIterator<Item = (StruckKick, KickEnd)>, record: &CycleRecord) {
        let cm = |value: f32| (100.0 * f64::from(value)).round() / 100.0;
        for (kick, end) in ended {
            let what = match kick.outcome(end, self.kick_follower.pitch()) {
                KickOutcome::PassCompleted => "pass",
                KickOutcome::PassFailed { .. } => "lost",
                KickOutcome::ShotOnTarget { .. } => "shot on target",
                KickOutcome::ShotOffTarget => "shot",
                KickOutcome::Neither => continue,
            };
            let Some(ball) = record.ball else { continue };
            let from = kick.position_m;
            let to = ball.position_m;
            let cycle = (kick.time_s / self.cycle_s).round() as u64;
            self.kicks.push(json!([cycle, kick.robot, cm(from.x), cm(from.y), cm(to.x), cm(to.y), what]));
        }
    }

    /// Returns the collected data as a block.
    fn part(&mut self) -> String {
        if self.columns.is_empty() {
            return String::new();
        }
        let changed = (self.thinning != core::mem::replace(&mut self.said, self.thinning)).then_some(self.thinning);
        let left_out = changed
            .and_then(Thinning::words)
            .map(|words| format!("To keep the page small, {words}, from {} on.", minutes(self.part_begins_s)));
        let (first_string, strings) = self.strings.take_new();
        self.parts += 1;
        let json = json!({
            "part": self.parts,
            "first_string": first_string,
            "strings": strings,
            "events": core::mem::take(&mut self.events),
            "kicks": core::mem::take(&mut self.kicks),
            "reasons": core::mem::take(&mut self.reasons),
            "left_out": left_out,
        });
        let text = block(&json, &core::mem::take(&mut self.columns));
        self.written_bytes += text.len();
        text
    }

    /// Leaves out more from now on if the page would become too large at the rate of the last part, which had `bytes`.
    fn thin(&mut self, record: &CycleRecord, bytes: usize) {
        let elapsed_s = record.time_s - self.began_s;
        let clock_left_s = record.game.time_left_s.filter(|_| self.fields.has("game.time_left_s"));
        let rest_s = match (self.halves, clock_left_s) {
            (Some(halves), Some(left_s)) => rest_of_match_s(elapsed_s, halves, f64::from(record.game.half), left_s),
            _ => self.length_s - elapsed_s,
        };
        // A match may always last longer: extra time, a shoot-out.
        let rest_s = rest_s.max(0.5 * self.part_length_s);
        let in_the_end = self.written_bytes as f64 + bytes as f64 / self.part_length_s * rest_s;
        // Short parts compress less well.
        let most = if self.part_length_s < LONGEST_PART_S { 1.3 * BUDGET_BYTES } else { BUDGET_BYTES };
        if in_the_end > most {
            self.thinning = self.thinning.next();
        }
    }
}

/// Returns a shoot-out as a number: the team that shoots (1 blue, 2 pink), and the goals of blue and pink in six bits each above; 0 if there
/// is none.
fn shoot_out_number(shoot_out: Option<&ShootOutRecord>) -> i32 {
    shoot_out.map_or(0, |ShootOutRecord { team, goals, .. }| {
        let [blue, pink] = [goals.blue, goals.pink].map(|goals| goals.min(63) as i32);
        1 + *team as i32 + 4 * blue + 256 * pink
    })
}

/// Returns the expected time until the end of a match of `count` halves of `half_s`, s, after `elapsed_s`: in this `half`, from 1, `left_s`
/// are left on the clock. The clock is expected to stand as often in the rest of the match as up to now.
fn rest_of_match_s(elapsed_s: f64, [half_s, count]: [f64; 2], half: f64, left_s: f64) -> f64 {
    /// The time for each second of the clock in a match that is too young to tell, and the clock until it does, s.
    const TIME_PER_CLOCK: f64 = 1.35;
    const YOUNG_S: f64 = 60.0;
    let rest_s = left_s + half_s * (count - half).max(0.0);
    let clock_s = half_s * count - rest_s;
    let pace = if clock_s < YOUNG_S { TIME_PER_CLOCK } else { (elapsed_s / clock_s).max(1.0) };
    rest_s * pace
}

/// Returns the robot in the record. A robot that is not there counts as removed.
fn robot_in(record: &CycleRecord, id: RobotId) -> std::borrow::Cow<'_, RobotRecord> {
    use std::borrow::Cow;
    record.robot(id).map(Cow::Borrowed).unwrap_or_else(|| {
        let penalised = Some(PenaltyRecord { reason: PenaltyReason::Manual, time_left_s: 0.0 });
        Cow::Owned(RobotRecord { penalised, ..RobotRecord::new(id) })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rest_of_a_match_is_expected_by_its_clock() {
        let halves = [600.0, 2.0];
        // Too young to tell: 1150 s of clock.
        assert_eq!(rest_of_match_s(60.0, halves, 1.0, 550.0), 1.35 * 1150.0);
        // 400 s of the clock have taken 600 s: the other 800 take 1200.
        assert_eq!(rest_of_match_s(600.0, halves, 1.0, 200.0), 1200.0);
        // In the last half, and in extra time, which may not be known before.
        assert_eq!(rest_of_match_s(1500.0, halves, 2.0, 200.0), 300.0);
        assert!(rest_of_match_s(2000.0, halves, 3.0, 100.0) > 100.0);
    }

    #[test]
    fn a_shoot_out_is_a_number_with_its_team_and_goals() {
        let goals = naoisis_core::game::Score { blue: 2, pink: 3 };
        let shoot_out = ShootOutRecord { team: naoisis_core::team::Team::Pink, taken: goals, goals };
        assert_eq!(shoot_out_number(Some(&shoot_out)), 2 + 4 * 2 + 256 * 3);
        assert_eq!(shoot_out_number(None), 0);
    }
}
