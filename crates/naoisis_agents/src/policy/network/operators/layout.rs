//! Operators that keep the numbers and change their shape or order, or make tensors of a given shape.

use super::super::{
    constants::Constant,
    tensor::{Offsets, axis_of, broadcast_shape, count, sizes_of, strides},
};
use super::{Element, Node, Reading, Tensor, input, one_result};

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

/// The shape of `x` without the dimensions of size 1 at `axes`, or without all of size 1.
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

/// The tensor `x` with its dimensions in the `order` given; reversed by default.
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

/// Checks that the second input holds integers, as shapes do.
fn expect_shape(node: &Node) -> Result<(), String> {
    match node.operand(1).is_some_and(|operand| operand.element == Element::Integer) {
        true => Ok(()),
        false => Err("its input `shape` must be integers".into()),
    }
}

pub(super) fn identity(node: &Node) -> Reading {
    one_result(node.element(), |x, _| Ok(x.clone()))
}

pub(super) fn dropout(node: &Node) -> Reading {
    // Both matter in training only.
    node.int("seed", 0)?;
    node.float("ratio", 0.5)?;
    node.number(1, "ratio")?;
    match node.number(2, "training_mode")? {
        Some(mode) if mode != 0.0 => Err("its input `training_mode` is set: export the model for inference".into()),
        _ => identity(node),
    }
}

pub(super) fn reshape(node: &Node) -> Reading {
    expect_shape(node)?;
    let zeros = node.flag("allowzero", false)?;
    one_result(node.element(), move |x, inputs| {
        let sizes = input(inputs, 1)?.integers()?;
        x.reshaped(reshaped(x, &sizes, zeros)?)
    })
}

pub(super) fn flatten(node: &Node) -> Reading {
    let axis = node.int("axis", 1)?;
    one_result(node.element(), move |x, _| {
        let rank = x.shape.len();
        let axis = if axis == rank as i64 { rank } else { axis_of(axis, rank)? };
        let (rows, columns) = x.shape.split_at(axis);
        x.reshaped(vec![rows.iter().product(), columns.iter().product()])
    })
}

pub(super) fn squeeze(node: &Node) -> Reading {
    let axes = node.axes(1, 13)?;
    one_result(node.element(), move |x, _| x.reshaped(squeezed(x, axes.as_deref())?))
}

pub(super) fn unsqueeze(node: &Node) -> Reading {
    let axes = node.axes(1, 13)?.ok_or("its axes are missing")?;
    one_result(node.element(), move |x, _| x.reshaped(unsqueezed(x, &axes)?))
}

pub(super) fn transpose(node: &Node) -> Reading {
    let order = node.ints("perm")?;
    one_result(node.element(), move |x, _| transposed(x, order.as_deref()))
}

pub(super) fn expand(node: &Node) -> Reading {
    expect_shape(node)?;
    one_result(node.element(), |x, inputs| {
        let shape = sizes_of(&input(inputs, 1)?.integers()?)?;
        x.broadcast_to(&broadcast_shape(&x.shape, &shape)?)
    })
}

pub(super) fn shape(node: &Node) -> Reading {
    let (start, end) = (node.int("start", 0)?, node.int("end", i64::MAX)?);
    one_result(Element::Integer, move |x, _| {
        let rank = x.shape.len() as i64;
        let bound = |at: i64| (if at < 0 { at.saturating_add(rank) } else { at }).clamp(0, rank) as usize;
        let sizes = x.shape.get(bound(start)..bound(end)).unwrap_or_default();
        Ok(Tensor { shape: vec![sizes.len()], values: sizes.iter().map(|&size| size as f32).collect() })
    })
}

pub(super) fn constant_of_shape(node: &Node) -> Reading {
    let value = match node.tensor("value")? {
        Some(value) => value,
        None => Constant::floats(vec![1], vec![0.0])?,
    };
    value.check_operand()?;
    let number = value.tensor.values[0];
    one_result(value.element, move |sizes, _| {
        let shape = sizes_of(&sizes.integers()?)?;
        let values = vec![number; count(&shape)?];
        Ok(Tensor { shape, values })
    })
}

#[cfg(test)]
mod tests {
    use super::super::testing;
    use super::*;

    fn run(name: &str, attributes: &[(&str, &[f32])], shape: &[usize]) -> Result<Tensor, String> {
        let numbers: usize = shape.iter().product();
        let x = Tensor { shape: shape.to_vec(), values: (0..numbers).map(|value| value as f32).collect() };
        testing::run(name, attributes, Element::Integer, &[x])
    }

    fn shaped(name: &str, attributes: &[(&str, &[f32])], shape: &[usize]) -> Vec<usize> {
        run(name, attributes, shape).unwrap().shape
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
        assert_eq!(shaped("Squeeze", &[], &[1, 2, 1]), [2]);
        assert_eq!(shaped("Squeeze", &[("axes", &[-1.0])], &[1, 2, 1]), [1, 2]);
        assert!(run("Squeeze", &[("axes", &[1.0])], &[1, 2]).is_err());
        assert_eq!(shaped("Unsqueeze", &[("axes", &[0.0, -1.0])], &[2]), [1, 2, 1]);
        assert!(run("Unsqueeze", &[("axes", &[0.0, 0.0])], &[2]).is_err());
        assert_eq!(shaped("Flatten", &[("axis", &[1.0])], &[2, 3, 4]), [2, 12]);
        assert_eq!(shaped("Flatten", &[("axis", &[0.0])], &[2, 3]), [1, 6]);
        assert_eq!(shaped("Flatten", &[("axis", &[2.0])], &[2, 3]), [6, 1]);
    }

    #[test]
    fn transposing_reorders_numbers() {
        let turned = run("Transpose", &[], &[2, 3]).unwrap();
        assert_eq!(turned, Tensor { shape: vec![3, 2], values: vec![0.0, 3.0, 1.0, 4.0, 2.0, 5.0] });
        assert_eq!(shaped("Transpose", &[("perm", &[1.0, 0.0, 2.0])], &[2, 3, 4]), [3, 2, 4]);
        assert!(run("Transpose", &[("perm", &[0.0, 0.0])], &[2, 3]).is_err());
    }

    #[test]
    fn shapes_become_tensors_and_back() {
        let sizes = run("Shape", &[("start", &[1.0])], &[2, 3, 4]).unwrap();
        assert_eq!(sizes, Tensor { shape: vec![2], values: vec![3.0, 4.0] });
        let two = Tensor { shape: vec![1], values: vec![2.0] };
        let wide = testing::run("Expand", &[], Element::Integer, &[two, sizes.clone()]).unwrap();
        assert_eq!(wide, Tensor { shape: vec![3, 4], values: vec![2.0; 12] });
        let filled = testing::run("ConstantOfShape", &[("value", &[7.0])], Element::Integer, &[sizes]).unwrap();
        assert_eq!(filled, Tensor { shape: vec![3, 4], values: vec![7.0; 12] });
        assert_eq!(shaped("Shape", &[("start", &[3.0]), ("end", &[-3.0])], &[2, 3, 4]), [0]);
    }
}
