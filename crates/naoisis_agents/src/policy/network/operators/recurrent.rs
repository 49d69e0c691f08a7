//! Recurrent layers: gated recurrent units and long short-term memory.

use super::super::{
    math::{sigmoid, tanh},
    tensor::{Tensor, count},
};
use super::{
    Element, Node, Operator, Reading, input,
    linear::{add_product, transposed_values},
};

/// The weights of a recurrent layer, whose gates lie side by side in each row.
#[derive(Debug)]
struct Weights {
    /// How many numbers each step of the sequence has.
    features: usize,
    /// How many numbers the state has.
    hidden: usize,
    /// One row per feature.
    input: Vec<f32>,
    /// One row per number of the state.
    recurrent: Vec<f32>,
    input_bias: Vec<f32>,
    recurrent_bias: Vec<f32>,
}

impl Weights {
    /// The weights in the inputs of `node`, a layer with so many `gates`.
    fn read(node: &Node, gates: usize) -> Result<Self, String> {
        node.expect_text("direction", "forward")?;
        node.expect_int("layout", 0)?;
        if node.operand(4).is_some() {
            return Err("its input `sequence_lens` is not supported: all sequences must be of one length".into());
        }
        let shape = node.parameter(1, "W")?.map(|constant| &constant.tensor.shape[..]);
        let Some(&[1, rows, features]) = shape else {
            return Err(format!("its input `W` must have one direction and three dimensions, not shape {shape:?}"));
        };
        let hidden = rows / gates;
        if rows == 0 || features == 0 || hidden * gates != rows {
            return Err(format!("its input `W` has {rows} rows, which is no multiple of {gates} gates"));
        }
        node.expect_int("hidden_size", hidden as i64)?;
        let input = node.weights(1, "W", &[1, rows, features])?.ok_or("its input `W` is missing")?;
        let recurrent = node.weights(2, "R", &[1, rows, hidden])?.ok_or("its input `R` is missing")?;
        let biases = node.weights(3, "B", &[1, 2 * rows])?;
        let biases = biases.map_or_else(|| vec![0.0; 2 * rows], |tensor| tensor.values.clone());
        let (input_bias, recurrent_bias) = biases.split_at(rows);
        Ok(Self {
            features,
            hidden,
            input: transposed_values(&input.values, rows, features),
            recurrent: transposed_values(&recurrent.values, rows, hidden),
            input_bias: input_bias.to_vec(),
            recurrent_bias: recurrent_bias.to_vec(),
        })
    }

    /// The steps and the batch of the sequences `x`.
    fn sequences(&self, x: &Tensor) -> Result<(usize, usize), String> {
        match x.shape[..] {
            [steps, batch, features] if features == self.features => Ok((steps, batch)),
            _ => Err(format!("its input has shape {:?} instead of steps, batch and {}", x.shape, self.features)),
        }
    }

    /// The states of a `batch` before the first step, as the optional input `index` gives them; otherwise 0.
    fn initial(&self, inputs: &[Option<&Tensor>], index: usize, batch: usize) -> Result<Vec<f32>, String> {
        match inputs.get(index).copied().flatten() {
            None => Ok(vec![0.0; count(&[batch, self.hidden])?]),
            Some(state) if state.shape == [1, batch, self.hidden] => Ok(state.values.clone()),
            Some(state) => {
                Err(format!("its state has shape {:?} instead of {:?}", state.shape, [1, batch, self.hidden]))
            }
        }
    }

    /// Runs `step` on the features and the position of each sequence of the batch, step by step, and gives the states
    /// of all steps and the last ones.
    fn unroll(
        &self,
        x: &Tensor,
        mut states: Vec<f32>,
        mut step: impl FnMut(&[f32], usize, &mut [f32]),
    ) -> Result<[Tensor; 2], String> {
        let (steps, batch) = self.sequences(x)?;
        let shape = vec![steps, 1, batch, self.hidden];
        let mut all = Vec::with_capacity(count(&shape)?);
        for sequences in x.values.chunks_exact(batch * self.features) {
            let pairs = sequences.chunks_exact(self.features).zip(states.chunks_exact_mut(self.hidden));
            for (index, (features, state)) in pairs.enumerate() {
                step(features, index, state);
            }
            all.extend_from_slice(&states);
        }
        Ok([Tensor { shape, values: all }, Tensor { shape: vec![1, batch, self.hidden], values: states }])
    }
}

/// A layer of gated recurrent units. Its gates are, in order: update, reset, candidate.
#[derive(Debug)]
struct Gru {
    weights: Weights,
    /// The part of the recurrent weights for the update and reset gates.
    gates: Vec<f32>,
    /// The part of the recurrent weights for the candidate.
    candidate: Vec<f32>,
    /// Whether the reset gate acts after the recurrent weights instead of before.
    linear_before_reset: bool,
}

impl Operator for Gru {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let (x, weights) = (input(inputs, 0)?, &self.weights);
        let hidden = weights.hidden;
        let (_, batch) = weights.sequences(x)?;
        let mut sums = vec![0.0; 3 * hidden];
        let mut recurrent = vec![0.0; hidden];
        let mut reset_state = vec![0.0; hidden];
        let results = weights.unroll(x, weights.initial(inputs, 5, batch)?, |features, _, state| {
            sums.copy_from_slice(&weights.input_bias);
            let (gates, candidate) = sums.split_at_mut(2 * hidden);
            add(gates, &weights.recurrent_bias[..2 * hidden]);
            recurrent.copy_from_slice(&weights.recurrent_bias[2 * hidden..]);
            if !self.linear_before_reset {
                add(candidate, &recurrent);
            }
            add_product(&mut sums, features, &weights.input);
            let (gates, candidate) = sums.split_at_mut(2 * hidden);
            add_product(gates, state, &self.gates);
            gates.iter_mut().for_each(|gate| *gate = sigmoid(*gate));
            let (update, reset) = gates.split_at(hidden);
            if self.linear_before_reset {
                add_product(&mut recurrent, state, &self.candidate);
                for ((sum, &recurrent), &reset) in candidate.iter_mut().zip(&recurrent).zip(reset) {
                    *sum += reset * recurrent;
                }
            } else {
                for ((product, &state), &reset) in reset_state.iter_mut().zip(&*state).zip(reset) {
                    *product = reset * state;
                }
                add_product(candidate, &reset_state, &self.candidate);
            }
            for ((state, &sum), &update) in state.iter_mut().zip(&*candidate).zip(update) {
                *state = (1.0 - update) * tanh(sum) + update * *state;
            }
        })?;
        Ok(results.into())
    }
}

/// A layer of long short-term memory. Its gates are, in order: input, output, forget, cell.
#[derive(Debug)]
struct Lstm(Weights);

impl Operator for Lstm {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let (x, weights) = (input(inputs, 0)?, &self.0);
        let hidden = weights.hidden;
        let (_, batch) = weights.sequences(x)?;
        let mut cells = weights.initial(inputs, 6, batch)?;
        let mut sums = vec![0.0; 4 * hidden];
        let results = weights.unroll(x, weights.initial(inputs, 5, batch)?, |features, index, state| {
            sums.copy_from_slice(&weights.input_bias);
            add(&mut sums, &weights.recurrent_bias);
            add_product(&mut sums, features, &weights.input);
            add_product(&mut sums, state, &weights.recurrent);
            let (gates, candidates) = sums.split_at_mut(3 * hidden);
            gates.iter_mut().for_each(|gate| *gate = sigmoid(*gate));
            candidates.iter_mut().for_each(|candidate| *candidate = tanh(*candidate));
            let cells = &mut cells[index * hidden..][..hidden];
            for (unit, (state, cell)) in state.iter_mut().zip(cells).enumerate() {
                *cell = gates[2 * hidden + unit] * *cell + gates[unit] * candidates[unit];
                *state = gates[hidden + unit] * tanh(*cell);
            }
        })?;
        let mut results = Vec::from(results);
        results.push(Tensor { shape: vec![1, batch, hidden], values: cells });
        Ok(results)
    }
}

/// Adds `terms` to `sums`.
fn add(sums: &mut [f32], terms: &[f32]) {
    sums.iter_mut().zip(terms).for_each(|(sum, &term)| *sum += term);
}

pub(super) fn gru(node: &Node) -> Reading {
    node.expect_floats()?;
    node.expect_texts("activations", &["Sigmoid", "Tanh"])?;
    let linear_before_reset = node.flag("linear_before_reset", false)?;
    let weights = Weights::read(node, 3)?;
    let hidden = weights.hidden;
    let columns = |from: usize, to: usize| {
        weights.recurrent.chunks_exact(3 * hidden).flat_map(|row| &row[from..to]).copied().collect()
    };
    let (gates, candidate) = (columns(0, 2 * hidden), columns(2 * hidden, 3 * hidden));
    let weights = Weights { recurrent: Vec::new(), ..weights };
    Ok((Box::new(Gru { weights, gates, candidate, linear_before_reset }), Element::Float))
}

pub(super) fn lstm(node: &Node) -> Reading {
    node.expect_floats()?;
    node.expect_texts("activations", &["Sigmoid", "Tanh", "Tanh"])?;
    node.expect_int("input_forget", 0)?;
    if node.operand(7).is_some() {
        return Err("its input `P` (peepholes) is not supported".into());
    }
    Ok((Box::new(Lstm(Weights::read(node, 4)?)), Element::Float))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A layer of one unit with one feature, the `input` and `recurrent` weights of its gates, and biases.
    fn weights(input: &[f32], recurrent: &[f32]) -> Weights {
        Weights {
            features: 1,
            hidden: 1,
            input: input.to_vec(),
            recurrent: recurrent.to_vec(),
            input_bias: vec![0.1; input.len()],
            recurrent_bias: vec![0.2; input.len()],
        }
    }

    fn tensor(shape: &[usize], values: &[f32]) -> Tensor {
        Tensor { shape: shape.to_vec(), values: values.to_vec() }
    }

    #[test]
    fn gated_unit_has_its_closed_form() {
        let x = tensor(&[1, 1, 1], &[0.7]);
        let state = tensor(&[1, 1, 1], &[-0.4]);
        for linear_before_reset in [false, true] {
            let gru = Gru {
                weights: weights(&[0.5, -0.3, 0.8], &[]),
                gates: vec![0.2, 0.9],
                candidate: vec![-0.6],
                linear_before_reset,
            };
            let results = gru.run(&[Some(&x), None, None, None, None, Some(&state)]).unwrap();
            let update = sigmoid(0.3 + 0.5 * 0.7 - 0.2 * 0.4);
            let reset = sigmoid(0.3 - 0.3 * 0.7 - 0.9 * 0.4);
            let candidate = match linear_before_reset {
                true => tanh(0.1 + 0.8 * 0.7 + reset * (0.2 + 0.6 * 0.4)),
                false => tanh(0.3 + 0.8 * 0.7 + 0.6 * (reset * 0.4)),
            };
            let expected = (1.0 - update) * candidate - update * 0.4;
            assert!((results[1].values[0] - expected).abs() < 1e-6);
            assert_eq!(results[0], tensor(&[1, 1, 1, 1], &results[1].values));
        }
    }

    #[test]
    fn long_short_term_memory_has_its_closed_form() {
        let lstm = Lstm(weights(&[0.5, -0.3, 0.8, 0.4], &[0.2, 0.9, -0.6, 0.7]));
        let x = tensor(&[1, 1, 1], &[0.7]);
        let (state, cell) = (tensor(&[1, 1, 1], &[-0.4]), tensor(&[1, 1, 1], &[0.9]));
        let results = lstm.run(&[Some(&x), None, None, None, None, Some(&state), Some(&cell)]).unwrap();
        let gate = |input: f32, recurrent: f32| 0.3 + input * 0.7 - recurrent * 0.4;
        let next = sigmoid(gate(0.8, -0.6)) * 0.9 + sigmoid(gate(0.5, 0.2)) * tanh(gate(0.4, 0.7));
        assert!((results[2].values[0] - next).abs() < 1e-6);
        assert!((results[1].values[0] - sigmoid(gate(-0.3, 0.9)) * tanh(next)).abs() < 1e-6);
    }

    #[test]
    fn steps_carry_the_state_of_each_sequence() {
        let lstm = Lstm(weights(&[0.5, -0.3, 0.8, 0.4], &[0.2, 0.9, -0.6, 0.7]));
        let both = lstm.run(&[Some(&tensor(&[2, 2, 1], &[0.1, 5.0, 0.3, -5.0]))]).unwrap();
        let alone = lstm.run(&[Some(&tensor(&[2, 1, 1], &[0.1, 0.3]))]).unwrap();
        assert_eq!(both[1].values[0], alone[1].values[0]);
        assert_eq!(both[0].shape, [2, 1, 2, 1]);
        assert!(lstm.run(&[Some(&tensor(&[2, 1, 2], &[0.0; 4]))]).is_err());
    }
}
