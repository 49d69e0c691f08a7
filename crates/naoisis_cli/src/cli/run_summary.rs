//! What `naoisis run` prints about a match.

use serde_json::{Value, to_value};
use std::collections::BTreeMap;

use naoisis_core::cycle::CycleClock;
use naoisis_core::events::{CommandKind, KickMiss, Refusal};
use naoisis_core::game::MatchResult;
use naoisis_core::referee::report::HEADER;
use naoisis_core::team::{PerTeam, RobotId, Team};
use naoisis_record::expectations::Watch;
use naoisis_record::record::recorder::EndReason;
use naoisis_sim::scenario::Scenario;

/// The results of a run.
#[derive(Default)]
pub struct Outcome {
    pub reason: EndReason,
    pub goals: Vec<(f64, Team)>,
    pub broken_invariants: Vec<String>,
    /// Measurements for expectations.
    pub watch: Watch,
    /// Number of robots whose programs were lost.
    pub agents_lost: PerTeam<u32>,
    /// Whether every robot that a program played has lost it.
    pub all_programs_lost: bool,
    /// Number of refused commands of robots that programs play, by robot, command and reason.
    pub refused: BTreeMap<(RobotId, CommandKind, Refusal), u32>,
    /// Number of kicks that did not reach the ball of robots that programs play, by robot, kick and reason.
    pub missed: BTreeMap<(RobotId, String, KickMiss), u32>,
    /// Number of the referee's decisions by kind, for --explain.
    pub decisions: BTreeMap<String, u32>,
    /// Whether the match was saved during the run, or saving failed.
    pub saved: bool,
    /// Reason why saving failed.
    pub not_saved: Option<String>,
}

/// Returns the title of the report, which names the match.
pub(super) fn title(scenario: &Scenario) -> String {
    let name = if scenario.name.is_empty() { "Match" } else { &scenario.name };
    let teams = match &scenario.teams {
        Some(teams) => format!(": blue {} against pink {}", teams.blue, teams.pink),
        None => String::new(),
    };
    let (rules, realism, seed) = (&scenario.rules, scenario.realism_in_words(), scenario.seed);
    format!("{name}{teams}. Rules {}, realism {realism}, seed {seed}.\n{HEADER}\n", rules.name)
}

/// Returns a line with the number of the referee's decisions by kind.
pub(super) fn tally(decisions: &BTreeMap<String, u32>) -> String {
    let count = |(kind, count): (&String, &u32)| format!("{count} {}", kind.replace('_', " "));
    let counts: Vec<String> = decisions.iter().map(count).collect();
    if counts.is_empty() { String::new() } else { format!("  decided  {}\n", counts.join(", ")) }
}

/// Returns the goals, the programs that were lost, the commands that were refused, the kicks that missed, and the result.
pub(super) fn summary(
    outcome: &Outcome,
    clock: CycleClock,
    started_at_cycle: u64,
    result: MatchResult,
    realism: &str,
    wall_s: f64,
) -> String {
    let mut text = String::new();
    for (time_s, team) in &outcome.goals {
        text += &format!("{:>7.1} s  goal for {team}\n", time_s);
    }
    if outcome.agents_lost != PerTeam::default() {
        let PerTeam { blue, pink } = outcome.agents_lost;
        text += &format!("programs lost: blue {blue}, pink {pink}\n");
    }
    for ((robot, command, reason), count) in &outcome.refused {
        text += &format!(
            "refused commands of {robot}: {count} x {}: {}\n",
            word(to_value(command)),
            word(to_value(reason)).replace('_', " ")
        );
    }
    for ((robot, kick, reason), count) in &outcome.missed {
        text += &format!("missed kicks of {robot}: {count} x {kick}: {}\n", word(to_value(reason)).replace('_', " "));
    }
    let end = words_of(outcome.reason);
    let simulated_s = clock.end_time_s();
    // A saved match starts in the middle.
    let cycles = clock.cycle - started_at_cycle;
    text += &format!(
        "{simulated_s:>7.1} s  {end}: {result}\n{} cycles in {wall_s:.2} s, {} times real time, realism {realism}\n",
        cycles,
        factor(cycles as f64 * clock.period_s / wall_s.max(1e-9)),
    );
    text
}

/// Returns the word that stands for a value in traces.
fn word(value: serde_json::Result<Value>) -> String {
    value.ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}

/// Returns the reason for the end in words.
pub(super) fn words_of(reason: EndReason) -> &'static str {
    match reason {
        EndReason::FinalWhistle => "final whistle",
        EndReason::Duration => "end",
        EndReason::Interrupted => "interrupted",
        EndReason::Failed => "stopped",
    }
}

/// Returns a number as text with two decimals below 1, one below 10, and none above.
fn factor(value: f64) -> String {
    let digits = if value < 1.0 { 2 } else { usize::from(value < 10.0) };
    format!("{value:.digits$}")
}
