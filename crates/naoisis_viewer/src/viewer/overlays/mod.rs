//! Overlays: drawings on the pitch of what robots see, hear, believe and want, of their bodies and trails, and of the
//! areas of the rules.
//!
//! Each kind has a switch for all robots, for the selected one, and for each robot. Robots' cameras do not see
//! overlays, because they have a renderer of their own.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use strum::VariantArray;

use super::display_settings::{DisplaySettings, Workspace, is_watching};
use super::pitch_frame::{PitchFrameSystems, between};
use super::shared::{DisplayFraction, RobotsWorld, Selection, SelectionSystems};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::PreviousPose;
use naoisis_core::team::RobotId;

mod beliefs;
mod bodies;
pub mod brush;
pub mod geometry;
mod legend;
pub mod panel;
mod senses;
mod surroundings;

pub use beliefs::draw_world_of;
pub(super) use beliefs::{SEEN_LATELY_S, faded};
pub use brush::{Brush, OverlayWords};
pub use senses::junction_letter;

/// Draws the overlays.
pub struct OverlaysPlugin;

impl Plugin for OverlaysPlugin {
    fn build(&self, app: &mut App) {
        app.init_gizmo_group::<brush::OverlayLines>()
            .init_resource::<Overlays>()
            .init_resource::<OverlayWords>()
            .add_message::<OverlayCommand>()
            .add_plugins((panel::OverlayPanelPlugin, legend::LegendPlugin))
            .add_systems(
                Update,
                (
                    handle_overlay_commands.after(SelectionSystems),
                    brush::set_lines.run_if(resource_changed::<DisplaySettings>),
                ),
            )
            .add_systems(
                PostUpdate,
                (
                    brush::forget_words,
                    (surroundings::draw_areas, surroundings::draw_last_touch).chain().run_if(not(is_watching)),
                    bodies::draw_bounds,
                    bodies::draw_kick_areas,
                    bodies::draw_trails,
                    bodies::draw_targets,
                    senses::draw_fields_of_view,
                    senses::draw_sonars,
                    senses::draw_percepts,
                    beliefs::draw_beliefs,
                    bodies::draw_drawings,
                )
                    .chain()
                    .in_set(OverlaySystems)
                    .after(PitchFrameSystems)
                    // The texts are drawn together with the panels.
                    .before(EguiPostUpdateSet::EndPass),
            );
    }
}

/// The systems that draw the overlays.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct OverlaySystems;

/// The kinds of overlays of robots.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash, Serialize, Deserialize, VariantArray)]
#[serde(rename_all = "snake_case")]
pub enum Overlay {
    /// The ground that its cameras see.
    FieldsOfView,
    /// The sectors and echoes of its sonars.
    Sonar,
    /// Its detections, at the positions it measured.
    Percepts,
    /// Its beliefs about itself, the ball and other robots, compared with the truth.
    Beliefs,
    /// Its targets and next steps.
    Targets,
    /// The drawings of its behaviour.
    Drawings,
    /// Its bounding boxes.
    Bounds,
    /// The regions in which it can kick the ball.
    KickAreas,
    /// Its recent path.
    Trails,
}

impl Overlay {
    /// All kinds.
    pub const ALL: [Overlay; Overlay::VARIANTS.len()] = *Overlay::VARIANTS.first_chunk().expect("as many as there are");

    /// Returns the name in the window.
    pub fn name(self) -> &'static str {
        match self {
            Overlay::FieldsOfView => "Fields of view",
            Overlay::Sonar => "Sonar",
            Overlay::Percepts => "Percepts",
            Overlay::Beliefs => "Beliefs and truth",
            Overlay::Targets => "Plans",
            Overlay::Drawings => "Own drawings",
            Overlay::Bounds => "Bounds",
            Overlay::KickAreas => "Kick areas",
            Overlay::Trails => "Trails",
        }
    }

    /// Returns the description in the window.
    pub fn description(self) -> &'static str {
        match self {
            Overlay::FieldsOfView => "The ground that the upper (yellow) and the lower (pale yellow) camera see",
            Overlay::Sonar => "The sectors of both sonars, and the echoes in them",
            Overlay::Percepts => "Detections of the cameras, at the positions that the robot measures",
            Overlay::Beliefs => {
                "Beliefs about itself, the ball and others, each with its 95 % ellipse and a line to the truth"
            }
            Overlay::Targets => "Target, effect of the current command, and direction of the head",
            Overlay::Drawings => "The lines, circles and words that its behaviour draws",
            Overlay::Bounds => "Boxes of torso and base, as used by collisions, sonars and cameras",
            Overlay::KickAreas => "Where the ball must lie for each kick",
            Overlay::Trails => "Path of the last seconds",
        }
    }
}

/// The robots for which a kind is drawn.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Shows {
    /// All robots.
    pub all: bool,
    /// The selected robot, while panels are shown.
    pub selected: bool,
    /// The selected robot, in the use [`Workspace::Teach`], where it must be switched on.
    pub selected_in_teaching: bool,
    /// These robots, selected or not.
    pub robots: BTreeSet<RobotId>,
}

/// Which overlays are drawn.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct Overlays {
    /// The kinds for robots.
    pub of_robots: BTreeMap<Overlay, Shows>,
    /// The last touch of the ball.
    pub last_touch: bool,
    /// The areas of the rules.
    pub areas: bool,
}

impl Default for Overlays {
    /// The default: perceptions, beliefs and commands of the selected robot.
    fn default() -> Self {
        let of_selected = [
            Overlay::FieldsOfView,
            Overlay::Sonar,
            Overlay::Percepts,
            Overlay::Beliefs,
            Overlay::Targets,
            Overlay::Drawings,
        ];
        Self {
            of_robots: of_selected.map(|overlay| (overlay, Shows { selected: true, ..default() })).into(),
            last_touch: false,
            areas: false,
        }
    }
}

impl Shows {
    /// Returns whether the kind is drawn for the selected robot.
    pub fn of_selected(&self, workspace: Workspace) -> bool {
        if workspace == Workspace::Teach { self.selected_in_teaching } else { self.selected }
    }
}

impl Overlays {
    /// Returns whether a kind is drawn for a robot.
    pub fn shows(&self, overlay: Overlay, robot: RobotId, selection: &Selection, workspace: Workspace) -> bool {
        self.of_robots.get(&overlay).is_some_and(|shows| {
            let is_selected = selection.0 == Some(robot);
            shows.all || (is_selected && shows.of_selected(workspace)) || shows.robots.contains(&robot)
        })
    }

    /// Returns whether a kind is drawn for any robot.
    pub fn shows_any(&self, overlay: Overlay, selection: &Selection, workspace: Workspace) -> bool {
        self.of_robots.get(&overlay).is_some_and(|shows| {
            shows.all || (selection.0.is_some() && shows.of_selected(workspace)) || !shows.robots.is_empty()
        })
    }
}

/// Commands about overlays.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum OverlayCommand {
    /// Switches a kind for all robots.
    ToggleAll(Overlay),
    /// Switches a kind for the selected robot.
    ToggleSelected(Overlay),
    /// Switches a kind for this robot.
    Toggle(Overlay, RobotId),
    /// Switches the last touch of the ball.
    ToggleLastTouch,
    /// Switches the areas of the rules.
    ToggleAreas,
    /// Switches all overlays off.
    Clear,
    /// Restores the default.
    Reset,
}

fn handle_overlay_commands(
    mut commands: MessageReader<OverlayCommand>,
    mut overlays: ResMut<Overlays>,
    display: Res<DisplaySettings>,
) {
    for command in commands.read() {
        overlays.apply(*command, display.workspace);
    }
}

impl Overlays {
    fn apply(&mut self, command: OverlayCommand, workspace: Workspace) {
        let flip = |switch: &mut bool| *switch = !*switch;
        match command {
            OverlayCommand::ToggleAll(overlay) => flip(&mut self.of_robots.entry(overlay).or_default().all),
            OverlayCommand::ToggleSelected(overlay) => {
                let shows = self.of_robots.entry(overlay).or_default();
                let is_teaching = workspace == Workspace::Teach;
                flip(if is_teaching { &mut shows.selected_in_teaching } else { &mut shows.selected });
            }
            OverlayCommand::Toggle(overlay, robot) => {
                let robots = &mut self.of_robots.entry(overlay).or_default().robots;
                if !robots.remove(&robot) {
                    robots.insert(robot);
                }
            }
            OverlayCommand::ToggleLastTouch => flip(&mut self.last_touch),
            OverlayCommand::ToggleAreas => flip(&mut self.areas),
            OverlayCommand::Clear => {
                *self = Overlays { of_robots: BTreeMap::new(), last_touch: false, areas: false };
            }
            OverlayCommand::Reset => *self = Overlays::default(),
        }
    }
}

/// The robots for which kinds are drawn, and the displayed poses.
#[derive(SystemParam)]
pub(super) struct Showing<'w> {
    overlays: Res<'w, Overlays>,
    display: Res<'w, DisplaySettings>,
    world: Option<Res<'w, RobotsWorld>>,
    selection: Res<'w, Selection>,
    fraction: Res<'w, DisplayFraction>,
    clock: Res<'w, CycleClock>,
}

impl Showing<'_> {
    /// Whether a kind is drawn for any robot.
    fn any(&self, overlay: Overlay) -> bool {
        // The watching workspace shows the match only. In the world of one robot, the other robots are not shown.
        let workspace = self.display.workspace;
        self.shows_truth()
            && workspace != Workspace::Watch
            && self.overlays.shows_any(overlay, &self.selection, workspace)
    }

    /// Whether the match is watched, without panels.
    fn is_watched(&self) -> bool {
        self.display.workspace == Workspace::Watch
    }

    /// Whether the truth is shown, instead of the world of one robot.
    fn shows_truth(&self) -> bool {
        self.world.as_ref().is_none_or(|world| !world.0)
    }

    /// Whether a kind is drawn for a robot; not for penalised robots.
    fn shows(&self, overlay: Overlay, robot: RobotId, penalty: &Penalty) -> bool {
        self.any(overlay) && !penalty.is_off_pitch() && self.wants(overlay, robot)
    }

    /// Whether a kind is chosen for a robot.
    fn wants(&self, overlay: Overlay, robot: RobotId) -> bool {
        self.overlays.shows(overlay, robot, &self.selection, self.display.workspace)
    }

    /// The displayed pose, pitch frame.
    fn place(&self, pose: &Pose, previous: &PreviousPose) -> Pose {
        between(previous.0, *pose, self.fraction.0, self.clock.period())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use naoisis_core::team::Team;

    const DEBUG: Workspace = Workspace::Debug;

    #[test]
    fn a_kind_is_shown_of_all_of_the_selected_or_of_some() {
        let (one, other) = (RobotId::new(Team::Blue, 1), RobotId::new(Team::Pink, 2));
        let (nobody, selected) = (Selection(None), Selection(Some(one)));
        let mut overlays = Overlays::default();
        assert!(overlays.shows(Overlay::Beliefs, one, &selected, DEBUG));
        assert!(!overlays.shows(Overlay::Beliefs, other, &selected, DEBUG));
        assert!(!overlays.shows_any(Overlay::Beliefs, &nobody, DEBUG));
        overlays.apply(OverlayCommand::Toggle(Overlay::Beliefs, other), DEBUG);
        assert!(
            overlays.shows(Overlay::Beliefs, other, &nobody, DEBUG)
                && overlays.shows_any(Overlay::Beliefs, &nobody, DEBUG)
        );
        overlays.apply(OverlayCommand::ToggleAll(Overlay::Trails), DEBUG);
        assert!(
            overlays.shows(Overlay::Trails, one, &nobody, DEBUG)
                && overlays.shows(Overlay::Trails, other, &nobody, DEBUG)
        );
        overlays.apply(OverlayCommand::ToggleAll(Overlay::Trails), DEBUG);
        assert!(!overlays.shows(Overlay::Trails, one, &selected, DEBUG));
        overlays.apply(OverlayCommand::Clear, DEBUG);
        assert!(Overlay::ALL.into_iter().all(|overlay| !overlays.shows(overlay, one, &selected, DEBUG)));
        overlays.apply(OverlayCommand::Reset, DEBUG);
        assert_eq!(overlays, Overlays::default());
    }

    #[test]
    fn who_is_selected_for_others_has_nothing_around_it_until_it_is_asked_for() {
        let one = RobotId::new(Team::Blue, 1);
        let selected = Selection(Some(one));
        let mut overlays = Overlays::default();
        assert!(Overlay::ALL.into_iter().all(|overlay| !overlays.shows_any(overlay, &selected, Workspace::Teach)));
        overlays.apply(OverlayCommand::ToggleSelected(Overlay::Beliefs), Workspace::Teach);
        assert!(overlays.shows(Overlay::Beliefs, one, &selected, Workspace::Teach));
        overlays.apply(OverlayCommand::ToggleSelected(Overlay::Beliefs), DEBUG);
        assert!(!overlays.shows(Overlay::Beliefs, one, &selected, DEBUG));
        assert!(overlays.shows(Overlay::Beliefs, one, &selected, Workspace::Teach));
    }

    #[test]
    fn what_is_shown_can_be_kept_in_a_file() {
        let mut overlays = Overlays::default();
        overlays.apply(OverlayCommand::Toggle(Overlay::Bounds, RobotId::new(Team::Pink, 2)), DEBUG);
        let text = ron::to_string(&overlays).unwrap();
        assert_eq!(ron::from_str::<Overlays>(&text).unwrap(), overlays);
    }
}
