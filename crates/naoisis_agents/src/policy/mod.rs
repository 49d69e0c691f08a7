//! Learned policies as players: neural networks in ONNX, which read an observation of a learning environment and answer with an action.
//!
//! `"behaviour": { "policy": "score.onnx" }` plays one robot, the team `policy:score.onnx` all robots of a team. `score.json` beside the
//! network is its [layout](PolicyLayout). A policy reads the same [observation](crate::environment::observation), in the same cycles, as in
//! the learning environment, and its [action](crate::environment::action) is held for as many cycles.
//!
//! The [network] is computed with sums in a fixed order and with own functions in place of the platform's, so that a match is the same on
//! every machine. The state of recurrent networks is a component, so that matches are saved with it.

mod built_in;
mod choice;
mod layout;
pub mod network;

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

pub use layout::{Choice, LoadedPolicy, PolicyError, PolicyLayout, StatePorts};

use crate::agents::{AgentSettings, RobotCommand, give_command};
use crate::environment::action::command;
use crate::environment::attempts::ChallengePlayer;
use crate::environment::episode::said;
use crate::environment::kind::ObservationKind;
use crate::environment::memory::Memory;
use crate::environment::observation::observed;
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::behaviour::{DecideSystems, Policy, PolicyCannotPlay, PolicyNeeds, PolicyReader};
use naoisis_core::cycle::Cycle;
use naoisis_core::events::{AgentLoss, CycleEvents, MatchEvent};
use naoisis_core::geometry::Pose;
use naoisis_core::knowledge::Knowledge;
use naoisis_core::random::BehaviourRandom;
use naoisis_core::robot::motion::WalkCommand;
use naoisis_core::team::{RobotId, Team};
use naoisis_sensing::sensing::odometry::Odometry;

/// Lets learned policies play.
pub struct PolicyPlugin;

impl Plugin for PolicyPlugin {
    fn build(&self, app: &mut App) {
        let somebody_plays = |players: Query<(), With<Policy>>| !players.is_empty();
        app.register_type::<PolicyState>()
            .init_resource::<LoadedPolicies>()
            .insert_resource(PolicyReader(read))
            .add_systems(Cycle, decide.run_if(somebody_plays).in_set(DecideSystems::Ask).ambiguous_with_all());
        built_in::add(app);
    }
}

/// The policies of files that have been read, by their paths.
#[derive(Resource, Default)]
struct LoadedPolicies(Mutex<BTreeMap<PathBuf, Arc<LoadedPolicy>>>);

impl LoadedPolicies {
    fn of(&self, path: &Path) -> Option<Arc<LoadedPolicy>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get(path).cloned()
    }

    fn insert(&self, path: PathBuf, policy: LoadedPolicy) -> Arc<LoadedPolicy> {
        let policy = Arc::new(policy);
        self.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path, policy.clone());
        policy
    }
}

/// What the policy of a robot keeps from cycle to cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Belief)]
pub struct PolicyState {
    /// The numbers of its last observation, by name.
    inputs: BTreeMap<String, f32>,
    /// What it needs to know of earlier cycles.
    memory: Memory,
    /// Whether it keeps messages.
    #[reflect(default)]
    listens: bool,
    /// Cycles for which the last action is still held.
    cycles_left: u32,
    /// The walk of the last action.
    walk: Option<WalkCommand>,
    /// The recurrent state: the numbers of each state input.
    recurrent: Vec<Vec<f32>>,
    /// Whether the policy has failed. Its robot stands.
    has_failed: bool,
}

/// Reads the policy of a team again, before a match begins.
fn read(world: &World, team: Team, file: &str) -> Result<PolicyNeeds, PolicyCannotPlay> {
    let policy = match built_in::named(file) {
        Some(policy) => policy.map_err(PolicyCannotPlay)?,
        None => {
            let path = path_of(world, team, file);
            let policy = LoadedPolicy::read(&path).map_err(|error| PolicyCannotPlay(error.to_string()))?;
            world.resource::<LoadedPolicies>().insert(path, policy)
        }
    };
    Ok(PolicyNeeds { belief: policy.layout.observation == ObservationKind::Belief })
}

/// Returns the number of interactions that a player was trained with; `None` if it was not trained, or its layout does not tell it.
pub fn interactions(player: &ChallengePlayer) -> Option<u64> {
    let built_in = |name: &str| built_in::named(name).and_then(Result::ok);
    let policy = match player {
        ChallengePlayer::Behaviour(name) | ChallengePlayer::Team(name) => built_in(name),
        ChallengePlayer::Policy(file) => {
            built_in(file).or_else(|| LoadedPolicy::read(Path::new(file)).ok().map(Arc::new))
        }
        _ => None,
    };
    policy?.layout.interactions
}

/// The path of a policy: from the folder in which the programs of the team run.
fn path_of(world: &World, team: Team, file: &str) -> PathBuf {
    let folder = world.get_resource::<AgentSettings>().and_then(|settings| settings.folders[team].as_deref());
    folder.map_or_else(|| PathBuf::from(file), |folder| folder.join(file))
}

/// The policy of a robot; it is read if a match was continued in which it plays.
fn loaded(world: &World, team: Team, file: &str) -> Result<Arc<LoadedPolicy>, String> {
    if let Some(policy) = built_in::named(file) {
        return policy;
    }
    let path = path_of(world, team, file);
    let policies = world.resource::<LoadedPolicies>();
    match policies.of(&path) {
        Some(policy) => Ok(policy),
        None => Ok(policies.insert(path.clone(), LoadedPolicy::read(&path).map_err(|error| error.to_string())?)),
    }
}

/// A robot whose policy decides in this cycle.
struct Deciding {
    id: RobotId,
    entity: Entity,
    state: PolicyState,
    observation: Vec<f32>,
}

/// Lets the policies of all robots decide. A policy that several robots share is run once for all of them.
fn decide(world: &mut World) {
    let mut robots = world.query::<(Entity, &RobotId, &Policy)>();
    let mut robots: Vec<(RobotId, Entity, String)> =
        robots.iter(world).map(|(entity, id, policy)| (*id, entity, policy.0.clone())).collect();
    robots.sort_unstable_by_key(|(id, ..)| *id);
    let mut deciding: BTreeMap<(Team, String), Vec<Deciding>> = BTreeMap::new();
    for (id, entity, file) in robots {
        // The component stays, because robots that lose and gain one are moved in memory.
        let state = world.get_mut::<PolicyState>(entity).map(|mut state| core::mem::take(&mut *state));
        let mut state =
            state.unwrap_or_else(|| PolicyState { memory: Memory::at(odometry(world, entity)), ..default() });
        if state.listens {
            state.memory.listen(world, entity);
        }
        if state.has_failed {
            world.entity_mut(entity).insert(state);
        } else if state.cycles_left > 0 {
            state.cycles_left -= 1;
            give(world, entity, RobotCommand { walk: state.walk, ..default() });
            world.entity_mut(entity).insert(state);
        } else {
            let robot = Deciding { id, entity, state, observation: Vec::new() };
            deciding.entry((id.team, file)).or_default().push(robot);
        }
    }
    for ((team, file), robots) in deciding {
        decide_together(world, team, &file, robots);
    }
}

/// Lets one policy decide for robots of one team.
fn decide_together(world: &mut World, team: Team, file: &str, mut robots: Vec<Deciding>) {
    let policy = match loaded(world, team, file) {
        Ok(policy) => policy,
        Err(problem) => return robots.into_iter().for_each(|robot| lose(world, file, robot, &problem)),
    };
    for robot in &mut robots {
        let (form, memory) = (policy.layout.observed(), &mut robot.state.memory);
        if form.extras.messages && !robot.state.listens {
            robot.state.listens = true;
            memory.listen(world, robot.entity);
        }
        if form.extras.tracked {
            memory.follow(form, world, robot.id);
        }
        let observed = observed(form, world, robot.id, memory);
        memory.odometry = odometry(world, robot.entity);
        robot.observation = observed.iter().map(|(_, value)| *value).collect();
        robot.state.inputs = observed.into_iter().map(|(entry, value)| (entry.to_string(), value)).collect();
    }
    let observations: Vec<&[f32]> = robots.iter().map(|robot| robot.observation.as_slice()).collect();
    let together = policy.outputs_of_all(&observations);
    for (index, mut robot) in robots.into_iter().enumerate() {
        let scores = match &together {
            Some(outputs) => Ok(outputs[index].clone()),
            None => policy.outputs(core::mem::take(&mut robot.observation), &mut robot.state.recurrent),
        };
        let command = scores
            .map_err(|error| error.to_string())
            .and_then(|scores| act(world, &policy.layout, &mut robot, &scores).map(|command| (command, scores)));
        match command {
            Ok((command, scores)) => {
                give(world, robot.entity, command);
                let values = choice::named(policy.layout.actions(), &scores);
                world.entity_mut(robot.entity).insert((Remarks { intention: None, values }, robot.state));
            }
            Err(problem) => lose(world, file, robot, &problem),
        }
    }
}

/// The command of a robot by the outputs of its policy, which is held for as many cycles as the layout says.
fn act(world: &mut World, layout: &PolicyLayout, robot: &mut Deciding, scores: &[f32]) -> Result<RobotCommand, String> {
    let random = world.get_mut::<BehaviourRandom>(robot.entity);
    let space = layout.actions();
    let action = choice::action_of(space, layout.choice, scores, random.map(Mut::into_inner))?;
    space.check(&action).map_err(|error| error.to_string())?;
    let command = RobotCommand {
        say: said(space, &action, layout.observation, world, robot.id),
        ..command(layout.action, &action[..layout.action.len()], world, robot.id)
    };
    robot.state.cycles_left = layout.cycles_per_step - 1;
    robot.state.walk = command.walk;
    Ok(command)
}

/// Gives a robot the command of its policy, whose kicks are those that the robot has.
fn give(world: &mut World, entity: Entity, command: RobotCommand) {
    let _ = give_command(world, entity, command);
}

/// Ends the play of a robot whose policy has failed.
fn lose(world: &mut World, file: &str, robot: Deciding, problem: &str) {
    let message = format!("its policy {file}: {problem}");
    let lost = MatchEvent::AgentLost { robot: robot.id, reason: AgentLoss::Malformed, message };
    world.resource_mut::<CycleEvents>().push(lost);
    world.entity_mut(robot.entity).insert(PolicyState { has_failed: true, ..robot.state });
}

/// The pose of a robot by its odometry.
fn odometry(world: &World, entity: Entity) -> Pose {
    world.get::<Odometry>(entity).map(|odometry| odometry.0).unwrap_or_default()
}

#[cfg(test)]
mod tests;
