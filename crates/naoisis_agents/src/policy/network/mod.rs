//! Learned policies as ONNX networks, run exactly.
//!
//! A [`Network`] is read from the bytes of an ONNX file, checked as a whole, and then run on tensors of 32-bit numbers.
//! It supports what policies of robots are made of: fully connected and recurrent layers, the usual activations and
//! normalisations, and the operators that exporters put between them.
//!
//! # The same bits everywhere
//!
//! The result of a run depends on the file and the inputs alone, not on the processor, the number of cores or the
//! system's libraries:
//!
//! - Every sum is taken in one order with a rounded multiplication and a rounded addition per term. A matrix product
//!   starts each output at 0 and adds the products over the shared dimension from its first element to its last; `Gemm`
//!   then multiplies by `alpha` and adds `beta` times its third input. A recurrent layer starts each gate at its bias,
//!   then adds the products with the inputs and then those with the state; where the reset gate of a `GRU` comes after
//!   the weights, the part it multiplies is a sum of its own. Reductions add in row-major order.
//! - Processors work on several outputs at once, never on several terms of one sum.
//! - Exponentials, logarithms, hyperbolic tangents and logistic functions are polynomials of this module; square roots
//!   and divisions are exact by IEEE 754.
//!
//! Other runtimes order their sums by processor, so they agree with this one only to within rounding.
//!
//! # Numbers
//!
//! All values are 32-bit floats. 64-bit floats are rounded on reading. Integers and truth values are held as floats
//! too, which is exact up to 16,777,216; larger constants are refused unless they are parameters, such as the ends of a
//! slice. NaN passes through, but its sign and payload may differ between processors.

mod constants;
mod error;
mod math;
mod node;
mod operators;
mod read;
mod tensor;
mod wire;

use std::{borrow::Cow, sync::Arc};

use operators::Operator;

pub use error::NetworkError;
pub(in crate::policy) use math::exp;
pub use tensor::Tensor;

/// An input or output of a network.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Port {
    /// The name in the file.
    pub name: String,
    /// The size of each dimension, where `None` is free, such as the batch.
    pub shape: Vec<Option<usize>>,
}

impl Port {
    /// Checks that `tensor` has the declared shape and as many numbers as its own shape says.
    fn check(&self, tensor: &Tensor) -> Result<(), NetworkError> {
        let fits = self.shape.len() == tensor.shape.len()
            && self.shape.iter().zip(&tensor.shape).all(|(expected, &found)| expected.is_none_or(|size| size == found));
        if fits && tensor::count(&tensor.shape) == Ok(tensor.values.len()) && !tensor.values.is_empty() {
            return Ok(());
        }
        Err(NetworkError::PortShape {
            name: self.name.clone(),
            expected: self.shape.clone(),
            found: tensor.shape.clone(),
            numbers: tensor.values.len(),
        })
    }
}

/// A network that was read from an ONNX file and checked; clones share it.
#[derive(Clone, Debug)]
pub struct Network(Arc<Program>);

/// The nodes of a network in the order in which they run. Values are numbered slots.
#[derive(Debug, Default)]
struct Program {
    inputs: Vec<Port>,
    input_slots: Vec<usize>,
    outputs: Vec<Port>,
    output_slots: Vec<usize>,
    /// The constant in each slot that holds one.
    constants: Vec<Option<Tensor>>,
    steps: Vec<Step>,
}

/// One node of a network.
#[derive(Debug)]
struct Step {
    node: String,
    name: &'static str,
    operator: Box<dyn Operator>,
    inputs: Vec<Option<usize>>,
    outputs: Vec<Option<usize>>,
    /// The slots that no later step needs.
    done: Vec<usize>,
}

impl Network {
    /// The network in the `bytes` of an ONNX file.
    ///
    /// # Errors
    ///
    /// A [`NetworkError`] that names what is not supported, if the file is no ONNX model, is too large, or uses
    /// anything that this module does not run. What can be known without inputs is checked here, so that running a
    /// network fails on the shapes of its inputs only.
    pub fn read(bytes: &[u8]) -> Result<Self, NetworkError> {
        read::read(bytes).map(|program| Self(Arc::new(program)))
    }

    /// The inputs that a run needs, without constants.
    pub fn inputs(&self) -> &[Port] {
        &self.0.inputs
    }

    /// The outputs that a run gives.
    pub fn outputs(&self) -> &[Port] {
        &self.0.outputs
    }

    /// The outputs for `inputs`, which are in the order of [`Network::inputs`]; the result is in that of
    /// [`Network::outputs`].
    ///
    /// # Errors
    ///
    /// A [`NetworkError`] if the number or the shapes of `inputs` are not those declared, or if a node cannot work on
    /// the shapes that follow from them.
    pub fn run(&self, inputs: &[Tensor]) -> Result<Vec<Tensor>, NetworkError> {
        let program = &*self.0;
        if inputs.len() != program.inputs.len() {
            return Err(NetworkError::InputCount { expected: program.inputs.len(), found: inputs.len() });
        }
        let mut values: Vec<Option<Cow<Tensor>>> =
            program.constants.iter().map(|constant| constant.as_ref().map(Cow::Borrowed)).collect();
        for ((port, &slot), input) in program.inputs.iter().zip(&program.input_slots).zip(inputs) {
            port.check(input)?;
            values[slot] = Some(Cow::Borrowed(input));
        }
        for step in &program.steps {
            let operands: Vec<Option<&Tensor>> =
                step.inputs.iter().map(|slot| slot.and_then(|slot| values[slot].as_deref())).collect();
            let results = step.run(&operands)?;
            for (slot, result) in step.outputs.iter().zip(results) {
                if let Some(slot) = *slot {
                    values[slot] = Some(Cow::Owned(result));
                }
            }
            for &slot in &step.done {
                values[slot] = None;
            }
        }
        let result = |(port, &slot): (&Port, &usize)| {
            let tensor = values[slot].as_deref().cloned().unwrap_or_default();
            port.check(&tensor).map(|()| tensor)
        };
        program.outputs.iter().zip(&program.output_slots).map(result).collect()
    }
}

impl Step {
    /// The results of the node for its `operands`, none of them empty.
    fn run(&self, operands: &[Option<&Tensor>]) -> Result<Vec<Tensor>, NetworkError> {
        let results = self.operator.run(operands).and_then(|results| {
            let empty = results.iter().any(|result| result.values.is_empty());
            if empty { Err("the result would be empty".into()) } else { Ok(results) }
        });
        results.map_err(|detail| NetworkError::Run { node: self.node.clone(), operator: self.name.into(), detail })
    }
}

#[cfg(test)]
mod tests;
