//! The supported operators.

mod elementwise;
mod layout;
mod linear;
mod normalise;
mod pair;
mod recurrent;
mod reduce;
mod select;

use std::fmt;

use super::{constants::Element, math, node::Node, tensor::Tensor};

/// An operator with its attributes and constant parameters.
pub(super) trait Operator: Send + Sync {
    /// The results for `inputs`, in the order of the node's outputs.
    ///
    /// Inputs that are left out, and those of which the operator keeps a copy, are `None`. None of the others is empty.
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String>;
}

impl fmt::Debug for dyn Operator {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.debug_struct("Operator").finish_non_exhaustive()
    }
}

/// What reading a node gives: its operator and the kind of number it makes.
type Reading = Result<(Box<dyn Operator>, Element), String>;

/// An operator with one result: that of its function for the first input and for all inputs.
struct OneResult<F>(F);

impl<F: Fn(&Tensor, &[Option<&Tensor>]) -> Result<Tensor, String> + Send + Sync> Operator for OneResult<F> {
    fn run(&self, inputs: &[Option<&Tensor>]) -> Result<Vec<Tensor>, String> {
        Ok(vec![self.0(input(inputs, 0)?, inputs)?])
    }
}

/// The operator whose one result is that of `function` for the first input and for all inputs, of the kind `element`.
fn one_result(
    element: Element,
    function: impl Fn(&Tensor, &[Option<&Tensor>]) -> Result<Tensor, String> + Send + Sync + 'static,
) -> Reading {
    Ok((Box::new(OneResult(function)), element))
}

/// A supported operator by name.
pub(super) struct Entry {
    pub(super) name: &'static str,
    /// How many inputs it needs.
    pub(super) inputs: usize,
    /// How many inputs it may have.
    pub(super) most_inputs: usize,
    /// How many outputs are supported.
    pub(super) most_outputs: usize,
    pub(super) read: fn(&Node) -> Reading,
}

const fn entry(name: &'static str, inputs: usize, most_inputs: usize, read: fn(&Node) -> Reading) -> Entry {
    Entry { name, inputs, most_inputs, most_outputs: 1, read }
}

/// As many inputs or outputs as the file names.
const ANY: usize = usize::MAX;

/// All supported operators, in alphabetical order.
const ENTRIES: &[Entry] = &[
    entry("Abs", 1, 1, |node| elementwise::on_all(node, f32::abs)),
    entry("Add", 2, 2, |node| pair::fold(node, |a, b| a + b)),
    entry("ArgMax", 1, 1, reduce::arg_max),
    entry("Asinh", 1, 1, |node| elementwise::on_floats(node, math::asinh)),
    entry("BatchNormalization", 5, 5, normalise::batch),
    entry("Cast", 1, 1, elementwise::cast),
    entry("Clip", 1, 3, elementwise::clip),
    entry("Concat", 1, ANY, select::concat),
    // Read without an operator: its tensor is a constant of the network.
    entry("Constant", 0, 0, layout::identity),
    entry("ConstantOfShape", 1, 1, layout::constant_of_shape),
    entry("Div", 2, 2, pair::div),
    entry("Dropout", 1, 3, layout::dropout),
    entry("Elu", 1, 1, elementwise::elu),
    entry("Exp", 1, 1, |node| elementwise::on_floats(node, math::exp)),
    entry("Expand", 2, 2, layout::expand),
    entry("Flatten", 1, 1, layout::flatten),
    Entry { most_outputs: 2, ..entry("GRU", 3, 6, recurrent::gru) },
    entry("Gather", 2, 2, select::gather),
    entry("Gemm", 2, 3, linear::gemm),
    entry("Identity", 1, 1, layout::identity),
    Entry { most_outputs: 3, ..entry("LSTM", 3, 8, recurrent::lstm) },
    entry("LayerNormalization", 2, 3, normalise::layer),
    entry("LeakyRelu", 1, 1, elementwise::leaky_relu),
    entry("Log", 1, 1, |node| elementwise::on_floats(node, math::log)),
    entry("LogSoftmax", 1, 1, normalise::log_softmax),
    entry("MatMul", 2, 2, linear::mat_mul),
    entry("Max", 1, ANY, |node| pair::fold(node, |a, b| if a > b || a.is_nan() { a } else { b })),
    entry("Min", 1, ANY, |node| pair::fold(node, |a, b| if a < b || a.is_nan() { a } else { b })),
    entry("Mul", 2, 2, |node| pair::fold(node, |a, b| a * b)),
    entry("Neg", 1, 1, |node| elementwise::on_all(node, |x| -x)),
    entry("Pow", 2, 2, elementwise::pow),
    entry("ReduceMean", 1, 2, reduce::mean),
    entry("ReduceSum", 1, 2, reduce::sum),
    entry("Relu", 1, 1, |node| elementwise::on_floats(node, |x| if x < 0.0 { 0.0 } else { x })),
    entry("Reshape", 2, 2, layout::reshape),
    entry("Shape", 1, 1, layout::shape),
    entry("Sigmoid", 1, 1, |node| elementwise::on_floats(node, math::sigmoid)),
    entry("Slice", 3, 5, select::slice),
    entry("Softmax", 1, 1, normalise::softmax),
    entry("Softplus", 1, 1, |node| elementwise::on_floats(node, math::softplus)),
    Entry { most_outputs: ANY, ..entry("Split", 1, 2, select::split) },
    entry("Sqrt", 1, 1, |node| elementwise::on_floats(node, f32::sqrt)),
    entry("Squeeze", 1, 2, layout::squeeze),
    entry("Sub", 2, 2, |node| pair::fold(node, |a, b| a - b)),
    entry("Tanh", 1, 1, |node| elementwise::on_floats(node, math::tanh)),
    entry("Transpose", 1, 1, layout::transpose),
    entry("Unsqueeze", 1, 2, layout::unsqueeze),
];

/// The supported operator `name`.
pub(super) fn entry_named(name: &str) -> Option<&'static Entry> {
    ENTRIES.iter().find(|entry| entry.name == name)
}

/// The names of all supported operators, for messages.
pub(super) fn names() -> String {
    let names: Vec<_> = ENTRIES.iter().map(|entry| entry.name).collect();
    names.join(", ")
}

/// The input `index` of a running operator.
fn input<'a>(inputs: &[Option<&'a Tensor>], index: usize) -> Result<&'a Tensor, String> {
    inputs.get(index).copied().flatten().ok_or_else(|| format!("its input {index} is missing"))
}

/// Single operators, run for tests.
#[cfg(test)]
mod testing {
    use rten_onnx::onnx::{AttributeProto, DataType, NodeProto, TensorProto};

    use super::super::{constants::Constant, node::Operand};
    use super::*;

    /// The result of version 12 of the operator `name` for `inputs`, which are constant and of the kind `element`.
    pub(super) fn run(
        name: &str,
        attributes: &[(&str, &[f32])],
        element: Element,
        inputs: &[Tensor],
    ) -> Result<Tensor, String> {
        let proto = NodeProto { attribute: attributes.iter().map(attribute).collect(), ..NodeProto::default() };
        let constant = |tensor: &Tensor| Constant { element, tensor: tensor.clone(), integers: Vec::new() };
        let constants: Vec<_> = inputs.iter().map(constant).collect();
        let operands = constants.iter().map(|constant| Some(Operand { element, constant: Some(constant) })).collect();
        let node = Node::new(&proto, 12, operands);
        let (operator, _) = (entry_named(name).unwrap().read)(&node)?;
        node.expect_all_read()?;
        let inputs: Vec<_> = inputs.iter().map(Some).collect();
        operator.run(&inputs).map(|mut results| results.remove(0))
    }

    /// The attribute `name` with `numbers`, of whatever type the operator asks for: all of them or the first one.
    fn attribute(&(name, numbers): &(&str, &[f32])) -> AttributeProto {
        let (data_type, float_data) = (Some(DataType::FLOAT), vec![numbers[0]]);
        AttributeProto {
            name: Some(name.into()),
            f: Some(numbers[0]),
            i: Some(numbers[0] as i64),
            ints: numbers.iter().map(|&number| number as i64).collect(),
            t: Some(TensorProto { data_type, float_data, ..TensorProto::default() }),
            ..AttributeProto::default()
        }
    }
}
