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
//! [`barrier`]. What parameters the system may have is a [list](parameters), which the compiler holds. It can run under
//! [conditions](Behaviour::run_if), and have its [turn](Behaviour::after) among the others. What it thinks of it can
//! [draw](drawings) for people, and [say why](reasons).

use bevy::prelude::*;
use core::any::TypeId;
use core::fmt;
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

pub mod barrier;
pub mod drawings;
mod function;
pub mod parameters;
pub mod reasons;
pub mod script;

use crate::cycle::{Cycle, CycleHalf, CycleSystems};
use crate::knowledge::Knowledge;
use barrier::{BarrierError, Breach};
pub use function::{Behaviour, IntoBehaviour, behaviour};
pub use parameters::BehaviourParam;

/// The registry of behaviours and teams, and scripts.
pub struct BehaviourPlugin;

impl Plugin for BehaviourPlugin {
    fn build(&self, app: &mut App) {
        app.init_resource::<BehaviourRegistry>()
            .register_type::<script::Script>()
            .register_type::<Idle>()
            .register_type::<Remote>()
            .register_type::<Program>()
            .register_type::<reasons::Reasons>()
            .add_plugins(drawings::DrawingsPlugin)
            .configure_sets(
                Cycle,
                (
                    DecideSystems::Believe.in_set(CycleHalf::Perceive),
                    DecideSystems::Script.in_set(CycleHalf::Act),
                    DecideSystems::Ask.in_set(CycleHalf::Act),
                    DecideSystems::Behave.in_set(CycleHalf::Act),
                )
                    .chain()
                    .in_set(CycleSystems::Decide),
            )
            .add_systems(Cycle, script::run_scripts.in_set(DecideSystems::Script));
        let mut registry = app.world_mut().resource_mut::<BehaviourRegistry>();
        registry.markers.insert(TypeId::of::<Idle>(), "idle".to_owned());
        registry.markers.insert(TypeId::of::<Remote>(), REMOTE.to_owned());
        registry.behaviours.insert("idle".to_owned(), |robot| {
            robot.insert(Idle);
        });
        registry.behaviours.insert(REMOTE.to_owned(), |robot| {
            robot.insert(Remote);
        });
    }
}

/// The parts of [`CycleSystems::Decide`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DecideSystems {
    /// Beliefs are updated from the sensors.
    Believe,
    /// Scripts decide.
    Script,
    /// Programs decide, for robots that are [`Remote`].
    Ask,
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

/// The name of the behaviour of robots that are [`Remote`].
pub const REMOTE: &str = "remote";

/// Marks a robot for which somebody outside the app decides: a program, or whoever runs the cycles.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Remote;

/// The program that decides for a robot: the words of its command line.
#[derive(Component, Clone, PartialEq, Eq, Debug, Default, Reflect)]
#[require(Remote)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Program(pub Vec<String>);

/// A team that a scenario can line up by name.
#[derive(Clone)]
pub struct TeamRecipe {
    /// What is special about it, in a sentence.
    pub description: String,
    behaviour_of: Arc<dyn Fn(u8, u8) -> Cow<'static, str> + Send + Sync>,
}

impl TeamRecipe {
    /// The name of the behaviour of the robot with this number (from 1) in a team of this size.
    pub fn behaviour_of(&self, number: u8, team_size: u8) -> Cow<'static, str> {
        (self.behaviour_of)(number, team_size)
    }
}

impl fmt::Debug for TeamRecipe {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("TeamRecipe").field("description", &self.description).finish_non_exhaustive()
    }
}

/// Behaviours and teams by name.
#[derive(Resource, Default)]
pub struct BehaviourRegistry {
    behaviours: BTreeMap<String, fn(&mut EntityWorldMut)>,
    markers: BTreeMap<TypeId, String>,
    /// Those that decide, in this order.
    turns: Vec<Turn>,
    teams: BTreeMap<String, TeamRecipe>,
}

/// When a behaviour decides among the others.
struct Turn {
    name: String,
    set: BehaviourTurn,
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
        let plays =
            |team: &TeamRecipe| robots.iter().all(|(number, behaviour)| team.behaviour_of(*number, size) == *behaviour);
        self.teams().find(|(_, team)| plays(team)).map(|(name, _)| name)
    }

    /// The behaviour whose robots carry this marker.
    pub fn name_of_marker(&self, marker: TypeId) -> Option<&str> {
        self.markers.get(&marker).map(String::as_str)
    }

    /// What ties a robot to the behaviour of this name.
    pub fn marker_of(&self, name: &str) -> Option<fn(&mut EntityWorldMut)> {
        self.behaviours.get(name).copied()
    }

    /// The place in the order for a behaviour that decides before and after these others: as late as may be.
    fn place_of(&self, behaviour: &Behaviour) -> Result<usize, Breach> {
        let after = behaviour.after.iter().map(|name| self.turn_of(name)).collect::<Result<Vec<_>, _>>()?;
        let before = behaviour.before.iter().map(|name| self.turn_of(name)).collect::<Result<Vec<_>, _>>()?;
        match (after.into_iter().max(), before.into_iter().min()) {
            (Some((earlier, after)), Some((later, before))) if earlier >= later => {
                Err(Breach::Order { after: after.to_owned(), before: before.to_owned() })
            }
            (_, Some((later, _))) => Ok(later),
            (_, None) => Ok(self.turns.len()),
        }
    }

    /// The place of a behaviour in the order.
    fn turn_of<'a>(&self, name: &'a str) -> Result<(usize, &'a str), Breach> {
        let place = self.turns.iter().position(|turn| turn.name == name);
        place.map(|place| (place, name)).ok_or_else(|| Breach::NoSuchBehaviour { name: name.to_owned() })
    }
}

/// Registers behaviours and teams.
pub trait BehaviourApp {
    /// Registers a system as the behaviour `name` of all robots that carry `Marker`. A scenario gives a robot the
    /// marker by naming the behaviour.
    ///
    /// Behaviours decide one after the other, in the order of their registration, unless [`behaviour`] gives them
    /// another turn.
    ///
    /// # Errors
    /// [`BarrierError`] when the system accesses what a robot cannot know, its name or marker are another's, or its turn
    /// is before or after a behaviour that there is not.
    fn try_add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoBehaviour<M>,
    ) -> Result<&mut Self, BarrierError>;

    /// As [`BehaviourApp::try_add_behaviour`], for a behaviour that is known to be honest.
    ///
    /// # Panics
    /// When it is not.
    fn add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoBehaviour<M>,
    ) -> &mut Self {
        match self.try_add_behaviour::<Marker, M>(name, system) {
            Ok(app) => app,
            Err(error) => panic!("{error}"),
        }
    }

    /// Registers a team that scenarios can line up. `behaviour_of` names the behaviour of the robot with a number (from
    /// 1) in a team of a size.
    fn add_team<Name: Into<Cow<'static, str>>>(
        &mut self,
        name: &str,
        description: &str,
        behaviour_of: impl Fn(u8, u8) -> Name + Send + Sync + 'static,
    ) -> &mut Self;
}

impl BehaviourApp for App {
    fn try_add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoBehaviour<M>,
    ) -> Result<&mut Self, BarrierError> {
        let mut behaviour = system.into_behaviour();
        let system = behaviour.name();
        let refuse = |reason| BarrierError { behaviour: name.to_owned(), system: system.clone(), reason };
        barrier::inspect_marker::<Marker>(self.world_mut()).map_err(refuse)?;
        barrier::inspect::<Marker>(name, &mut behaviour, self.world_mut())?;
        let mut registry = self.world_mut().get_resource_or_init::<BehaviourRegistry>();
        if registry.behaviours.contains_key(name) {
            return Err(refuse(Breach::NameTaken));
        }
        if registry.markers.contains_key(&TypeId::of::<Marker>()) {
            let component = core::any::type_name::<Marker>().to_owned();
            return Err(refuse(Breach::NoMarker { component }));
        }
        let place = registry.place_of(&behaviour).map_err(refuse)?;
        registry.markers.insert(TypeId::of::<Marker>(), name.to_owned());
        registry.behaviours.insert(name.to_owned(), |robot| {
            robot.insert(Marker::default());
        });
        // Behaviours write the same components of different robots. The engine cannot know that, so that each has its
        // turn.
        let set = BehaviourTurn(registry.turns.len());
        registry.turns.insert(place, Turn { name: name.to_owned(), set });
        let earlier = place.checked_sub(1).map(|place| registry.turns[place].set);
        let later = registry.turns.get(place + 1).map(|turn| turn.set);
        self.add_systems(Cycle, behaviour.into_configs().in_set(set))
            .configure_sets(Cycle, set.in_set(DecideSystems::Behave));
        if let Some(earlier) = earlier {
            self.configure_sets(Cycle, set.after(earlier));
        }
        if let Some(later) = later {
            self.configure_sets(Cycle, set.before(later));
        }
        Ok(self)
    }

    fn add_team<Name: Into<Cow<'static, str>>>(
        &mut self,
        name: &str,
        description: &str,
        behaviour_of: impl Fn(u8, u8) -> Name + Send + Sync + 'static,
    ) -> &mut Self {
        let recipe = TeamRecipe {
            description: description.to_owned(),
            behaviour_of: Arc::new(move |number, team_size| behaviour_of(number, team_size).into()),
        };
        self.world_mut().get_resource_or_init::<BehaviourRegistry>().teams.insert(name.to_owned(), recipe);
        self
    }
}
