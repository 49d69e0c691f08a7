//! Behaviours: systems that decide for robots, and the information barrier.
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
//! The registration checks which components the system accesses, and refuses access to ground truth: see [`barrier`]. The compiler
//! restricts the system's parameters to a [list](parameters). A behaviour can have [run conditions](Behaviour::run_if) and an
//! [order](Behaviour::after) among the others, [draw](drawings) on the pitch for people, and give [reasons].

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
pub mod remarks;
pub mod script;

use crate::cycle::{Cycle, CycleHalf, CyclePanic, CycleSystems};
use crate::knowledge::Knowledge;
use crate::team::{RobotId, Team};
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
            .register_type::<Policy>()
            .register_type::<reasons::Reasons>()
            .add_plugins(drawings::DrawingsPlugin)
            .configure_sets(
                Cycle,
                (
                    DecideSystems::Believe.in_set(CycleHalf::Perceive),
                    DecideSystems::Script.in_set(CycleHalf::Act),
                    DecideSystems::Ask.in_set(CycleHalf::Act),
                    DecideSystems::Behave.in_set(CycleHalf::Act).run_if(some_may_have_behaviours),
                )
                    .chain()
                    .in_set(CycleSystems::Decide),
            )
            .add_systems(Cycle, script::run_scripts.in_set(DecideSystems::Script));
        let mut registry = app.world_mut().resource_mut::<BehaviourRegistry>();
        registry.add_without_system::<Idle>("idle");
        registry.add_without_system::<Remote>(REMOTE);
    }
}

/// Marks a robot for which no behaviour decides, such as those that learn. If all robots have the mark, no behaviour runs. The mark is not part of a
/// saved match.
#[derive(Component, Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct WithoutBehaviour;

/// Whether there is a robot that may have a behaviour, or none at all.
fn some_may_have_behaviours(
    without: Query<(), With<WithoutBehaviour>>,
    others: Query<(), (With<RobotId>, Without<WithoutBehaviour>)>,
) -> bool {
    without.is_empty() || !others.is_empty()
}

/// The parts of [`CycleSystems::Decide`].
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DecideSystems {
    /// Beliefs are updated from the sensors.
    Believe,
    /// Scripts decide.
    Script,
    /// Programs decide for [`Remote`] robots.
    Ask,
    /// Behaviours decide.
    Behave,
}

/// A function that begins a cycle in which programs play, without waiting for them for more than 20 ms: it runs the first half, asks the
/// programs, and returns the first robot whose program has not answered yet. If it returns `None`, [`run_cycle`](crate::cycle::run_cycle)
/// waits for no program. Windows call it, so that they stay alive while a program thinks.
#[derive(Resource, Clone, Copy, Debug)]
pub struct AskAhead(pub fn(&mut World) -> Result<Option<RobotId>, CyclePanic>);

/// The system set of one registered behaviour, by the number of behaviours registered before it.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct BehaviourSet(usize);

/// Marks a robot that does nothing.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Idle;

/// The name of the behaviour of robots that are [`Remote`].
pub const REMOTE: &str = "remote";

/// Marks a robot that is controlled from outside the app: by a program, or by the code that runs the cycles.
#[derive(Component, Clone, Copy, Default, Debug, Reflect)]
#[reflect(Component, @Knowledge::Belief)]
pub struct Remote;

/// The program that decides for a robot: the words of its command line.
#[derive(Component, Clone, PartialEq, Eq, Debug, Default, Reflect)]
#[require(Remote)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Program(pub Vec<String>);

/// The learned policy that decides for a robot: the path of its file.
#[derive(Component, Clone, PartialEq, Eq, Debug, Default, Reflect)]
#[reflect(Component, @Knowledge::Truth)]
pub struct Policy(pub String);

/// What a policy needs of its robot besides the sensors.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default)]
pub struct PolicyNeeds {
    /// Whether it needs the belief of the built-in estimator.
    pub belief: bool,
}

/// A learned policy cannot play, with the reason.
#[derive(Clone, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct PolicyCannotPlay(pub String);

debug_as_displayed!(PolicyCannotPlay);

/// A function that reads the file of a policy of a team, and returns what the policy needs. The plugin that plays policies sets it.
#[derive(Resource, Clone, Copy, Debug)]
pub struct PolicyReader(pub fn(&World, Team, &str) -> Result<PolicyNeeds, PolicyCannotPlay>);

impl PolicyReader {
    /// Reads the file of a policy of `team`.
    ///
    /// # Errors
    /// [`PolicyCannotPlay`] if the policy cannot play, or this program plays no policies.
    pub fn read(world: &World, team: Team, file: &str) -> Result<PolicyNeeds, PolicyCannotPlay> {
        let no_reader =
            || PolicyCannotPlay("this program plays no learned policies; add the `PolicyPlugin`".to_owned());
        (world.get_resource::<PolicyReader>().ok_or_else(no_reader)?.0)(world, team, file)
    }
}

/// A team that a scenario can line up by name.
#[derive(Clone)]
pub struct TeamRecipe {
    /// The team's description in a sentence.
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
    /// The behaviours in the order in which they decide.
    execution_order: Vec<OrderedBehaviour>,
    teams: BTreeMap<String, TeamRecipe>,
}

/// A behaviour in the execution order.
struct OrderedBehaviour {
    name: String,
    set: BehaviourSet,
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

    /// The team with this name.
    pub fn team(&self, name: &str) -> Option<&TeamRecipe> {
        self.teams.get(name)
    }

    /// The first team whose robots with these numbers have exactly these behaviours.
    pub fn team_of(&self, robots: &[(u8, &str)]) -> Option<&str> {
        let size = u8::try_from(robots.len()).ok().filter(|size| *size > 0)?;
        let plays =
            |team: &TeamRecipe| robots.iter().all(|(number, behaviour)| team.behaviour_of(*number, size) == *behaviour);
        self.teams().find(|(_, team)| plays(team)).map(|(name, _)| name)
    }

    /// The name of the behaviour with this marker.
    pub fn name_of_marker(&self, marker: TypeId) -> Option<&str> {
        self.markers.get(&marker).map(String::as_str)
    }

    /// The function that inserts the marker of the behaviour with this name.
    pub fn marker_of(&self, name: &str) -> Option<fn(&mut EntityWorldMut)> {
        self.behaviours.get(name).copied()
    }

    /// Registers the behaviour `name` of all robots that carry `Marker`, for which a plugin decides.
    pub fn add_without_system<Marker: Component + Default>(&mut self, name: &str) {
        self.markers.insert(TypeId::of::<Marker>(), name.to_owned());
        self.behaviours.insert(name.to_owned(), |robot| {
            robot.insert(Marker::default());
        });
    }

    /// The index in the execution order at which `behaviour` is inserted: the last that its constraints allow.
    fn place_of(&self, behaviour: &Behaviour) -> Result<usize, Breach> {
        let after = behaviour.after.iter().map(|name| self.index_of(name)).collect::<Result<Vec<_>, _>>()?;
        let before = behaviour.before.iter().map(|name| self.index_of(name)).collect::<Result<Vec<_>, _>>()?;
        match (after.into_iter().max(), before.into_iter().min()) {
            (Some((earlier, after)), Some((later, before))) if earlier >= later => {
                Err(Breach::Order { after: after.to_owned(), before: before.to_owned() })
            }
            (_, Some((later, _))) => Ok(later),
            (_, None) => Ok(self.execution_order.len()),
        }
    }

    /// The index of a behaviour in the execution order, with its name.
    fn index_of<'a>(&self, name: &'a str) -> Result<(usize, &'a str), Breach> {
        let place = self.execution_order.iter().position(|behaviour| behaviour.name == name);
        place.map(|place| (place, name)).ok_or_else(|| Breach::NoSuchBehaviour { name: name.to_owned() })
    }
}

/// Registers behaviours and teams.
pub trait BehaviourApp {
    /// Registers a system as the behaviour `name` of all robots that carry `Marker`. A scenario gives a robot the
    /// marker by naming the behaviour.
    ///
    /// Behaviours decide one after the other, in the order of their registration, unless [`behaviour`] gives them another order.
    ///
    /// # Errors
    /// [`BarrierError`] if the system accesses ground truth, its name or marker are in use, or it is ordered before or after a
    /// behaviour that does not exist.
    fn try_add_behaviour<Marker: Component + Default, M>(
        &mut self,
        name: &str,
        system: impl IntoBehaviour<M>,
    ) -> Result<&mut Self, BarrierError>;

    /// Like [`BehaviourApp::try_add_behaviour`], but panics on errors.
    ///
    /// # Panics
    /// If the behaviour is refused.
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

    /// Registers a team that scenarios can line up. `behaviour_of` maps the number of a robot, from 1, and the size of the team to
    /// the name of the robot's behaviour.
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
        if !self.is_plugin_added::<BehaviourPlugin>() {
            return Err(refuse(Breach::NoSimulation));
        }
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
        registry.add_without_system::<Marker>(name);
        // Behaviours write the same components of different robots. The engine cannot know that the robots differ, so behaviours need an
        // order.
        let set = BehaviourSet(registry.execution_order.len());
        registry.execution_order.insert(place, OrderedBehaviour { name: name.to_owned(), set });
        let earlier = place.checked_sub(1).map(|place| registry.execution_order[place].set);
        let later = registry.execution_order.get(place + 1).map(|behaviour| behaviour.set);
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
