//! A node of a file as the operators read it: its attributes and what is known of its inputs.

use std::cell::RefCell;

use rten_onnx::onnx::{AttributeProto, AttributeType, NodeProto};

use super::{
    constants::{Constant, Element},
    tensor::Tensor,
};

/// What is known of an input of a node before the network runs.
#[derive(Clone, Copy)]
pub(super) struct Operand<'a> {
    pub(super) element: Element,
    /// The value, if it is constant.
    pub(super) constant: Option<&'a Constant>,
}

/// A node while its operator is read.
pub(super) struct Node<'a> {
    proto: &'a NodeProto,
    /// The version of the operators.
    pub(super) operator_set: i64,
    /// The inputs, where `None` is left out.
    pub(super) inputs: Vec<Option<Operand<'a>>>,
    /// The names of the attributes read so far.
    read: RefCell<Vec<&'a str>>,
    /// For each input, whether the operator keeps a copy of its constant.
    kept: RefCell<Vec<bool>>,
}

impl<'a> Node<'a> {
    pub(super) fn new(proto: &'a NodeProto, operator_set: i64, inputs: Vec<Option<Operand<'a>>>) -> Self {
        let kept = RefCell::new(vec![false; inputs.len()]);
        Self { proto, operator_set, inputs, read: RefCell::default(), kept }
    }

    /// The attribute `name`, which must have the type `kind` if it is there.
    fn attribute(&self, name: &str, kind: AttributeType) -> Result<Option<&'a AttributeProto>, String> {
        let found = self.proto.attribute.iter().find(|attribute| attribute.name.as_deref() == Some(name));
        let Some(attribute) = found else {
            return Ok(None);
        };
        self.read.borrow_mut().extend(attribute.name.as_deref());
        if attribute.r#type.is_some_and(|found| found != kind) {
            return Err(format!("its attribute `{name}` has the wrong type"));
        }
        Ok(Some(attribute))
    }

    /// The integer attribute `name`, or `default`.
    pub(super) fn int(&self, name: &str, default: i64) -> Result<i64, String> {
        Ok(self.attribute(name, AttributeType::INT)?.map_or(default, |attribute| attribute.i.unwrap_or(0)))
    }

    /// Whether the attribute `name` is set, or `default`.
    pub(super) fn flag(&self, name: &str, default: bool) -> Result<bool, String> {
        Ok(self.int(name, i64::from(default))? != 0)
    }

    /// The floating-point attribute `name`, or `default`, which must be finite.
    pub(super) fn float(&self, name: &str, default: f32) -> Result<f32, String> {
        let found = self.attribute(name, AttributeType::FLOAT)?.map_or(default, |attribute| attribute.f.unwrap_or(0.0));
        if found.is_finite() { Ok(found) } else { Err(format!("its attribute `{name}` is {found}")) }
    }

    /// The list of integers in the attribute `name`.
    pub(super) fn ints(&self, name: &str) -> Result<Option<Vec<i64>>, String> {
        Ok(self.attribute(name, AttributeType::INTS)?.map(|attribute| attribute.ints.clone()))
    }

    /// The tensor in the attribute `name`.
    pub(super) fn tensor(&self, name: &str) -> Result<Option<Constant>, String> {
        let found = self.attribute(name, AttributeType::TENSOR)?.and_then(|attribute| attribute.t.as_ref());
        found.map(Constant::from_tensor).transpose()
    }

    /// Checks that the text attribute `name` is absent or equal to `expected`.
    pub(super) fn expect_text(&self, name: &str, expected: &str) -> Result<(), String> {
        match self.attribute(name, AttributeType::STRING)?.map(|attribute| attribute.s.as_deref().unwrap_or_default()) {
            Some(found) if found != expected => {
                Err(format!("its `{name}` is {found:?}, and only {expected:?} is supported"))
            }
            _ => Ok(()),
        }
    }

    /// Checks that the attribute `name`, a list of texts, is absent or equal to `expected`.
    pub(super) fn expect_texts(&self, name: &str, expected: &[&str]) -> Result<(), String> {
        match self.attribute(name, AttributeType::STRINGS)?.map(|attribute| &attribute.strings) {
            Some(found) if found != expected => {
                Err(format!("its `{name}` are {found:?}, and only {expected:?} are supported"))
            }
            _ => Ok(()),
        }
    }

    /// Checks that the integer attribute `name` is absent or `expected`.
    pub(super) fn expect_int(&self, name: &str, expected: i64) -> Result<(), String> {
        let found = self.int(name, expected)?;
        if found == expected {
            Ok(())
        } else {
            Err(format!("its `{name}` is {found}, and only {expected} is supported"))
        }
    }

    /// Checks that every attribute was read, since the others would change what the node does.
    pub(super) fn expect_all_read(&self) -> Result<(), String> {
        let read = self.read.borrow();
        let names = self.proto.attribute.iter().map(|attribute| attribute.name.as_deref().unwrap_or_default());
        match names.into_iter().find(|name| !read.contains(name)) {
            Some(name) => Err(format!("its attribute `{name}` is not supported")),
            None => Ok(()),
        }
    }

    /// Checks that the inputs are floating-point numbers.
    pub(super) fn expect_floats(&self) -> Result<(), String> {
        match self.inputs.iter().flatten().all(|operand| operand.element == Element::Float) {
            true => Ok(()),
            false => Err("its inputs must be floating-point numbers".into()),
        }
    }

    /// The kind of number of the first input.
    pub(super) fn element(&self) -> Element {
        self.operand(0).map_or(Element::Float, |operand| operand.element)
    }

    /// The input `index`, unless it is left out.
    pub(super) fn operand(&self, index: usize) -> Option<Operand<'a>> {
        self.inputs.get(index).copied().flatten()
    }

    /// The number of outputs that the file names, trailing ones left out included.
    pub(super) fn outputs(&self) -> usize {
        self.proto.output.len()
    }

    /// The constant at input `index` for the operator to keep, so that runs need not pass it; `None` if it is left out
    /// or not constant.
    pub(super) fn keep(&self, index: usize) -> Option<&'a Constant> {
        let constant = self.operand(index)?.constant?;
        self.kept.borrow_mut()[index] = true;
        Some(constant)
    }

    /// The parameter at input `index`, which must be constant unless it is left out.
    pub(super) fn parameter(&self, index: usize, name: &str) -> Result<Option<&'a Constant>, String> {
        match (self.operand(index), self.keep(index)) {
            (Some(_), None) => Err(format!("its input `{name}` must be constant")),
            (_, constant) => Ok(constant),
        }
    }

    /// The integers of the parameter at input `index`.
    pub(super) fn integers(&self, index: usize, name: &str) -> Result<Option<Vec<i64>>, String> {
        match self.parameter(index, name)? {
            Some(constant) if constant.element == Element::Float => Err(format!("its input `{name}` must be integers")),
            constant => Ok(constant.map(|constant| constant.integers.clone())),
        }
    }

    /// The single number of the parameter at input `index`.
    pub(super) fn number(&self, index: usize, name: &str) -> Result<Option<f32>, String> {
        match self.parameter(index, name)?.map(|constant| constant.tensor.values.as_slice()) {
            Some(&[value]) => Ok(Some(value)),
            Some(values) => Err(format!("its input `{name}` must be one number, not {}", values.len())),
            None => Ok(None),
        }
    }

    /// The floats of the parameter at input `index`, which must have the `shape`.
    pub(super) fn weights(&self, index: usize, name: &str, shape: &[usize]) -> Result<Option<&'a Tensor>, String> {
        match self.parameter(index, name)?.map(|constant| &constant.tensor) {
            Some(tensor) if tensor.shape != shape => {
                Err(format!("its input `{name}` must have shape {shape:?}, not {:?}", tensor.shape))
            }
            tensor => Ok(tensor),
        }
    }

    /// The axes of the node: an attribute in older versions of the operators, the input `index` from `since` on.
    pub(super) fn axes(&self, index: usize, since: i64) -> Result<Option<Vec<i64>>, String> {
        if self.operator_set < since { self.ints("axes") } else { self.integers(index, "axes") }
    }

    /// For each input, whether the operator keeps its constant.
    pub(super) fn into_kept(self) -> Vec<bool> {
        self.kept.into_inner()
    }
}
