"""Learned policies: what is trained in Python plays without it, with the same outputs."""

import json
import pickle
from pathlib import Path

import gymnasium
import numpy as np
import pytest

import naoisis
from naoisis.self_play import SelfPlay

SCORE = Path(__file__).parents[2] / "assets/policies/score_empty_goal.onnx"


def torch_with_onnx():
    """PyTorch, where it and the package that its exporter needs are installed."""
    pytest.importorskip("onnx")
    return pytest.importorskip("torch")


def test_a_policy_of_a_file_scores_in_its_environment():
    policy = naoisis.Policy(SCORE)
    assert policy.layout["observation"] == "belief"
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="belief", action="discrete")
    scored = 0
    for seed in range(1, 6):
        observation, _ = env.reset(seed=seed)
        ended = False
        while not ended:
            observation, _, terminated, truncated, info = env.step(policy(observation))
            ended = terminated or truncated
        scored += info["success"]
    assert scored >= 4


def test_rows_are_robots_and_the_seed_draws():
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="belief").unwrapped
    observations = np.zeros((3, len(env.observation_names)))
    scores = naoisis.Policy(SCORE).scores(observations)
    assert scores.shape == (3, 13) and np.array_equal(scores[1], naoisis.Policy(SCORE).scores(observations[1]))
    first, second, other = (naoisis.Policy(SCORE, seed) for seed in (1, 1, 2))
    drawn = [[policy(observations[0]) for _ in range(40)] for policy in (first, second, other)]
    assert drawn[0] == drawn[1] != drawn[2]


def test_what_is_no_policy_is_refused_by_name(tmp_path):
    with pytest.raises(ValueError, match="missing.onnx: "):
        naoisis.Policy(tmp_path / "missing.onnx")
    with pytest.raises(ValueError, match="has 5: it was made for"):
        naoisis.Policy(SCORE).scores(np.zeros(5))
    with pytest.raises(ValueError, match="expected one row of numbers"):
        naoisis.Policy(SCORE)(np.zeros((1, 1, 1)))


@pytest.mark.parametrize("action", ["continuous", "multi_discrete", "discrete", "velocities"])
def test_a_module_of_torch_plays_as_it_was_trained(tmp_path, action):
    torch = torch_with_onnx()
    options = {"control": "blue", "opponents": "roles", "observation": "belief"}
    envs = naoisis.vector_env("match3v3", 2, action=action, cycles_per_step=5, **options)
    observations, _ = envs.reset(seed=1)
    outputs = 8 if action == "continuous" else sum(len(names) for names in envs.action_names)
    torch.manual_seed(3)
    last = [torch.nn.Tanh()] if action == "continuous" else []
    layers = [
        torch.nn.Linear(observations.shape[1], 32),
        torch.nn.ReLU(),
        torch.nn.LayerNorm(32),
        torch.nn.Linear(32, outputs),
    ]
    module = torch.nn.Sequential(*layers, *last)
    policy = naoisis.export_policy(module, tmp_path / "policy.onnx", envs, interactions=1234, note="a test")
    layout = json.loads((tmp_path / "policy.json").read_text())
    assert (layout["action"], layout["cycles_per_step"], layout["note"]) == (action, 5, "a test")
    assert (layout["team_mates"], layout["opponents"], layout["interactions"]) == (2, 3, 1234)
    with torch.no_grad():
        expected = module(torch.from_numpy(observations)).numpy()
    assert np.allclose(policy.scores(observations), expected, atol=1e-4)
    envs.step(policy(observations))
    # The same file plays a whole team, without Python.
    match = naoisis.Match("match3v3", blue=f"policy:{tmp_path / 'policy.onnx'}", seed=1)
    match.run(2.0)
    assert not [event for event in match.truth()["events"] if event["type"] == "agent_lost"]


STATE = {"hidden": (1, 8)}


def recurrent(torch, length):
    """Returns a policy of discrete actions with a memory."""

    class Recurrent(torch.nn.Module):
        def __init__(self):
            super().__init__()
            self.cell, self.out = torch.nn.GRUCell(length, 8), torch.nn.Linear(8, 13)

        def forward(self, observed, hidden):
            hidden = self.cell(observed, hidden)
            return self.out(hidden), hidden

    torch.manual_seed(1)
    return Recurrent()


def test_a_recurrent_module_keeps_its_state(tmp_path):
    torch = torch_with_onnx()
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="belief", action="discrete")
    observation, _ = env.reset(seed=1)

    policy = naoisis.export_policy(recurrent(torch, len(observation)), tmp_path / "policy.onnx", env, state=STATE)
    first, second = policy.scores(observation), policy.scores(observation)
    assert not np.array_equal(first, second)
    policy.reset()
    assert np.array_equal(policy.scores(observation), first)
    with pytest.raises(ValueError, match="2 rows after 1"):
        policy.scores(np.stack([observation, observation]))


def test_a_pool_keeps_the_memory_of_each_robot(tmp_path, monkeypatch):
    torch = torch_with_onnx()
    envs = SelfPlay("TwoOnTwo", 3, observation="belief", action="discrete")
    module, path = recurrent(torch, len(envs.observation_names)), tmp_path / "policy.onnx"
    policy = naoisis.export_policy(module, path, envs.envs, state=STATE)
    envs.add(pickle.loads(pickle.dumps(policy)))
    envs.reset(seed=3)
    envs.drawn[:] = [1, 0, 1]
    step, played = envs.envs.step, []
    monkeypatch.setattr(envs.envs, "step", lambda actions: played.append(actions) or step(actions))
    # The pink robots of the first and of the last world, each alone.
    alone = {row: naoisis.Policy(path) for row in (2, 3, 10, 11)}
    for turn in range(6):
        if turn == 3:
            # Fewer robots than before.
            envs.drawn[2] = 0
            del alone[10], alone[11]
        expected = {row: of_robot(envs._seen[row]) for row, of_robot in alone.items()}
        envs.step(np.zeros(6, int))
        assert {row: played[-1][row] for row in alone} == expected


def test_what_cannot_be_exported_is_refused(tmp_path):
    torch = torch_with_onnx()
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="belief", action="discrete")
    length = env.observation_space.shape[0]
    good = naoisis.export_policy(torch.nn.Linear(length, 13), tmp_path / "policy.onnx", env, note="good")
    observation = np.zeros(length, np.float32)
    answer = good(observation)
    with pytest.raises(ValueError, match="^module: the network answers 5 numbers; expected 13 scores or 1 choices"):
        naoisis.export_policy(torch.nn.Linear(length, 5), tmp_path / "policy.onnx", env)
    with pytest.raises(ValueError, match="interactions|invalid value"):
        naoisis.export_policy(torch.nn.Linear(length, 13), tmp_path / "policy.onnx", env, interactions=-1)
    with pytest.raises(ValueError, match=r"ends in \.onnx"):
        naoisis.export_policy(torch.nn.Linear(length, 13), tmp_path / "policy", env)
    with pytest.raises(TypeError, match="expected an environment of naoisis"):
        naoisis.export_policy(torch.nn.Linear(length, 13), tmp_path / "policy.onnx", gymnasium.make("CartPole-v1"))

    class Forgetful(torch.nn.Linear):
        """What it counts in Python is a constant in the file."""

        calls = 0

        def forward(self, observed):
            self.calls += 1
            return super().forward(observed) + self.calls

    with pytest.raises(ValueError, match="the module answers"):
        naoisis.export_policy(Forgetful(length, 13), tmp_path / "policy.onnx", env)
    normalised = gymnasium.wrappers.NormalizeObservation(env)
    with pytest.raises(ValueError, match="NormalizeObservation normalises observations"):
        naoisis.export_policy(torch.nn.Linear(length, 13), tmp_path / "policy.onnx", normalised)
    box = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="belief")
    rescaled = gymnasium.wrappers.RescaleAction(box, 0.0, 1.0)
    with pytest.raises(ValueError, match="RescaleAction changes actions"):
        naoisis.export_policy(torch.nn.Linear(length, 8), tmp_path / "policy.onnx", rescaled)

    class OfAll(torch.nn.Linear):
        """It answers a robot by what the others observe, too."""

        def forward(self, observed):
            return super().forward(observed - 0.5 * observed.mean(0, keepdim=True))

    with pytest.raises(ValueError, match="otherwise for several rows"):
        naoisis.export_policy(OfAll(length, 13), tmp_path / "policy.onnx", env)
    with pytest.raises(ValueError, match="expected 13 scores, or 1 choices, whole numbers below"):
        naoisis.export_policy(torch.nn.Linear(length, 1), tmp_path / "policy.onnx", env)

    class Logarithm(torch.nn.Linear):
        """It answers NaN for about half of all numbers."""

        def forward(self, observed):
            return torch.log(super().forward(observed))

    with pytest.raises(ValueError, match="the module answers"):
        naoisis.export_policy(Logarithm(length, 13), tmp_path / "policy.onnx", env)
    parts = torch.nn.Sequential(torch.nn.Linear(length, 13), torch.nn.BatchNorm1d(13)).train()
    parts[1].eval()
    naoisis.export_policy(parts, tmp_path / "parts.onnx", env)
    assert [part.training for part in parts] == [True, False]
    for suffix in (".onnx", ".json"):
        (tmp_path / "parts").with_suffix(suffix).unlink()
    images = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="image")
    with pytest.raises(ValueError, match="is an image"):
        naoisis.export_policy(torch.nn.Linear(length, 13), tmp_path / "policy.onnx", images)
    # The policy that was there before is untouched.
    assert naoisis.Policy(tmp_path / "policy.onnx")(observation) == answer
    assert sorted(file.name for file in tmp_path.iterdir()) == ["policy.json", "policy.onnx"]
