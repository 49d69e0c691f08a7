//! Operators that keep the numbers and change their shape or order, or make tensors of a given shape.

use super::super::{
    constants::Constant,
    tensor::{Offsets, axis_of, broadcast_shape, count, sizes_of, strides},
};
use super::{Element, Node, Operator, Reading, Tensor, input};

/// An operator on the shape of a tensor.
#[derive(Debug)]
enum Layout {
    Same,
    /// The shape comes from the second input; with `zeros`, a size of 0 is one instead of a copy of the input's size.
    Reshape {
        zeros: bool,
    },
    Flatten {
        axis: i64,
    },
    /// Without the dimensions at the axes, or without all of size 1.
    Squeeze(Option<Vec<i64>>),
    /// With new dimensions of size 1 at the axes.
    Unsqueeze(Vec<i64>),
    /// In another order of dimensions; reversed by default.
    Transpose(Option<Vec<i64>>),
    /// Broadcast with the shape in the second input.
    Expand,
    /// The sizes of some of the dimensions.
    Shape {
        start: i64,
        end: i64,
    },
    /// One number repeated in the shape given.
    Filled(f32),
}

impl Operator for Layout {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let result = match self {
            Self::Same => x.clone(),
            Self::Reshape { zeros } => x.reshaped(reshaped(x, &input(inputs, 1)?.integers()?, *zeros)?)?,
            Self::Flatten { axis } => {
                let rank = x.shape.len();
                let axis = if *axis == rank as i64 { rank } else { axis_of(*axis, rank)? };
                let (rows, columns) = x.shape.split_at(axis);
                x.reshaped(vec![rows.iter().product(), columns.iter().product()])?
            }
            Self::Squeeze(axes) => x.reshaped(squeezed(x, axes.as_deref())?)?,
            Self::Unsqueeze(axes) => x.reshaped(unsqueezed(x, axes)?)?,
            Self::Transpose(order) => transposed(x, order.as_deref())?,
            Self::Expand => x.broadcast_to(&broadcast_shape(&x.shape, &sizes_of(&input(inputs, 1)?.integers()?)?)?)?,
            Self::Shape { start, end } => {
                let rank = x.shape.len() as i64;
                let bound = |at: i64| (if at < 0 { at.saturating_add(rank) } else { at }).clamp(0, rank) as usize;
                let sizes = x.shape.get(bound(*start)..bound(*end)).unwrap_or_default();
                Tensor { shape: vec![sizes.len()], values: sizes.iter().map(|&size| size as f32).collect() }
            }
            Self::Filled(value) => {
                let shape = sizes_of(&x.integers()?)?;
                let values = vec![*value; count(&shape)?];
                Tensor { shape, values }
            }
        };
        Ok(vec![result])
    }
}

/// The shape that `sizes` ask of `x`, where -1 stands for what is left and 0, without `zeros`, for the size of `x`.
fn reshaped(x: &Tensor, sizes: &[i64], zeros: bool) -> Result<Vec<usize>, String> {
    let mut shape = Vec::with_capacity(sizes.len());
    let mut rest = None;
    for (axis, &size) in sizes.iter().enumerate() {
        shape.push(match size {
            -1 if rest.replace(axis).is_some() => return Err(format!("shape {sizes:?} leaves two sizes open")),
            -1 => 1,
            0 if !zeros => *x.shape.get(axis).ok_or_else(|| format!("shape {sizes:?} copies a missing size"))?,
            _ => usize::try_from(size).map_err(|_| format!("{size} is not a size"))?,
        });
    }
    if let Some(axis) = rest {
        shape[axis] = x.values.len() / count(&shape)?.max(1);
    }
    Ok(shape)
}

/// The shape of `x` without the dimensions of size 1 at `axes`.
fn squeezed(x: &Tensor, axes: Option<&[i64]>) -> Result<Vec<usize>, String> {
    let mut dropped: Vec<bool> = x.shape.iter().map(|&size| axes.is_none() && size == 1).collect();
    for &axis in axes.unwrap_or_default() {
        let axis = axis_of(axis, x.shape.len())?;
        if x.shape[axis] != 1 {
            return Err(format!("dimension {axis} of shape {:?} is not 1", x.shape));
        }
        dropped[axis] = true;
    }
    Ok(x.shape.iter().zip(dropped).filter(|(_, dropped)| !dropped).map(|(&size, _)| size).collect())
}

/// The shape of `x` with dimensions of size 1 at `axes` of the result.
fn unsqueezed(x: &Tensor, axes: &[i64]) -> Result<Vec<usize>, String> {
    let rank = x.shape.len() + axes.len();
    count(&vec![1; rank])?;
    let mut is_new = vec![false; rank];
    for &axis in axes {
        let axis = axis_of(axis, rank)?;
        if std::mem::replace(&mut is_new[axis], true) {
            return Err(format!("axes {axes:?} repeat"));
        }
    }
    let mut sizes = x.shape.iter().copied();
    Ok(is_new.into_iter().map(|is_new| if is_new { 1 } else { sizes.next().unwrap_or(1) }).collect())
}

/// The tensor `x` with its dimensions in the `order` given.
fn transposed(x: &Tensor, order: Option<&[i64]>) -> Result<Tensor, String> {
    let rank = x.shape.len();
    let order: Vec<usize> = match order {
        Some(order) => order.iter().map(|&axis| axis_of(axis, rank)).collect::<Result<_, _>>()?,
        None => (0..rank).rev().collect(),
    };
    if order.len() != rank || (0..rank).any(|axis| !order.contains(&axis)) {
        return Err(format!("{order:?} is no order of {rank} dimensions"));
    }
    let own = strides(&x.shape);
    let shape: Vec<usize> = order.iter().map(|&axis| x.shape[axis]).collect();
    let strides: Vec<isize> = order.iter().map(|&axis| own[axis]).collect();
    let values = Offsets::new(&shape, &strides, 0, x.values.len()).map(|offset| x.values[offset]).collect();
    Ok(Tensor { shape, values })
}

/// The operator `layout`, which keeps the kind of number.
fn same(node: &Node, layout: Layout) -> Reading {
    Ok((Box::new(layout), node.element()))
}

/// Checks that the second input holds integers, as shapes do.
fn expect_shape(node: &Node) -> Result<(), String> {
    match node.operand(1).is_some_and(|operand| operand.element == Element::Integer) {
        true => Ok(()),
        false => Err("its input `shape` must be integers".into()),
    }
}

pub(super) fn identity(node: &Node) -> Reading {
    same(node, Layout::Same)
}

pub(super) fn dropout(node: &Node) -> Reading {
    // Both matter in training only.
    node.int("seed", 0)?;
    node.float("ratio", 0.5)?;
    node.number(1, "ratio")?;
    match node.number(2, "training_mode")? {
        Some(mode) if mode != 0.0 => Err("its input `training_mode` is set: export the model for inference".into()),
        _ => same(node, Layout::Same),
    }
}

pub(super) fn reshape(node: &Node) -> Reading {
    expect_shape(node)?;
    same(node, Layout::Reshape { zeros: node.flag("allowzero", false)? })
}

pub(super) fn flatten(node: &Node) -> Reading {
    same(node, Layout::Flatten { axis: node.int("axis", 1)? })
}

pub(super) fn squeeze(node: &Node) -> Reading {
    same(node, Layout::Squeeze(node.axes(1, 13)?))
}

pub(super) fn unsqueeze(node: &Node) -> Reading {
    same(node, Layout::Unsqueeze(node.axes(1, 13)?.ok_or("its axes are missing")?))
}

pub(super) fn transpose(node: &Node) -> Reading {
    same(node, Layout::Transpose(node.ints("perm")?))
}

pub(super) fn expand(node: &Node) -> Reading {
    expect_shape(node)?;
    same(node, Layout::Expand)
}

pub(super) fn shape(node: &Node) -> Reading {
    let layout = Layout::Shape { start: node.int("start", 0)?, end: node.int("end", i64::MAX)? };
    Ok((Box::new(layout), Element::Integer))
}

pub(super) fn constant_of_shape(node: &Node) -> Reading {
    let value = match node.tensor("value")? {
        Some(value) => value,
        None => Constant::floats(vec![1], vec![0.0])?,
    };
    value.check_operand()?;
    Ok((Box::new(Layout::Filled(value.tensor.values[0])), value.element))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(layout: Layout, shape: &[usize]) -> Result<Tensor, String> {
        let numbers: usize = shape.iter().product();
        let x = Tensor { shape: shape.to_vec(), values: (0..numbers).map(|value| value as f32).collect() };
        layout.run(&[Some(&x)]).map(|mut results| results.remove(0))
    }

    fn shaped(layout: Layout, shape: &[usize]) -> Vec<usize> {
        run(layout, shape).unwrap().shape
    }

    #[test]
    fn reshaping_copies_and_completes_sizes() {
        let x = Tensor { shape: vec![2, 3, 4], values: vec![0.0; 24] };
        assert_eq!(reshaped(&x, &[0, -1], false), Ok(vec![2, 12]));
        assert_eq!(reshaped(&x, &[24], false), Ok(vec![24]));
        assert!(reshaped(&x, &[-1, -1], false).is_err());
        assert!(reshaped(&x, &[-2], false).is_err());
        assert!(reshaped(&x, &[2, 3, 4, 0], false).is_err());
        assert!(x.reshaped(vec![5]).is_err());
        assert!(x.reshaped(reshaped(&x, &[7, -1], false).unwrap()).is_err());
    }

    #[test]
    fn dimensions_are_dropped_and_added() {
        assert_eq!(shaped(Layout::Squeeze(None), &[1, 2, 1]), [2]);
        assert_eq!(shaped(Layout::Squeeze(Some(vec![-1])), &[1, 2, 1]), [1, 2]);
        assert!(run(Layout::Squeeze(Some(vec![1])), &[1, 2]).is_err());
        assert_eq!(shaped(Layout::Unsqueeze(vec![0, -1]), &[2]), [1, 2, 1]);
        assert!(run(Layout::Unsqueeze(vec![0, 0]), &[2]).is_err());
        assert_eq!(shaped(Layout::Flatten { axis: 1 }, &[2, 3, 4]), [2, 12]);
        assert_eq!(shaped(Layout::Flatten { axis: 0 }, &[2, 3]), [1, 6]);
        assert_eq!(shaped(Layout::Flatten { axis: 2 }, &[2, 3]), [6, 1]);
    }

    #[test]
    fn transposing_reorders_numbers() {
        let turned = run(Layout::Transpose(None), &[2, 3]).unwrap();
        assert_eq!(turned, Tensor { shape: vec![3, 2], values: vec![0.0, 3.0, 1.0, 4.0, 2.0, 5.0] });
        assert_eq!(shaped(Layout::Transpose(Some(vec![1, 0, 2])), &[2, 3, 4]), [3, 2, 4]);
        assert!(run(Layout::Transpose(Some(vec![0, 0])), &[2, 3]).is_err());
    }

    #[test]
    fn shapes_become_tensors_and_back() {
        let sizes = run(Layout::Shape { start: 1, end: i64::MAX }, &[2, 3, 4]).unwrap();
        assert_eq!(sizes, Tensor { shape: vec![2], values: vec![3.0, 4.0] });
        let filled = Layout::Filled(7.0).run(&[Some(&sizes)]).unwrap().remove(0);
        assert_eq!(filled, Tensor { shape: vec![3, 4], values: vec![7.0; 12] });
        let wide = Layout::Expand.run(&[Some(&Tensor { shape: vec![1], values: vec![2.0] }), Some(&sizes)]).unwrap();
        assert_eq!(wide[0], Tensor { shape: vec![3, 4], values: vec![2.0; 12] });
        assert_eq!(shaped(Layout::Shape { start: 3, end: -3 }, &[2, 3, 4]), [0]);
    }
}
