//! Tensors of 32-bit numbers, their shapes and broadcasting.

/// The most numbers one tensor may hold, which is also where 32-bit floats stop holding every integer.
pub(super) const MOST_NUMBERS: usize = 1 << 24;

/// The most dimensions a tensor may have.
pub(super) const MOST_DIMENSIONS: usize = 16;

/// An array of numbers in row-major order: the last dimension changes fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tensor {
    /// The size of each dimension; empty for a single number.
    pub shape: Vec<usize>,
    /// The numbers, as many as the product of `shape`.
    pub values: Vec<f32>,
}

impl Tensor {
    /// The same numbers under another `shape`, which must hold as many.
    pub(super) fn reshaped(&self, shape: Vec<usize>) -> Result<Self, String> {
        if count(&shape)? != self.values.len() {
            return Err(format!("{} numbers of shape {:?} do not fit {shape:?}", self.values.len(), self.shape));
        }
        Ok(Self { shape, values: self.values.clone() })
    }

    /// The numbers as integers, such as sizes and indices.
    pub(super) fn integers(&self) -> Result<Vec<i64>, String> {
        let integer = |&value: &f32| {
            let rounded = value as i64;
            if rounded as f32 == value { Ok(rounded) } else { Err(format!("{value} is not an integer")) }
        };
        self.values.iter().map(integer).collect()
    }

    /// The tensor repeated along dimensions of size 1, and along missing leading ones, to fill `shape`.
    pub(super) fn broadcast_to(&self, shape: &[usize]) -> Result<Self, String> {
        if broadcast_shape(&self.shape, shape)? != shape {
            return Err(format!("shape {:?} does not broadcast to {shape:?}", self.shape));
        }
        let numbers = count(shape)?;
        let strides = broadcast_strides(&self.shape, shape);
        let values = Offsets::new(shape, &strides, 0, numbers).map(|offset| self.values[offset]).collect();
        Ok(Self { shape: shape.to_vec(), values })
    }
}

/// How many numbers a tensor of `shape` holds, if it may be that large.
pub(super) fn count(shape: &[usize]) -> Result<usize, String> {
    if shape.len() > MOST_DIMENSIONS {
        return Err(format!("{} dimensions are more than the {MOST_DIMENSIONS} allowed", shape.len()));
    }
    let product = shape.iter().try_fold(1_usize, |product, &size| product.checked_mul(size));
    match product {
        Some(numbers) if numbers <= MOST_NUMBERS => Ok(numbers),
        _ => Err(format!("a tensor of shape {shape:?} is larger than the {MOST_NUMBERS} numbers allowed")),
    }
}

/// The `axis` counted from the front, where a negative one counts from behind, among `rank` dimensions.
pub(super) fn axis_of(axis: i64, rank: usize) -> Result<usize, String> {
    let from_front = if axis < 0 { axis.saturating_add(rank as i64) } else { axis };
    match usize::try_from(from_front) {
        Ok(index) if index < rank => Ok(index),
        _ => Err(format!("axis {axis} does not exist among {rank} dimensions")),
    }
}

/// The sizes of `sizes` as unsigned numbers.
pub(super) fn sizes_of(sizes: &[i64]) -> Result<Vec<usize>, String> {
    sizes.iter().map(|&size| usize::try_from(size).map_err(|_| format!("{size} is not a size"))).collect()
}

/// How far apart neighbours along each dimension lie in a tensor of `shape`.
pub(super) fn strides(shape: &[usize]) -> Vec<isize> {
    let mut strides = vec![1; shape.len()];
    for axis in (1..shape.len()).rev() {
        strides[axis - 1] = strides[axis] * shape[axis] as isize;
    }
    strides
}

/// The common shape of tensors of shapes `a` and `b`, by NumPy's rules.
pub(super) fn broadcast_shape(a: &[usize], b: &[usize]) -> Result<Vec<usize>, String> {
    let rank = a.len().max(b.len());
    let size = |shape: &[usize], axis: usize| (axis + shape.len()).checked_sub(rank).map_or(1, |at| shape[at]);
    (0..rank)
        .map(|axis| match (size(a, axis), size(b, axis)) {
            (x, y) if x == y || y == 1 => Ok(x),
            (1, y) => Ok(y),
            _ => Err(format!("shapes {a:?} and {b:?} do not broadcast")),
        })
        .collect()
}

/// The strides that walk a tensor of shape `from` as if it had the shape `to`, to which it broadcasts.
pub(super) fn broadcast_strides(from: &[usize], to: &[usize]) -> Vec<isize> {
    let missing = to.len() - from.len();
    let own = strides(from);
    (0..to.len())
        .map(|axis| if axis < missing || from[axis - missing] == 1 { 0 } else { own[axis - missing] })
        .collect()
}

/// The positions in a tensor's values of the elements of a view of it, in the view's row-major order.
pub(super) struct Offsets<'a> {
    shape: &'a [usize],
    strides: &'a [isize],
    index: Vec<usize>,
    offset: isize,
    left: usize,
}

impl<'a> Offsets<'a> {
    /// The `numbers` positions of a view of `shape` whose first element lies at `start`, with `strides` per dimension.
    pub(super) fn new(shape: &'a [usize], strides: &'a [isize], start: usize, numbers: usize) -> Self {
        Self { shape, strides, index: vec![0; shape.len()], offset: start as isize, left: numbers }
    }
}

impl Iterator for Offsets<'_> {
    type Item = usize;

    fn next(&mut self) -> Option<usize> {
        self.left = self.left.checked_sub(1)?;
        let here = self.offset as usize;
        for axis in (0..self.shape.len()).rev() {
            self.index[axis] += 1;
            self.offset += self.strides[axis];
            if self.index[axis] < self.shape[axis] {
                break;
            }
            self.offset -= self.strides[axis] * self.shape[axis] as isize;
            self.index[axis] = 0;
        }
        Some(here)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.left, Some(self.left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The element of `tensor` that broadcasting puts at `index`, found without strides.
    fn naive(tensor: &Tensor, index: &[usize]) -> f32 {
        let own = &index[index.len() - tensor.shape.len()..];
        let at = own.iter().zip(&tensor.shape).fold(0, |at, (&i, &size)| at * size + if size == 1 { 0 } else { i });
        tensor.values[at]
    }

    proptest! {
        #[test]
        fn broadcasting_agrees_with_a_naive_reference(
            shape in prop::collection::vec(1_usize..4, 0..4),
            ones in prop::collection::vec(any::<bool>(), 4),
            missing in 0_usize..4,
        ) {
            let kept: Vec<usize> = shape.iter().zip(&ones).map(|(&size, &one)| if one { 1 } else { size }).collect();
            let from = kept[missing.min(kept.len())..].to_vec();
            let numbers: usize = from.iter().product();
            let tensor = Tensor { shape: from, values: (0..numbers).map(|value| value as f32).collect() };
            let wide = tensor.broadcast_to(&shape).unwrap();
            for (position, &value) in wide.values.iter().enumerate() {
                let mut rest = position;
                let mut index = vec![0; shape.len()];
                for axis in (0..shape.len()).rev() {
                    index[axis] = rest % shape[axis];
                    rest /= shape[axis];
                }
                prop_assert_eq!(value, naive(&tensor, &index));
            }
        }
    }

    #[test]
    fn shapes_that_do_not_broadcast_are_named() {
        assert_eq!(broadcast_shape(&[2, 1], &[3]), Ok(vec![2, 3]));
        assert!(broadcast_shape(&[2, 4], &[3]).unwrap_err().contains("[2, 4] and [3]"));
        assert!(Tensor { shape: vec![3], values: vec![0.0; 3] }.broadcast_to(&[1]).is_err());
    }

    #[test]
    fn sizes_are_limited() {
        assert_eq!(count(&[]), Ok(1));
        assert_eq!(count(&[4096, 4096]), Ok(MOST_NUMBERS));
        assert!(count(&[4096, 4097]).is_err());
        assert!(count(&[usize::MAX, 2]).is_err());
        assert!(count(&[1; 17]).is_err());
    }

    #[test]
    fn axes_count_from_both_ends() {
        assert_eq!(axis_of(-1, 3), Ok(2));
        assert_eq!(axis_of(2, 3), Ok(2));
        assert!(axis_of(3, 3).is_err());
        assert!(axis_of(-4, 3).is_err());
        assert!(axis_of(i64::MIN, 3).is_err());
    }

    #[test]
    fn integers_are_exact_or_refused() {
        assert_eq!(Tensor { shape: vec![2], values: vec![-1.0, 3.0] }.integers(), Ok(vec![-1, 3]));
        assert!(Tensor { shape: vec![], values: vec![0.5] }.integers().is_err());
        assert!(Tensor { shape: vec![], values: vec![f32::NAN] }.integers().is_err());
    }
}
