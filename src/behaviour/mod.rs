//! Behaviours: systems that decide for robots, and the barrier that keeps them honest.
//!
//! A behaviour is a Bevy system that is tied to its robots by a marker component and registered under a name. It
//! reads sensors and beliefs, writes beliefs and commands, and may keep components and resources of its own:
//!
//! ```
//! use bevy::prelude::*;
//! use naoisis::prelude::*;
//!
//! #[derive(Component, Default)]
//! struct BallWatcher;
//!
//! fn watch_ball(mut robots: Query<(&Percepts, &HeadAngles, &mut HeadCommand), With<BallWatcher>>) {
//!     for (percepts, head, mut command) in &mut robots {
//!         if let Some(ball) = percepts.ball {
//!             command.yaw = ball.position_m.to_angle();
//!         } else {
//!             command.yaw = head.yaw + 0.1;
//!         }
//!     }
//! }
//!
//! let mut app = App::new();
//! app.add_plugins(NaoisisPlugins);
//! app.add_behaviour::<BallWatcher, _>("ball watcher", watch_ball);
//! ```
//!
//! The registration reads which components the system accesses, and refuses one that reaches for ground truth: see
//! [`barrier`]. What it thinks of it can [draw](drawings) for people.

use bevy::prelude::*;
use core::any::TypeId;
use std::collections::BTreeMap;

pub mod barrier;
pub mod drawings;
pub mod script;

use crate::cycle::{Cycle, CycleSystems};
use crate::knowledge::Knowledge;
use barrier::{BarrierError, Breach};

/// The registry of behaviours and teams, and scripts.
pub struct BehaviourPlugin;

impl Plugin for BehaviourPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<BehaviourRegistry>()
            .register_type::<script::Script>()
            .register_type::<Idle>()
            .add_plugins(drawings::DrawingsPlugin)
            .configure_sets(Cycle, (DecideSystems::Believe, DecideSystems::Behave).chain().in_set(CycleSystems::Decide))
            .add_systems(Cycle, script::run_scripts.in_set(CycleSystems::Decide).before(DecideSystems::Believe));
        app.world_mut().resource_mut::<BehaviourRegistry>().behaviours.insert("idle".to_owned(), |robot| {
            robot.insert(Idle);
        });
    }
}

/// The parts of [`CycleSystems::Decide`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DecideSystems {
    /// Beliefs are updated from the sensors.
    Believe,
    /// Behaviours decide.
    Behave,
}

/// The place of one registered behaviour among the others.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct BehaviourTurn(usize);

/// Marks a robot that does nothing.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Idle;

/// A team that a scenario can line up by name.
#[derive(Clone, Debug)]
pub struct TeamRecipe {
    /// What is special about it, in a sentence.
    pub description: String,
    /// The name of the behaviour of the robot with this number (from 1) in a team of this size.
    pub behaviour_of: fn(number: u8, team_size: u8) -> &'static str,
}

/// Behaviours and teams by name.
#[derive(Resource, Default)]
pub struct BehaviourRegistry {
    behaviours: BTreeMap<String, fn(&mut EntityWorldMut)>,
    markers: BTreeMap<TypeId, String>,
    teams: BTreeMap<String, TeamRecipe>,
}

impl BehaviourRegistry {
    /// The names of all behaviours, sorted.
    pub fn behaviour_names(&self) -> impl Iterator<Item = &str> {
        self.behaviours.keys().map(String::as_str)
    }

    /// All teams by name, sorted.
    pub fn teams(&self) -> impl Iterator<Item = (&str, &TeamRecipe)> {
        self.teams.iter().map(|(name, team)| (name.as_str(), team))
    }

    /// The team of this name.
    pub fn team(&self, name: &str) -> Option<&TeamRecipe> {
        self.teams.get(name)
    }

    /// The team whose robots of these numbers have these behaviours, and no others do; the first of several.
    pub fn team_of(&self, robots: &[(u8, &str)]) -> Option<&str> {
        let size = u8::try_from(robots.len()).ok().filter(|size| *size > 0)?;
        let plays = |team: &TeamRecipe| {
            robots.iter().all(|(number, behaviour)| (team.behaviour_of)(*number, size) == *behaviour)
        };
        self.teams().find(|(_, team)| plays(team)).map(|(name, _)| name)
    }

    /// The behaviour whose robots carry this marker.
    pub(crate) fn name_of_marker(&self, marker: TypeId) -> Option<&str> {
        self.markers.get(&marker).map(String::as_str)
    }

    /// What ties a robot to the behaviour of this name.
    pub(crate) fn marker_of(&self, name: &str) -> Option<fn(&mut EntityWorldMut)> {
        self.behaviours.get(name).copied()
    }
}

/// Registers behaviours and teams.
pub trait BehaviourApp {
    /// Registers `system` as the behaviour `name` of all robots that carry `Marker`. A scenario gives a robot the
    /// marker by naming the behaviour.
    ///
    /// # Errors
    /// [`BarrierError`] when the system accesses what a robot cannot know, or its name or marker are another's.
    fn try_add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoSystem<(), (), M>,
    ) -> Result<&mut Self, BarrierError>;

    /// As [`BehaviourApp::try_add_behaviour`], for a behaviour that is known to be honest.
    ///
    /// # Panics
    /// When it is not.
    fn add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoSystem<(), (), M>,
    ) -> &mut Self {
        match self.try_add_behaviour::<Marker, M>(name, system) {
            Ok(app) => app,
            Err(error) => panic!("{error}"),
        }
    }

    /// Registers a team that scenarios can line up.
    fn add_team(
        &mut self,
        name: &str,
        description: &str,
        behaviour_of: fn(number: u8, team_size: u8) -> &'static str,
    ) -> &mut Self;
}

impl BehaviourApp for App {
    fn try_add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoSystem<(), (), M>,
    ) -> Result<&mut Self, BarrierError> {
        let mut system = IntoSystem::into_system(system);
        let refuse = |system: &dyn System<In = (), Out = ()>, reason| BarrierError {
            behaviour: name.to_owned(),
            system: system.name().to_string(),
            reason,
        };
        if let Err(reason) = barrier::inspect_marker::<Marker>(self.world_mut()) {
            return Err(refuse(&system, reason));
        }
        barrier::inspect::<Marker>(name, &mut system, self.world_mut())?;
        let mut registry = self.world_mut().get_resource_or_init::<BehaviourRegistry>();
        if registry.behaviours.contains_key(name) {
            return Err(refuse(&system, Breach::NameTaken));
        }
        if let Some(owner) = registry.markers.insert(TypeId::of::<Marker>(), name.to_owned())
            && owner != name
        {
            registry.markers.insert(TypeId::of::<Marker>(), owner);
            let component = core::any::type_name::<Marker>().to_owned();
            return Err(refuse(&system, Breach::NoMarker { component }));
        }
        registry.behaviours.insert(name.to_owned(), |robot| {
            robot.insert(Marker::default());
        });
        // Behaviours write the same components of different robots. The engine cannot know that, so that they run
        // in the order of their registration.
        let turn = registry.behaviours.len();
        self.add_systems(Cycle, system.in_set(BehaviourTurn(turn)).in_set(DecideSystems::Behave));
        for earlier in 0..turn {
            self.configure_sets(Cycle, BehaviourTurn(turn).after(BehaviourTurn(earlier)));
        }
        Ok(self)
    }

    fn add_team(
        &mut self,
        name: &str,
        description: &str,
        behaviour_of: fn(number: u8, team_size: u8) -> &'static str,
    ) -> &mut Self {
        self.world_mut()
            .get_resource_or_init::<BehaviourRegistry>()
            .teams
            .insert(name.to_owned(), TeamRecipe { description: description.to_owned(), behaviour_of });
        self
    }
}
