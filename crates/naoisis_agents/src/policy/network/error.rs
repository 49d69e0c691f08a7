//! Why a network was refused or could not run.

use super::tensor::MOST_NUMBERS;

/// Why a file is refused as a network, or why a network cannot run on its inputs.
#[derive(Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NetworkError {
    /// The bytes are no ONNX model.
    #[error("the file is not a readable ONNX model: {detail}")]
    NotOnnx {
        /// What is wrong with the bytes.
        detail: String,
    },
    /// The model needs a version of ONNX's operators that is not supported.
    #[error("the model uses operator set {found:?}, and 11 to 20 are supported: export it with another opset_version")]
    OperatorSet {
        /// The version that the file names.
        found: Option<i64>,
    },
    /// The graph of the model does not hold together.
    #[error("the graph is refused: {detail}")]
    Graph {
        /// What is wrong with the graph.
        detail: String,
    },
    /// A constant tensor, such as a weight, is refused.
    #[error(
        "tensor `{name}` is refused: {detail}; tensors hold at most {MOST_NUMBERS} finite numbers of 32 or 64 bits"
    )]
    Tensor {
        /// The name of the tensor.
        name: String,
        /// What is wrong with the tensor.
        detail: String,
    },
    /// A node has an operator that is not supported.
    #[error("node `{node}` uses operator {operator}, which is not supported; supported are {supported}")]
    UnknownOperator {
        /// The name of the node.
        node: String,
        /// The operator, with its domain if that is not the default one.
        operator: String,
        /// All supported operators.
        supported: String,
    },
    /// A node uses a supported operator in a way that is not supported.
    #[error("node `{node}` ({operator}) is refused: {detail}")]
    Node {
        /// The name of the node.
        node: String,
        /// The operator of the node.
        operator: String,
        /// What is wrong with the node.
        detail: String,
    },
    /// The network was run on the wrong number of inputs.
    #[error("the network has {expected} inputs, and {found} were given")]
    InputCount {
        /// The number of inputs of the network.
        expected: usize,
        /// The number of tensors given.
        found: usize,
    },
    /// A tensor does not fit the declared shape of an input or output.
    #[error(
        "`{name}` is declared with shape {expected:?} (None is free), and {numbers} numbers of shape {found:?} came"
    )]
    PortShape {
        /// The name of the input or output.
        name: String,
        /// The declared shape.
        expected: Vec<Option<usize>>,
        /// The shape of the tensor.
        found: Vec<usize>,
        /// How many numbers the tensor holds.
        numbers: usize,
    },
    /// A node cannot work on the shapes or numbers it gets.
    #[error("node `{node}` ({operator}) cannot run: {detail}")]
    Run {
        /// The name of the node.
        node: String,
        /// The operator of the node.
        operator: String,
        /// What is wrong with the inputs of the node.
        detail: String,
    },
}

naoisis_core::debug_as_displayed!(NetworkError);
