//! Normalisations: softmax, and by mean and variance.

use super::super::{
    math::{exp, ln},
    tensor::axis_of,
};
use super::{Element, Node, Operator, Reading, Tensor, input};

/// Exponentials divided by their sum, or the logarithms of that.
#[derive(Debug)]
struct Softmax {
    axis: i64,
    /// Whether all dimensions from `axis` on are normalised as one, as older versions do.
    flattened: bool,
    logarithm: bool,
}

impl Operator for Softmax {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let axis = axis_of(self.axis, x.shape.len())?;
        let (outer, from) = x.shape.split_at(axis);
        let (length, inner) = match self.flattened {
            true => (from.iter().product(), 1),
            false => (from[0], from[1..].iter().product()),
        };
        let mut values = x.values.clone();
        for block in 0..outer.iter().product() {
            for column in 0..inner {
                let start: usize = block * length * inner + column;
                self.normalise(&mut values, start, inner, length);
            }
        }
        Ok(vec![Tensor { shape: x.shape.clone(), values }])
    }
}

impl Softmax {
    /// Normalises the `length` numbers of `values` at `start` and every `stride` after it.
    fn normalise(&self, values: &mut [f32], start: usize, stride: usize, length: usize) {
        let positions = || (0..length).map(|index| start + index * stride);
        // Unlike `f32::max`, this does not leave the sign of 0 to the platform.
        let larger = |largest, at: usize| if values[at] > largest { values[at] } else { largest };
        let largest = positions().fold(f32::NEG_INFINITY, larger);
        let mut sum = 0.0;
        for at in positions() {
            let power = exp(values[at] - largest);
            sum += power;
            values[at] = if self.logarithm { values[at] - largest } else { power };
        }
        let logarithm = ln(sum);
        for at in positions() {
            values[at] = if self.logarithm { values[at] - logarithm } else { values[at] / sum };
        }
    }
}

/// Numbers brought to mean 0 and variance 1 over the last dimensions, then scaled and shifted.
#[derive(Debug)]
struct LayerNormalisation {
    axis: i64,
    epsilon: f32,
}

impl Operator for LayerNormalisation {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let (x, scale) = (input(inputs, 0)?, input(inputs, 1)?);
        let axis = axis_of(self.axis, x.shape.len())?;
        let normalised = &x.shape[axis..];
        let length = normalised.iter().product::<usize>();
        let scale = scale.broadcast_to(normalised)?;
        let bias = match inputs.get(2).copied().flatten() {
            Some(bias) => bias.broadcast_to(normalised)?.values,
            None => vec![0.0; length],
        };
        let mut values = x.values.clone();
        for row in values.chunks_exact_mut(length) {
            let mean = row.iter().fold(0.0, |sum, &value| sum + value) / length as f32;
            row.iter_mut().for_each(|value| *value -= mean);
            let variance = row.iter().fold(0.0, |sum, &value| sum + value * value) / length as f32;
            let deviation = (variance + self.epsilon).sqrt();
            for ((value, &scale), &bias) in row.iter_mut().zip(&scale.values).zip(&bias) {
                *value = *value / deviation * scale + bias;
            }
        }
        Ok(vec![Tensor { shape: x.shape.clone(), values }])
    }
}

/// Numbers normalised per channel, which is the second dimension, by a mean and variance found in training.
#[derive(Debug)]
struct BatchNormalisation {
    epsilon: f32,
}

impl Operator for BatchNormalisation {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let [scale, bias, mean, variance] = [1, 2, 3, 4].map(|index| input(inputs, index));
        let parameters = [scale?, bias?, mean?, variance?];
        let channels = x.shape.get(1).copied().unwrap_or(1);
        if let Some(wrong) = parameters.iter().find(|parameter| parameter.shape != [channels]) {
            return Err(format!("a parameter has shape {:?} instead of {channels} channels", wrong.shape));
        }
        let [scale, bias, mean, variance] = parameters.map(|parameter| &parameter.values);
        let inner = x.shape.iter().skip(2).product::<usize>();
        let mut values = x.values.clone();
        for (index, block) in values.chunks_exact_mut(inner).enumerate() {
            let channel = index % channels;
            let deviation = (variance[channel] + self.epsilon).sqrt();
            for value in block {
                *value = (*value - mean[channel]) / deviation * scale[channel] + bias[channel];
            }
        }
        Ok(vec![Tensor { shape: x.shape.clone(), values }])
    }
}

fn any_softmax(node: &Node, logarithm: bool) -> Reading {
    node.expect_floats()?;
    let flattened = node.operator_set < 13;
    let axis = node.int("axis", if flattened { 1 } else { -1 })?;
    Ok((Box::new(Softmax { axis, flattened, logarithm }), Element::Float))
}

pub(super) fn softmax(node: &Node) -> Reading {
    any_softmax(node, false)
}

pub(super) fn log_softmax(node: &Node) -> Reading {
    any_softmax(node, true)
}

pub(super) fn layer(node: &Node) -> Reading {
    node.expect_floats()?;
    node.expect_int("stash_type", 1)?;
    let layer = LayerNormalisation { axis: node.int("axis", -1)?, epsilon: node.float("epsilon", 1e-5)? };
    Ok((Box::new(layer), Element::Float))
}

pub(super) fn batch(node: &Node) -> Reading {
    node.expect_floats()?;
    node.expect_int("training_mode", 0)?;
    // Used in training only.
    node.float("momentum", 0.9)?;
    Ok((Box::new(BatchNormalisation { epsilon: node.float("epsilon", 1e-5)? }), Element::Float))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tensor(shape: &[usize], values: &[f32]) -> Tensor {
        Tensor { shape: shape.to_vec(), values: values.to_vec() }
    }

    #[test]
    fn softmax_sums_to_one_and_ignores_a_common_offset() {
        let softmax = Softmax { axis: 1, flattened: false, logarithm: false };
        let x = tensor(&[1, 3, 2], &[1.0, 5.0, 2.0, 5.0, 3.0, 5.0]);
        let result = softmax.run(&[Some(&x)]).unwrap().remove(0);
        assert!((result.values.iter().step_by(2).sum::<f32>() - 1.0).abs() < 1e-6);
        assert!((result.values[1] - 1.0 / 3.0).abs() < 1e-6);
        let moved = Tensor { values: x.values.iter().map(|value| value + 64.0).collect(), ..x.clone() };
        assert_eq!(softmax.run(&[Some(&moved)]).unwrap()[0], result);
        let logarithms = Softmax { logarithm: true, ..softmax }.run(&[Some(&x)]).unwrap().remove(0);
        for (power, logarithm) in result.values.iter().zip(&logarithms.values) {
            assert!((exp(*logarithm) - power).abs() < 1e-6);
        }
    }

    #[test]
    fn older_softmax_takes_all_later_dimensions_as_one() {
        let softmax = Softmax { axis: 1, flattened: true, logarithm: false };
        let result = softmax.run(&[Some(&tensor(&[1, 2, 2], &[0.0; 4]))]).unwrap();
        assert_eq!(result[0].values, [0.25; 4]);
    }

    #[test]
    fn layers_have_mean_zero_and_variance_one_before_their_scale() {
        let layer = LayerNormalisation { axis: -1, epsilon: 0.0 };
        let x = tensor(&[2, 2], &[1.0, 3.0, -4.0, 4.0]);
        let (scale, bias) = (tensor(&[2], &[2.0, 3.0]), tensor(&[2], &[1.0, 0.0]));
        let result = layer.run(&[Some(&x), Some(&scale), Some(&bias)]).unwrap();
        assert_eq!(result[0].values, [-1.0, 3.0, -1.0, 3.0]);
        assert!(layer.run(&[Some(&x), Some(&tensor(&[3], &[1.0; 3]))]).is_err());
    }

    #[test]
    fn batches_are_normalised_per_channel() {
        let [scale, bias, mean, variance] =
            [[1.0, 2.0], [0.0, 1.0], [1.0, 0.0], [4.0, 1.0]].map(|values| tensor(&[2], &values));
        let x = tensor(&[1, 2, 2], &[3.0, 5.0, 1.0, 2.0]);
        let batch = BatchNormalisation { epsilon: 0.0 };
        let result = batch.run(&[Some(&x), Some(&scale), Some(&bias), Some(&mean), Some(&variance)]).unwrap();
        assert_eq!(result[0].values, [1.0, 2.0, 3.0, 5.0]);
        assert!(batch.run(&[Some(&x), Some(&scale), Some(&bias), Some(&mean), Some(&x)]).is_err());
    }
}
