//! A moment as a test: a scenario that says what is expected of it.

use super::Run;
use crate::scenario::{Expectation, Scenario};
use crate::team::Team;

/// How often a test plays the moment. With so many, what is expected of it is told from half of that.
const TIMES: usize = 50;

/// The situation of a moment that was played on, with what is expected of it: that a team scores in the same time, in at least so
/// many of a hundred times.
///
/// # Errors
/// When the expectation is none.
pub(super) fn of_moment(situation: Scenario, team: Team, percent: u32, run: &Run) -> Result<Scenario, String> {
    let for_s = run.for_s;
    let text = format!("{team}.goals >= 1 within {for_s} s in {percent} % of {TIMES}");
    let expectation: Expectation = text.parse().map_err(|error| format!("{error}"))?;
    let name = if situation.name.is_empty() { "moment".to_owned() } else { format!("{} test", situation.name) };
    Ok(Scenario { name, duration_s: Some(for_s as f32), expectations: vec![expectation], ..situation })
}
