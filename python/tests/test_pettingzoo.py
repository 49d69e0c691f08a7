"""The environment of PettingZoo."""

import warnings

import numpy as np
import pytest

import naoisis

pytest.importorskip("pettingzoo")
from pettingzoo.test import parallel_api_test, parallel_seed_test
from pettingzoo.test.state_test import state_test
from pettingzoo.utils import parallel_to_aec

OPTIONS = {"control": "blue", "opponents": "roles", "set": {"duration_s": 5}}


@pytest.mark.parametrize("observation", ["perception", "belief", "truth", "image"])
def test_pettingzoo_accepts_it(observation):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        parallel_api_test(naoisis.parallel_env("match3v3", observation=observation, **OPTIONS), num_cycles=60)


@pytest.mark.parametrize("control", ["blue", "pink", ["blue", "pink"]])
def test_the_state_has_a_space_and_the_frame_of_blue(control):
    env = naoisis.parallel_env("match3v3", control=control, set={"duration_s": 2})
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        state_test(parallel_to_aec(naoisis.parallel_env("match3v3", control=control)), env, 30)
    env.reset(seed=1)
    state = dict(zip(env.state_names, env.state()))
    # Each team stands in its own half.
    assert state["blue1.x"] < 0 < state["pink1.x"], state


def test_the_same_seed_is_the_same_match():
    parallel_seed_test(lambda: naoisis.parallel_env("TwoOnTwo"), num_cycles=30)


def test_both_teams_can_be_controlled_and_a_penalised_robot_stays():
    env = naoisis.parallel_env("match3v3", control=["blue", "pink"], observation="truth", set={"rules.penalty_s": 5})
    assert env.possible_agents == ["blue_1", "blue_2", "blue_3", "pink_1", "pink_2", "pink_3"]
    observations, _ = env.reset(seed=1)
    # The teams see the same from either side.
    x = env.observation_names.index("own.x")
    assert observations["blue_1"][x] < 0 and observations["pink_1"][x] < 0
    ahead = {agent: np.array([1, 0, 0, 0, 0, -1, 0, 0], np.float32) for agent in env.agents}
    flag = env.observation_names.index("body.penalised")
    penalised = False
    while env.agents and not penalised:
        observations, *_ = env.step(ahead)
        penalised = any(observation[flag] for observation in observations.values())
        assert set(observations) == set(env.possible_agents)
    assert penalised and env.agents == env.possible_agents


def test_bad_steps_are_clear_exceptions():
    env = naoisis.parallel_env("TwoOnTwo")
    action = np.zeros(8, np.float32)
    with pytest.raises(naoisis.MatchError, match="has not begun"):
        env.step({"blue_1": action, "blue_2": action})
    env.reset(seed=1)
    with pytest.raises(ValueError, match="missing for blue_2"):
        env.step({"blue_1": action})
    with pytest.raises(ValueError, match="expected"):
        env.step({"blue_1": action[:3], "blue_2": action[:3]})
    with pytest.raises(ValueError, match="render_mode"):
        naoisis.parallel_env("TwoOnTwo", render_mode="ascii")
