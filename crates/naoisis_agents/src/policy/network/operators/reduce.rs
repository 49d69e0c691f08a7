//! Sums, means and the position of the largest number along axes.

use super::super::tensor::{Offsets, axis_of, count, strides};
use super::{Element, Node, Operator, Reading, Tensor, input};

/// A sum or mean along axes, added in row-major order.
#[derive(Debug)]
struct Reduce {
    /// `None` for all axes.
    axes: Option<Vec<i64>>,
    keep: bool,
    mean: bool,
}

impl Operator for Reduce {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let mut reduced = vec![self.axes.is_none(); x.shape.len()];
        for &axis in self.axes.as_deref().unwrap_or_default() {
            reduced[axis_of(axis, x.shape.len())?] = true;
        }
        let kept: Vec<usize> = x.shape.iter().zip(&reduced).map(|(&size, &gone)| if gone { 1 } else { size }).collect();
        let mut steps = strides(&kept);
        steps.iter_mut().zip(&reduced).filter(|(_, gone)| **gone).for_each(|(step, _)| *step = 0);
        let mut values = vec![0.0; count(&kept)?];
        for (&value, offset) in x.values.iter().zip(Offsets::new(&x.shape, &steps, 0, x.values.len())) {
            values[offset] += value;
        }
        if self.mean {
            let terms = (x.values.len() / values.len().max(1)) as f32;
            values.iter_mut().for_each(|value| *value /= terms);
        }
        let shape = kept.iter().zip(&reduced).filter(|(_, gone)| self.keep || !**gone).map(|(&size, _)| size).collect();
        Ok(vec![Tensor { shape, values }])
    }
}

/// The position of the largest number along an axis.
#[derive(Debug)]
struct ArgMax {
    axis: i64,
    keep: bool,
    /// Whether the last of several equal numbers counts instead of the first.
    last: bool,
}

impl Operator for ArgMax {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let axis = axis_of(self.axis, x.shape.len())?;
        let (outer, from) = x.shape.split_at(axis);
        let (length, inner) = (from[0], from[1..].iter().product::<usize>());
        let mut values = Vec::with_capacity(x.values.len() / length.max(1));
        for block in x.values.chunks_exact(length * inner) {
            for column in 0..inner {
                let value = |index: usize| block[index * inner + column];
                let better = |at: usize, best: usize| value(at) > value(best) || self.last && value(at) == value(best);
                let best = (0..length).fold(0, |best, index| if better(index, best) { index } else { best });
                values.push(best as f32);
            }
        }
        let kept = if self.keep { &[1][..] } else { &[] };
        Ok(vec![Tensor { shape: [outer, kept, &from[1..]].concat(), values }])
    }
}

/// The sum or `mean` that `node` asks for, whose axes are an input from version `since` on.
fn reduce(node: &Node, mean: bool, since: i64) -> Reading {
    let nothing = node.flag("noop_with_empty_axes", false)?;
    let axes = node.axes(1, since)?.filter(|axes| !axes.is_empty()).or(nothing.then(Vec::new));
    let keep = node.flag("keepdims", true)?;
    Ok((Box::new(Reduce { axes, keep, mean }), node.element()))
}

pub(super) fn mean(node: &Node) -> Reading {
    node.expect_floats()?;
    reduce(node, true, 18)
}

pub(super) fn sum(node: &Node) -> Reading {
    reduce(node, false, 13)
}

pub(super) fn arg_max(node: &Node) -> Reading {
    let (axis, keep) = (node.int("axis", 0)?, node.flag("keepdims", true)?);
    let last = node.flag("select_last_index", false)?;
    Ok((Box::new(ArgMax { axis, keep, last }), Element::Integer))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn x() -> Tensor {
        Tensor { shape: vec![2, 3], values: vec![1.0, 5.0, 5.0, 4.0, 3.0, 2.0] }
    }

    #[test]
    fn sums_and_means_go_along_the_axes() {
        let run = |axes: Option<&[i64]>, keep, mean| {
            Reduce { axes: axes.map(<[i64]>::to_vec), keep, mean }.run(&[Some(&x())]).unwrap().remove(0)
        };
        assert_eq!(run(Some(&[-1]), false, false), Tensor { shape: vec![2], values: vec![11.0, 9.0] });
        assert_eq!(run(Some(&[0]), true, true), Tensor { shape: vec![1, 3], values: vec![2.5, 4.0, 3.5] });
        assert_eq!(run(None, false, false), Tensor { shape: vec![], values: vec![20.0] });
        assert_eq!(run(Some(&[]), true, false), x());
        assert!(Reduce { axes: Some(vec![2]), keep: true, mean: false }.run(&[Some(&x())]).is_err());
    }

    #[test]
    fn the_first_or_last_of_the_largest_is_found() {
        let run = |axis, keep, last| ArgMax { axis, keep, last }.run(&[Some(&x())]).unwrap().remove(0);
        assert_eq!(run(1, true, false), Tensor { shape: vec![2, 1], values: vec![1.0, 0.0] });
        assert_eq!(run(1, false, true), Tensor { shape: vec![2], values: vec![2.0, 0.0] });
        assert_eq!(run(0, false, false).values, [1.0, 0.0, 0.0]);
    }
}
