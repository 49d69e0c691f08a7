//! Constant tensors of a file.

use rten_onnx::onnx::{AttributeProto, DataLocation, DataType, NodeProto, TensorProto};

use super::tensor::{MOST_NUMBERS, Tensor, count, sizes_of};

/// The kind of number a value holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Element {
    /// Floating-point numbers.
    Float,
    /// Integers, or truth values as 0 and 1.
    Integer,
}

impl Element {
    /// The kind of number for ONNX's type `code`, if it is supported.
    pub(super) fn of(code: DataType) -> Result<Self, String> {
        match code {
            DataType::FLOAT | DataType::DOUBLE => Ok(Self::Float),
            DataType::INT32 | DataType::INT64 | DataType::BOOL => Ok(Self::Integer),
            _ => Err(format!("elements of type {code} are not supported, only FLOAT, DOUBLE, INT32, INT64 and BOOL")),
        }
    }
}

/// A tensor that the file gives.
#[derive(Clone, Debug)]
pub(super) struct Constant {
    pub(super) element: Element,
    pub(super) tensor: Tensor,
    /// The exact numbers of an integer tensor; empty for floats.
    pub(super) integers: Vec<i64>,
}

impl Constant {
    /// A constant of floats, all of which must be finite.
    pub(super) fn floats(shape: Vec<usize>, values: Vec<f32>) -> Result<Self, String> {
        if let Some(value) = values.iter().find(|value| !value.is_finite()) {
            return Err(format!("it holds {value}"));
        }
        Ok(Self { element: Element::Float, tensor: Tensor { shape, values }, integers: Vec::new() })
    }

    /// A constant of integers.
    pub(super) fn integers(shape: Vec<usize>, integers: Vec<i64>) -> Self {
        let values = integers.iter().map(|&value| value as f32).collect();
        Self { element: Element::Integer, tensor: Tensor { shape, values }, integers }
    }

    /// The constant that running a node on constants gave.
    pub(super) fn computed(element: Element, tensor: Tensor) -> Result<Self, String> {
        match element {
            Element::Float => Self::floats(tensor.shape, tensor.values),
            Element::Integer => Ok(Self::integers(tensor.shape.clone(), tensor.integers()?)),
        }
    }

    /// Checks that the tensor can take part in computations: it is not empty and floats hold all its integers.
    pub(super) fn check_operand(&self) -> Result<(), String> {
        if self.tensor.values.is_empty() {
            return Err("an input is an empty constant".into());
        }
        match self.integers.iter().find(|value| value.unsigned_abs() > MOST_NUMBERS as u64) {
            Some(value) => Err(format!("integers up to {MOST_NUMBERS} are supported, not {value}")),
            None => Ok(()),
        }
    }

    /// The constant in the message `proto`.
    pub(super) fn from_tensor(proto: &TensorProto) -> Result<Self, String> {
        if proto.data_location == Some(DataLocation::EXTERNAL) || !proto.external_data.is_empty() {
            let advice = "save the model with all weights inside (`external_data=False` in PyTorch)";
            return Err(format!("its numbers are in another file; {advice}"));
        }
        let shape = sizes_of(&proto.dims)?;
        let expected = count(&shape)?;
        let code = proto.data_type.unwrap_or(DataType(0));
        let constant = match Element::of(code)? {
            Element::Float => Self::floats(shape, floats_of(proto, code)?)?,
            Element::Integer => Self::integers(shape, integers_of(proto, code)?),
        };
        let found = constant.tensor.values.len();
        if found == expected { Ok(constant) } else { Err(format!("it holds {found} numbers instead of {expected}")) }
    }

    /// The constant that a node with the operator `Constant` gives.
    pub(super) fn from_node(node: &NodeProto) -> Result<Self, String> {
        let [attribute] = node.attribute.as_slice() else {
            return Err("it needs exactly one attribute".into());
        };
        let AttributeProto { f, i, t, floats, ints, .. } = attribute;
        match (attribute.name.as_deref(), t) {
            (Some("value"), Some(tensor)) => Self::from_tensor(tensor),
            (Some("value_float"), _) => Self::floats(Vec::new(), vec![f.unwrap_or(0.0)]),
            (Some("value_floats"), _) => Self::floats(vec![floats.len()], floats.clone()),
            (Some("value_int"), _) => Ok(Self::integers(Vec::new(), vec![i.unwrap_or(0)])),
            (Some("value_ints"), _) => Ok(Self::integers(vec![ints.len()], ints.clone())),
            _ => Err("only tensors of numbers are supported as constants".into()),
        }
    }
}

/// The numbers of `proto`, which has floats of the type `code`.
fn floats_of(proto: &TensorProto, code: DataType) -> Result<Vec<f32>, String> {
    match (&proto.raw_data, code) {
        (Some(raw), DataType::FLOAT) => from_raw(&raw.borrow(), f32::from_le_bytes),
        (Some(raw), _) => from_raw(&raw.borrow(), |bytes| f64::from_le_bytes(bytes) as f32),
        (None, DataType::FLOAT) => Ok(proto.float_data.clone()),
        (None, _) => Ok(proto.double_data.iter().map(|&value| value as f32).collect()),
    }
}

/// The numbers of `proto`, which has integers or truth values of the type `code`.
fn integers_of(proto: &TensorProto, code: DataType) -> Result<Vec<i64>, String> {
    match (&proto.raw_data, code) {
        (Some(raw), DataType::INT64) => from_raw(&raw.borrow(), i64::from_le_bytes),
        (Some(raw), DataType::INT32) => from_raw(&raw.borrow(), |bytes| i64::from(i32::from_le_bytes(bytes))),
        (Some(raw), _) => from_raw(&raw.borrow(), |[byte]| i64::from(byte != 0)),
        (None, DataType::INT64) => Ok(proto.int64_data.clone()),
        (None, _) => Ok(proto.int32_data.iter().map(|&value| i64::from(value)).collect()),
    }
}

/// The numbers in `raw`, of `N` bytes each.
fn from_raw<const N: usize, T>(raw: &[u8], number: impl Fn([u8; N]) -> T) -> Result<Vec<T>, String> {
    let (chunks, rest) = raw.as_chunks::<N>();
    if !rest.is_empty() {
        return Err(format!("its {} bytes are no whole count of numbers", raw.len()));
    }
    Ok(chunks.iter().map(|&bytes| number(bytes)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::RefCell;

    fn tensor(code: DataType, dims: &[i64], raw: Vec<u8>) -> TensorProto {
        TensorProto {
            dims: dims.to_vec(),
            data_type: Some(code),
            raw_data: Some(RefCell::new(raw)),
            ..TensorProto::default()
        }
    }

    #[test]
    fn numbers_of_every_supported_type_are_read() {
        let doubles = Constant::from_tensor(&tensor(DataType::DOUBLE, &[1], 0.1_f64.to_le_bytes().to_vec())).unwrap();
        assert_eq!(doubles.tensor.values, [0.1]);
        let truths = Constant::from_tensor(&tensor(DataType::BOOL, &[2], vec![0, 1])).unwrap();
        assert_eq!(truths.integers, [0, 1]);
        let integers = TensorProto { int32_data: vec![-7], raw_data: None, ..tensor(DataType::INT32, &[], vec![]) };
        assert_eq!(Constant::from_tensor(&integers).unwrap().integers, [-7]);
    }

    #[test]
    fn unusable_tensors_are_refused() {
        let refused = |proto: &TensorProto| Constant::from_tensor(proto).unwrap_err();
        assert!(refused(&tensor(DataType::FLOAT16, &[1], vec![0, 0])).contains("FLOAT16"));
        assert!(refused(&tensor(DataType::STRING, &[1], vec![])).contains("STRING"));
        assert!(refused(&tensor(DataType::FLOAT, &[2], vec![0; 4])).contains("1 numbers instead of 2"));
        assert!(refused(&tensor(DataType::FLOAT, &[1], vec![0; 5])).contains("whole count"));
        assert!(refused(&tensor(DataType::FLOAT, &[-1], vec![])).contains("not a size"));
        assert!(refused(&tensor(DataType::FLOAT, &[1 << 40, 1 << 40], vec![])).contains("larger"));
        assert!(refused(&tensor(DataType::FLOAT, &[1], f32::NAN.to_le_bytes().to_vec())).contains("NaN"));
        assert!(refused(&tensor(DataType::DOUBLE, &[1], 1e300_f64.to_le_bytes().to_vec())).contains("inf"));
        let external = TensorProto { data_location: Some(DataLocation::EXTERNAL), ..TensorProto::default() };
        assert!(refused(&external).contains("another file"));
    }
}
