//! Operators on pairs of numbers, with broadcasting.

use super::super::tensor::broadcast_shape;
use super::{Element, Node, Reading, Tensor, one_result};

/// The tensor of `function` of each pair of numbers of `a` and `b`.
fn combine(mut a: Tensor, b: &Tensor, function: impl Fn(f32, f32) -> f32) -> Result<Tensor, String> {
    let shape = broadcast_shape(&a.shape, &b.shape)?;
    if a.shape != shape {
        a = a.broadcast_to(&shape)?;
    }
    if let [other] = b.values[..] {
        a.values.iter_mut().for_each(|value| *value = function(*value, other));
    } else if shape.ends_with(&b.shape) {
        for row in a.values.chunks_exact_mut(b.values.len().max(1)) {
            row.iter_mut().zip(&b.values).for_each(|(value, &other)| *value = function(*value, other));
        }
    } else {
        let b = b.broadcast_to(&shape)?;
        a.values.iter_mut().zip(&b.values).for_each(|(value, &other)| *value = function(*value, other));
    }
    Ok(a)
}

/// The operator that applies `function` to the tensors of `node` from the first to the last.
///
/// They must hold the same kind of number.
pub(super) fn fold(node: &Node, function: impl Fn(f32, f32) -> f32 + Send + Sync + 'static) -> Reading {
    let element = node.element();
    if !node.inputs.iter().all(|operand| operand.is_some_and(|operand| operand.element == element)) {
        return Err("its inputs must hold the same kind of number".into());
    }
    one_result(element, move |first, inputs| {
        inputs[1..].iter().flatten().try_fold(first.clone(), |result, other| combine(result, other, &function))
    })
}

pub(super) fn div(node: &Node) -> Reading {
    match node.element() {
        Element::Float => fold(node, |a, b| a / b),
        Element::Integer => fold(node, |a, b| (a / b).trunc()),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::run;
    use super::*;

    fn tensor(shape: &[usize], values: &[f32]) -> Tensor {
        Tensor { shape: shape.to_vec(), values: values.to_vec() }
    }

    #[test]
    fn every_form_of_broadcasting_gives_the_numbers_of_the_full_one() {
        let full = tensor(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        for other in [
            tensor(&[], &[10.0]),
            tensor(&[3], &[10.0, 20.0, 30.0]),
            tensor(&[2, 1], &[10.0, 20.0]),
            tensor(&[2, 1, 1], &[10.0, 20.0]),
        ] {
            let shape = broadcast_shape(&full.shape, &other.shape).unwrap();
            let wide = (full.broadcast_to(&shape).unwrap(), other.broadcast_to(&shape).unwrap());
            let expected: Vec<f32> = wide.0.values.iter().zip(&wide.1.values).map(|(a, b)| a - b).collect();
            let result = run("Sub", &[], Element::Float, &[full.clone(), other.clone()]).unwrap();
            assert_eq!(result, Tensor { shape, values: expected.clone() });
            let turned = run("Sub", &[], Element::Float, &[other, full.clone()]).unwrap();
            assert_eq!(turned.values, expected.iter().map(|value| -value).collect::<Vec<_>>());
        }
    }

    #[test]
    fn largest_and_smallest_of_several_keep_nan() {
        let [a, b, c] = [[1.0, f32::NAN], [3.0, 0.0], [2.0, 0.0]].map(|values| tensor(&[2], &values));
        let largest = run("Max", &[], Element::Float, &[a.clone(), b.clone(), c]).unwrap();
        assert_eq!(largest.values[0], 3.0);
        assert!(largest.values[1].is_nan());
        let smallest = run("Min", &[], Element::Float, &[b, a]).unwrap();
        assert_eq!(smallest.values[0], 1.0);
        assert!(smallest.values[1].is_nan());
    }

    #[test]
    fn integers_divide_towards_zero() {
        let inputs = [tensor(&[2], &[7.0, -7.0]), tensor(&[1], &[2.0])];
        assert_eq!(run("Div", &[], Element::Integer, &inputs).unwrap().values, [3.0, -3.0]);
    }
}
