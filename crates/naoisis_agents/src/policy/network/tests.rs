//! Tests of whole networks, built with the writer of the ONNX library.

use std::cell::RefCell;

use proptest::prelude::*;
use rten_onnx::onnx::{
    AttributeProto, AttributeType, DataLocation, DataType, Dimension, GraphProto, ModelProto, NodeProto,
    OperatorSetIdProto, TensorProto, TensorShapeProto, TypeProto, TypeProtoTensor, ValueInfoProto,
};

use super::*;

/// A node named after its operator.
fn node(operator: &str, inputs: &[&str], outputs: &[&str]) -> NodeProto {
    NodeProto {
        name: Some(format!("my_{operator}")),
        op_type: Some(operator.into()),
        input: inputs.iter().map(|&name| name.into()).collect(),
        output: outputs.iter().map(|&name| name.into()).collect(),
        ..NodeProto::default()
    }
}

fn with(mut node: NodeProto, name: &str, set: impl Fn(&mut AttributeProto), kind: AttributeType) -> NodeProto {
    let mut attribute = AttributeProto { name: Some(name.into()), r#type: Some(kind), ..AttributeProto::default() };
    set(&mut attribute);
    node.attribute.push(attribute);
    node
}

fn with_int(node: NodeProto, name: &str, value: i64) -> NodeProto {
    with(node, name, |attribute| attribute.i = Some(value), AttributeType::INT)
}

fn with_text(node: NodeProto, name: &str, value: &str) -> NodeProto {
    with(node, name, |attribute| attribute.s = Some(value.into()), AttributeType::STRING)
}

fn floats(name: &str, dims: &[i64], values: &[f32]) -> TensorProto {
    let bytes = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    TensorProto {
        name: Some(name.into()),
        dims: dims.to_vec(),
        data_type: Some(DataType::FLOAT),
        raw_data: Some(RefCell::new(bytes)),
        ..TensorProto::default()
    }
}

fn integers(name: &str, values: &[i64]) -> TensorProto {
    TensorProto {
        name: Some(name.into()),
        dims: vec![values.len() as i64],
        data_type: Some(DataType::INT64),
        int64_data: values.to_vec(),
        ..TensorProto::default()
    }
}

/// An input or output `name` of floats, whose dimensions of size 0 are free.
fn value(name: &str, shape: &[i64]) -> ValueInfoProto {
    let dimension = |&size: &i64| match size {
        0 => Dimension { dim_param: Some("batch".into()), dim_value: None },
        _ => Dimension { dim_value: Some(size), dim_param: None },
    };
    let shape = Some(TensorShapeProto { dim: shape.iter().map(dimension).collect() });
    let tensor_type = Some(TypeProtoTensor { elem_type: Some(DataType::FLOAT), shape });
    ValueInfoProto { name: Some(name.into()), r#type: Some(TypeProto { tensor_type, sequence: None }) }
}

/// A model from `x`, of two numbers per row, to `y`, of two more.
fn model(node: Vec<NodeProto>, initializer: Vec<TensorProto>) -> ModelProto {
    let (input, output) = (vec![value("x", &[0, 2])], vec![value("y", &[0, 2])]);
    ModelProto {
        ir_version: Some(8),
        graph: Some(GraphProto { node, initializer, input, output, value_info: Vec::new() }),
        opset_import: vec![OperatorSetIdProto { domain: None, version: Some(17) }],
        ..ModelProto::default()
    }
}

fn read(model: &ModelProto) -> Result<Network, NetworkError> {
    Network::read(&model.write_buf().unwrap())
}

fn refusal(nodes: Vec<NodeProto>, initializers: Vec<TensorProto>) -> String {
    read(&model(nodes, initializers)).unwrap_err().to_string()
}

/// A layer with weights and a bias, then a hyperbolic tangent.
fn layer() -> ModelProto {
    let gemm = with_int(node("Gemm", &["x", "w", "b"], &["h"]), "transB", 1);
    let weights = floats("w", &[2, 2], &[0.5, -0.25, 1.0, 2.0]);
    model(vec![gemm, node("Tanh", &["h"], &["y"])], vec![weights, floats("b", &[2], &[0.5, -1.0])])
}

fn tensor(shape: &[usize], values: &[f32]) -> Tensor {
    Tensor { shape: shape.to_vec(), values: values.to_vec() }
}

#[test]
fn a_layer_runs_on_batches_of_any_size() {
    let network = read(&layer()).unwrap();
    assert_eq!(network.inputs(), [Port { name: "x".into(), shape: vec![None, Some(2)] }]);
    assert_eq!(network.outputs(), [Port { name: "y".into(), shape: vec![None, Some(2)] }]);
    let both = network.run(&[tensor(&[2, 2], &[1.0, 2.0, -0.5, 0.25])]).unwrap();
    let expected = [0.5, 4.0, 0.1875, -1.0].map(math::tanh);
    assert_eq!(both, [tensor(&[2, 2], &expected)]);
    let alone = network.run(&[tensor(&[1, 2], &[-0.5, 0.25])]).unwrap();
    assert_eq!(alone, [tensor(&[1, 2], &expected[2..])]);
}

#[test]
fn inputs_of_other_shapes_are_refused() {
    let network = read(&layer()).unwrap();
    assert_eq!(network.run(&[]), Err(NetworkError::InputCount { expected: 1, found: 0 }));
    for wrong in [tensor(&[1, 3], &[0.0; 3]), tensor(&[2], &[0.0; 2]), tensor(&[1, 2], &[0.0]), tensor(&[0, 2], &[])] {
        assert!(matches!(network.run(&[wrong]), Err(NetworkError::PortShape { name, .. }) if name == "x"));
    }
}

#[test]
fn what_depends_on_constants_alone_is_computed_on_reading() {
    let nodes = vec![
        node("Identity", &["sizes"], &["same"]),
        node("Concat", &["same", "one"], &["shape"]),
        node("Expand", &["w", "shape"], &["wide"]),
        node("Add", &["x", "wide"], &["y"]),
    ];
    let nodes = nodes.into_iter().map(|node| if node.input[0] == "same" { with_int(node, "axis", 0) } else { node });
    let constants = vec![integers("sizes", &[1]), integers("one", &[2]), floats("w", &[], &[3.0])];
    let network = read(&model(nodes.collect(), constants)).unwrap();
    assert_eq!(network.0.steps.len(), 1);
    assert_eq!(network.run(&[tensor(&[1, 2], &[1.0, 2.0])]), Ok(vec![tensor(&[1, 2], &[4.0, 5.0])]));
}

#[test]
fn unsupported_operators_are_named_with_those_supported() {
    let message = refusal(vec![node("Conv", &["x"], &["y"])], vec![]);
    assert!(message.contains("`my_Conv` uses operator Conv") && message.contains("Gemm, Identity"), "{message}");
    let foreign = NodeProto { domain: Some("com.microsoft".into()), ..node("Gelu", &["x"], &["y"]) };
    assert!(refusal(vec![foreign], vec![]).contains("com.microsoft.Gelu"));
    let branch = with(
        node("If", &["x"], &["y"]),
        "then_branch",
        |attribute| attribute.g = Some(GraphProto::default()),
        AttributeType::GRAPH,
    );
    assert!(refusal(vec![branch], vec![]).contains("operator If"));
}

#[test]
fn graphs_that_do_not_hold_together_are_refused() {
    let message = refusal(vec![node("Add", &["x", "z"], &["y"])], vec![]);
    assert!(message.contains("uses `z`, which no node"), "{message}");
    let cycle = vec![node("Add", &["x", "y"], &["h"]), node("Tanh", &["h"], &["y"])];
    assert!(refusal(cycle, vec![]).contains("cycles"));
    let twice = vec![node("Tanh", &["x"], &["y"]), node("Relu", &["x"], &["y"])];
    assert!(refusal(twice, vec![]).contains("two values are named `y`"));
    assert!(refusal(vec![node("Tanh", &["x"], &["h"])], vec![]).contains("no node makes the output `y`"));
}

#[test]
fn unusable_models_are_refused() {
    assert!(matches!(Network::read(b"no model"), Err(NetworkError::NotOnnx { .. })));
    assert!(Network::read(&[]).unwrap_err().to_string().contains("no graph"));
    for version in [10, 21] {
        let mut old = layer();
        old.opset_import[0].version = Some(version);
        assert_eq!(read(&old).unwrap_err(), NetworkError::OperatorSet { found: Some(version) });
    }
    let mut half = layer();
    let graph = half.graph.as_mut().unwrap();
    graph.input[0].r#type.as_mut().unwrap().tensor_type.as_mut().unwrap().elem_type = Some(DataType::FLOAT16);
    assert!(read(&half).unwrap_err().to_string().contains("FLOAT16"));
}

#[test]
fn unusable_constants_are_refused() {
    let with_weights = |weights: TensorProto| refusal(vec![node("Add", &["x", "w"], &["y"])], vec![weights]);
    let message = with_weights(floats("w", &[1], &[f32::INFINITY]));
    assert!(message.contains("tensor `w` is refused: it holds inf"), "{message}");
    let external = TensorProto { data_location: Some(DataLocation::EXTERNAL), ..floats("w", &[1], &[]) };
    assert!(with_weights(external).contains("another file"));
    assert!(with_weights(floats("w", &[0], &[])).contains("empty constant"));
    assert!(with_weights(integers("w", &[1])).contains("same kind of number"));
    let large = vec![integers("a", &[1 << 40]), integers("b", &[2])];
    assert!(refusal(vec![node("Add", &["a", "b"], &["y"])], large).contains("1099511627776"));
}

#[test]
fn unsupported_uses_of_operators_are_refused() {
    let state = || vec![floats("w", &[1, 6, 2], &[0.0; 12]), floats("r", &[1, 6, 2], &[0.0; 12])];
    let gru = || node("GRU", &["x", "w", "r"], &["", "y"]);
    let scalar = |value| vec![floats("e", &[], &[value])];
    let cases = [
        (vec![node("Pow", &["x", "e"], &["y"])], scalar(3.0), "exponent is 3"),
        (vec![node("Pow", &["x", "x"], &["y"])], vec![], "`exponent` must be constant"),
        (vec![with_int(node("Tanh", &["x"], &["y"]), "fast", 1)], vec![], "attribute `fast` is not supported"),
        (vec![with_text(node("Elu", &["x"], &["y"]), "alpha", "1")], vec![], "`alpha` has the wrong type"),
        (vec![with_int(node("Cast", &["x"], &["y"]), "to", 10)], vec![], "FLOAT16"),
        (vec![node("Add", &["x"], &["y"])], vec![], "needs 2 inputs"),
        (vec![node("Tanh", &["x", "x"], &["y"])], vec![], "2 inputs"),
        (vec![node("Dropout", &["x"], &["y", "mask"])], vec![], "2 outputs"),
        (vec![with_text(gru(), "direction", "reverse")], state(), "\"reverse\""),
        (vec![with_int(gru(), "hidden_size", 3)], state(), "`hidden_size` is 3"),
        (vec![node("GRU", &["x", "x", "x"], &["y"])], vec![], "`W` must be constant"),
        (vec![node("Gemm", &["x", "e"], &["y"])], scalar(1.0), "not that of a matrix"),
        (vec![node("Reshape", &["x", "x"], &["y"])], vec![], "must be integers"),
        (vec![node("Constant", &[], &["y"])], vec![], "exactly one attribute"),
    ];
    for (nodes, initializers, expected) in cases {
        let message = refusal(nodes, initializers);
        assert!(message.contains(expected), "{message} does not say {expected}");
    }
}

#[test]
fn failing_runs_name_the_node() {
    let nodes = vec![with_int(node("Concat", &["x", "w"], &["y"]), "axis", 1)];
    let network = read(&model(nodes, vec![floats("w", &[1, 2], &[0.0; 2])])).unwrap();
    let message = network.run(&[tensor(&[2, 2], &[0.0; 4])]).unwrap_err().to_string();
    assert!(message.contains("`my_Concat` (Concat) cannot run: shapes [2, 2] and [1, 2]"), "{message}");
    let wide = network.run(&[tensor(&[1, 2], &[0.0; 2])]).unwrap_err();
    assert!(matches!(wide, NetworkError::PortShape { name, found, .. } if name == "y" && found == [1, 4]));
}

proptest! {
    #[test]
    fn damaged_files_give_errors(changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)) {
        let mut bytes = layer().write_buf().unwrap();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        if let Ok(network) = Network::read(&bytes) {
            let input = |port: &Port| {
                let shape: Vec<usize> = port.shape.iter().map(|size| size.unwrap_or(3)).collect();
                let numbers = tensor::count(&shape).unwrap_or(0);
                Tensor { shape, values: vec![1.0; numbers] }
            };
            let inputs: Vec<_> = network.inputs().iter().map(input).collect();
            drop(network.run(&inputs));
        }
    }

    #[test]
    fn any_bytes_give_errors(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        prop_assert!(Network::read(&bytes).is_err());
    }
}
