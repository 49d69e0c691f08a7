//! Operators that join tensors and take parts of them.

use super::super::tensor::{MOST_DIMENSIONS, Offsets, axis_of, count, sizes_of, strides};
use super::{Node, Operator, Reading, Tensor, input};

/// Tensors joined along an axis.
#[derive(Debug)]
struct Concat {
    axis: i64,
}

impl Operator for Concat {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let first = input(inputs, 0)?;
        let axis = axis_of(self.axis, first.shape.len())?;
        let mut shape = first.shape.clone();
        shape[axis] = 0;
        for other in inputs.iter().flatten() {
            let fits = other.shape.len() == shape.len()
                && other.shape.iter().zip(&first.shape).enumerate().all(|(at, (a, b))| at == axis || a == b);
            if !fits {
                return Err(format!("shapes {:?} and {:?} do not join along axis {axis}", first.shape, other.shape));
            }
            shape[axis] += other.shape[axis];
        }
        let mut values = Vec::with_capacity(count(&shape)?);
        for block in 0..shape[..axis].iter().product() {
            for other in inputs.iter().flatten() {
                let length = other.shape[axis..].iter().product::<usize>();
                values.extend_from_slice(&other.values[block * length..][..length]);
            }
        }
        Ok(vec![Tensor { shape, values }])
    }
}

/// A tensor cut along an axis, into parts of given sizes or into a number of equal ones.
#[derive(Debug)]
struct Split {
    axis: i64,
    sizes: Option<Vec<usize>>,
    parts: usize,
}

impl Operator for Split {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let axis = axis_of(self.axis, x.shape.len())?;
        let whole = x.shape[axis];
        let sizes = match &self.sizes {
            Some(sizes) => sizes.clone(),
            None => {
                // The last part is smaller if the parts cannot be equal.
                let size = whole.div_ceil(self.parts);
                (0..self.parts).map(|part| whole.saturating_sub(part * size).min(size)).collect()
            }
        };
        if sizes.iter().try_fold(0_usize, |sum, &size| sum.checked_add(size)) != Some(whole) {
            return Err(format!("parts of sizes {sizes:?} do not make up axis {axis} of shape {:?}", x.shape));
        }
        let inner = x.shape[axis + 1..].iter().product::<usize>();
        let mut start = 0;
        let part = |size: usize| {
            let rows = x.values.chunks_exact(whole * inner);
            let values = rows.flat_map(|row| &row[start * inner..(start + size) * inner]).copied().collect();
            start += size;
            let mut shape = x.shape.clone();
            shape[axis] = size;
            Tensor { shape, values }
        };
        Ok(sizes.into_iter().map(part).collect())
    }
}

/// A range along one axis.
#[derive(Debug)]
struct Range {
    axis: i64,
    start: i64,
    end: i64,
    step: i64,
}

/// A tensor's elements in ranges along some axes.
#[derive(Debug)]
struct Slice(Vec<Range>);

impl Operator for Slice {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let mut shape = x.shape.clone();
        let mut steps = strides(&shape);
        let mut offset = 0;
        for range in &self.0 {
            let axis = axis_of(range.axis, shape.len())?;
            let size = x.shape[axis] as i64;
            let from_front = |at: i64| if at < 0 { at.saturating_add(size) } else { at };
            let (low, high) = if range.step > 0 { (0, size) } else { (-1, size - 1) };
            let start = from_front(range.start).clamp(low.max(0), high);
            let end = from_front(range.end).clamp(low, high);
            let distance = if range.step > 0 { end - start } else { start - end };
            let length = distance.max(0) as u64;
            shape[axis] = length.div_ceil(range.step.unsigned_abs()) as usize;
            offset += start as usize * steps[axis] as usize;
            steps[axis] = steps[axis].saturating_mul(range.step as isize);
        }
        let numbers = count(&shape)?;
        let values = Offsets::new(&shape, &steps, offset, numbers).map(|offset| x.values[offset]).collect();
        Ok(vec![Tensor { shape, values }])
    }
}

/// The parts of a tensor at given indices along an axis.
#[derive(Debug)]
struct Gather {
    axis: i64,
    indices: Vec<i64>,
    /// The shape of the indices, which replaces the axis.
    shape: Vec<usize>,
}

impl Operator for Gather {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let x = input(inputs, 0)?;
        let axis = axis_of(self.axis, x.shape.len())?;
        let (outer, from) = x.shape.split_at(axis);
        let (whole, inner) = (from[0], from[1..].iter().product::<usize>());
        let shape = [outer, &self.shape, &from[1..]].concat();
        let mut values = Vec::with_capacity(count(&shape)?);
        for block in x.values.chunks_exact(whole * inner) {
            for &index in &self.indices {
                let index = axis_of(index, whole)
                    .map_err(|_| format!("index {index} does not exist along axis {axis} of shape {:?}", x.shape))?;
                values.extend_from_slice(&block[index * inner..][..inner]);
            }
        }
        Ok(vec![Tensor { shape, values }])
    }
}

pub(super) fn concat(node: &Node) -> Reading {
    let axis = node.int("axis", i64::MAX)?;
    match node.inputs.iter().all(|operand| operand.is_some_and(|operand| operand.element == node.element())) {
        true => Ok((Box::new(Concat { axis }), node.element())),
        false => Err("its inputs must hold the same kind of number".into()),
    }
}

pub(super) fn split(node: &Node) -> Reading {
    let sizes = if node.operator_set < 13 { node.ints("split")? } else { node.integers(1, "split")? };
    let sizes = sizes.as_deref().map(sizes_of).transpose()?;
    let parts = node.outputs();
    let named = node.int("num_outputs", parts as i64)?;
    if named != parts as i64 || sizes.as_ref().is_some_and(|sizes| sizes.len() != parts) {
        return Err(format!("it has {parts} outputs, which does not fit its parts"));
    }
    let axis = node.int("axis", 0)?;
    Ok((Box::new(Split { axis, sizes, parts }), node.element()))
}

pub(super) fn slice(node: &Node) -> Reading {
    let required = |index, name| node.integers(index, name)?.ok_or_else(|| format!("its input `{name}` is missing"));
    let (starts, ends) = (required(1, "starts")?, required(2, "ends")?);
    let axes = node.integers(3, "axes")?.unwrap_or_else(|| (0..starts.len() as i64).collect());
    let steps = node.integers(4, "steps")?.unwrap_or_else(|| vec![1; starts.len()]);
    if [ends.len(), axes.len(), steps.len()] != [starts.len(); 3] {
        return Err("its starts, ends, axes and steps differ in number".into());
    }
    if starts.len() > MOST_DIMENSIONS {
        return Err(format!("it has {} axes, and at most {MOST_DIMENSIONS} are supported", starts.len()));
    }
    if steps.contains(&0) {
        return Err("it has a step of 0".into());
    }
    if axes.iter().enumerate().any(|(at, axis)| axes[..at].contains(axis)) {
        return Err(format!("its axes {axes:?} repeat"));
    }
    let ranges = starts.iter().zip(&ends).zip(axes.iter().zip(&steps));
    let range = |((&start, &end), (&axis, &step))| Range { axis, start, end, step };
    Ok((Box::new(Slice(ranges.map(range).collect())), node.element()))
}

pub(super) fn gather(node: &Node) -> Reading {
    let indices = node.integers(1, "indices")?.ok_or("its input `indices` is missing")?;
    let shape = node.keep(1).map(|constant| constant.tensor.shape.clone()).unwrap_or_default();
    let axis = node.int("axis", 0)?;
    Ok((Box::new(Gather { axis, indices, shape }), node.element()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn counted(shape: &[usize]) -> Tensor {
        let numbers: usize = shape.iter().product();
        Tensor { shape: shape.to_vec(), values: (0..numbers).map(|value| value as f32).collect() }
    }

    fn slice(x: &Tensor, axis: i64, start: i64, end: i64, step: i64) -> Tensor {
        Slice(vec![Range { axis, start, end, step }]).run(&[Some(x)]).unwrap().remove(0)
    }

    #[test]
    fn slices_run_both_ways() {
        let x = counted(&[2, 3]);
        assert_eq!(slice(&x, -1, 1, i64::MAX, 1).values, [1.0, 2.0, 4.0, 5.0]);
        assert_eq!(slice(&x, 1, -1, i64::MIN, -2).values, [2.0, 0.0, 5.0, 3.0]);
        assert_eq!(slice(&x, 0, -1, 2, 1), Tensor { shape: vec![1, 3], values: vec![3.0, 4.0, 5.0] });
        assert!(slice(&x, 0, 5, 9, 1).values.is_empty());
        assert!(slice(&x, 0, 0, i64::MIN, i64::MIN).values.len() == 3);
    }

    #[test]
    fn gathering_replaces_the_axis_by_the_indices() {
        let x = counted(&[2, 3]);
        let gather = |indices: &[i64], shape: &[usize]| {
            Gather { axis: 1, indices: indices.to_vec(), shape: shape.to_vec() }.run(&[Some(&x)])
        };
        assert_eq!(gather(&[-1], &[]).unwrap()[0], Tensor { shape: vec![2], values: vec![2.0, 5.0] });
        assert_eq!(gather(&[0, 2], &[1, 2]).unwrap()[0].shape, [2, 1, 2]);
        assert!(gather(&[3], &[1]).unwrap_err().contains("index 3"));
    }

    #[test]
    fn parts_that_do_not_fit_are_refused() {
        let split = |sizes: &[usize]| Split { axis: 0, sizes: Some(sizes.to_vec()), parts: sizes.len() };
        assert!(split(&[1, 2]).run(&[Some(&counted(&[4]))]).is_err());
        assert!(split(&[usize::MAX, 5]).run(&[Some(&counted(&[4]))]).is_err());
        let uneven = Split { axis: 0, sizes: None, parts: 2 }.run(&[Some(&counted(&[5]))]).unwrap();
        assert_eq!((uneven[0].values.len(), uneven[1].values.len()), (3, 2));
        let concat = Concat { axis: 0 };
        assert!(concat.run(&[Some(&counted(&[2, 2])), Some(&counted(&[2, 3]))]).is_err());
    }

    proptest! {
        #[test]
        fn joining_the_parts_gives_the_whole(
            shape in prop::collection::vec(1_usize..4, 1..4),
            sizes in prop::collection::vec(1_usize..4, 1..4),
            axis in 0_usize..4,
        ) {
            let axis = axis % shape.len();
            let mut shape = shape;
            shape[axis] = sizes.iter().sum();
            let x = counted(&shape);
            let parts = sizes.len();
            let split = Split { axis: axis as i64, sizes: Some(sizes), parts };
            let parts = split.run(&[Some(&x)]).unwrap();
            let again = Concat { axis: axis as i64 }.run(&parts.iter().map(Some).collect::<Vec<_>>()).unwrap();
            prop_assert_eq!(&again[0], &x);
        }
    }
}
