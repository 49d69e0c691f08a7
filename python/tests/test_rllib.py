"""The environment of RLlib, where it is installed."""

import numpy as np
import pytest

pytest.importorskip("ray.rllib")
from naoisis.rllib import MatchEnv  # noqa: E402


def test_an_episode_is_played_with_all_agents_to_its_end():
    env = MatchEnv({"scenario": "TwoOnTwo", "control": "blue", "set": {"duration_s": 1}})
    observations, _ = env.reset(seed=1)
    assert set(observations) == set(env.agents) == {"blue_1", "blue_2"}
    actions = {agent: np.zeros(8, np.float32) for agent in env.agents}
    for step in range(10):
        observations, rewards, terminateds, truncateds, _ = env.step(actions)
        assert env.observation_spaces["blue_1"].contains(observations["blue_1"])
        assert truncateds["__all__"] == (step == 9) and not terminateds["__all__"]
