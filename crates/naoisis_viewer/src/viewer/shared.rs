//! State that all parts of the viewer use, and the order of systems that change it.

use bevy::prelude::*;
use std::path::PathBuf;
use std::time::Instant;

use super::speed::Speed;
use super::theme::minutes;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState};
use naoisis_core::team::RobotId;

/// The systems that perform the actions of keys.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct KeysSystems;

/// The systems that select robots.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SelectionSystems;

/// The systems that move the camera.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CameraSystems;

/// The intention of a robot that is driven by hand.
pub const DRIVEN: &str = "driven by hand";

/// The time from which on the window says that it waits for a program, s.
const NOTICEABLE_WAIT_S: f32 = 0.5;

/// The state of playback.
#[derive(Resource, Clone, PartialEq, Debug)]
pub struct Playback {
    /// Whether the match is paused.
    pub paused: bool,
    /// The wanted speed.
    pub speed: Speed,
    /// The recent speed, simulated seconds per second.
    pub achieved: f32,
    /// The error of the last command, if any.
    pub problem: Option<String>,
    /// The last cycle of the match, if the scenario limits it.
    pub(super) last_cycle: Option<u64>,
    /// Whether a cycle failed, so that the match cannot continue.
    pub(super) failed: bool,
    /// The cycles that were run since the achieved speed was computed, and the time.
    pub(super) measured: (f64, f32),
    /// The robot whose program the match waits for, and since when.
    pub(super) awaited: Option<(RobotId, Instant)>,
}

impl Playback {
    /// Returns the robot whose program the match waits for, and the time that it has waited, s, if this is noticeable.
    pub(super) fn awaited(&self) -> Option<(RobotId, f32)> {
        let (robot, since) = self.awaited?;
        let waited_s = since.elapsed().as_secs_f32();
        (waited_s >= NOTICEABLE_WAIT_S).then_some((robot, waited_s))
    }

    /// Notes that this many cycles were shown.
    pub(super) fn note_progress(&mut self, cycles: f64) {
        self.measured.0 += cycles;
    }
}

impl Default for Playback {
    fn default() -> Self {
        Self {
            paused: false,
            speed: Speed::Times(1.0),
            achieved: 0.0,
            problem: None,
            last_cycle: None,
            failed: false,
            measured: (0.0, 0.0),
            awaited: None,
        }
    }
}

/// The name of the match before the one that is shown, and the time at which it was left, if it is kept.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default)]
pub struct MatchBefore(pub Option<String>);

/// Prepares for keeping the match that is shown, before another takes its place, if it is to be kept.
#[derive(Resource, Clone, Copy, Debug)]
pub struct KeepMatch(pub fn(&mut World) -> Option<KeepLeft>);

/// Keeps the match that was left. Another one is in the world already, but not yet its past.
pub type KeepLeft = Box<dyn FnOnce(&mut World)>;

/// Puts another match in place of the one that is shown, which is kept if the window has [`KeepMatch`].
///
/// # Errors
/// That of `begin`. The current match then continues.
pub fn replace_match<E>(world: &mut World, begin: impl FnOnce(&mut World) -> Result<(), E>) -> Result<(), E> {
    let keep = world.get_resource::<KeepMatch>().copied().and_then(|KeepMatch(prepare)| prepare(world));
    begin(world)?;
    if let Some(keep) = keep {
        keep(world);
    }
    Ok(())
}

/// Why nothing can be done to a match that has ended.
pub const OVER: &str = "The match is over: R plays it again, or go back and branch (F)";

/// Returns whether the match has ended.
pub fn is_over(game: &Game, clock: &CycleClock, playback: &Playback) -> bool {
    game.state == GameState::Finished || playback.last_cycle.is_some_and(|last| clock.cycle >= last)
}

/// Returns the half, the clock and the state of the game for the score; only the clock if there is little room.
pub fn clock_words(game: &Game, clock: &CycleClock, playback: &Playback, has_room: bool) -> String {
    if game.state == GameState::Finished {
        return state_name(game.state).to_owned();
    }
    let is_over = is_over(game, clock, playback);
    let left = game.time_left_s(clock);
    let time = left.map_or_else(|| minutes(clock.end_time_s() as f32), minutes);
    if !has_room {
        return if is_over { "over".to_owned() } else { time };
    }
    let time = left.map_or_else(|| time.clone(), |_| format!("half {}   {time} left", game.half));
    match left {
        _ if is_over => format!("{time}   end of the scenario"),
        _ if game.stop.is_some() => format!("{time}   stopped"),
        Some(_) => format!("{time}   {}", state_words(game, clock)),
        None => format!("{time}   no referee"),
    }
}

/// The state of the game; a time-out with its team and its remaining time.
fn state_words(game: &Game, clock: &CycleClock) -> String {
    let Some(timeout) = game.timeout else { return state_name(game.state).to_owned() };
    let of = timeout.team.map_or_else(|| "the referee".to_owned(), |team| team.to_string());
    format!("time-out of {of}: {}", minutes((timeout.cycles_left as f64 * clock.period_s) as f32))
}

/// Returns the name of a state of the game in the window.
pub fn state_name(state: GameState) -> &'static str {
    match state {
        GameState::Initial => "initial",
        GameState::Standby => "standby",
        GameState::Ready => "ready",
        GameState::Set => "set",
        GameState::Playing => "playing",
        GameState::Timeout => "time-out",
        GameState::Finished => "finished",
    }
}

/// The displayed time as a fraction of the last cycle, from its start (0) to its end (1).
#[derive(Resource, Clone, Copy, PartialEq, Debug)]
pub struct DisplayFraction(pub f32);

impl Default for DisplayFraction {
    fn default() -> Self {
        Self(1.0)
    }
}

/// Whether the match is drawn as it was when the robots sensed in this cycle, at its start: through a robot's camera, detections lie on
/// the objects.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct DrawnWhenSensed(pub bool);

/// The file of the trace that is shown, if any.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Default)]
pub struct OpenedTrace(pub Option<PathBuf>);

/// The match that is shown is being saved as a trace in a file.
#[derive(Message, Clone, PartialEq, Eq, Debug)]
pub struct TraceSaved(pub PathBuf);

/// The selected robot, if any.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Selection(pub Option<RobotId>);

/// Returns the short name of a robot, such as `b7`.
pub fn short_name(id: RobotId) -> String {
    id.team.name().chars().take(1).chain(id.number.to_string().chars()).collect()
}

/// The areas of the names on the pitch, logical pixels of the window, the topmost last.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct NameAreas(pub Vec<(RobotId, Rect)>);

impl NameAreas {
    /// Returns the robot whose name is at a position.
    pub fn at(&self, place: Vec2) -> Option<RobotId> {
        self.0.iter().rev().find(|(_, area)| area.contains(place)).map(|(id, _)| *id)
    }
}

/// A notice to the user, shown for some seconds.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct Notice {
    /// The text.
    pub text: String,
    /// The remaining time, s.
    pub left_s: f32,
}

impl Notice {
    /// The least time for which a notice is shown, s; longer texts are shown longer.
    const SHOWN_S: f32 = 6.0;
    const LETTER_S: f32 = 0.1;

    /// Shows a notice.
    pub fn tell(&mut self, text: impl Into<String>) {
        let text = text.into();
        let left_s = Self::SHOWN_S.max(3.0 + Self::LETTER_S * text.chars().count() as f32);
        *self = Notice { text, left_s };
    }
}

/// Whether only the world of the selected robot is shown, as it believes it to be.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct RobotsWorld(pub bool);

/// The distance in +y at which another match is drawn on a pitch of its own, m; `None` if there is no such pitch.
#[derive(Resource, Clone, Copy, PartialEq, Debug, Default)]
pub struct SecondPitch(pub Option<f32>);

/// Returns whether the truth is shown.
pub fn shows_truth(world: Option<Res<RobotsWorld>>) -> bool {
    world.is_none_or(|world| !world.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::game::Timeout;
    use naoisis_core::team::Team;

    #[test]
    fn a_match_that_is_over_is_not_said_to_be_played() {
        let clock = CycleClock { cycle: 300, period_s: 0.1 };
        let game = Game { state: GameState::Playing, ..default() };
        let words = |last_cycle, has_room| clock_words(&game, &clock, &Playback { last_cycle, ..default() }, has_room);
        assert_eq!([words(None, true), words(None, false)], ["0:30   no referee", "0:30"]);
        assert_eq!([words(Some(300), true), words(Some(300), false)], ["0:30   end of the scenario", "over"]);
        let timeout = Timeout { team: Some(Team::Pink), cycles_left: 1500, before_shoot_out: false };
        let in_timeout =
            Game { state: GameState::Timeout, timeout: Some(timeout), cycles_left: Some(3000), ..default() };
        let words = clock_words(&in_timeout, &clock, &Playback::default(), true);
        assert_eq!(words, "half 0   5:00 left   time-out of pink: 2:30");
        let finished = Game { state: GameState::Finished, ..default() };
        assert_eq!(clock_words(&finished, &clock, &Playback::default(), true), "finished");
    }
}
