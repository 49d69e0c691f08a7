//! Operators on each number by itself, such as activations.

use rten_onnx::onnx::DataType;

use super::{Element, Node, Reading, Tensor, math, one_result};

/// The operator that applies `function` to each number, and so makes numbers of the kind `element`.
fn each(element: Element, function: impl Fn(f32) -> f32 + Send + Sync + 'static) -> Reading {
    one_result(element, move |x, _| {
        Ok(Tensor { shape: x.shape.clone(), values: x.values.iter().map(|&value| function(value)).collect() })
    })
}

/// The operator for a `function` of floats.
pub(super) fn on_floats(node: &Node, function: impl Fn(f32) -> f32 + Send + Sync + 'static) -> Reading {
    node.expect_floats()?;
    each(Element::Float, function)
}

/// The operator for a `function` that keeps the kind of number.
pub(super) fn on_all(node: &Node, function: impl Fn(f32) -> f32 + Send + Sync + 'static) -> Reading {
    each(node.element(), function)
}

pub(super) fn elu(node: &Node) -> Reading {
    let alpha = node.float("alpha", 1.0)?;
    on_floats(node, move |x| if x < 0.0 { alpha * (math::exp(x) - 1.0) } else { x })
}

pub(super) fn leaky_relu(node: &Node) -> Reading {
    let alpha = node.float("alpha", 0.01)?;
    on_floats(node, move |x| if x < 0.0 { alpha * x } else { x })
}

pub(super) fn clip(node: &Node) -> Reading {
    let low = node.number(1, "min")?.unwrap_or(f32::NEG_INFINITY);
    let high = node.number(2, "max")?.unwrap_or(f32::INFINITY);
    on_all(node, move |x| {
        let raised = if x < low { low } else { x };
        if raised > high { high } else { raised }
    })
}

pub(super) fn pow(node: &Node) -> Reading {
    match node.number(1, "exponent")? {
        Some(2.0) => on_all(node, |x| x * x),
        Some(0.5) => on_floats(node, f32::sqrt),
        Some(1.0) => on_floats(node, |x| x),
        other => Err(format!("its exponent is {}, and only 0.5, 1 and 2 are supported", other.unwrap_or(0.0))),
    }
}

pub(super) fn cast(node: &Node) -> Reading {
    // Matters for 8-bit floats only.
    node.int("saturate", 1)?;
    let code = DataType(i32::try_from(node.int("to", 0)?).unwrap_or(0));
    let element = Element::of(code)?;
    match element {
        Element::Float => each(element, |x| x),
        Element::Integer if code == DataType::BOOL => each(element, |x| f32::from(x != 0.0)),
        Element::Integer => each(element, f32::trunc),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    fn run(name: &str, attributes: &[(&str, &[f32])], inputs: &[&[f32]]) -> Vec<f32> {
        let tensor = |values: &&[f32]| Tensor { shape: vec![values.len()], values: values.to_vec() };
        let inputs: Vec<_> = inputs.iter().map(tensor).collect();
        testing::run(name, attributes, Element::Float, &inputs).unwrap().values
    }

    #[test]
    fn activations_have_their_closed_forms() {
        let x = &[-2.0, 0.0, 3.0];
        assert_eq!(run("Relu", &[], &[x]), [0.0, 0.0, 3.0]);
        assert_eq!(run("LeakyRelu", &[("alpha", &[0.5])], &[x]), [-1.0, 0.0, 3.0]);
        assert_eq!(run("Elu", &[("alpha", &[2.0])], &[x]), [2.0 * (math::exp(-2.0) - 1.0), 0.0, 3.0]);
        assert_eq!(run("Clip", &[], &[x, &[-1.0], &[2.0]]), [-1.0, 0.0, 2.0]);
        assert_eq!(run("Pow", &[], &[x, &[2.0]]), [4.0, 0.0, 9.0]);
        assert_eq!(run("Cast", &[("to", &[DataType::INT32.0 as f32])], &[&[-1.7, 1.7]]), [-1.0, 1.0]);
        assert_eq!(run("Cast", &[("to", &[DataType::BOOL.0 as f32])], &[x]), [1.0, 0.0, 1.0]);
    }

    #[test]
    fn nan_passes_through() {
        let x = &[f32::NAN];
        for result in [run("Relu", &[], &[x]), run("Clip", &[], &[x, &[0.0], &[1.0]]), run("Elu", &[], &[x])] {
            assert!(result[0].is_nan());
        }
    }
}
