//! Operators on pairs of numbers, with broadcasting.

use super::super::tensor::broadcast_shape;
use super::{Element, Node, Operator, Reading, Tensor};

/// A function of two numbers, applied to the tensors of a node from the first to the last.
#[derive(Clone, Copy, Debug)]
enum Pair {
    Add,
    Div,
    /// Division that drops the fraction.
    DivIntegers,
    Max,
    Min,
    Mul,
    Sub,
}

impl Operator for Pair {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let mut operands = inputs.iter().flatten();
        let mut result = (*operands.next().ok_or("it has no inputs")?).clone();
        for other in operands {
            result = match self {
                Self::Add => combine(result, other, |a, b| a + b),
                Self::Div => combine(result, other, |a, b| a / b),
                Self::DivIntegers => combine(result, other, |a, b| (a / b).trunc()),
                Self::Max => combine(result, other, |a, b| if a > b || a.is_nan() { a } else { b }),
                Self::Min => combine(result, other, |a, b| if a < b || a.is_nan() { a } else { b }),
                Self::Mul => combine(result, other, |a, b| a * b),
                Self::Sub => combine(result, other, |a, b| a - b),
            }?;
        }
        Ok(vec![result])
    }
}

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

/// The operator for the function `pair`, whose inputs must hold the same kind of number.
fn same(node: &Node, pair: Pair) -> Reading {
    let element = node.element();
    match node.inputs.iter().all(|operand| operand.is_some_and(|operand| operand.element == element)) {
        true => Ok((Box::new(pair), element)),
        false => Err("its inputs must hold the same kind of number".into()),
    }
}

pub(super) fn add(node: &Node) -> Reading {
    same(node, Pair::Add)
}

pub(super) fn div(node: &Node) -> Reading {
    same(node, if node.element() == Element::Integer { Pair::DivIntegers } else { Pair::Div })
}

pub(super) fn max(node: &Node) -> Reading {
    same(node, Pair::Max)
}

pub(super) fn min(node: &Node) -> Reading {
    same(node, Pair::Min)
}

pub(super) fn mul(node: &Node) -> Reading {
    same(node, Pair::Mul)
}

pub(super) fn sub(node: &Node) -> Reading {
    same(node, Pair::Sub)
}

#[cfg(test)]
mod tests {
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
            let result = Pair::Sub.run(&[Some(&full), Some(&other)]).unwrap().remove(0);
            assert_eq!(result, Tensor { shape, values: expected.clone() });
            let turned = Pair::Sub.run(&[Some(&other), Some(&full)]).unwrap().remove(0);
            assert_eq!(turned.values, expected.iter().map(|value| -value).collect::<Vec<_>>());
        }
    }

    #[test]
    fn largest_and_smallest_of_several_keep_nan() {
        let [a, b, c] = [[1.0, f32::NAN], [3.0, 0.0], [2.0, 0.0]].map(|values| tensor(&[2], &values));
        let inputs = [Some(&a), Some(&b), Some(&c)];
        let largest = Pair::Max.run(&inputs).unwrap().remove(0);
        assert_eq!(largest.values[0], 3.0);
        assert!(largest.values[1].is_nan());
        let smallest = Pair::Min.run(&[Some(&b), Some(&a)]).unwrap().remove(0);
        assert_eq!(smallest.values[0], 1.0);
        assert!(smallest.values[1].is_nan());
    }

    #[test]
    fn integers_divide_towards_zero() {
        let (a, b) = (tensor(&[2], &[7.0, -7.0]), tensor(&[1], &[2.0]));
        assert_eq!(Pair::DivIntegers.run(&[Some(&a), Some(&b)]).unwrap()[0].values, [3.0, -3.0]);
    }
}
