"""What is observed besides, what robots say, what is drawn for episodes, and what infos tell of them."""

import pickle

import gymnasium
import numpy as np
import pytest

import naoisis
from naoisis.self_play import SelfPlay

pettingzoo = pytest.importorskip("pettingzoo")


def _pair(**options):
    """Two robots of a team that hear all that they say."""
    options = {"action": "continuous", "extras": ["messages"], "says": 2, **options}
    return naoisis.parallel_env("TwoOnTwo", "blue", observation="perception", **options)


def _saying(send, *words):
    return np.array([*[0.0] * 8, send, *words], np.float32)


def test_what_a_robot_says_is_what_its_team_mate_hears():
    env = _pair()
    env.reset(seed=1)
    names = env.observation_names
    columns = [names.index(f"message1.{name}") for name in ("heard", "word1", "word2")]
    silent = {agent: _saying(0.0, 1.0, 1.0) for agent in env.agents}
    observations, *_ = env.step(silent)
    assert all((observations[agent][columns] == 0.0).all() for agent in env.agents)
    first, second = env.agents
    env.step({first: _saying(1.0, 0.25, -1.0), second: _saying(0.0, 0.0, 0.0)})
    observations, *_ = env.step(silent)
    assert observations[second][columns].tolist() == [1.0, 0.25, -1.0]
    assert observations[first][columns].tolist() == [0.0, 0.0, 0.0]
    age = names.index("message1.age")
    before = observations[second][age]
    observations, *_ = env.step(silent)
    assert (
        observations[second][age] == pytest.approx(before + 0.06 / 0.02 * 0.02, abs=0.1)
        and observations[second][age] > before
    )
    # Robots with a belief send their pose, too.
    assert observations[second][names.index("message1.pose_known")] == 0.0


def test_a_message_that_is_lost_is_not_heard():
    env = _pair(set={"messages.loss": 1.0})
    env.reset(seed=1)
    for _ in range(5):
        observations, *_ = env.step({agent: _saying(1.0, 1.0, 1.0) for agent in env.agents})
    heard = env.observation_names.index("message1.heard")
    assert all(observations[agent][heard] == 0.0 for agent in env.agents)


def test_words_are_one_more_choice():
    env = _pair(action="velocities")
    assert env.action_names[-1] == ["say_nothing", "say_word1", "say_word2"]
    env.reset(seed=1)
    for _ in range(2):
        observations, *_ = env.step({agent: [0, 0, 0, 0, 2] for agent in env.agents})
    words = [env.observation_names.index(f"message1.word{word}") for word in (1, 2)]
    assert observations["blue_1"][words].tolist() == [0.0, 1.0]


def test_a_set_play_is_observed_as_the_robot_was_told_of_it():
    plain = naoisis.MatchEnv("match7v7", control="blue1").observation_names
    env = naoisis.MatchEnv("match7v7", control="blue1", extras=["set_plays"])
    names = env.observation_names
    assert names[: len(plain)] == plain and names[len(plain)] == "set_play.kick_off"
    left = names.index("set_play.seconds_left")
    observation, _ = env.reset(seed=1)
    times = []
    for _ in range(500):
        observation = env.step(np.zeros(8, np.float32))[0]
        assert env.observation_space.contains(observation)
        times.append(observation[left])
    # The teams have 45 s to get ready, and are told of the first of a half after some seconds.
    begin = next(index for index, time in enumerate(times) if time > 0)
    assert 30 < times[begin] <= 45
    assert times[-1] == pytest.approx(times[begin] - (499 - begin) * env._worlds.step_s, abs=0.1)


def test_penalties_of_other_robots_are_observed_by_their_numbers():
    penalty = {"at_s": 0.5, "do": {"penalise": {"robot": "pink2", "reason": "pushing", "duration_s": 0.5}}}
    env = naoisis.MatchEnv("match3v3", control="blue1", extras=["penalties"], set={"interventions": [penalty]})
    names = [
        f"{group}.penalised"
        for group in ("told_mate1", "told_mate2", "told_opponent1", "told_opponent2", "told_opponent3")
    ]
    assert env.observation_names[-5:] == names
    observation, _ = env.reset(seed=1)
    told = {tuple(env.step(np.zeros(8, np.float32))[0][-5:]) for _ in range(20)}
    assert told == {(0, 0, 0, 0, 0), (0, 0, 0, 1, 0)}


def test_robots_keep_their_places_while_they_are_followed():
    """The nearest opponent changes, and its place in the observation does not."""
    jumps = {}
    for extras in ((), ("tracked",)):
        env = naoisis.MatchEnv("match3v3", control="blue2", observation="belief", opponents="roles", extras=extras)
        place = [env.observation_names.index(f"opponent1.{name}") for name in ("known", "x", "y")]
        observation, _ = env.reset(seed=2)
        jumps[extras] = 0
        for _ in range(1200):
            last = observation[place]
            observation = env.step(np.zeros(8, np.float32))[0]
            now = observation[place]
            if last[0] and now[0]:
                jumps[extras] += bool(np.hypot(*(now - last)[1:]) > 1.0)
    assert jumps[()] > 2 * jumps["tracked",] + 3, jumps


def test_fields_are_drawn_for_each_episode_and_told():
    draws = {"messages.loss": (0.1, 0.4), "duration_s": [0.5, 1.0], "messages.delay_cycles": range(2, 5)}
    env = naoisis.MatchEnv("TwoOnTwo", draws=draws, realism=["ideal", "realistic"])
    infos = [env.reset(seed=seed)[1] for seed in range(30)]
    losses = [info["drawn"]["messages.loss"] for info in infos]
    assert all(0.1 <= loss <= 0.4 for loss in losses) and len(set(losses)) == 30
    assert {info["drawn"]["duration_s"] for info in infos} == {0.5, 1.0}
    assert {info["drawn"]["messages.delay_cycles"] for info in infos} == {2, 3, 4}
    assert {info["realism"] for info in infos} == {"ideal", "realistic"}
    # The same seed draws the same, and the episode is as long as was drawn.
    for seed in range(3):
        info = env.reset(seed=seed)[1]
        assert info == infos[seed]
        steps = 0
        while not env.step(np.zeros(8, np.float32))[3]:
            steps += 1
        assert (steps + 1) * env._worlds.step_s == pytest.approx(info["drawn"]["duration_s"], abs=env._worlds.step_s)


def test_draws_of_a_reset_hold_under_autoreset():
    envs = naoisis.vector_env("ScoreEmptyGoal", 2, observation="truth", autoreset_mode="same_step")
    _, info = envs.reset(seed=1, options={"draws": {"duration_s": [0.2, 0.4]}, "set": {"messages.loss": 0.5}})
    drawn = [*info["drawn"]["duration_s"]]
    for _ in range(40):
        _, _, _, truncations, info = envs.step(np.zeros(envs.action_space.shape, np.float32))
        if truncations.any():
            drawn += info["drawn"]["duration_s"][info["drawn"]["_duration_s"]].tolist()
    assert set(drawn) == {0.2, 0.4}
    # The draws of an environment hold again after a reset without others.
    assert "drawn" not in envs.reset(seed=1)[1]


@pytest.mark.parametrize("observation", ["perception", "belief", "truth"])
def test_any_realism_can_be_set_by_a_reset(observation):
    env = naoisis.MatchEnv("match3v3", control="blue2", observation=observation)
    for realism in ("paper", "realistic", "ideal"):
        first, _ = env.reset(seed=1, options={"set": {"realism": realism}})
        assert env.observation_space.contains(first)
        for _ in range(50):
            assert env.observation_space.contains(env.step(env.action_space.sample())[0])


def test_infos_tell_the_opponents_and_the_counts_of_an_episode():
    env = gymnasium.make(
        "naoisis/Match3v3-v0", control="blue2", opponents=["roles", "passers"], statistics=True, set={"duration_s": 30}
    )
    _, begun = env.reset(seed=5)
    assert begun["opponents"] in ("roles", "passers") and begun["match_seed"] < 2**64
    truncated = False
    while not truncated:
        _, _, _, truncated, ended = env.step(np.zeros(8, np.float32))
    assert ended["opponents"] == begun["opponents"] and ended["match_seed"] == begun["match_seed"]
    statistics = ended["statistics"]
    assert statistics["possession"] + statistics["opponents_possession"] in (pytest.approx(1.0), 0.0)
    assert statistics["opponents_distance_m"] > 1.0 and statistics["distance_m"] >= 0.0


def test_the_counts_are_those_of_the_agents_team():
    envs = naoisis.vector_env("OneOnOne", 1, control=["blue1", "pink1"], statistics=True, set={"duration_s": 3})
    envs.reset(seed=1)
    over = np.zeros(2, bool)
    while not over.any():
        actions = np.tile(np.float32([1, 0, 0, 0, 0, 0, 0, 0]), (2, 1))
        _, _, terminations, truncations, info = envs.step(actions)
        over = terminations | truncations
    counts = info["statistics"]
    assert counts["distance_m"][0] == counts["opponents_distance_m"][1] > 0.0
    assert counts["distance_m"][1] == counts["opponents_distance_m"][0] > 0.0


def test_an_episode_is_played_again_by_its_match_seed_and_what_was_drawn():
    options = {"observation": "truth", "draws": {"messages.delay_cycles": [1, 10]}, "autoreset_mode": "same_step"}
    envs = naoisis.vector_env("ScoreEmptyGoal", 2, **options)
    envs.reset(seed=4, options={"set": {"duration_s": 0.2}})
    for _ in range(5):
        observations, _, _, truncations, info = envs.step(np.zeros((2, 8), np.float32))
        if truncations.any():
            again = naoisis.MatchEnv("ScoreEmptyGoal", observation="truth")
            drawn = {name: value[1] for name, value in info["drawn"].items() if not name.startswith("_")}
            first, told = again.reset(seed=9, options={"match_seed": int(info["match_seed"][1]), "set": drawn})
            assert np.array_equal(first, observations[1]) and told["match_seed"] == info["match_seed"][1]
            assert isinstance(drawn["messages.delay_cycles"], int)
            # Only the first episode is that one.
            assert again.reset()[1]["match_seed"] != told["match_seed"]


def test_what_is_set_is_not_drawn():
    draws = {"messages.loss": (0.0, 0.3), "messages.delay_cycles": [1, 10]}
    env = naoisis.MatchEnv("ScoreEmptyGoal", draws=draws)
    drawn = env.reset(options={"match_seed": 7})[1]["drawn"]
    info = env.reset(options={"match_seed": 7, "set": {"messages.loss": 0.9}})[1]
    assert info["drawn"] == {**drawn, "messages.loss": 0.9}
    assert naoisis.Match.restore(env.snapshot()).scenario["messages"]["loss"] == pytest.approx(0.9)
    with pytest.raises(ValueError, match=r"draws: messages\.loss is set, too"):
        naoisis.MatchEnv("ScoreEmptyGoal", draws=draws, set={"messages.loss": 0.9})


def test_the_largest_match_seeds_are_told_by_the_vector_environments_of_gymnasium():
    envs = gymnasium.make_vec(
        "naoisis/ScoreEmptyGoal-v0", 4, vectorization_mode="sync", set={"duration_s": 0.2}, observation="truth"
    )
    seeds = {int(seed) for seed in envs.reset(seed=1)[1]["match_seed"]}
    for _ in range(12):
        info = envs.step(envs.action_space.sample())[4]
        seeds |= {int(seed) for seed in info.get("match_seed", ())}
    assert max(seeds) > 2**63


def test_infos_tell_nothing_that_a_reset_has_changed():
    env = naoisis.MatchEnv("match3v3", control="blue1", opponents=["roles", "passers"], realism=["ideal", "realistic"])
    snapshot = env.reset(seed=1) and env.snapshot()
    assert set(env.reset(options={"set": {"realism": "realistic"}})[1]) == {"match_seed", "opponents"}
    assert set(env.reset(options={"set": {"teams.pink": "roles"}})[1]) == {"match_seed", "realism"}
    assert set(env.reset(options={"snapshot": snapshot})[1]) == {"match_seed"}
    assert set(env.reset()[1]) == {"match_seed", "opponents", "realism"}


def test_a_copy_from_the_middle_of_an_episode_has_no_counts_of_a_part():
    envs = naoisis.vector_env("ScoreEmptyGoal", 1, statistics=True, set={"duration_s": 0.5}, autoreset_mode="same_step")
    envs.reset(seed=1)
    envs.step(np.zeros((1, 8), np.float32))
    copy = pickle.loads(pickle.dumps(envs))
    ends = []
    while len(ends) < 2:
        info = copy.step(np.zeros((1, 8), np.float32))[4]
        ends += [info["final_info"]] if "final_info" in info else []
    assert ["statistics" in end for end in ends] == [False, True]


@naoisis.batch_reward
def _nearer(steps):
    before, after = steps.column("ball.x")
    return after - before


def test_an_environment_with_a_reward_of_all_worlds_can_be_pickled():
    envs = naoisis.vector_env("ScoreEmptyGoal", 2, reward=_nearer)
    envs.reset(seed=1)
    action = np.ones((2, 8), np.float32)
    copy = pickle.loads(pickle.dumps(envs))
    assert np.array_equal(envs.step(action)[1], copy.step(action)[1])
    assert pickle.loads(pickle.dumps(_nearer)) is _nearer
    assert naoisis.MatchEnv(reward=_nearer).reward_weights == {}


def test_a_reward_cannot_change_the_step_that_it_sees():
    @naoisis.batch_reward
    def changes(steps):
        steps.terminated[...] = True

    envs = naoisis.vector_env("ScoreEmptyGoal", 1, reward=changes)
    envs.reset(seed=1)
    with pytest.raises(ValueError, match="read-only"):
        envs.step(np.zeros((1, 8), np.float32))


def test_a_penalised_robot_says_nothing():
    env = _pair()
    env.reset(seed=1, options={"set": {"interventions": [{"at_s": 0.0, "do": {"penalise": {"robot": "blue1"}}}]}})
    names = env.observation_names
    for _ in range(20):
        observations, *_ = env.step({agent: _saying(1.0, 1.0, 1.0) for agent in env.agents})
    assert observations["blue_1"][names.index("body.penalised")] == 1.0
    # What it said before it was told of its penalty gets old, and it hears its team-mate all the time.
    ages = [observations[agent][names.index("message1.age")] for agent in ("blue_1", "blue_2")]
    assert ages[0] < 0.2 and ages[1] > 10 * env._worlds.step_s


@pytest.mark.parametrize("mode", ["next_step", "same_step", "disabled"])
def test_a_reward_of_all_worlds_sees_each_step_from_its_beginning_to_its_end(mode):
    seen = []

    @naoisis.batch_reward
    def reward(steps):
        seen.append(steps)
        before, after = steps.column("ball.x")
        return after - before + 100 * steps.truncated

    options = {"observation": "truth", "set": {"duration_s": 0.5}, "autoreset_mode": mode}
    envs = naoisis.vector_env("ScoreEmptyGoal", 3, reward=reward, **options)
    envs.reset(seed=1)
    state = envs.state()
    rewards, ends, over = [], 0, np.zeros(3, bool)
    for _ in range(20):
        begins = over & (mode == "next_step")
        _, reward_now, terminations, truncations, info = envs.step(np.zeros((3, 8), np.float32))
        steps, over = seen[-1], terminations | truncations
        if not begins.any():
            assert np.array_equal(steps.before, state)
        if mode == "same_step":
            ends += over.any()
            if over.any():
                assert np.array_equal(info["final_info"]["state"], steps.after)
        elif not begins.any():
            assert np.array_equal(steps.after, envs.state())
        assert (reward_now[begins] == 0.0).all() and np.array_equal(reward_now[~begins] > 50, truncations[~begins])
        rewards.append(reward_now)
        if mode == "disabled" and over.any():
            envs.reset(options={"reset_mask": over})
        state = envs.state()
    assert mode != "same_step" or ends >= 3


def test_a_reward_of_all_worlds_that_is_no_array_of_them_is_a_clear_exception():
    for value, exception, words in [
        (np.zeros(2, complex), TypeError, "expected an array of numbers"),
        (["1", "2"], TypeError, "expected an array of numbers"),
        (None, TypeError, "expected an array of numbers"),
        (np.zeros(5), ValueError, r"shape \(5,\); expected \(2, 1\) or \(2,\)"),
        ([1.0, np.nan], ValueError, "not finite"),
        ("x", TypeError, "expected an array of numbers"),
    ]:
        envs = naoisis.vector_env("ScoreEmptyGoal", 2, reward=naoisis.batch_reward(lambda steps, value=value: value))
        envs.reset(seed=1)
        with pytest.raises(exception, match=words):
            envs.step(np.zeros((2, 8), np.float32))


def test_masks_say_which_choices_have_an_effect():
    env = naoisis.MatchEnv("GetUp", action="multi_discrete")
    env.reset(seed=1)
    mask = env.action_masks()
    names = [name for names in env.action_names for name in names]
    allowed = {name for name, allows in zip(names, mask) if allows}
    # It lies: it cannot walk and kick, and it can move its head.
    assert "forward" not in allowed and "left_straight" not in allowed and {"stand", "no_kick", "down"} <= allowed
    env = naoisis.MatchEnv("ScoreEmptyGoal", action="discrete")
    env.reset(seed=1)
    assert env.action_masks().all() and env.action_masks().shape == (13,)
    envs = naoisis.vector_env("TwoOnTwo", 3, control="blue", action="velocities")
    envs.reset(seed=1)
    assert envs.action_masks().shape == (6, 20)
    with pytest.raises(ValueError, match="has no choices"):
        continuous = naoisis.MatchEnv("ScoreEmptyGoal")
        continuous.reset(seed=1)
        continuous.action_masks()


def test_a_choice_that_is_masked_changes_nothing():
    """Robots that do only what is allowed, and robots that try the rest too, get up in the same way."""
    poses = []
    for choice in (0, 1, 9):
        env = naoisis.MatchEnv("GetUp", action="discrete", observation="truth")
        env.reset(seed=3)
        for _ in range(10):
            choice_now = choice if not env.action_masks()[choice] else 0
            env.step(choice_now)
        poses.append(env.truth()["robots"][0]["pose"])
    assert poses[0] == poses[1] == poses[2]


def test_an_environment_with_extras_can_be_copied_in_the_middle_of_an_episode():
    envs = naoisis.vector_env(
        "TwoOnTwo",
        2,
        control="blue",
        extras=["messages", "tracked", "set_plays"],
        says=1,
        draws={"messages.loss": (0.0, 0.5)},
    )
    envs.reset(seed=1)
    action = np.tile(np.float32([1, 0, 0, 0, 0, 0, 0, 0, 1, 0.5]), (4, 1))
    for _ in range(5):
        envs.step(action)
    copy = pickle.loads(pickle.dumps(envs))
    for _ in range(5):
        assert np.array_equal(envs.step(action)[0], copy.step(action)[0])


def test_self_play_has_the_infos_of_its_team():
    envs = SelfPlay("OneOnOne", 3, observation="belief", statistics=True, set={"duration_s": 1.0}, extras=["set_plays"])
    _, info = envs.reset(seed=1)
    assert info["match_seed"].shape == (3,)
    over = np.zeros(3, bool)
    while not over.any():
        _, _, terminations, truncations, info = envs.step(np.zeros((3, 8), np.float32))
        over = terminations | truncations
    assert info["final_info"]["statistics"]["falls"].shape == (3,) and info["final_info"]["state"].shape[0] == 3


@pytest.mark.parametrize(
    ("options", "exception", "words"),
    [
        ({"extras": ["x"]}, ValueError, "extras: there is no 'x'; expected set_plays, penalties, messages, tracked"),
        ({"extras": "messages"}, TypeError, "extras: expected a list"),
        ({"says": 9}, ValueError, "says: 9 is out of range"),
        ({"says": 1, "action": "discrete"}, ValueError, "says: an action `discrete` is one choice"),
        ({"draws": {"x": (0, 1)}}, naoisis.ScenarioError, "there is no field `x`"),
        ({"draws": {"messages.loss": (0, 2)}}, naoisis.ScenarioError, "`loss` is 2"),
        ({"draws": {"messages.loss": (1, 0)}}, ValueError, "is no range"),
        ({"draws": {"messages.loss": 1}}, TypeError, "expected a tuple of the least"),
        ({"draws": [1]}, TypeError, "draws: expected a dictionary"),
        ({"draws": {"seed": [1]}}, ValueError, "draws: episodes have seeds of their own"),
        ({"set": {"seed": 1}}, ValueError, "set: episodes have seeds of their own"),
        ({"draws": {"realism": ["ideal"]}}, ValueError, "draws: realism is an option of its own"),
        (
            {"draws": {"messages": [{"loss": 0.5}], "messages.loss": [0.1]}},
            ValueError,
            "messages.loss is a part of messages",
        ),
        ({"realism": ["ideal", "x"]}, naoisis.ScenarioError, "`realism` is `x`"),
        ({"realism": 3}, TypeError, "realism: expected a level"),
    ],
)
def test_bad_extras_and_draws_are_clear_exceptions(options, exception, words):
    with pytest.raises(exception, match=words):
        naoisis.MatchEnv("TwoOnTwo", **options)


def test_a_situation_with_a_range_the_wrong_way_round_is_a_clear_exception():
    env = naoisis.MatchEnv("ScoreEmptyGoal")
    with pytest.raises(ValueError, match="ball.x_m is from 2 to 1; expected the least value and then the greatest"):
        env.reset(seed=1, options={"situation": {"ball": {"x_m": [2, 1], "y_m": [0, 0]}}})
