//! Learned policies as players: neural networks in ONNX, which read an observation of a learning environment and answer with an action.
//!
//! `"behaviour": { "policy": "score.onnx" }` plays one robot, the team `policy:score.onnx` all robots of a team. `score.json` beside the
//! network is its [layout](PolicyLayout). A policy reads the same [observation](crate::environment::observation), in the same cycles, as in
//! the learning environment, and its [action](crate::environment::action) is held for as many cycles.
//!
//! The [network] is computed with sums in a fixed order and with own functions in place of the platform's, so that a match is the same on
//! every machine. The state of recurrent networks is a component, so that matches are saved with it.

mod layout;
pub mod network;

use bevy::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

pub use layout::{Choice, LoadedPolicy, PolicyError, PolicyLayout, StatePorts};

use crate::agents::{AgentSettings, RobotCommand, give_command};
use crate::environment::action::{ActionKind, command};
use crate::environment::episode::team_message;
use crate::environment::observation::{Memory, ObservationKind, entries, observe};
use naoisis_core::behaviour::remarks::Remarks;
use naoisis_core::behaviour::{DecideSystems, Policy, PolicyNeeds, PolicyReader};
use naoisis_core::cycle::Cycle;
use naoisis_core::events::{AgentLoss, CycleEvents, MatchEvent};
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
    }
}

/// The policies that have been read, by their paths.
#[derive(Resource, Default)]
struct LoadedPolicies(Mutex<BTreeMap<PathBuf, Arc<LoadedPolicy>>>);

/// What the policy of a robot keeps from cycle to cycle.
#[derive(Component, Clone, PartialEq, Debug, Default, Reflect, Serialize, Deserialize)]
#[reflect(Component, @Knowledge::Belief)]
pub struct PolicyState {
    /// The odometry at the last observation.
    memory: Memory,
    /// Cycles for which the last action is still held.
    cycles_left: u32,
    /// The walk of the last action.
    walk: Option<WalkCommand>,
    /// The recurrent state: the numbers of each state input.
    recurrent: Vec<Vec<f32>>,
    /// Whether the policy has failed. Its robot stands.
    has_failed: bool,
}

/// Reads the policy of a team anew, before a match begins.
fn read(world: &World, team: Team, file: &str) -> Result<PolicyNeeds, String> {
    let path = path_of(world, team, file);
    let policy = LoadedPolicy::read(&path).map_err(|error| error.to_string())?;
    let needs = PolicyNeeds { belief: policy.layout.observation == ObservationKind::Belief };
    if let Some(loaded) = world.get_resource::<LoadedPolicies>() {
        loaded.0.lock().unwrap_or_else(PoisonError::into_inner).insert(path, Arc::new(policy));
    }
    Ok(needs)
}

/// The path of a policy: from the folder in which the programs of the team run.
fn path_of(world: &World, team: Team, file: &str) -> PathBuf {
    let folder = world.get_resource::<AgentSettings>().and_then(|settings| settings.folders[team].as_deref());
    folder.map_or_else(|| PathBuf::from(file), |folder| folder.join(Path::new(file)))
}

/// The policy of a robot; it is read if a match was continued in which it plays.
fn loaded(world: &World, team: Team, file: &str) -> Result<Arc<LoadedPolicy>, String> {
    let path = path_of(world, team, file);
    let policies = world.resource::<LoadedPolicies>();
    let find = || policies.0.lock().unwrap_or_else(PoisonError::into_inner).get(&path).cloned();
    if let Some(policy) = find() {
        return Ok(policy);
    }
    read(world, team, file)?;
    find().ok_or_else(|| "the policy cannot be read".to_owned())
}

/// Lets the policies of all robots decide.
fn decide(world: &mut World) {
    let mut robots = world.query::<(Entity, &RobotId, &Policy)>();
    let mut robots: Vec<(RobotId, Entity, String)> =
        robots.iter(world).map(|(entity, id, policy)| (*id, entity, policy.0.clone())).collect();
    robots.sort_unstable_by_key(|(id, ..)| *id);
    for (id, entity, file) in robots {
        let mut state = world
            .get::<PolicyState>(entity)
            .cloned()
            .unwrap_or_else(|| PolicyState { memory: Memory { odometry: odometry(world, entity) }, ..default() });
        if !state.has_failed {
            let mut random = world.get::<BehaviourRandom>(entity).cloned();
            match step(world, id, entity, &file, &mut state, random.as_mut()) {
                Ok((command, values)) => {
                    // The policy's kicks are those that its robot has.
                    let _ = give_command(world, entity, command);
                    let mut robot = world.entity_mut(entity);
                    if let Some(values) = values {
                        robot.insert(Remarks { intention: None, values });
                    }
                    if let Some(random) = random {
                        robot.insert(random);
                    }
                }
                Err(problem) => {
                    state.has_failed = true;
                    let message = format!("its policy {file}: {problem}");
                    let lost = MatchEvent::AgentLost { robot: id, reason: AgentLoss::Malformed, message };
                    world.resource_mut::<CycleEvents>().push(lost);
                }
            }
        }
        world.entity_mut(entity).insert(state);
    }
}

/// The pose of a robot by its odometry.
fn odometry(world: &World, entity: Entity) -> naoisis_core::geometry::Pose {
    world.get::<Odometry>(entity).map(|odometry| odometry.0).unwrap_or_default()
}

/// The command of a robot in this cycle and, if its policy has decided anew, the values of its outputs by name.
fn step(
    world: &World,
    id: RobotId,
    entity: Entity,
    file: &str,
    state: &mut PolicyState,
    random: Option<&mut BehaviourRandom>,
) -> Result<(RobotCommand, Option<BTreeMap<String, f32>>), String> {
    if state.cycles_left > 0 {
        state.cycles_left -= 1;
        return Ok((RobotCommand { walk: state.walk, ..default() }, None));
    }
    let policy = loaded(world, id.team, file)?;
    let PolicyLayout { observation, action, cycles_per_step, choice, .. } = policy.layout;
    let mut observed = vec![0.0; entries(observation, world, id).len()];
    observe(&mut observed, observation, world, id, &state.memory);
    state.memory.odometry = odometry(world, entity);
    let scores = policy.outputs(observed, &mut state.recurrent).map_err(|error| error.to_string())?;
    let action_values = action_of(action, choice, &scores, random)?;
    action.check(&action_values).map_err(|error| error.to_string())?;
    let say = (observation == ObservationKind::Belief).then(|| team_message(world, id)).flatten();
    let command = RobotCommand { say, ..command(action, &action_values, world, id) };
    state.cycles_left = cycles_per_step - 1;
    state.walk = command.walk;
    Ok((command, Some(named(action, &scores))))
}

/// The action that follows from the outputs of a network: the outputs themselves of a continuous action; otherwise the choices, or
/// the scores of the choices of each list one after the other.
fn action_of(
    kind: ActionKind,
    choice: Choice,
    outputs: &[f32],
    mut random: Option<&mut BehaviourRandom>,
) -> Result<Vec<f32>, String> {
    if outputs.iter().any(|output| !output.is_finite()) {
        return Err("an output is not finite".to_owned());
    }
    if outputs.len() == kind.len() {
        return Ok(outputs.to_vec());
    }
    let names = kind.names();
    let scores: usize = names.iter().map(Vec::len).sum();
    if kind == ActionKind::Continuous || outputs.len() != scores {
        let expected = match kind {
            ActionKind::Continuous => format!("{}", kind.len()),
            _ => format!("{scores} scores or {} choices", kind.len()),
        };
        return Err(format!("the action has {} numbers; expected {expected}", outputs.len()));
    }
    let mut rest = outputs;
    let choices = names.iter().map(|names| {
        let (scores, others) = rest.split_at(names.len());
        rest = others;
        let index = match (choice, random.as_deref_mut()) {
            (Choice::Drawn, Some(random)) => drawn(scores, random),
            _ => likeliest(scores),
        };
        index as f32
    });
    Ok(choices.collect())
}

/// The index of the highest score; of equal ones the first.
fn likeliest(scores: &[f32]) -> usize {
    (1..scores.len()).fold(0, |best, index| if scores[index] > scores[best] { index } else { best })
}

/// An index drawn with probabilities in proportion to the exponentials of the scores.
fn drawn(scores: &[f32], random: &mut BehaviourRandom) -> usize {
    let highest = scores[likeliest(scores)];
    let weights: Vec<f32> = scores.iter().map(|score| network::exp(score - highest)).collect();
    let sum = weights.iter().fold(0.0, |sum, weight| sum + weight);
    let mut left = sum * random.uniform();
    for (index, weight) in weights.iter().enumerate() {
        if left < *weight {
            return index;
        }
        left -= weight;
    }
    likeliest(scores)
}

/// The outputs by the names of the action.
fn named(kind: ActionKind, outputs: &[f32]) -> BTreeMap<String, f32> {
    let names = kind.names();
    let named: Vec<String> = if kind == ActionKind::Continuous {
        names.concat().iter().map(|name| (*name).to_owned()).collect()
    } else if outputs.len() == kind.len() {
        (1..=outputs.len()).map(|list| format!("choice{list}")).collect()
    } else if names.len() == 1 {
        names.concat().iter().map(|name| (*name).to_owned()).collect()
    } else {
        let of_list = |(list, names): (usize, &Vec<&str>)| {
            names.iter().map(move |name| format!("{list}.{name}")).collect::<Vec<_>>()
        };
        (1..).zip(&names).flat_map(of_list).collect()
    };
    named.into_iter().zip(outputs.iter().copied()).collect()
}

#[cfg(test)]
mod tests;
