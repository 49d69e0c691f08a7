//! Operators on each number by itself, such as activations.

use rten_onnx::onnx::DataType;

use super::super::math;
use super::{Element, Node, Operator, Reading, Tensor, input};

/// A function of one number, applied to each number of a tensor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Elementwise {
    Abs,
    Asinh,
    Clip { low: f32, high: f32 },
    Elu { alpha: f32 },
    Exp,
    LeakyRelu { alpha: f32 },
    Log,
    Neg,
    Relu,
    Same,
    Sigmoid,
    Softplus,
    Sqrt,
    Square,
    Tanh,
    Truncate,
    Truth,
}

impl Operator for Elementwise {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        Ok(vec![match *self {
            Self::Abs => each(x, f32::abs),
            Self::Asinh => each(x, math::asinh),
            Self::Clip { low, high } => each(x, |x| clipped(x, low, high)),
            Self::Elu { alpha } => each(x, |x| if x < 0.0 { alpha * (math::exp(x) - 1.0) } else { x }),
            Self::Exp => each(x, math::exp),
            Self::LeakyRelu { alpha } => each(x, |x| if x < 0.0 { alpha * x } else { x }),
            Self::Log => each(x, math::log),
            Self::Neg => each(x, |x| -x),
            Self::Relu => each(x, |x| if x < 0.0 { 0.0 } else { x }),
            Self::Same => x.clone(),
            Self::Sigmoid => each(x, math::sigmoid),
            Self::Softplus => each(x, math::softplus),
            Self::Sqrt => each(x, f32::sqrt),
            Self::Square => each(x, |x| x * x),
            Self::Tanh => each(x, math::tanh),
            Self::Truncate => each(x, f32::trunc),
            Self::Truth => each(x, |x| f32::from(x != 0.0)),
        }])
    }
}

/// The tensor of `function` of each number of `x`.
fn each(x: &Tensor, function: impl Fn(f32) -> f32) -> Tensor {
    Tensor { shape: x.shape.clone(), values: x.values.iter().map(|&value| function(value)).collect() }
}

/// The number `x`, but at least `low`, and then at most `high`.
fn clipped(x: f32, low: f32, high: f32) -> f32 {
    let raised = if x < low { low } else { x };
    if raised > high { high } else { raised }
}

/// The operator for a `function` of floats.
fn on_floats(node: &Node, function: Elementwise) -> Reading {
    node.expect_floats()?;
    Ok((Box::new(function), Element::Float))
}

/// The operator for a `function` that keeps the kind of number.
fn on_all(node: &Node, function: Elementwise) -> Reading {
    Ok((Box::new(function), node.element()))
}

pub(super) fn abs(node: &Node) -> Reading {
    on_all(node, Elementwise::Abs)
}

pub(super) fn neg(node: &Node) -> Reading {
    on_all(node, Elementwise::Neg)
}

pub(super) fn exp(node: &Node) -> Reading {
    on_floats(node, Elementwise::Exp)
}

pub(super) fn asinh(node: &Node) -> Reading {
    on_floats(node, Elementwise::Asinh)
}

pub(super) fn log(node: &Node) -> Reading {
    on_floats(node, Elementwise::Log)
}

pub(super) fn relu(node: &Node) -> Reading {
    on_floats(node, Elementwise::Relu)
}

pub(super) fn sigmoid(node: &Node) -> Reading {
    on_floats(node, Elementwise::Sigmoid)
}

pub(super) fn softplus(node: &Node) -> Reading {
    on_floats(node, Elementwise::Softplus)
}

pub(super) fn sqrt(node: &Node) -> Reading {
    on_floats(node, Elementwise::Sqrt)
}

pub(super) fn tanh(node: &Node) -> Reading {
    on_floats(node, Elementwise::Tanh)
}

pub(super) fn elu(node: &Node) -> Reading {
    on_floats(node, Elementwise::Elu { alpha: node.float("alpha", 1.0)? })
}

pub(super) fn leaky_relu(node: &Node) -> Reading {
    on_floats(node, Elementwise::LeakyRelu { alpha: node.float("alpha", 0.01)? })
}

pub(super) fn clip(node: &Node) -> Reading {
    let low = node.number(1, "min")?.unwrap_or(f32::NEG_INFINITY);
    let high = node.number(2, "max")?.unwrap_or(f32::INFINITY);
    on_all(node, Elementwise::Clip { low, high })
}

pub(super) fn pow(node: &Node) -> Reading {
    let function = match node.number(1, "exponent")? {
        Some(2.0) => Elementwise::Square,
        Some(0.5) => Elementwise::Sqrt,
        Some(1.0) => Elementwise::Same,
        other => return Err(format!("its exponent is {}, and only 0.5, 1 and 2 are supported", other.unwrap_or(0.0))),
    };
    if function == Elementwise::Square { on_all(node, function) } else { on_floats(node, function) }
}

pub(super) fn cast(node: &Node) -> Reading {
    // Matters for 8-bit floats only.
    node.int("saturate", 1)?;
    let code = DataType(i32::try_from(node.int("to", 0)?).unwrap_or(0));
    let element = Element::of(code)?;
    let function = match element {
        Element::Float => Elementwise::Same,
        Element::Integer if code == DataType::BOOL => Elementwise::Truth,
        Element::Integer => Elementwise::Truncate,
    };
    Ok((Box::new(function), element))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(function: Elementwise, values: &[f32]) -> Vec<f32> {
        let x = Tensor { shape: vec![values.len()], values: values.to_vec() };
        function.run(&[Some(&x)]).unwrap().remove(0).values
    }

    #[test]
    fn activations_have_their_closed_forms() {
        let x = [-2.0, 0.0, 3.0];
        assert_eq!(run(Elementwise::Relu, &x), [0.0, 0.0, 3.0]);
        assert_eq!(run(Elementwise::LeakyRelu { alpha: 0.5 }, &x), [-1.0, 0.0, 3.0]);
        assert_eq!(run(Elementwise::Elu { alpha: 2.0 }, &x), [2.0 * (math::exp(-2.0) - 1.0), 0.0, 3.0]);
        assert_eq!(run(Elementwise::Clip { low: -1.0, high: 2.0 }, &x), [-1.0, 0.0, 2.0]);
        assert_eq!(run(Elementwise::Square, &x), [4.0, 0.0, 9.0]);
        assert_eq!(run(Elementwise::Truncate, &[-1.7, 1.7]), [-1.0, 1.0]);
        assert_eq!(run(Elementwise::Truth, &x), [1.0, 0.0, 1.0]);
    }

    #[test]
    fn nan_passes_through() {
        for function in [Elementwise::Relu, Elementwise::Clip { low: 0.0, high: 1.0 }, Elementwise::Elu { alpha: 1.0 }]
        {
            assert!(run(function, &[f32::NAN])[0].is_nan());
        }
    }
}
