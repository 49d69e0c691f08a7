"""The environment of RLlib, where it is installed."""

import importlib.util
import math
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("ray.rllib")
from naoisis.rllib import MatchEnv


def test_an_episode_is_played_with_all_agents_to_its_end():
    env = MatchEnv({"scenario": "TwoOnTwo", "control": "blue", "set": {"duration_s": 1}})
    observations, _ = env.reset(seed=1)
    assert set(observations) == set(env.agents) == {"blue_1", "blue_2"}
    actions = {agent: np.zeros(8, np.float32) for agent in env.agents}
    for step in range(10):
        observations, rewards, terminateds, truncateds, _ = env.step(actions)
        assert env.observation_spaces["blue_1"].contains(observations["blue_1"])
        assert truncateds["__all__"] == (step == 9) and not terminateds["__all__"]


def test_other_processes_play_what_the_example_learns_from(capsys):
    ray = pytest.importorskip("ray")
    pytest.importorskip("torch")
    spec = importlib.util.spec_from_file_location(
        "rllib_main", Path(__file__).parent.parent / "examples" / "rllib" / "main.py"
    )
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    # Two processors are needed: each of them plays one.
    ray.init(num_cpus=3, include_dashboard=False, log_to_driver=False)
    try:
        mean = example.main(2, runners=2)
    finally:
        ray.shutdown()
    assert "iteration 2: mean return" in capsys.readouterr().out
    # No episode may have ended yet.
    assert math.isnan(mean) or -20 < mean < 20
