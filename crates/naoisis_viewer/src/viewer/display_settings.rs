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

/// Defines [`Switch`] and [`DisplaySettings`] by a list: the variant, the field, and whether the switch is on at first.
macro_rules! switches {
    ($($(#[$documentation:meta])* $variant:ident $field:ident = $default:literal;)*) => {
        /// A part of the window that can be shown or hidden.
        #[derive(Clone, Copy, PartialEq, Eq, Debug)]
        pub enum Switch {
            $($(#[$documentation])* $variant,)*
        }

        /// Which panels are shown, and how the window is drawn.
        #[derive(Resource, Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
        #[serde(default)]
        pub struct DisplaySettings {
            /// The use of the window.
            pub workspace: Workspace,
            $($(#[$documentation])* pub $field: bool,)*
            /// The size of panels.
            pub panel_scale: PanelScale,
        }

        impl Default for DisplaySettings {
            fn default() -> Self {
                let (workspace, panel_scale) = (Workspace::default(), PanelScale::default());
                Self { workspace, $($field: $default,)* panel_scale }
            }
        }

        impl DisplaySettings {
            /// Returns the value of a switch, to change it.
            pub fn of_mut(&mut self, switch: Switch) -> &mut bool {
                match switch {
                    $(Switch::$variant => &mut self.$field,)*
                }
            }
        }
    };
}

switches! {
    /// The list of keys.
    Help help = false;
    /// The list of commands, to find one by typing.
    Commands commands = false;
    /// The scenario and its settings.
    Game game = false;
    /// The list of events.
    Events events = true;
    /// Names above the robots.
    Labels labels = true;
    /// Shadows and smooth edges.
    FineDrawing fine_drawing = true;
    /// The switches of the overlays.
    Overlays overlays = false;
    /// The selected robot.
    Robot robot = true;
    /// The cameras of all robots.
    Cameras cameras = false;
    /// The lanes of the whole match.
    Lanes lanes = false;
    /// The plots of numbers over time.
    Plots plots = false;
    /// The repetitions from the moment that is shown.
    ManyTimes many_times = false;
    /// The search for what decided the match.
    Decided decided = false;
    /// The statistics of the match. At the end of a match that is watched they are shown in any case.
    Summary summary = false;
    /// The cost of a frame.
    FrameCost frame_cost = false;
    /// Light panels instead of dark ones.
    Light light = false;
    /// Larger panels, thicker lines and a legend of the overlays, for a projector.
    Projector projector = false;
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
