//! Commands of keys and buttons: messages between the parts of the viewer.

use bevy::prelude::*;

use super::display_settings::{Switch, Workspace};
use super::speed::Speed;
use naoisis_core::camera_model::CameraName;
use naoisis_core::game::Intervention;
use naoisis_core::team::{RobotId, Team};

/// An action of a key or a button.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum Action {
    /// A command about the match.
    Command(ViewerCommand),
    /// A change of the moment that is shown.
    Timeline(TimelineCommand),
    /// Plays on from the moment that is shown, as a new branch.
    PlayFromHere,
    /// Shows another branch or match beside this one.
    Compare,
    /// Jumps to another event.
    Find(FindEvent),
    /// Changes the view.
    View(ViewPreset),
    /// Selects another robot.
    Select(SelectionCommand),
    /// Shows or hides a part of the window.
    Toggle(Switch),
    /// Changes the use of the window.
    Workspace(Workspace),
    /// Changes to the next (1) or previous (-1) use of the window.
    NextWorkspace(i8),
    /// An intervention by hand.
    Hand(HandAction),
    /// An action for presenting the match.
    Teach(TeachAction),
    /// Makes panels and text larger (1) or smaller (-1).
    ScalePanels(i8),
    /// Saves a picture in the current folder.
    Picture(TakePicture),
    /// Opens the dialog for files.
    OpenFile,
    /// Fills the screen with the window, or ends this.
    FullScreen,
    /// Makes something of the match for others.
    Share(Share),
    /// Starts or ends a recording of the window in the current folder.
    Film(ToggleFilm),
}

/// Commands about the match.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum ViewerCommand {
    /// Pauses or continues.
    TogglePause,
    /// Pauses if the match runs, and runs one cycle.
    Step,
    /// Selects the next higher speed.
    Faster,
    /// Selects the next lower speed.
    Slower,
    /// Sets the speed.
    SetSpeed(Speed),
    /// Restarts the same match.
    Restart,
    /// Restarts with the next seed.
    RestartWithNextSeed,
    /// Shows the match before, and keeps this one in its place.
    MatchBefore,
    /// Starts the built-in scenario of this name.
    Load(&'static str),
}

/// Commands about the moment that is shown.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum TimelineCommand {
    /// Shows the end of this cycle, or the present if it has not been played.
    GoTo(u64),
    /// Moves by this number of cycles and pauses. Negative numbers go back.
    Step(i64),
    /// Moves by this number of seconds. Negative numbers go back.
    Skip(f64),
    /// Shows the present; in a replay, the end.
    Present,
}

/// Jumps to an event of the chosen kind, of the selected robot if there is one.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum FindEvent {
    /// The next event.
    Next,
    /// The previous event.
    Previous,
}

/// The views.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum ViewPreset {
    /// The whole pitch from the side, as on television.
    Broadcast,
    /// The whole pitch from above.
    TopDown,
    /// The part of the pitch where play is.
    FollowPlay,
    /// Close to the ball, following it.
    FollowBall,
    /// Behind the selected robot, following it.
    FollowRobot,
    /// Through a camera of the selected robot.
    RobotCamera(CameraName),
    /// Flying freely by the mouse.
    Fly,
}

/// Selects a robot.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum SelectionCommand {
    /// This robot, if it is in the match.
    Robot(RobotId),
    /// The robot of this team and number.
    Number(Team, u8),
    /// The next robot by id.
    Next,
    /// The previous robot by id.
    Previous,
    /// No robot.
    Nobody,
}

/// Interventions by keys and buttons.
#[derive(Message, Clone, Copy, PartialEq, Debug)]
pub enum HandAction {
    /// Blows the whistle.
    Whistle,
    /// Penalises the selected robot, or ends its penalty.
    PenaliseOrReturn,
    /// Puts the ball on the centre mark, in play.
    DropBall,
    /// Makes another call of the referee.
    Intervene(Intervention),
    /// Starts or stops driving the selected robot by the keyboard.
    Drive,
    /// Saves the current situation as a scenario file.
    KeepSituation,
    /// Saves the match, to continue it later, and its trace.
    KeepMatch,
    /// Undoes the last step.
    Undo,
    /// Redoes the last undone step.
    Redo,
}

/// Actions for presenting the match.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum TeachAction {
    /// Switches drawing by the mouse.
    Pen,
    /// Removes the last stroke.
    Erase,
    /// Switches between the world as the selected robot believes it and the truth.
    RobotsWorld,
    /// Adds a bookmark with a caption at this moment.
    Bookmark,
    /// Shows the next bookmark.
    NextBookmark,
    /// Shows the previous bookmark.
    PreviousBookmark,
}

/// What is made of the match for others.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum Share {
    /// The command that opens the moment that is shown, in the clipboard.
    Link,
    /// A picture of the window, in the clipboard.
    Picture,
    /// A web page of the match, in the current folder.
    Page,
}

/// Takes a picture of the window.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum TakePicture {
    /// With its panels.
    OfWindow,
    /// Without panels: the match with the names of the robots.
    OfMatch,
}

/// Starts or ends a recording of the window.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum ToggleFilm {
    /// A video.
    Video,
    /// A video without panels.
    VideoOfMatch,
    /// A folder of PNG files.
    Frames,
}

/// Asks for another branch or match on a pitch of its own, beside the match that is shown, or ends this.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub struct Compare;
