//! From the bytes of an ONNX file to a checked program.

use std::collections::{HashMap, HashSet};

use rten_onnx::onnx::{GraphProto, ModelProto, NodeProto, ValueInfoProto};

use super::{
    NetworkError, Port, Program, Step,
    constants::{Constant, Element},
    node::{Node, Operand},
    operators::{self, Entry},
    tensor::Tensor,
    wire,
};

/// The program in the `bytes` of an ONNX file.
pub(super) fn read(bytes: &[u8]) -> Result<Program, NetworkError> {
    wire::check(bytes).map_err(|detail| NetworkError::NotOnnx { detail })?;
    let model = ModelProto::parse_buf(bytes).map_err(|error| NetworkError::NotOnnx { detail: error.to_string() })?;
    let graph = model.graph.as_ref().ok_or_else(|| NetworkError::NotOnnx { detail: "it has no graph".into() })?;
    let default = model.opset_import.iter().find(|set| is_default(set.domain.as_deref()));
    let found = default.and_then(|set| set.version);
    let operator_set =
        found.filter(|version| (11..=20).contains(version)).ok_or(NetworkError::OperatorSet { found })?;
    let mut reader = Reader { operator_set, ..Reader::default() };
    reader.read_initializers(graph)?;
    reader.read_inputs(graph)?;
    let made: HashSet<&str> = graph.node.iter().flat_map(|node| &node.output).map(String::as_str).collect();
    for node in &graph.node {
        reader.read_node(node, &made)?;
    }
    reader.read_outputs(graph)?;
    Ok(reader.finish())
}

/// Whether `domain` is that of ONNX's own operators.
fn is_default(domain: Option<&str>) -> bool {
    matches!(domain, None | Some("" | "ai.onnx"))
}

/// What is known of a value.
struct Slot {
    element: Element,
    constant: Option<Constant>,
}

/// A program while it is read.
#[derive(Default)]
struct Reader {
    operator_set: i64,
    names: HashMap<String, usize>,
    slots: Vec<Slot>,
    program: Program,
}

impl Reader {
    /// Gives the value `name` a slot of its own.
    fn add(&mut self, name: &str, element: Element, constant: Option<Constant>) -> Result<usize, NetworkError> {
        let slot = self.slots.len();
        if self.names.insert(name.into(), slot).is_some() {
            return Err(NetworkError::Graph { detail: format!("two values are named `{name}`") });
        }
        self.slots.push(Slot { element, constant });
        Ok(slot)
    }

    fn read_initializers(&mut self, graph: &GraphProto) -> Result<(), NetworkError> {
        for tensor in &graph.initializer {
            let name = tensor.name.as_deref().unwrap_or_default();
            let constant =
                Constant::from_tensor(tensor).map_err(|detail| NetworkError::Tensor { name: name.into(), detail })?;
            self.add(name, constant.element, Some(constant))?;
        }
        Ok(())
    }

    /// Reads the inputs of the graph. Older files list their initializers among them.
    fn read_inputs(&mut self, graph: &GraphProto) -> Result<(), NetworkError> {
        let initializers: HashSet<_> = graph.initializer.iter().map(|tensor| &tensor.name).collect();
        for value in graph.input.iter().filter(|value| !initializers.contains(&value.name)) {
            let (port, element) = port(value).map_err(|detail| NetworkError::Graph { detail })?;
            let slot = self.add(&port.name, element, None)?;
            self.program.inputs.push(port);
            self.program.input_slots.push(slot);
        }
        Ok(())
    }

    fn read_outputs(&mut self, graph: &GraphProto) -> Result<(), NetworkError> {
        for value in &graph.output {
            let (port, _) = port(value).map_err(|detail| NetworkError::Graph { detail })?;
            let Some(&slot) = self.names.get(&port.name) else {
                return Err(NetworkError::Graph { detail: format!("no node makes the output `{}`", port.name) });
            };
            self.program.outputs.push(port);
            self.program.output_slots.push(slot);
        }
        if self.program.outputs.is_empty() {
            return Err(NetworkError::Graph { detail: "it has no outputs".into() });
        }
        Ok(())
    }

    /// The slot of the value `name`, or `None` for an input left out; `made` are the outputs of all nodes.
    fn slot(&self, name: &str, made: &HashSet<&str>) -> Result<Option<usize>, String> {
        match self.names.get(name) {
            _ if name.is_empty() => Ok(None),
            Some(&slot) => Ok(Some(slot)),
            None if made.contains(name) => {
                Err(format!("it uses `{name}` before a node makes it: nodes must be in order and without cycles"))
            }
            None => Err(format!("it uses `{name}`, which no node, input or constant provides")),
        }
    }

    fn read_node(&mut self, proto: &NodeProto, made: &HashSet<&str>) -> Result<(), NetworkError> {
        let (node, entry) = entry_of(proto)?;
        let refused = |detail: String| NetworkError::Node { node: node.clone(), operator: entry.name.into(), detail };
        if entry.name == "Constant" {
            let constant = Constant::from_node(proto).map_err(refused)?;
            let name = proto.output.first().map(String::as_str).unwrap_or_default();
            return self.add(name, constant.element, Some(constant)).map(drop);
        }
        let slots: Result<Vec<_>, _> = proto.input.iter().map(|name| self.slot(name, made)).collect();
        let mut inputs = slots.map_err(refused)?;
        let (operator, element, kept) = self.read_operator(proto, entry, &inputs).map_err(refused)?;
        for (input, kept) in inputs.iter_mut().zip(kept) {
            if kept {
                *input = None;
            }
        }
        let mut step = Step { node, name: entry.name, operator, inputs, outputs: Vec::new(), done: Vec::new() };
        let constants = self.fold(&step, element)?;
        let is_constant = constants.is_some();
        let mut constants = constants.unwrap_or_default().into_iter();
        for name in &proto.output {
            let constant = constants.next();
            let slot = if name.is_empty() { None } else { Some(self.add(name, element, constant)?) };
            step.outputs.push(slot);
        }
        if !is_constant {
            self.program.steps.push(step);
        }
        Ok(())
    }

    /// The operator of the node `proto` with its `inputs`, what it makes, and which inputs it keeps.
    fn read_operator(
        &self,
        proto: &NodeProto,
        entry: &Entry,
        inputs: &[Option<usize>],
    ) -> Result<(Box<dyn operators::Operator>, Element, Vec<bool>), String> {
        let operand = |slot: usize| {
            let slot = &self.slots[slot];
            Operand { element: slot.element, constant: slot.constant.as_ref() }
        };
        let operands: Vec<_> = inputs.iter().map(|slot| slot.map(operand)).collect();
        let given = operands.iter().rposition(Option::is_some).map_or(0, |last| last + 1);
        if given > entry.most_inputs {
            return Err(format!("it has {given} inputs, and at most {} are supported", entry.most_inputs));
        }
        if operands.iter().take(entry.inputs).flatten().count() < entry.inputs {
            return Err(format!("it needs {} inputs, of which not all are there", entry.inputs));
        }
        let outputs = proto.output.iter().rposition(|name| !name.is_empty()).map_or(0, |last| last + 1);
        if outputs > entry.most_outputs {
            return Err(format!("it has {outputs} outputs, and at most {} are supported", entry.most_outputs));
        }
        let node = Node::new(proto, self.operator_set, operands.clone());
        let (operator, element) = (entry.read)(&node)?;
        node.expect_all_read()?;
        let kept = node.into_kept();
        for (operand, &kept) in operands.iter().zip(&kept) {
            if let Some(constant) = operand.and_then(|operand| operand.constant)
                && !kept
            {
                constant.check_operand()?;
            }
        }
        Ok((operator, element, kept))
    }

    /// The results of `step` if they do not depend on the network's inputs.
    fn fold(&self, step: &Step, element: Element) -> Result<Option<Vec<Constant>>, NetworkError> {
        let constant = |slot: &Option<usize>| slot.map(|slot| self.slots[slot].constant.as_ref());
        let operands: Vec<_> = step.inputs.iter().map(constant).collect();
        if operands.iter().any(|operand| matches!(operand, Some(None))) {
            return Ok(None);
        }
        let tensors: Vec<Option<&Tensor>> =
            operands.into_iter().map(|operand| operand.flatten().map(|constant| &constant.tensor)).collect();
        let results = step.run(&tensors)?.into_iter().map(|tensor| Constant::computed(element, tensor));
        let constants: Result<_, _> = results.collect();
        constants.map(Some).map_err(|detail| NetworkError::Tensor { name: step.node.clone(), detail })
    }

    /// The program, with the constants that its steps need and the slots that each step is the last to need.
    fn finish(self) -> Program {
        let Self { slots, mut program, .. } = self;
        let mut needed: HashSet<usize> = program.output_slots.iter().copied().collect();
        for step in program.steps.iter_mut().rev() {
            let used = step.outputs.iter().chain(&step.inputs).flatten();
            step.done = used.copied().filter(|&slot| needed.insert(slot)).collect();
        }
        let constants = slots.into_iter().enumerate();
        program.constants = constants
            .map(|(slot, value)| value.constant.filter(|_| needed.contains(&slot)).map(|constant| constant.tensor))
            .collect();
        program
    }
}

/// The name by which messages call the node `proto`, and its operator.
fn entry_of(proto: &NodeProto) -> Result<(String, &'static Entry), NetworkError> {
    let first_output = proto.output.first().map(String::as_str).unwrap_or_default();
    let node = proto.name.clone().filter(|name| !name.is_empty()).unwrap_or_else(|| format!("of {first_output}"));
    let name = proto.op_type.as_deref().unwrap_or_default();
    let domain = proto.domain.as_deref();
    match operators::entry_named(name).filter(|_| is_default(domain)) {
        Some(entry) => Ok((node, entry)),
        None => {
            let operator =
                if is_default(domain) { name.into() } else { format!("{}.{name}", domain.unwrap_or_default()) };
            Err(NetworkError::UnknownOperator { node, operator, supported: operators::names() })
        }
    }
}

/// The input or output that `value` declares, and its kind of number.
fn port(value: &ValueInfoProto) -> Result<(Port, Element), String> {
    let name = value.name.clone().unwrap_or_default();
    let tensor = value.r#type.as_ref().and_then(|kind| kind.tensor_type.as_ref());
    let tensor = tensor.ok_or_else(|| format!("`{name}` is not declared as a tensor"))?;
    let code = tensor.elem_type.ok_or_else(|| format!("`{name}` has no type of elements"))?;
    let element = Element::of(code).map_err(|detail| format!("`{name}`: {detail}"))?;
    let shape = tensor.shape.as_ref().ok_or_else(|| format!("`{name}` has no declared shape"))?;
    let size = |dimension: &rten_onnx::onnx::Dimension| match dimension.dim_value {
        None => Ok(None),
        Some(size) if size > 0 => usize::try_from(size).map(Some).map_err(|error| error.to_string()),
        Some(size) => Err(format!("`{name}` has a dimension of size {size}")),
    };
    let shape = shape.dim.iter().map(size).collect::<Result<_, _>>()?;
    Ok((Port { name, shape }, element))
}
