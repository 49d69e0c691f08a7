//! Replays of goals in slow motion: shortly after a goal, its past is shown from near, and then the match continues.

use bevy::prelude::*;
use core::f32::consts::FRAC_PI_4;

use crate::viewer::camera::{CameraMode, ViewerCamera};
use crate::viewer::commands::{TimelineCommand, ViewPreset};
use crate::viewer::display_settings::DisplaySettings;
use crate::viewer::display_settings::Workspace;
use crate::viewer::event_log::EventLog;
use crate::viewer::shared::{Playback, is_over};
use crate::viewer::speed::Speed;
use crate::viewer::timeline::Timeline;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Game;
use naoisis_core::pitch::End;
use naoisis_core::team::Team;
use naoisis_record::record::history::History;
use naoisis_record::record::match_marks::{Mark, MarkKind};

/// The time after a goal at which its replay starts, and the time before the goal from which it shows it, s of the
/// match.
const AFTER_S: f64 = 1.0;
const RUN_UP_S: f64 = 2.5;
/// The speed of replays.
const SLOW: Speed = Speed::Times(0.4);
/// The speed of the match from which there are no replays.
const FASTEST: f64 = 2.0;
/// A change of the moment by more than this is a jump, s. On a slow display, a frame may take longer than a second.
const LONGEST_STEP_S: f64 = 3.0;

/// Replays goals in the use [`Workspace::Watch`].
pub struct GoalReplayPlugin;

impl Plugin for GoalReplayPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<GoalReplay>().add_systems(Update, show_goals);
    }
}

/// The goal that is replayed or will be.
#[derive(Resource, Default, Debug)]
pub struct GoalReplay {
    /// The moment that was shown in the last frame, cycles.
    before: Option<f64>,
    /// The goal to replay.
    due: Option<Mark>,
    shown: Option<Shown>,
}

/// A running replay.
#[derive(Debug)]
struct Shown {
    words: String,
    /// The part of the match that is shown, cycles.
    part: [f64; 2],
    /// Whether it has started, or for how many frames it has not.
    has_begun: bool,
    waited: u8,
    /// The moment at which a trace continues after it, cycles.
    goes_on_at: f64,
    /// The state of the viewer before it.
    speed: Speed,
    camera: ViewerCamera,
}

impl GoalReplay {
    /// Returns the text of the goal that is replayed, if any.
    pub fn words(&self) -> Option<&str> {
        self.shown.as_ref().map(|shown| shown.words.as_str())
    }

    /// Returns whether a goal is replayed or will be.
    pub fn is_busy(&self) -> bool {
        self.shown.is_some() || self.due.is_some()
    }
}

/// The last goal between two moments of the match, cycles.
fn goal_between(marks: &[Mark], before: f64, now: f64) -> Option<Mark> {
    let is_between = |cycle: f64| before < cycle && cycle <= now;
    marks.iter().rev().find(|mark| mark.kind == MarkKind::Goal && is_between(mark.cycle as f64)).copied()
}

fn show_goals(
    display: Res<DisplaySettings>,
    (clock, game, timeline, history, log): (Res<CycleClock>, Res<Game>, Res<Timeline>, Res<History>, Res<EventLog>),
    mut replay: ResMut<GoalReplay>,
    mut playback: ResMut<Playback>,
    mut camera: Single<&mut ViewerCamera>,
    (mut moments, mut views): (MessageWriter<TimelineCommand>, MessageWriter<ViewPreset>),
) {
    let now = timeline.cursor().unwrap_or(clock.cycle as f64);
    let is_watching = display.workspace == Workspace::Watch;
    if let Some(shown) = replay.shown.as_mut() {
        let is_in_it = timeline.is_past() && (shown.part[0] - 1.0..=shown.part[1]).contains(&now);
        shown.has_begun |= is_in_it;
        shown.waited = shown.waited.saturating_add(1);
        // If the match was restarted meanwhile, the replay never starts.
        let is_left = !is_in_it && (shown.has_begun || shown.waited > 3);
        if !is_left && is_watching {
            return;
        }
        // If the user went to another moment meanwhile, that moment stays.
        let has_ended = timeline.is_past() && (shown.part[1]..shown.part[1] + 30.0).contains(&now);
        let goes_on_at = shown.goes_on_at;
        playback.speed = shown.speed;
        **camera = ViewerCamera { current: camera.current, ..shown.camera };
        *replay = GoalReplay { before: Some(goes_on_at), ..default() };
        if !is_watching {
            views.write(ViewPreset::Broadcast);
        }
        if has_ended || !is_watching {
            let back =
                if timeline.is_replay() { TimelineCommand::GoTo(goes_on_at as u64) } else { TimelineCommand::Present };
            moments.write(back);
        }
        return;
    }
    let before = replay.before.replace(now);
    let per_second = 1.0 / clock.period_s;
    let goes_on = !timeline.is_past() || timeline.is_replay();
    let is_slow = matches!(playback.speed, Speed::Times(factor) if factor <= FASTEST);
    let has_jumped = before.is_none_or(|before| !(0.0..=LONGEST_STEP_S * per_second).contains(&(now - before)));
    if !is_watching || !goes_on || !is_slow || has_jumped {
        replay.due = None;
        return;
    }
    if let Some(goal) = before.and_then(|before| goal_between(history.marks(), before, now)) {
        replay.due = Some(goal);
    }
    let at_end = is_over(&game, &clock, &playback) || playback.paused && timeline.is_replay();
    let Some(goal) = replay.due.filter(|goal| at_end || now - goal.cycle as f64 >= AFTER_S * per_second) else {
        return;
    };
    replay.due = None;
    // In the cycle of the goal itself, the ball may already be back on the centre.
    let last = goal.cycle.saturating_sub(1) as f64;
    let first = (last - RUN_UP_S * per_second).max(0.0);
    replay.shown = Some(Shown {
        words: words(&log, goal.cycle as f64 * clock.period_s, goal.team),
        part: [first, last],
        has_begun: false,
        waited: 0,
        goes_on_at: now,
        speed: playback.speed,
        camera: **camera,
    });
    playback.speed = SLOW;
    playback.paused = false;
    camera.mode = CameraMode::Ball;
    camera.wanted.distance = 2.6;
    camera.wanted.elevation = 0.35;
    // The camera looks towards the goal that the ball goes into.
    let end = game.own_end(goal.team.unwrap_or_default().opponent());
    camera.wanted.azimuth = if end == End::PositiveX { -FRAC_PI_4 } else { FRAC_PI_4 };
    moments.write(TimelineCommand::GoTo(first as u64));
}

/// The text of the goal of a team at a time, s.
fn words(log: &EventLog, time_s: f64, team: Option<Team>) -> String {
    /// The tolerance for the time of an entry, which is that of its cycle, rounded.
    const NEAR_S: f64 = 0.1;
    let entries = log.until(time_s + NEAR_S).iter().rev().take_while(|entry| entry.time_s > time_s - NEAR_S);
    let goal = entries.into_iter().find(|entry| entry.important && entry.team == team);
    goal.map_or_else(|| "Goal".to_owned(), |entry| entry.text.clone())
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::events::MatchEvent;
    use naoisis_core::game::Evidence;

    #[test]
    fn a_goal_is_shown_again_when_it_has_just_been_passed() {
        let mark = |cycle, kind| Mark { cycle, kind, team: Some(Team::Pink) };
        let marks = [mark(10, MarkKind::Goal), mark(12, MarkKind::Out), mark(40, MarkKind::Goal)];
        assert_eq!(goal_between(&marks, 9.5, 10.0), Some(marks[0]));
        assert_eq!(goal_between(&marks, 10.0, 39.9), None);
        assert_eq!(goal_between(&marks, 0.0, 50.0), Some(marks[2]));
    }

    #[test]
    fn a_goal_is_named_after_its_scorer() {
        let mut log = EventLog::default();
        let scorer = Some(naoisis_core::team::RobotId::new(Team::Pink, 2));
        let goal = MatchEvent::Goal { team: Team::Pink, scorer, own_goal: false, evidence: Evidence::default() };
        log.note(4.0, [&goal]);
        assert_eq!(words(&log, 4.0, Some(Team::Pink)), "Goal for pink by pink2");
        assert_eq!(words(&log, 9.0, Some(Team::Pink)), "Goal");
    }
}
