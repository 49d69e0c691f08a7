"""Converts a policy of ``main.py`` to ONNX, which naoisis plays without Python, and writes its layout (.json).

``pip install onnx``, then ``python export.py policies/ScoreEmptyGoal-belief.npz score_empty_goal.onnx``.
``naoisis challenge ScoreEmptyGoal --policy score_empty_goal.onnx`` measures the policy's success rate, and
``{"behaviour": {"policy": "score_empty_goal.onnx"}}`` gives it to a robot of a scenario. Only policies that observe beliefs can be
converted: the others have a memory in NumPy (``policy.Senses``).
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper


def spread(name: str) -> tuple[list[onnx.NodeProto], list[onnx.TensorProto], str]:
    """Returns the nodes and constants that compute ``policy.spread`` of the tensor ``name``, and the name of the result."""
    numbers = {"three": 3.0, "twenty": 20.0, "one": 1.0, "least": -3.0, "most": 3.0}
    constants = [numpy_helper.from_array(np.array(value, np.float32), key) for key, value in numbers.items()]
    nodes = [
        helper.make_node("Div", [name, "three"], ["third"]),
        helper.make_node("Clip", ["third", "least", "most"], ["far"]),
        helper.make_node("Mul", [name, "twenty"], ["large"]),
        helper.make_node("Asinh", ["large"], ["bent"]),
        helper.make_node("Div", ["bent", "three"], ["near"]),
        helper.make_node("Concat", ["far", "near"], ["features"], axis=1),
    ]
    return nodes, constants, "features"


def network(layers: list[tuple[np.ndarray, np.ndarray]]) -> onnx.ModelProto:
    """Returns the whole network: features, hidden layers with tanh, and the logits of the choices. ``layers`` has the weights and biases of
    each."""
    numbers = layers[0][0].shape[1] // 2
    nodes, constants, signal = spread("observation")
    for index, (weight, bias) in enumerate(layers):
        constants += [numpy_helper.from_array(weight.astype(np.float32), f"weight{index}")]
        constants += [numpy_helper.from_array(bias.astype(np.float32), f"bias{index}")]
        is_last = index == len(layers) - 1
        out = "scores" if is_last else f"sum{index}"
        nodes.append(helper.make_node("Gemm", [signal, f"weight{index}", f"bias{index}"], [out], transB=1))
        if not is_last:
            nodes.append(helper.make_node("Tanh", [out], [f"hidden{index}"]))
            signal = f"hidden{index}"
    ports = [
        helper.make_tensor_value_info(name, TensorProto.FLOAT, ["batch", length])
        for name, length in (("observation", numbers), ("scores", len(layers[-1][1])))
    ]
    graph = helper.make_graph(nodes, "policy", ports[:1], ports[1:], constants)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.checker.check_model(model, full_check=True)
    return model


def main() -> None:
    """Reads the policy, and writes the network and its layout."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("policy", type=Path, help="a file in the folder `policies`, of a policy that observes beliefs")
    parser.add_argument("out", type=Path, help="the ONNX file to write")
    arguments = parser.parse_args()
    with np.load(arguments.policy) as file:
        layers = [(file[f"weight{layer}"], file[f"bias{layer}"]) for layer in range(len(file.files) // 2)]
    # The last row of the learning curve beside the policy.
    steps = int(arguments.policy.with_suffix(".csv").read_text().split()[-1].split(",")[0])
    onnx.save(network(layers), arguments.out)
    layout = {
        "observation": "belief",
        "action": "discrete",
        "cycles_per_step": 3,
        "choice": "drawn",
        "interactions": steps,
        "note": f"learned by python/examples/ppo/main.py: {arguments.policy.stem}",
    }
    arguments.out.with_suffix(".json").write_text(json.dumps(layout, indent=2) + "\n")


if __name__ == "__main__":
    main()
