//! Matrix products.

use super::super::tensor::{Offsets, broadcast_shape, broadcast_strides, count};
use super::{Element, Node, Operator, Reading, Tensor, input};

/// `alpha` A B + `beta` C, where A or B may be transposed first.
#[derive(Debug)]
struct Gemm {
    alpha: f32,
    beta: f32,
    transpose_a: bool,
    transpose_b: bool,
    /// B if it is constant, already transposed where needed.
    weights: Option<Tensor>,
}

impl Operator for Gemm {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let mut a = input(inputs, 0)?;
        let transposed_a;
        if self.transpose_a {
            transposed_a = transposed(a)?;
            a = &transposed_a;
        }
        let turned_b;
        let b = match &self.weights {
            Some(weights) => weights,
            None if self.transpose_b => {
                turned_b = transposed(input(inputs, 1)?)?;
                &turned_b
            }
            None => input(inputs, 1)?,
        };
        let (&[rows, inner], &[b_rows, columns]) = (&a.shape[..], &b.shape[..]) else {
            return Err(format!("shapes {:?} and {:?} are not those of matrices", a.shape, b.shape));
        };
        if inner != b_rows {
            return Err(format!("matrices of shapes {:?} and {:?} do not multiply", a.shape, b.shape));
        }
        let shape = vec![rows, columns];
        let mut values = vec![0.0; count(&shape)?];
        for (result, row) in values.chunks_exact_mut(columns).zip(a.values.chunks_exact(inner)) {
            add_product(result, row, &b.values);
        }
        if self.alpha != 1.0 {
            values.iter_mut().for_each(|value| *value *= self.alpha);
        }
        if let Some(&Some(c)) = inputs.get(2) {
            let strides = match broadcast_shape(&c.shape, &shape)? == shape {
                true => broadcast_strides(&c.shape, &shape),
                false => return Err(format!("shape {:?} does not broadcast to {shape:?}", c.shape)),
            };
            for (value, offset) in values.iter_mut().zip(Offsets::new(&shape, &strides, 0, rows * columns)) {
                *value += self.beta * c.values[offset];
            }
        }
        Ok(vec![Tensor { shape, values }])
    }
}

/// The product of matrices in the last two dimensions, broadcast over the others, as in NumPy.
#[derive(Debug)]
struct MatMul;

impl Operator for MatMul {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        let (a, b) = (input(inputs, 0)?, input(inputs, 1)?);
        let mismatch = || format!("shapes {:?} and {:?} do not multiply", a.shape, b.shape);
        // A vector stands for a matrix of one row on the left, and of one column on the right.
        let (outer_a, rows, inner) = match a.shape[..] {
            [ref outer @ .., rows, inner] => (outer, rows, inner),
            [inner] => (&[][..], 1, inner),
            [] => return Err(mismatch()),
        };
        let (outer_b, b_rows, columns) = match b.shape[..] {
            [ref outer @ .., b_rows, columns] => (outer, b_rows, columns),
            [b_rows] => (&[][..], b_rows, 1),
            [] => return Err(mismatch()),
        };
        if inner != b_rows {
            return Err(mismatch());
        }
        let outer = broadcast_shape(outer_a, outer_b)?;
        let products = count(&outer)?;
        let mut shape = outer.clone();
        shape.extend((a.shape.len() > 1).then_some(rows));
        shape.extend((b.shape.len() > 1).then_some(columns));
        let mut values = vec![0.0; count(&shape)?];
        let (strides_a, strides_b) = (broadcast_strides(outer_a, &outer), broadcast_strides(outer_b, &outer));
        let offsets = Offsets::new(&outer, &strides_a, 0, products).zip(Offsets::new(&outer, &strides_b, 0, products));
        for (result, (at_a, at_b)) in values.chunks_exact_mut(rows * columns).zip(offsets) {
            let left = &a.values[at_a * rows * inner..][..rows * inner];
            let right = &b.values[at_b * inner * columns..][..inner * columns];
            for (result, row) in result.chunks_exact_mut(columns).zip(left.chunks_exact(inner)) {
                add_product(result, row, right);
            }
        }
        Ok(vec![Tensor { shape, values }])
    }
}

/// Adds to each of the `sums` the product of `row` with the matrix of `weights`, which has one row per number of `row`.
///
/// The terms of each sum are added from the first row of the weights to the last. The inner loop runs over the sums, so
/// that processors can add to several at once without a change of that order.
pub(super) fn add_product(sums: &mut [f32], row: &[f32], weights: &[f32]) {
    for (&factor, weights) in row.iter().zip(weights.chunks_exact(sums.len().max(1))) {
        for (sum, &weight) in sums.iter_mut().zip(weights) {
            *sum += factor * weight;
        }
    }
}

/// The matrix `tensor` with rows and columns exchanged.
fn transposed(tensor: &Tensor) -> Result<Tensor, String> {
    let [rows, columns] = tensor.shape[..] else {
        return Err(format!("shape {:?} is not that of a matrix", tensor.shape));
    };
    Ok(Tensor { shape: vec![columns, rows], values: transposed_values(&tensor.values, rows, columns) })
}

/// The `values` of a matrix of `rows` and `columns` with rows and columns exchanged.
pub(super) fn transposed_values(values: &[f32], rows: usize, columns: usize) -> Vec<f32> {
    (0..columns).flat_map(|column| (0..rows).map(move |row| values[row * columns + column])).collect()
}

pub(super) fn gemm(node: &Node) -> Reading {
    node.expect_floats()?;
    let transpose_b = node.flag("transB", false)?;
    let weights = match node.keep(1) {
        Some(constant) => {
            constant.check_operand()?;
            let turned = transposed(&constant.tensor)?;
            Some(if transpose_b { turned } else { constant.tensor.clone() })
        }
        None => None,
    };
    let gemm = Gemm {
        alpha: node.float("alpha", 1.0)?,
        beta: node.float("beta", 1.0)?,
        transpose_a: node.flag("transA", false)?,
        transpose_b,
        weights,
    };
    Ok((Box::new(gemm), Element::Float))
}

pub(super) fn mat_mul(node: &Node) -> Reading {
    node.expect_floats()?;
    Ok((Box::new(MatMul), Element::Float))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tensor(shape: &[usize], values: &[f32]) -> Tensor {
        Tensor { shape: shape.to_vec(), values: values.to_vec() }
    }

    #[test]
    fn general_product_turns_scales_and_adds() {
        let a = tensor(&[2, 1], &[1.0, 2.0]);
        let b = tensor(&[3, 2], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let c = tensor(&[1], &[10.0]);
        let gemm = Gemm { alpha: 2.0, beta: 0.5, transpose_a: true, transpose_b: true, weights: None };
        let result = gemm.run(&[Some(&a), Some(&b), Some(&c)]).unwrap().remove(0);
        assert_eq!(result, tensor(&[1, 3], &[15.0, 27.0, 39.0]));
        assert!(gemm.run(&[Some(&b), Some(&b)]).unwrap_err().contains("do not multiply"));
        assert!(gemm.run(&[Some(&a), Some(&b), Some(&tensor(&[2], &[0.0, 0.0]))]).is_err());
    }

    #[test]
    fn products_broadcast_over_leading_dimensions() {
        let a = tensor(&[2, 1, 2], &[1.0, 2.0, 3.0, 4.0]);
        let b = tensor(&[2, 2], &[1.0, 10.0, 100.0, 1000.0]);
        let result = MatMul.run(&[Some(&a), Some(&b)]).unwrap().remove(0);
        assert_eq!(result, tensor(&[2, 1, 2], &[201.0, 2010.0, 403.0, 4030.0]));
        let vector = tensor(&[2], &[1.0, 2.0]);
        assert_eq!(MatMul.run(&[Some(&vector), Some(&vector)]).unwrap()[0], tensor(&[], &[5.0]));
        assert_eq!(MatMul.run(&[Some(&b), Some(&vector)]).unwrap()[0], tensor(&[2], &[21.0, 2100.0]));
    }

    #[test]
    fn sums_are_taken_from_the_first_term_to_the_last() {
        let mut sums = [0.0];
        add_product(&mut sums, &[1e8, 1.0, -1e8], &[1.0, 1.0, 1.0]);
        assert_eq!(sums, [0.0]);
        let mut sums = [0.0];
        add_product(&mut sums, &[1e8, -1e8, 1.0], &[1.0, 1.0, 1.0]);
        assert_eq!(sums, [1.0]);
    }
}
