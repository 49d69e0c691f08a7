//! What is drawn on the pitch: what robots see, hear, believe and want, their bodies and ways, and the rules' areas.
//!
//! Each kind has a switch, for all robots, for the selected one, and for each. Robots' cameras see none of it: they have
//! a renderer of their own.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_egui::EguiPostUpdateSet;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

use super::display_settings::{DisplaySettings, Workspace, is_watching};
use super::shared::{DisplayFraction, RobotsWorld, Selection, SelectionSystems};
use super::stage::{StageSystems, between};
use naoisis_core::cycle::CycleClock;
use naoisis_core::game::Penalty;
use naoisis_core::geometry::Pose;
use naoisis_core::robot::PreviousPose;
use naoisis_core::team::RobotId;

mod beliefs;
mod bodies;
pub mod brush;
pub mod geometry;
pub mod panel;
mod senses;
mod surroundings;

pub use beliefs::draw_world_of;
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
            .add_plugins(panel::OverlayPanelPlugin)
            .add_systems(Startup, brush::set_lines)
            .add_systems(Update, obey_overlay_commands.after(SelectionSystems))
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
                    .after(StageSystems)
                    // The panels write the words.
                    .before(EguiPostUpdateSet::EndPass),
            );
    }
}

/// The systems that draw the overlays.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct OverlaySystems;

/// What can be drawn of a robot.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Overlay {
    /// The ground that its cameras see.
    FieldsOfView,
    /// The sectors of its sonars, and their echoes.
    Sonar,
    /// What it recognised, where it thinks that it is.
    Percepts,
    /// Where it believes itself, the ball and the opponents, against the truth.
    Beliefs,
    /// Where it means to go, what it does next.
    Targets,
    /// What its behaviour draws.
    Drawings,
    /// Its bodies.
    Bounds,
    /// Where its feet reach the ball.
    KickAreas,
    /// Where it came from.
    Trails,
}

impl Overlay {
    /// All of them.
    pub const ALL: [Overlay; 9] = [
        Overlay::FieldsOfView,
        Overlay::Sonar,
        Overlay::Percepts,
        Overlay::Beliefs,
        Overlay::Targets,
        Overlay::Drawings,
        Overlay::Bounds,
        Overlay::KickAreas,
        Overlay::Trails,
    ];

    /// Its name, for people.
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

    /// What it shows, for people.
    pub fn description(self) -> &'static str {
        match self {
            Overlay::FieldsOfView => "The ground that the upper (yellow) and the lower (orange) camera see",
            Overlay::Sonar => "The sectors of both sonars, and the echoes in them",
            Overlay::Percepts => "What the cameras recognised, where the robot measures it to be",
            Overlay::Beliefs => {
                "Where the robot believes itself, the ball and others, each with its 95 % ellipse and the way to the truth"
            }
            Overlay::Targets => "Where the robot means to go, where this cycle's command leads, where it will look",
            Overlay::Drawings => "The lines, circles and words that its behaviour draws",
            Overlay::Bounds => "The boxes of torso and base that collisions, sonars and cameras know",
            Overlay::KickAreas => "Where the ball must lie for each kick",
            Overlay::Trails => "The way of the last seconds",
        }
    }
}

/// Of whom a kind is drawn.
#[derive(Clone, PartialEq, Eq, Debug, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct Shows {
    /// Of all robots.
    pub all: bool,
    /// Of the selected one, while panels are shown.
    pub selected: bool,
    /// Of the selected one, while the match is shown to others: whoever selects a robot for them has switched it on there.
    pub selected_in_teaching: bool,
    /// Of these robots, whether they are selected or not.
    pub robots: BTreeSet<RobotId>,
}

/// What is drawn, and of whom.
#[derive(Resource, Clone, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(default)]
pub struct Overlays {
    /// What is drawn of robots, and of which.
    pub of_robots: BTreeMap<Overlay, Shows>,
    /// Who touched the ball last.
    pub last_touch: bool,
    /// The areas that the rules speak of.
    pub areas: bool,
}

impl Default for Overlays {
    /// What the selected robot senses, believes and wants.
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
    /// Whether it is drawn of whoever is selected.
    pub fn of_selected(&self, workspace: Workspace) -> bool {
        if workspace == Workspace::Teach { self.selected_in_teaching } else { self.selected }
    }
}

impl Overlays {
    /// Whether a kind is drawn of a robot.
    pub fn shows(&self, overlay: Overlay, robot: RobotId, selection: &Selection, workspace: Workspace) -> bool {
        self.of_robots.get(&overlay).is_some_and(|shows| {
            let is_selected = selection.0 == Some(robot);
            shows.all || (is_selected && shows.of_selected(workspace)) || shows.robots.contains(&robot)
        })
    }

    /// Whether a kind is drawn of anyone.
    pub fn shows_any(&self, overlay: Overlay, selection: &Selection, workspace: Workspace) -> bool {
        self.of_robots.get(&overlay).is_some_and(|shows| {
            shows.all || (selection.0.is_some() && shows.of_selected(workspace)) || !shows.robots.is_empty()
        })
    }
}

/// Changes what is drawn.
#[derive(Message, Clone, Copy, PartialEq, Eq, Debug)]
pub enum OverlayCommand {
    /// A kind, of all robots or not.
    ToggleAll(Overlay),
    /// A kind, of the selected robot or not.
    ToggleSelected(Overlay),
    /// A kind, of this robot or not.
    Toggle(Overlay, RobotId),
    /// Who touched the ball last.
    ToggleLastTouch,
    /// The areas that the rules speak of.
    ToggleAreas,
    /// Nothing at all.
    Clear,
    /// What is drawn at first.
    Reset,
}

fn obey_overlay_commands(
    mut commands: MessageReader<OverlayCommand>,
    mut overlays: ResMut<Overlays>,
    display: Res<DisplaySettings>,
) {
    for command in commands.read() {
        overlays.obey(*command, display.workspace);
    }
}

impl Overlays {
    fn obey(&mut self, command: OverlayCommand, workspace: Workspace) {
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

/// Which robots a kind is drawn of, and where things are shown.
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
    /// Whether a kind is drawn of anyone.
    fn any(&self, overlay: Overlay) -> bool {
        // Who watches wants to see the match; in one robot's world there are no others.
        let shows_truth = self.world.as_ref().is_none_or(|world| !world.0);
        let workspace = self.display.workspace;
        shows_truth && workspace != Workspace::Watch && self.overlays.shows_any(overlay, &self.selection, workspace)
    }

    /// Whether a kind is drawn of a robot; nothing is of those that are off the pitch.
    fn shows(&self, overlay: Overlay, robot: RobotId, penalty: &Penalty) -> bool {
        let shows = || self.overlays.shows(overlay, robot, &self.selection, self.display.workspace);
        self.any(overlay) && !penalty.is_off_pitch() && shows()
    }

    /// Where something is shown, pitch frame.
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
        overlays.obey(OverlayCommand::Toggle(Overlay::Beliefs, other), DEBUG);
        assert!(
            overlays.shows(Overlay::Beliefs, other, &nobody, DEBUG)
                && overlays.shows_any(Overlay::Beliefs, &nobody, DEBUG)
        );
        overlays.obey(OverlayCommand::ToggleAll(Overlay::Trails), DEBUG);
        assert!(
            overlays.shows(Overlay::Trails, one, &nobody, DEBUG)
                && overlays.shows(Overlay::Trails, other, &nobody, DEBUG)
        );
        overlays.obey(OverlayCommand::ToggleAll(Overlay::Trails), DEBUG);
        assert!(!overlays.shows(Overlay::Trails, one, &selected, DEBUG));
        overlays.obey(OverlayCommand::Clear, DEBUG);
        assert!(Overlay::ALL.into_iter().all(|overlay| !overlays.shows(overlay, one, &selected, DEBUG)));
        overlays.obey(OverlayCommand::Reset, DEBUG);
        assert_eq!(overlays, Overlays::default());
    }

    #[test]
    fn who_is_selected_for_others_has_nothing_around_it_until_it_is_asked_for() {
        let one = RobotId::new(Team::Blue, 1);
        let selected = Selection(Some(one));
        let mut overlays = Overlays::default();
        assert!(Overlay::ALL.into_iter().all(|overlay| !overlays.shows_any(overlay, &selected, Workspace::Teach)));
        overlays.obey(OverlayCommand::ToggleSelected(Overlay::Beliefs), Workspace::Teach);
        assert!(overlays.shows(Overlay::Beliefs, one, &selected, Workspace::Teach));
        overlays.obey(OverlayCommand::ToggleSelected(Overlay::Beliefs), DEBUG);
        assert!(!overlays.shows(Overlay::Beliefs, one, &selected, DEBUG));
        assert!(overlays.shows(Overlay::Beliefs, one, &selected, Workspace::Teach));
    }

    #[test]
    fn what_is_shown_can_be_kept_in_a_file() {
        let mut overlays = Overlays::default();
        overlays.obey(OverlayCommand::Toggle(Overlay::Bounds, RobotId::new(Team::Pink, 2)), DEBUG);
        let text = ron::to_string(&overlays).unwrap();
        assert_eq!(ron::from_str::<Overlays>(&text).unwrap(), overlays);
    }
}
