//! What the parts of the viewer tell each other, and what all of them know: messages, the order of those who write and read
//! them, and what is shown now.

use bevy::prelude::*;

use super::display_settings::{Switch, Workspace};
use super::speed::Speed;
use naoisis_core::camera_model::CameraName;
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::{Game, GameState};
use naoisis_core::team::{RobotId, Team};

/// The systems that carry out what the keys mean.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct KeysSystems;

/// The systems that select robots.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SelectionSystems;

/// The systems that let the user move the camera.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct CameraSystems;

/// What a key, or a button, does.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum Action {
    /// Something for the match.
    Command(ViewerCommand),
    /// Another moment of the match.
    Timeline(TimelineCommand),
    /// The moment that is shown, played on beside the match.
    PlayFromHere,
    /// The moment of another event.
    Find(FindEvent),
    /// Another view.
    View(ViewPreset),
    /// Another robot.
    Select(SelectionCommand),
    /// Shows or hides something.
    Toggle(Switch),
    /// Uses the window for this.
    Workspace(Workspace),
    /// Uses the window for the next thing (1), or the one before (-1).
    NextWorkspace(i8),
    /// Something for the match, by hand.
    Hand(HandAction),
    /// Something for those to whom the match is shown.
    Teach(TeachAction),
    /// Larger panels and text (1), or smaller ones (-1).
    ScalePanels(i8),
    /// Writes a picture of the window to the current folder.
    Screenshot,
    /// Begins or ends a film of the window in the current folder.
    Film(ToggleFilm),
}

/// What the user wants of the match.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum ViewerCommand {
    /// Stop, or go on.
    TogglePause,
    /// Stop if it runs, and run one cycle.
    Step,
    /// The next higher speed.
    Faster,
    /// The next lower speed.
    Slower,
    /// This speed.
    SetSpeed(Speed),
    /// From the start, the same match again.
    Restart,
    /// From the start, with the next seed.
    RestartWithNextSeed,
    /// The built-in scenario of this name, from the start.
    Load(&'static str),
}

/// What the user wants to see.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum TimelineCommand {
    /// The end of this cycle; of one that is not there yet, the present.
    GoTo(u64),
    /// So many cycles later; earlier, if negative. The match stands then.
    Step(i64),
    /// So many seconds later; earlier, if negative.
    Skip(f64),
    /// The match as it is now; of a replay, its end.
    Present,
}

/// The moment of the next event of the chosen kind is to be shown, or of the one before: of the selected robot, if one is.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum FindEvent {
    /// The next one.
    Next,
    /// The one before.
    Previous,
}

/// The views to choose from.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum ViewPreset {
    /// The whole pitch from the side, as on television.
    Broadcast,
    /// The whole pitch from above.
    TopDown,
    /// The part of the pitch where the match is played.
    FollowPlay,
    /// Close to the ball, wherever it goes.
    FollowBall,
    /// Behind the selected robot, wherever it goes.
    FollowRobot,
    /// What one of the selected robot's cameras sees.
    Eyes(CameraName),
    /// Wherever the mouse flies to.
    Fly,
}

/// Another robot is to be selected.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum SelectionCommand {
    /// This one, if it is in the match.
    Robot(RobotId),
    /// Blue's or pink's robot of this number.
    Number(Team, u8),
    /// The next one in the order of the ids.
    Next,
    /// The one before.
    Previous,
    /// No robot is selected.
    Nobody,
}

/// What the user does to the match other than with the mouse.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum HandAction {
    /// The whistle.
    Whistle,
    /// Removes the selected robot from the pitch, or ends its penalty.
    PenaliseOrReturn,
    /// Puts the ball on the centre, in play.
    DropBall,
    /// Drives the selected robot by the keyboard, or stops to.
    Drive,
    /// Saves the present situation as a scenario file.
    KeepSituation,
    /// Takes back what was done last.
    Undo,
    /// Does again what was taken back.
    Redo,
}

/// What the user does for those to whom the match is shown.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum TeachAction {
    /// The mouse draws, or no longer.
    Pen,
    /// Takes back what was drawn last.
    Erase,
    /// Only the world of the selected robot, as it believes it to be, or the truth again.
    RobotsWorld,
    /// Keeps this moment with a caption.
    Bookmark,
    /// Shows the next of the moments that were kept.
    NextBookmark,
    /// Shows the one before.
    PreviousBookmark,
}

/// Begins a film of what is shown, or ends the one that is being taken.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum ToggleFilm {
    /// A video.
    Video,
    /// A folder of PNG files.
    Frames,
}

/// How the match is being shown.
#[derive(Resource, Clone, PartialEq, Debug)]
pub struct Playback {
    /// Whether the match stands still.
    pub paused: bool,
    /// The wanted speed.
    pub speed: Speed,
    /// The speed of late, in simulated seconds a second.
    pub achieved: f32,
    /// What is wrong with the last command, if anything.
    pub problem: Option<String>,
    /// The cycle after which the match is over, where the scenario says.
    pub(super) last_cycle: Option<u64>,
    /// Whether a cycle could not be finished, so that the match cannot go on.
    pub(super) failed: bool,
    /// Cycles run, and over which time, since the achieved speed was last worked out.
    pub(super) measured: (f64, f32),
}

impl Playback {
    /// Notes that so many cycles were shown.
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
        }
    }
}

/// Whether the match has come to its end.
pub fn is_over(game: &Game, clock: &CycleClock, playback: &Playback) -> bool {
    game.state == GameState::Finished || playback.last_cycle.is_some_and(|last| clock.cycle >= last)
}

/// Where between the start (0) and the end (1) of the last cycle the match is shown.
#[derive(Resource, Clone, Copy, PartialEq, Debug)]
pub struct DisplayFraction(pub f32);

impl Default for DisplayFraction {
    fn default() -> Self {
        Self(1.0)
    }
}

/// The selected robot, if any.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct Selection(pub Option<RobotId>);

/// What the user is told of what was done, for a while.
#[derive(Resource, Clone, PartialEq, Debug, Default)]
pub struct Notice {
    /// The words.
    pub text: String,
    /// For how long they are still shown, s.
    pub left_s: f32,
}

impl Notice {
    /// How long words are shown, s: at least, and more for each letter, as people read.
    const SHOWN_S: f32 = 6.0;
    const LETTER_S: f32 = 0.1;

    /// Tells something.
    pub fn tell(&mut self, text: impl Into<String>) {
        let text = text.into();
        let left_s = Self::SHOWN_S.max(3.0 + Self::LETTER_S * text.chars().count() as f32);
        *self = Notice { text, left_s };
    }
}

/// Whether only the world of the selected robot is shown, as it believes it to be.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct RobotsWorld(pub bool);

/// Whether all is shown as it is.
pub fn shows_truth(world: Option<Res<RobotsWorld>>) -> bool {
    world.is_none_or(|world| !world.0)
}
