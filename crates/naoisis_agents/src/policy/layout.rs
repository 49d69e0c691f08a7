//! The layout of a policy: which observation it reads, and how its outputs are an action. A JSON file beside the ONNX file has it.

use core::fmt;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::path::Path;

use super::network::{Network, NetworkError, Port, Tensor};
use crate::environment::{ActionKind, ActionSpace, Extras, ObservationForm, ObservationKind, Others};
use naoisis_core::read_file::read_file;

/// The greatest number of cycles for which an action is held.
const MOST_CYCLES: u32 = 1000;

/// How a policy is used: the contents of `NAME.json` beside `NAME.onnx`.
#[derive(Clone, PartialEq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PolicyLayout {
    /// The observation that the network reads, in the order of the learning environments.
    pub observation: ObservationKind,
    /// The kind of action that follows from the network's output.
    pub action: ActionKind,
    /// What is in the observation besides, and what the robot can say with its action.
    #[serde(default, skip_serializing_if = "Extras::is_empty")]
    pub extras: Extras,
    /// The number of cycles for which an action is held, from 1 to 1000: that of the learning environment.
    #[serde(default = "three")]
    pub cycles_per_step: u32,
    /// How choices follow from the scores of a network: the likeliest, or drawn with the probabilities of a softmax.
    #[serde(default)]
    pub choice: Choice,
    /// Inputs and outputs that carry a recurrent state from step to step. The state of the first step is 0.
    #[serde(default)]
    pub state: Vec<StatePorts>,
    /// The number of other robots of its team in the observation, if it is the same in all matches: the nearest ones are in it, and those
    /// that a match lacks are unknown. Without it, the observation has those of the match. It is given together with `opponents`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub team_mates: Option<u8>,
    /// The number of robots of the other team in the observation: see `team_mates`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub opponents: Option<u8>,
    /// The number of interactions that it was trained with: steps of environments or of demonstrations, counted for each agent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interactions: Option<u64>,
    /// A note for people: how the policy was made.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub note: String,
}

/// How a choice follows from scores.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Choice {
    /// The choice with the highest score; of equal ones the first.
    #[default]
    Likeliest,
    /// A random choice: scores are the logarithms of relative probabilities.
    Drawn,
}

/// A recurrent state: the value of an output becomes that of an input in the next step.
#[derive(Clone, PartialEq, Eq, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StatePorts {
    /// The name of the input.
    pub input: String,
    /// The name of the output.
    pub output: String,
}

impl PolicyLayout {
    /// The observation with its extras and robots.
    pub(super) fn observed(&self) -> ObservationForm {
        let others = self.team_mates.zip(self.opponents);
        let others = others.map(|(team_mates, opponents)| Others { team_mates, opponents });
        ObservationForm { kind: self.observation, extras: self.extras, others }
    }

    /// The numbers of its action. The words of a layout are checked when it is read.
    pub fn actions(&self) -> ActionSpace {
        ActionSpace::new(self.action, self.extras.words).unwrap_or_else(|_| self.action.into())
    }
}

fn three() -> u32 {
    3
}

/// The error that a policy cannot be used.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum PolicyError {
    /// A file cannot be read.
    #[error("{file}: {problem}")]
    Unreadable {
        /// The file.
        file: String,
        /// What is wrong.
        problem: String,
    },
    /// The network cannot be read.
    #[error("{file}: {error}")]
    Network {
        /// The file.
        file: String,
        /// What is wrong.
        error: NetworkError,
    },
    /// The layout does not fit the network.
    #[error("{file}: {problem}")]
    Layout {
        /// The file.
        file: String,
        /// What is wrong, and what is expected.
        problem: String,
    },
    /// The network has no outputs for an observation.
    #[error("{0}")]
    Outputs(String),
}

naoisis_core::debug_as_displayed!(PolicyError);

/// A policy that is ready to play.
#[derive(Debug)]
pub struct LoadedPolicy {
    /// The network.
    pub(super) network: Network,
    /// Its use.
    pub(super) layout: PolicyLayout,
    /// The index of the input with the observation.
    observation: usize,
    /// The index of the output with the action.
    action: usize,
    /// For each state, the indices of its input and of its output.
    states: Vec<[usize; 2]>,
}

impl LoadedPolicy {
    /// Reads a policy and its layout.
    ///
    /// # Errors
    /// What is wrong with the files.
    pub fn read(path: &Path) -> Result<Self, PolicyError> {
        let file = path.display().to_string();
        let unreadable = |file: &str, problem: String| PolicyError::Unreadable { file: file.to_owned(), problem };
        let bytes = read_file(path).map_err(|error| unreadable(&file, error.to_string()))?;
        let network = Network::read(&bytes).map_err(|error| PolicyError::Network { file, error })?;
        let path = path.with_extension("json");
        let file = path.display().to_string();
        let text = read_file(&path).map_err(|error| {
            unreadable(&file, format!("{error}; a policy needs its layout, such as {EXAMPLE} beside it"))
        })?;
        let layout = serde_json::from_slice(&text).map_err(|error| unreadable(&file, error.to_string()))?;
        Self::new(network, layout).map_err(|problem| PolicyError::Layout { file, problem })
    }

    /// Reads a policy from the contents of its two files.
    pub(super) fn from_contents(network: &[u8], layout: &str) -> Result<Self, String> {
        let network = Network::read(network).map_err(|error| error.to_string())?;
        Self::new(network, serde_json::from_str(layout).map_err(|error| error.to_string())?)
    }

    /// Joins a network and its layout.
    fn new(network: Network, layout: PolicyLayout) -> Result<Self, String> {
        if layout.observation == ObservationKind::Truth {
            return Err("players know no `truth`; expected `perception`, `belief` or `body`".to_owned());
        }
        if !(1..=MOST_CYCLES).contains(&layout.cycles_per_step) {
            return Err(format!("`cycles_per_step` is {}; expected 1 to {MOST_CYCLES}", layout.cycles_per_step));
        }
        if layout.team_mates.is_some() != layout.opponents.is_some() {
            return Err("it has one of `team_mates` and `opponents`; expected both or none".to_owned());
        }
        ActionSpace::new(layout.action, layout.extras.words).map_err(|error| format!("`extras.words`: {error}"))?;
        let index = |ports: &[Port], name: &str, what: &str| {
            let names = || ports.iter().map(|port| port.name.as_str()).collect::<Vec<_>>().join(", ");
            let index = ports.iter().position(|port| port.name == name);
            index.ok_or_else(|| format!("the network has no {what} `{name}`; expected one of {}", names()))
        };
        let states = layout.state.iter().map(|StatePorts { input, output }| {
            Ok([index(network.inputs(), input, "input")?, index(network.outputs(), output, "output")?])
        });
        let states: Vec<[usize; 2]> = states.collect::<Result<_, String>>()?;
        let other = |ports: &[Port], side: usize, what: &str| {
            let mut others = (0..ports.len()).filter(|index| states.iter().all(|state| state[side] != *index));
            match (others.next(), others.next()) {
                (Some(index), None) => Ok(index),
                (first, _) => Err(format!(
                    "the network has {} besides those in `state`; expected one",
                    if first.is_some() { format!("several {what}s") } else { format!("no {what}") }
                )),
            }
        };
        let (observation, action) = (other(network.inputs(), 0, "input")?, other(network.outputs(), 1, "output")?);
        let policy = Self { network, layout, observation, action, states };
        policy.check_action()?;
        Ok(policy)
    }

    /// Checks that the network answers with an action of the layout, if it tells the length of its observation.
    fn check_action(&self) -> Result<(), String> {
        let port = &self.network.inputs()[self.observation];
        let Some(Some(width)) = port.shape.last() else { return Ok(()) };
        let outer: usize = port.shape.iter().rev().skip(1).map(|length| length.unwrap_or(1)).product();
        let answer = self.run(vec![0.0; width * outer], &mut Vec::new())?;
        let space = self.layout.actions();
        let scores: usize = space.names().iter().map(Vec::len).sum();
        let expected = match space.kind() {
            ActionKind::Continuous => space.len().to_string(),
            _ => format!("{scores} scores or {} choices", space.len()),
        };
        if answer.len() == space.len() || answer.len() == scores {
            return Ok(());
        }
        Err(format!("the network answers {} numbers; expected {expected} of its `action`", answer.len()))
    }

    /// The layout.
    pub fn layout(&self) -> &PolicyLayout {
        &self.layout
    }

    /// Returns the outputs of the network for an observation: the numbers of the action, or the scores of its choices. `recurrent` has the
    /// state before the step, or is empty before the first one, and receives the state after it.
    ///
    /// # Errors
    /// The observation has another length than the network's input, or its values cannot be computed.
    pub fn outputs(&self, observation: Vec<f32>, recurrent: &mut Vec<Vec<f32>>) -> Result<Vec<f32>, PolicyError> {
        self.run(observation, recurrent).map_err(PolicyError::Outputs)
    }

    /// Returns the outputs for several observations in one run, the same numbers as [`LoadedPolicy::outputs`] for each of them. Returns
    /// `None` if they have to be computed one by one: the network has a state or no free number of rows, or it fails.
    pub(super) fn outputs_of_all(&self, observations: &[&[f32]]) -> Option<Vec<Vec<f32>>> {
        let rows = observations.len();
        let [None, width] = self.network.inputs()[self.observation].shape[..] else { return None };
        let length = observations.first()?.len();
        if rows == 1 || !self.states.is_empty() || width.is_some_and(|width| width != length) {
            return None;
        }
        let input = Tensor { shape: vec![rows, length], values: observations.concat() };
        let output = self.network.run(&[input]).ok()?.swap_remove(self.action);
        let is_of_rows = output.shape.first() == Some(&rows);
        let length = (output.values.len() / rows).max(1);
        is_of_rows.then(|| output.values.chunks(length).map(<[f32]>::to_vec).collect())
    }

    fn run(&self, observation: Vec<f32>, recurrent: &mut Vec<Vec<f32>>) -> Result<Vec<f32>, String> {
        let ports = self.network.inputs();
        let mut inputs: Vec<Tensor> = ports.iter().map(|_| Tensor::default()).collect();
        let shape = Self::shape_of(&ports[self.observation], Some(observation.len()))?;
        inputs[self.observation] = Tensor { shape, values: observation };
        recurrent.resize(self.states.len(), Vec::new());
        for ([input, _], before) in self.states.iter().zip(recurrent.iter()) {
            let shape = Self::shape_of(&ports[*input], None)?;
            let count = shape.iter().product();
            let values = if before.len() == count { before.clone() } else { vec![0.0; count] };
            inputs[*input] = Tensor { shape, values };
        }
        let mut outputs = self.network.run(&inputs).map_err(|error| error.to_string())?;
        for ([_, output], state) in self.states.iter().zip(recurrent) {
            state.clone_from(&outputs[*output].values);
        }
        Ok(outputs.swap_remove(self.action).values)
    }

    /// The shape of an input that has `count` numbers: free dimensions are 1, but the last one.
    fn shape_of(port: &Port, count: Option<usize>) -> Result<Vec<usize>, String> {
        let mut shape: Vec<usize> = port.shape.iter().map(|length| length.unwrap_or(1)).collect();
        let Some(count) = count else { return Ok(shape) };
        if let (Some(last), Some(None)) = (shape.last_mut(), port.shape.last()) {
            *last = count;
        }
        if shape.iter().product::<usize>() != count {
            let expected = shape.iter().product::<usize>();
            return Err(format!(
                "the policy reads {expected} numbers, and the observation of its robot has {count}: it was made for a match with another \
                 number of robots, or for another observation"
            ));
        }
        Ok(shape)
    }
}

/// Shows the ports of the network and their use.
impl fmt::Display for LoadedPolicy {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shape = |port: &Port| {
            let lengths =
                port.shape.iter().map(|length| length.map_or_else(|| "?".to_owned(), |length| length.to_string()));
            format!("`{}` [{}]", port.name, lengths.collect::<Vec<_>>().join(", "))
        };
        let word = |value: serde_json::Result<serde_json::Value>| {
            value.ok().and_then(|value| value.as_str().map(str::to_owned))
        };
        let PolicyLayout { observation, action, cycles_per_step, .. } = &self.layout;
        let [observation, action] = [word(serde_json::to_value(observation)), word(serde_json::to_value(action))]
            .map(Option::unwrap_or_default);
        let (inputs, outputs) = (self.network.inputs(), self.network.outputs());
        write!(
            formatter,
            "{} is the observation `{observation}`, {} is the action `{action}`, held for {cycles_per_step} cycles",
            shape(&inputs[self.observation]),
            shape(&outputs[self.action])
        )?;
        for [input, output] in &self.states {
            write!(formatter, ", {} is the state, then {}", shape(&inputs[*input]), shape(&outputs[*output]))?;
        }
        match self.layout.interactions {
            Some(interactions) => write!(formatter, "; trained with {interactions} interactions"),
            None => Ok(()),
        }
    }
}

/// A layout, for error messages.
const EXAMPLE: &str = r#"{ "observation": "belief", "action": "discrete" }"#;
