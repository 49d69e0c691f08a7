//! The action that follows from the outputs of a network.

use std::collections::BTreeMap;

use super::{Choice, network};
use crate::environment::{ActionKind, ActionSpace};
use naoisis_core::random::BehaviourRandom;

/// The action that follows from the outputs of a network: the outputs themselves of a continuous action; otherwise the choices, or
/// the scores of the choices of each list one after the other.
pub(super) fn action_of(
    space: ActionSpace,
    choice: Choice,
    outputs: &[f32],
    mut random: Option<&mut BehaviourRandom>,
) -> Result<Vec<f32>, String> {
    if outputs.iter().any(|output| !output.is_finite()) {
        return Err("an output is not finite".to_owned());
    }
    if outputs.len() == space.len() {
        return Ok(outputs.to_vec());
    }
    let names = space.names();
    let scores: usize = names.iter().map(Vec::len).sum();
    if space.kind() == ActionKind::Continuous || outputs.len() != scores {
        let expected = match space.kind() {
            ActionKind::Continuous => format!("{}", space.len()),
            _ => format!("{scores} scores or {} choices", space.len()),
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
pub(super) fn named(space: ActionSpace, outputs: &[f32]) -> BTreeMap<String, f32> {
    let names = space.names();
    let named: Vec<String> = if space.kind() == ActionKind::Continuous {
        names.concat().iter().map(|name| (*name).to_owned()).collect()
    } else if outputs.len() == space.len() {
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
