//! A behaviour for registration: a system with safe parameters, its order among the others, and its run conditions.

use bevy::ecs::schedule::{BoxedCondition, IntoScheduleConfigs, ScheduleConfigs};
use bevy::ecs::system::{BoxedSystem, IntoResult, ReadOnlySystemParam, ScheduleSystem, SystemParamFunction};
use bevy::prelude::*;

use super::parameters::BehaviourParam;

/// Conversion into a behaviour: implemented for functions and closures whose parameters are all [known to be safe](super::parameters), and
/// for [`Behaviour`]s made of them.
#[diagnostic::on_unimplemented(
    message = "`{Self}` is no behaviour",
    label = "no behaviour",
    note = "a behaviour is a plain function or closure over queries, resources and `Local`s; not a piped or exclusive system",
    note = "for an order or a condition: `behaviour(system).after(\"another\").run_if(condition)`"
)]
pub trait IntoBehaviour<M> {
    /// Converts into a behaviour.
    fn into_behaviour(self) -> Behaviour;
}

/// Distinguishes functions from [`Behaviour`]s.
#[doc(hidden)]
pub struct IsFunction;

impl<M: 'static, F> IntoBehaviour<(IsFunction, M)> for F
where
    F: SystemParamFunction<M, In = (), Out: IntoResult<()>, Param: BehaviourParam>,
{
    fn into_behaviour(self) -> Behaviour {
        Behaviour {
            system: Box::new(IntoSystem::into_system(self)),
            conditions: Vec::new(),
            before: Vec::new(),
            after: Vec::new(),
        }
    }
}

impl IntoBehaviour<Behaviour> for Behaviour {
    fn into_behaviour(self) -> Behaviour {
        self
    }
}

/// Makes a behaviour of a system with safe parameters, to which an order and conditions can be added:
///
/// ```
/// use bevy::prelude::*;
/// use naoisis::prelude::*;
///
/// #[derive(Resource, Default)]
/// struct Tactics {
///     attack: bool,
/// }
///
/// #[derive(Component, Default)]
/// struct Captain;
///
/// #[derive(Component, Default)]
/// struct Rusher;
///
/// fn call(mut tactics: ResMut<Tactics>, captains: Query<&Percepts, With<Captain>>) {
///     tactics.attack = captains.iter().any(|percepts| percepts.ball.is_some());
/// }
///
/// fn rush(mut robots: Query<&mut WalkCommand, With<Rusher>>) {
///     for mut walk in &mut robots {
///         *walk = WalkCommand::new(0.01, 0.0, 0.0);
///     }
/// }
///
/// let mut app = App::new();
/// app.add_plugins(NaoisisPlugins).init_resource::<Tactics>();
/// app.add_behaviour::<Rusher, _>("rusher", behaviour(rush).run_if(|tactics: Res<Tactics>| tactics.attack));
/// // So that the call has its effect in the same cycle.
/// app.add_behaviour::<Captain, _>("captain", behaviour(call).before("rusher"));
/// ```
pub fn behaviour<M>(system: impl IntoBehaviour<M>) -> Behaviour {
    system.into_behaviour()
}

/// A behaviour with its order and run conditions, made by [`behaviour`].
#[must_use = "a behaviour does nothing until it is added to an app"]
pub struct Behaviour {
    pub(super) system: BoxedSystem,
    pub(super) conditions: Vec<BoxedCondition>,
    pub(super) before: Vec<String>,
    pub(super) after: Vec<String>,
}

impl Behaviour {
    /// Runs the behaviour only in cycles in which all its conditions hold. In other cycles persistent commands of its robots stay,
    /// and the others are empty.
    ///
    /// A condition is a read-only system that returns a `bool`, as in Bevy, under the same barrier as the behaviour itself.
    pub fn run_if<M: 'static, C>(mut self, condition: C) -> Self
    where
        C: SystemParamFunction<M, In = (), Out: IntoResult<bool>, Param: BehaviourParam + ReadOnlySystemParam>,
    {
        self.conditions.push(Box::new(IntoSystem::into_system(condition)));
        self
    }

    /// Orders this behaviour before the registered behaviour `name`.
    pub fn before(mut self, name: impl Into<String>) -> Self {
        self.before.push(name.into());
        self
    }

    /// Orders this behaviour after the registered behaviour `name`. By default a behaviour decides after all that were registered
    /// earlier.
    pub fn after(mut self, name: impl Into<String>) -> Self {
        self.after.push(name.into());
        self
    }

    /// The name of its system.
    pub(super) fn name(&self) -> String {
        self.system.name().to_string()
    }

    /// The system with its conditions, for a schedule.
    pub fn into_configs(self) -> ScheduleConfigs<ScheduleSystem> {
        let mut configs = IntoScheduleConfigs::into_configs(self.system);
        for condition in self.conditions {
            configs.run_if_dyn(condition);
        }
        configs
    }
}
