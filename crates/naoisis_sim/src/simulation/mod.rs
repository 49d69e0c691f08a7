//! Runs a match in an [`App`]: starts it from a scenario, runs its cycles, and gives access to its state.
//!
//! A headless test of a behaviour is a few lines:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! let mut app = App::new();
//! app.add_plugins((MinimalPlugins, NaoisisPlugins));
//! app.start_match(&Scenario::from_json(
//!     r#"{ "rules": "free", "ball": { "position_m": [0.15, -0.05] },
//!          "robots": [{ "number": 1, "behaviour": { "script": [{ "kick": { "type": "right_straight" } }] } }] }"#,
//! )?)?;
//! app.run_cycles(30);
//! assert!(app.ball().unwrap().position.x > 1.0);
//! # Ok::<(), Box<dyn core::error::Error>>(())
//! ```

use bevy::app::PluginGroupBuilder;
use bevy::ecs::schedule::ScheduleLabel;
use bevy::prelude::*;

mod cycle_runner;
pub mod invariants;
mod match_commands;
pub mod names;
mod parallel;
pub mod rules;
pub mod sensors;
mod settings;
mod situation;
pub mod snapshot;
mod spawn;
mod start;
pub mod triggers;

pub use cycle_runner::{CycleRunnerPlugin, RunCycle};
pub use match_commands::{MatchCommands, end_match, is_over};
pub use parallel::play_in_order;
pub use rules::{RuleApp, RuleRegistry};
pub use sensors::{SensorApp, SensorRegistry};
pub use settings::{change_settings, changeable, is_changeable};
pub use situation::situation;
pub use snapshot::{Snapshot, SnapshotError};
pub use spawn::{MatchEntity, give_belief, resolved};
pub use start::start as start_match;
pub use triggers::{Fell, GoalScored, Kicked, MatchEnd, MatchEnded, MatchNotStarted, MatchStarted, Penalised};

use crate::scenario::{Scenario, ScenarioFault};
use crate::teams::BuiltInTeamsPlugin;
use naoisis_core::ball::{BallPlugin, BallVelocity};
use naoisis_core::behaviour::BehaviourPlugin;
use naoisis_core::collision::CollisionPlugin;
use naoisis_core::communication::CommunicationPlugin;
use naoisis_core::cycle::{CycleClock, CyclePlugin, run_cycle};
use naoisis_core::events::{CycleEvents, EventsPlugin, MatchEvent};
use naoisis_core::game::{Game, GameState};
use naoisis_core::geometry::Pose;
use naoisis_core::pitch::PitchPlugin;
use naoisis_core::random::{BehaviourRandom, RandomStreams};
use naoisis_core::referee::RefereePlugin;
use naoisis_core::robot::{RobotPlugin, Roster};
use naoisis_core::team::RobotId;
use naoisis_sensing::belief::SimpleBeliefPlugin;
use naoisis_sensing::sensing::SensingPlugin;
use naoisis_sensing::sensing::buttons::{self, ButtonReadings, Buttons};
use naoisis_sensing::sensing::imu::{self, Imu, ImuReading};

/// All plugins of a headless match, without a window, a renderer or assets.
///
/// The owner of the app runs the cycles with [`MatchApp::run_cycles`] or [`run_cycle`]. In an app that runs by itself, for example with
/// `DefaultPlugins`, a schedule of the app runs them: see [`NaoisisPlugins::in_schedule`].
///
/// # Members
///
/// | plugin | what it adds | without it |
/// |---|---|---|
/// | [`CyclePlugin`] | the [`Cycle`](naoisis_core::cycle::Cycle) schedule, its sets and its clock | no match can be started |
/// | [`EventsPlugin`] | [events of a cycle](naoisis_core::events), as a resource and as messages | no match can be started |
/// | [`MatchPlugin`] | custom [sensors] of the program, [events](triggers) for observers | no match can be started |
/// | [`CustomRulesPlugin`](rules::CustomRulesPlugin) | custom [rules] of the program | no match can be started |
/// | [`PitchPlugin`] | the pitch, before there is a match | each match still brings its pitch |
/// | [`RobotPlugin`] | robots that walk, turn their heads, kick and fall | no match can be started |
/// | [`BallPlugin`] | a ball that rolls | the ball rests where it is, unless a robot or post pushes it |
/// | [`CollisionPlugin`] | collisions; robots and ball move to where a cycle takes them | no match can be started |
/// | [`SensingPlugin`] | cameras, vision, sonars, odometry | robots sense nothing; no built-in belief, no built-in teams |
/// | [`CommunicationPlugin`] | messages between robots | robots receive no messages |
/// | [`BehaviourPlugin`] | behaviours, scripts, teams | no match can be started |
/// | [`RefereePlugin`] | the referee, and the status of the game for robots | no match can be started |
/// | [`InvariantPlugin`](invariants::InvariantPlugin) | checks of invariants | invariants are not checked |
/// | [`SimpleBeliefPlugin`] | the built-in [belief](naoisis_sensing::belief) | robots have none, and there are no built-in teams |
/// | [`BuiltInTeamsPlugin`] | the built-in [teams](crate::teams) | scenarios cannot name them |
///
/// Each plugin can be disabled: `NaoisisPlugins.build().disable::<SimpleBeliefPlugin>()`. If no match can be started, [`start_match`]
/// returns which plugin is missing. For a match without a referee, use the rules `free` instead.
pub struct NaoisisPlugins;

impl NaoisisPlugins {
    /// Returns the plugins, with a [`CycleRunnerPlugin`] that runs a cycle each time `schedule` runs, as long as there is a match that is
    /// not over. In `FixedUpdate` the timestep is that of the scenario.
    ///
    /// ```
    /// use bevy::prelude::*;
    /// use bevy::time::TimeUpdateStrategy;
    /// use naoisis::prelude::*;
    ///
    /// fn begin(mut commands: Commands) {
    ///     commands.start_match(Scenario { duration_s: Some(1.0), ..default() });
    /// }
    ///
    /// let mut app = App::new();
    /// app.add_plugins((MinimalPlugins, NaoisisPlugins::in_schedule(FixedUpdate))).add_systems(Startup, begin);
    /// // The clock of this test: each frame is as long as a cycle.
    /// app.insert_resource(TimeUpdateStrategy::FixedTimesteps(1));
    /// for _frame in 0..100 {
    ///     app.update();
    /// }
    /// assert_eq!(app.cycle(), 30);
    /// ```
    pub fn in_schedule(schedule: impl ScheduleLabel) -> PluginGroupBuilder {
        NaoisisPlugins.build().add(CycleRunnerPlugin::new(schedule))
    }
}

impl PluginGroup for NaoisisPlugins {
    fn build(self) -> PluginGroupBuilder {
        PluginGroupBuilder::start::<Self>()
            .add(CyclePlugin::default())
            .add(EventsPlugin)
            .add(MatchPlugin)
            .add(rules::CustomRulesPlugin)
            .add(PitchPlugin)
            .add(RobotPlugin)
            .add(BallPlugin)
            .add(CollisionPlugin)
            .add(SensingPlugin)
            .add(CommunicationPlugin)
            .add(BehaviourPlugin)
            .add(RefereePlugin)
            .add(invariants::InvariantPlugin)
            .add(SimpleBeliefPlugin)
            .add(BuiltInTeamsPlugin)
    }
}

/// Adds the scenario, the random numbers, the registry of sensors, and the [events](triggers) for observers.
pub struct MatchPlugin;

impl Plugin for MatchPlugin {
    fn build(&self, app: &mut App) {
        app.register_type::<MatchEntity>()
            .register_type::<Scenario>()
            .register_type::<RandomStreams>()
            .register_type::<BehaviourRandom>()
            .register_type::<sensors::SensorRecord>()
            .register_type::<imu::ImuMemory>()
            .register_type::<buttons::ButtonReading>()
            .init_resource::<SensorRegistry>();
        // A name that is free cannot be refused.
        let _ = sensors::add_optional_sensor::<Imu, ImuReading, _>(app, "imu", imu::measure);
        let _ = sensors::add_optional_sensor::<Buttons, ButtonReadings, _>(app, "buttons", buttons::feel);
        triggers::add_triggers(app);
    }
}

/// Starts and runs a match in an [`App`] with the [`NaoisisPlugins`], and gives access to its state.
pub trait MatchApp {
    /// Starts the scenario's match in the app, and removes an earlier one.
    ///
    /// # Errors
    /// [`ScenarioFault`] if the scenario contradicts itself or names a behaviour or team that is not registered, or if a plugin of the
    /// [`NaoisisPlugins`] is missing. The app is unchanged then.
    fn start_match(&mut self, scenario: &Scenario) -> Result<&mut Self, ScenarioFault>;

    /// Removes the match from the app, like [`end_match`].
    fn end_match(&mut self) -> &mut Self;

    /// Runs this many cycles.
    fn run_cycles(&mut self, count: usize) -> &mut Self;

    /// Runs at most `most` cycles, until `condition` holds after a cycle. Returns whether it held.
    fn run_until(&mut self, most: usize, condition: impl FnMut(&App) -> bool) -> bool;

    /// Returns the number of cycles run.
    fn cycle(&self) -> u64;

    /// Returns the true pose of a robot.
    fn robot_pose(&self, id: RobotId) -> Option<Pose>;

    /// Returns a component of a robot.
    fn robot<C: Component>(&self, id: RobotId) -> Option<&C>;

    /// Returns the true position of the ball, as a pose.
    fn ball(&self) -> Option<Pose>;

    /// Returns the true velocity of the ball, m/s.
    fn ball_velocity(&self) -> Option<Vec2>;

    /// Returns the state of the game.
    fn game(&self) -> &Game;

    /// Returns the events of the last cycle.
    fn events(&self) -> &[MatchEvent];

    /// Returns whether the final whistle has been blown.
    fn is_finished(&self) -> bool {
        self.game().state == GameState::Finished
    }
}

impl MatchApp for App {
    fn start_match(&mut self, scenario: &Scenario) -> Result<&mut Self, ScenarioFault> {
        start_match(self.world_mut(), scenario)?;
        Ok(self)
    }

    fn end_match(&mut self) -> &mut Self {
        end_match(self.world_mut());
        self
    }

    fn run_cycles(&mut self, count: usize) -> &mut Self {
        for _ in 0..count {
            run_cycle(self.world_mut());
        }
        self
    }

    fn run_until(&mut self, most: usize, mut condition: impl FnMut(&App) -> bool) -> bool {
        (0..most).any(|_| {
            run_cycle(self.world_mut());
            condition(self)
        })
    }

    fn cycle(&self) -> u64 {
        self.world().resource::<CycleClock>().cycle
    }

    fn robot_pose(&self, id: RobotId) -> Option<Pose> {
        self.robot::<Pose>(id).copied()
    }

    fn robot<C: Component>(&self, id: RobotId) -> Option<&C> {
        let entity = self.world().resource::<Roster>().get(id)?;
        self.world().get::<C>(entity)
    }

    fn ball(&self) -> Option<Pose> {
        spawn::ball_component::<Pose>(self.world())
    }

    fn ball_velocity(&self) -> Option<Vec2> {
        spawn::ball_component::<BallVelocity>(self.world()).map(|velocity| velocity.0)
    }

    fn game(&self) -> &Game {
        self.world().resource::<Game>()
    }

    fn events(&self) -> &[MatchEvent] {
        self.world().resource::<CycleEvents>()
    }
}
