//! What the window shows: its panels, and how they are drawn.

use bevy::prelude::*;
use serde::{Deserialize, Serialize};

/// The use of the window.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Workspace {
    /// The match as on television: a camera that follows play, a large score, replays of goals in slow motion, a
    /// summary at the end.
    Watch,
    /// All panels: perceptions, beliefs and commands of robots, events.
    #[default]
    Debug,
    /// Only the pitch, with a pen, large words, the world of one robot, and bookmarks with captions.
    Teach,
}

impl Workspace {
    /// All uses, in the order of the key that switches between them.
    pub const ALL: [Workspace; 3] = [Workspace::Watch, Workspace::Debug, Workspace::Teach];

    /// Returns the name in the window.
    pub fn name(self) -> &'static str {
        match self {
            Workspace::Watch => "Watch",
            Workspace::Debug => "Debug",
            Workspace::Teach => "Teach",
        }
    }

    /// Returns what the window shows in this use, as a sentence.
    pub fn description(self) -> &'static str {
        match self {
            Workspace::Watch => "A camera that follows play, replays of goals, statistics.",
            Workspace::Debug => "Perceptions, beliefs and decisions of robots, and repetitions of moments.",
            Workspace::Teach => "Only the pitch, with a pen and bookmarks with captions.",
        }
    }

    /// Returns the use that is `steps` further in [`Workspace::ALL`].
    pub fn neighbour(self, steps: i8) -> Workspace {
        let count = Self::ALL.len() as isize;
        let index = Self::ALL.iter().position(|other| *other == self).unwrap_or(0) as isize;
        Self::ALL[(index + isize::from(steps)).rem_euclid(count) as usize]
    }
}

/// Returns whether the use is [`Workspace::Watch`].
pub fn is_watching(display: Res<DisplaySettings>) -> bool {
    display.workspace == Workspace::Watch
}

/// Returns whether the use is [`Workspace::Debug`], which shows panels.
pub fn is_debugging(display: Res<DisplaySettings>) -> bool {
    display.workspace == Workspace::Debug
}

/// Returns whether the use is [`Workspace::Teach`].
pub fn is_teaching(display: Res<DisplaySettings>) -> bool {
    display.workspace == Workspace::Teach
}

/// A part of the window that can be shown or hidden.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Switch {
    /// The list of keys.
    Help,
    /// The list of commands, to find one by typing.
    Commands,
    /// The scenario and its settings.
    Game,
    /// The list of events.
    Events,
    /// Names above the robots.
    Labels,
    /// Shadows and smooth edges.
    FineDrawing,
    /// The switches of the overlays.
    Overlays,
    /// The selected robot.
    Robot,
    /// The cameras of all robots.
    Cameras,
    /// The lanes of the whole match.
    Lanes,
    /// The plots of numbers over time.
    Plots,
    /// The repetitions from the moment that is shown.
    ManyTimes,
    /// The search for what decided the match.
    Decided,
    /// The statistics of the match.
    Summary,
    /// The cost of a frame.
    FrameCost,
    /// Light panels instead of dark ones.
    Light,
    /// Larger panels, thicker lines and a legend of the overlays, for a projector.
    Projector,
}

/// The size of panels and their text.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
pub struct PanelScale(u8);

impl PanelScale {
    /// The factors to choose from; the middle one is that of the display.
    const FACTORS: [f32; 8] = [0.7, 0.8, 0.9, 1.0, 1.15, 1.35, 1.6, 2.0];

    /// Returns the factor relative to the display.
    pub fn factor(self) -> f32 {
        Self::FACTORS.get(usize::from(self.0)).copied().unwrap_or(1.0)
    }

    /// The size that is `steps` larger.
    pub(super) fn larger(self, steps: i8) -> Self {
        Self(self.0.saturating_add_signed(steps).min(Self::FACTORS.len() as u8 - 1))
    }
}

impl Default for PanelScale {
    fn default() -> Self {
        Self(3)
    }
}

/// Which panels are shown, and how the window is drawn.
#[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct DisplaySettings {
    /// The use of the window.
    pub workspace: Workspace,
    /// The list of keys.
    pub help: bool,
    /// The list of commands.
    pub commands: bool,
    /// The scenario and its settings.
    pub game: bool,
    /// The list of events.
    pub events: bool,
    /// Names above the robots.
    pub labels: bool,
    /// Shadows and smooth edges.
    pub fine_drawing: bool,
    /// Whether the switches of the overlays are shown.
    pub overlays: bool,
    /// Whether the panel of the selected robot is shown.
    pub robot: bool,
    /// Whether the camera images of all robots are shown.
    pub cameras: bool,
    /// Whether the lanes of the whole match are shown.
    pub lanes: bool,
    /// Whether the plots of numbers over time are shown.
    pub plots: bool,
    /// Whether the repetitions from the shown moment are shown.
    pub many_times: bool,
    /// Whether the search for what decided the match is shown.
    pub decided: bool,
    /// Whether the statistics of the match are shown. At the end of a match that is watched they are shown in any case.
    pub summary: bool,
    /// Whether the cost of a frame is shown.
    pub frame_cost: bool,
    /// Whether panels are light instead of dark.
    pub light: bool,
    /// Whether the window is for a projector: panels are larger, lines are thicker, and overlays have a legend.
    pub projector: bool,
    /// The size of panels.
    pub panel_scale: PanelScale,
}

impl Default for DisplaySettings {
    fn default() -> Self {
        Self {
            workspace: Workspace::default(),
            help: false,
            commands: false,
            game: false,
            events: true,
            labels: true,
            fine_drawing: true,
            overlays: false,
            robot: true,
            cameras: false,
            lanes: false,
            plots: false,
            many_times: false,
            decided: false,
            summary: false,
            frame_cost: false,
            light: false,
            projector: false,
            panel_scale: PanelScale::default(),
        }
    }
}

impl DisplaySettings {
    /// Panels at the right or above the match. Only one of them is open at a time.
    const OPENED: [Switch; 8] = [
        Switch::Summary,
        Switch::Help,
        Switch::Commands,
        Switch::Game,
        Switch::Overlays,
        Switch::Cameras,
        Switch::Decided,
        Switch::ManyTimes,
    ];

    /// Shows or hides a part of the window.
    pub fn toggle(&mut self, switch: Switch) {
        let was_on = *self.of_mut(switch);
        if Self::OPENED.contains(&switch) {
            self.close_opened();
        }
        *self.of_mut(switch) = !was_on;
    }

    /// Returns whether a panel at the right is open.
    pub fn has_panel_at_right(&self) -> bool {
        self.game || self.overlays || self.cameras || self.decided || self.many_times
    }

    /// Returns the size of panels relative to the display, in a window of this height, logical pixels.
    pub fn panel_factor(&self, height: f32) -> f32 {
        /// How much larger panels are for a projector, and the height from which on they grow with the window.
        const PROJECTED: f32 = 1.35;
        const HEIGHT: f32 = 1080.0;
        self.panel_scale.factor() * if self.projector { PROJECTED * (height / HEIGHT).max(1.0) } else { 1.0 }
    }

    /// Changes the use of the window. Closes panels that were opened for the last one.
    pub fn enter(&mut self, workspace: Workspace) {
        self.workspace = workspace;
        self.close_opened();
    }

    /// Closes the panels at the right and above the match.
    pub fn close_opened(&mut self) {
        for opened in Self::OPENED {
            *self.of_mut(opened) = false;
        }
    }

    /// Returns the value of a switch, to change it.
    pub fn of_mut(&mut self, switch: Switch) -> &mut bool {
        match switch {
            Switch::Help => &mut self.help,
            Switch::Commands => &mut self.commands,
            Switch::Game => &mut self.game,
            Switch::Events => &mut self.events,
            Switch::Labels => &mut self.labels,
            Switch::FineDrawing => &mut self.fine_drawing,
            Switch::Overlays => &mut self.overlays,
            Switch::Robot => &mut self.robot,
            Switch::Cameras => &mut self.cameras,
            Switch::Lanes => &mut self.lanes,
            Switch::Plots => &mut self.plots,
            Switch::ManyTimes => &mut self.many_times,
            Switch::Decided => &mut self.decided,
            Switch::Summary => &mut self.summary,
            Switch::FrameCost => &mut self.frame_cost,
            Switch::Light => &mut self.light,
            Switch::Projector => &mut self.projector,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_key_goes_through_all_three_and_back() {
        let mut now = Workspace::default();
        for expected in [Workspace::Teach, Workspace::Watch, Workspace::Debug] {
            now = now.neighbour(1);
            assert_eq!(now, expected);
        }
        assert_eq!(Workspace::Watch.neighbour(-1), Workspace::Teach);
    }

    #[test]
    fn what_is_opened_takes_turns() {
        let mut display = DisplaySettings::default();
        for switch in DisplaySettings::OPENED {
            display.toggle(switch);
            let open = DisplaySettings::OPENED.into_iter().filter(|other| *display.of_mut(*other));
            assert_eq!(open.collect::<Vec<_>>(), [switch]);
        }
        display.toggle(Switch::ManyTimes);
        assert!(!display.many_times && display.events, "what is always there stays");
    }

    #[test]
    fn nothing_is_left_open_from_another_way_to_use_the_window() {
        let mut display = DisplaySettings { game: true, ..default() };
        display.enter(Workspace::Watch);
        assert!(!display.game && display.workspace == Workspace::Watch);
        // A file from before there were three workspaces.
        let text = r#"{ "light": true }"#;
        assert_eq!(serde_json::from_str::<DisplaySettings>(text).unwrap().workspace, Workspace::Debug);
    }

    #[test]
    fn panels_are_as_large_as_the_display_has_them_at_first_and_stay_within_limits() {
        assert_eq!(PanelScale::default().factor(), 1.0);
        assert_eq!(PanelScale::default().larger(100).factor(), 2.0);
        assert_eq!(PanelScale::default().larger(-100).factor(), 0.7);
    }
}
