"""Environments, as the libraries want them."""

import signal
import threading
import warnings
from pathlib import Path

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AutoresetMode

import naoisis
import naoisis.tables

TASKS = [f"{name}-v{version}" for name, version, _ in naoisis.challenges()]


@pytest.mark.parametrize("task", TASKS)
@pytest.mark.parametrize("observation", ["perception", "belief", "truth", "image"])
def test_gymnasium_accepts_every_task(task, observation):
    env = gymnasium.make(f"naoisis/{task}", observation=observation, render_mode="rgb_array")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env.unwrapped)
    assert env.unwrapped.render().shape == (540, 960, 3)


@pytest.mark.parametrize("action", ["continuous", "multi_discrete", "discrete", "velocities"])
def test_every_number_has_a_name_and_every_choice_does_what_it_says(action):
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", action=action, observation="truth").unwrapped
    assert len(env.observation_names) == len(set(env.observation_names)) == env.observation_space.shape[0]
    start, _ = env.reset(seed=1)
    if action == "continuous":
        forward = np.array([1, 0, 0, 0, 0, -1, 0, 0], np.float32)
        assert env.action_names[0][0] == "walk.forward"
    else:
        index = env.action_names[0].index("forward")
        forward = index if action == "discrete" else np.array([index, *[0] * (len(env.action_names) - 1)])
    names = env.observation_names
    for _ in range(10):
        last, *_ = env.step(forward)
    way = last - start
    cos, sin = start[names.index("own.cos")], start[names.index("own.sin")]
    ahead = cos * way[names.index("own.x")] + sin * way[names.index("own.y")]
    # 30 cycles at 0.2 m/s.
    assert ahead == pytest.approx(0.2, abs=0.01)


def test_the_page_of_the_repository_is_that_of_the_lists():
    page = Path(__file__).parent.parent / "OBSERVATIONS.md"
    assert page.read_text() == naoisis.tables.page(), "write it again: python -m naoisis.tables > OBSERVATIONS.md"


def test_perceptions_are_those_of_the_match():
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0").unwrapped
    seen = 0
    for seed in range(5):
        observation, _ = env.reset(seed=seed)
        names = dict(zip(env.observation_names, observation))
        robot = env.truth()["robots"][0]
        ball = robot["percepts"]["ball"]
        assert names["ball.seen"] == (ball is not None)
        if ball is not None:
            seen += 1
            assert [names["ball.x"], names["ball.y"]] == pytest.approx(ball["position_m"], abs=1e-4)
        assert names["head.yaw"] == pytest.approx(np.radians(robot["head_deg"][0]), abs=1e-4)
    assert seen > 0
    assert not {"own.x", "ball.vx"} & set(names)


def test_tasks_have_the_robot_of_the_challenge_in_each_realism():
    def sonar(**options):
        """The range of the sonar, which says that there is no echo."""
        env = naoisis.MatchEnv("ScoreEmptyGoal", **options)
        observation, _ = env.reset(seed=1)
        return observation[env.observation_names.index("sonar.left")]

    assert sonar(realism="realistic") == sonar(realism="realistic", set={"model": "nao_v6"})
    assert sonar(realism="realistic") != sonar(realism="realistic", set={"model": "nao"})
    assert sonar(realism="ideal") == sonar()
    spaces = [
        naoisis.MatchEnv("ScoreEmptyGoal", realism=level).observation_space for level in (None, "ideal", "realistic")
    ]
    assert spaces[0] == spaces[1] == spaces[2]


def test_a_task_ends_with_success_or_failure():
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="truth", action="discrete", realism="ideal").unwrapped
    names, acts = env.observation_names, env.action_names[0]
    outcomes = []
    for seed in range(6):
        observation, _ = env.reset(seed=seed)
        total = 0.0
        while True:
            values = dict(zip(names, observation))
            action = acts.index(_towards_goal(values))
            observation, reward, terminated, truncated, info = env.step(action)
            total += reward
            if terminated or truncated:
                break
        outcomes.append(info["success"])
        # A success is worth 10, and whatever else happens little.
        assert (total > 8) == info["success"]
    assert sum(outcomes) >= 4, outcomes


def _towards_goal(values):
    """A robot that walks behind the ball, before its left foot, and kicks it straight."""
    ball = np.array([values["ball.x"], values["ball.y"]])
    goal = np.array([values["goal.x"], values["goal.y"]])
    to_goal = (goal - ball) / np.linalg.norm(goal - ball)
    left_of_line = np.array([-to_goal[1], to_goal[0]])
    line = np.arctan2(to_goal[1], to_goal[0])
    if abs(line) < 0.12 and 0.1 < ball[0] < 0.2 and 0.02 < abs(ball[1]) < 0.09:
        return "left_straight" if ball[1] > 0 else "right_straight"
    spot = ball - 0.15 * to_goal - 0.05 * left_of_line
    if ball @ to_goal < 0.1:
        # It stands before the ball, and goes around it.
        spot = ball - 0.35 * to_goal + (0.3 if ball @ left_of_line > 0 else -0.3) * -left_of_line
    bearing = np.arctan2(spot[1], spot[0])
    if np.linalg.norm(spot) > 0.35:
        if abs(bearing) < 0.15:
            return "forward"
        turn = "left" if bearing > 0 else "right"
        return f"forward_turn_{turn}" if abs(bearing) < 0.5 else f"turn_{turn}"
    if abs(line) > 0.1:
        return "turn_left" if line > 0 else "turn_right"
    if abs(spot[1]) > max(0.02, 0.7 * abs(spot[0])):
        return "left" if spot[1] > 0 else "right"
    return "forward" if spot[0] > 0 else "backward"


def _play(envs, steps, seed=7):
    random = np.random.default_rng(seed)
    observations, _ = envs.reset(seed=seed)
    played = [observations]
    for _ in range(steps):
        actions = random.uniform(-1, 1, envs.action_space.shape).astype(np.float32)
        played.extend(envs.step(actions)[:4])
    return played


def test_a_batch_is_the_same_on_any_number_of_threads_and_as_single_environments():
    options = {"control": "blue", "observation": "belief", "set": {"duration_s": 3}}
    batches = [naoisis.vector_env("match3v3", num_envs=4, threads=threads, **options) for threads in (1, 3)]
    assert batches[0].num_envs == 12 and batches[0].agents == ["blue1", "blue2", "blue3"]
    one, three = (_play(envs, 35) for envs in batches)
    assert all(np.array_equal(a, b) for a, b in zip(one, three))
    vector = gymnasium.make_vec("naoisis/ScoreEmptyGoal-v0", num_envs=2, threads=1)
    single = gymnasium.make("naoisis/ScoreEmptyGoal-v0").unwrapped
    observations, _ = vector.reset(seed=3)
    expected, _ = single.reset(seed=4)
    assert np.array_equal(observations[1], expected)
    for step in range(20):
        actions = np.full(vector.action_space.shape, np.sin(step), np.float32)
        many, one = vector.step(actions), single.step(actions[1])
        assert np.array_equal(many[0][1], one[0]) and many[1][1] == pytest.approx(one[1])


def _short(mode, **options):
    """Episodes of ten steps, in worlds of two agents."""
    return naoisis.vector_env(
        "TwoOnTwo", 3, control="blue", observation="truth", set={"duration_s": 1}, autoreset_mode=mode, **options
    )


def test_the_three_modes_of_autoreset():
    """The same episodes in each, of which only the seams differ."""
    envs = {mode: _short(mode) for mode in ("next_step", "same_step", "disabled")}
    for mode, env in envs.items():
        assert env.metadata["autoreset_mode"] is AutoresetMode[mode.upper()]
        env.reset(seed=1)
    stand = np.zeros(envs["disabled"].action_space.shape, np.float32)
    for step in range(10):
        results = {mode: env.step(stand) for mode, env in envs.items()}
        over = step == 9
        assert all(result[3].all() == over for result in results.values())
        if not over:
            assert np.array_equal(results["next_step"][0], results["same_step"][0])
    last = results["disabled"][0]
    assert np.array_equal(results["next_step"][0], last)
    info = results["same_step"][4]
    assert info["_final_obs"].all() and np.array_equal(np.stack(info["final_obs"]), last)
    assert not info["final_info"]["success"].any()
    begun = results["same_step"][0]
    assert not np.array_equal(begun, last)
    # The next step begins the next episode, whatever it asks for.
    observations, rewards, terminations, truncations, _ = envs["next_step"].step(stand)
    assert np.array_equal(observations, begun) and not rewards.any() and not (terminations | truncations).any()
    with pytest.raises(naoisis.MatchError, match="world 0 is over"):
        envs["disabled"].step(stand)
    mask = np.array([False, False, True, True, False, False])
    observations, _ = envs["disabled"].reset(options={"reset_mask": mask})
    assert np.array_equal(observations[mask], begun[mask]) and np.array_equal(observations[~mask], last[~mask])
    for wrong in (mask[:3], mask.astype(int), [True] * 6, np.array([True, False] * 3)):
        with pytest.raises(ValueError, match="reset_mask"):
            envs["disabled"].reset(options={"reset_mask": wrong})


def test_a_step_fills_the_callers_arrays():
    env, other = _short("same_step"), _short("same_step")
    env.reset(seed=2)
    other.reset(seed=2)
    actions = np.ones(env.action_space.shape, np.float32)
    shape = env.observation_space.shape
    arrays = [np.full(shape, np.nan, np.float32), np.ones(6, np.float32), np.ones(6, bool), np.ones(6, bool)]
    env.step_into(actions, *arrays)
    assert all(np.array_equal(mine, theirs) for mine, theirs in zip(arrays, other.step(actions)))
    for index, wrong in (
        (0, arrays[0][:, 1:]),
        (0, arrays[0].astype(float)),
        (1, arrays[1][:3]),
        (2, arrays[2].astype(int)),
    ):
        given = list(arrays)
        given[index] = wrong
        with pytest.raises((TypeError, ValueError)):
            env.step_into(actions, *given)
    # Rows in the order of Fortran would be written along columns.
    for given, words in (
        ([np.zeros(shape[::-1], np.float32).T, *arrays[1:]], "observations: expected a contiguous array, row by row"),
        ([np.zeros(arrays[0].size, np.float32), *arrays[1:]], "observations: an array of shape"),
        ([arrays[0].astype(float), *arrays[1:]], "observations: float64; expected float32"),
    ):
        with pytest.raises((TypeError, ValueError), match=words):
            env.step_into(actions, *given)
    # An array cannot be two of them.
    with pytest.raises(ValueError, match="truncations"):
        env.step_into(actions, arrays[0], arrays[1], arrays[2], arrays[2])


def test_images_are_observed():
    env = naoisis.vector_env("ScoreEmptyGoal", 2, observation="image", image_size=(60, 80), camera="bottom")
    observations, _ = env.reset(seed=1)
    assert observations["image"].shape == (2, 60, 80, 3) and observations["image"].std() > 10
    assert observations["body"].shape == (2, len(env.observation_names))
    again, *_ = env.step(np.zeros(env.action_space.shape, np.float32))
    assert env.observation_space.contains(again)


def test_rewards_are_named_or_ones_own():
    assert set(naoisis.rewards()) == {"score", "success", "ball_to_goal", "to_ball", "time"}
    walk = np.array([1, 0, 0, 0, 0, -1, 0, 0], np.float32)
    env = gymnasium.make("naoisis/ScoreEmptyGoal-v0", reward={"to_ball": 2.0, "time": -1.0}).unwrapped
    own = gymnasium.make(
        "naoisis/ScoreEmptyGoal-v0", reward=lambda truth, robot: truth["robots"][0]["pose"][0] * (robot == "blue1")
    ).unwrapped
    env.reset(seed=1)
    own.reset(seed=1)

    def distance():
        truth = env.truth()
        return np.linalg.norm(np.subtract(truth["ball"]["position_m"][:2], truth["robots"][0]["pose"][:2]))

    before = distance()
    reward = env.step(walk)[1]
    assert reward == pytest.approx(2 * (before - distance()) - 0.1, abs=1e-3)
    assert own.step(walk)[1] == pytest.approx(own.truth()["robots"][0]["pose"][0])
    for wrong, exception in (({"goals": 1}, ValueError), (3, TypeError), ({"score": "much"}, ValueError)):
        with pytest.raises(exception, match="goals|reward|much"):
            gymnasium.make("naoisis/ScoreEmptyGoal-v0", reward=wrong)


@pytest.mark.parametrize(
    ("options", "exception", "words"),
    [
        ({"observation": "everything"}, ValueError, "observation: there is no"),
        ({"action": "fly"}, ValueError, "action: there is no"),
        ({"autoreset_mode": "never"}, (ValueError, KeyError), "autoreset_mode"),
        ({"num_envs": 0}, ValueError, "num_envs"),
        ({"num_envs": 1_000_000}, MemoryError, "num_envs: 1,000,000 worlds need more than 1,445.0 GB"),
        ({"reward": {"score": "a"}}, ValueError, "reward: expected a number for score, not 'a'"),
        ({"control": "blue9"}, ValueError, "there is no robot `blue9`"),
        ({"control": []}, ValueError, "control: 0 robots"),
        ({"scenario": "ScoreGoal"}, naoisis.ScenarioError, "no built-in scenario"),
        ({"camera": "left"}, ValueError, "camera"),
        ({"cycles_per_step": 0}, ValueError, "cycles_per_step"),
        ({"realism": "real"}, naoisis.ScenarioError, "expected"),
        ({"opponents": "nobody", "scenario": "Match3v3"}, naoisis.ScenarioError, "no team `nobody`"),
    ],
)
def test_bad_options_are_clear_exceptions(options, exception, words):
    with pytest.raises(exception, match=words):
        naoisis.vector_env(**{"scenario": "ScoreEmptyGoal", "num_envs": 2, **options})


def test_bad_actions_are_clear_exceptions_and_change_nothing():
    env = naoisis.vector_env("ScoreEmptyGoal", 2)
    good = np.zeros((2, 8), np.float32)
    with pytest.raises(naoisis.MatchError, match="has not begun"):
        env.step(good)
    env.reset(seed=1)
    bad = good.copy()
    bad[1, 2] = np.nan
    for wrong, exception, words in (
        (bad, ValueError, "row 1: the action has NaN for walk.turn"),
        (good[:1], ValueError, "expected \\(2, 8\\)"),
        ("up", TypeError, "actions"),
        (None, (TypeError, ValueError), "actions"),
    ):
        with pytest.raises(exception, match=words):
            env.step(wrong)
    choices = naoisis.vector_env("ScoreEmptyGoal", 1, action="discrete")
    choices.reset(seed=1)
    for wrong in (13, -1, 0.5):
        with pytest.raises(ValueError, match="expected a whole number from 0 to 12"):
            choices.step([wrong])
    env.close()
    with pytest.raises(naoisis.MatchError, match="closed"):
        env.step(good)


def test_who_says_only_how_it_walks_looks_at_the_ball():
    envs = naoisis.vector_env("ScoreEmptyGoal", 8, observation="belief", action="velocities", autoreset_mode="disabled")
    assert [names[0] for names in envs.action_names] == ["stay", "stay", "straight", "no_kick"]
    envs.reset(seed=3)
    stand, turn = np.zeros((8, 4), int), np.zeros((8, 4), int)
    turn[:, 2] = envs.action_names[2].index("turn_slowly_left")
    # It searches, and then keeps the ball in view while the body turns by 27 deg.
    for action in [stand] * 50 + [turn] * 10:
        seen, *_ = envs.step(action)
    known, age = (seen[:, envs.observation_names.index(f"ball.{name}")] for name in ("known", "age"))
    assert known.all() and np.median(age) < 0.3, (known, age)


def test_robots_with_beliefs_tell_each_other_where_they_are():
    def share_known(loss):
        envs = naoisis.vector_env(
            "TwoOnTwo", 8, control="blue", observation="belief", action="discrete", set={"messages": {"loss": loss}}
        )
        envs.reset(seed=1)
        for _ in range(5):
            seen, *_ = envs.step(np.zeros(16, int))
        known, age = (seen[:, envs.observation_names.index(f"team_mate1.{name}")] for name in ("known", "age"))
        return np.mean((known > 0.5) & (age < 0.3))

    assert share_known(0.0) == 1.0 > share_known(1.0)


def test_a_second_thread_in_an_environment_is_told_so():
    env = naoisis.vector_env("match3v3", 4, control="blue2", threads=1, cycles_per_step=300)
    env.reset(seed=1)
    actions = np.zeros(env.action_space.shape, np.float32)
    thread = threading.Thread(target=env.step, args=(actions,))
    thread.start()
    refused = 0
    while thread.is_alive() and not refused:
        try:
            env.state()
        except naoisis.MatchError as error:
            refused += "another thread" in str(error)
    thread.join()
    assert refused


def test_the_state_is_named():
    env = naoisis.vector_env("match3v3", 2, control="blue2")
    env.reset(seed=1)
    state = env.state()
    assert state.shape == (2, len(env.state_names)) and "pink3.cos" in env.state_names


@pytest.mark.parametrize("scorer", ["blue", "pink"])
def test_success_is_that_of_the_agents_own_team(scorer):
    sign = 1 if scorer == "blue" else -1
    goal = {
        "set": {"ball.velocity_mps": [3.0 * sign, 0.0]},
        "situation": {"ball": {"x_m": [2.0 * sign] * 2, "y_m": [0.4, 0.4]}},
    }
    for control in ("blue", "pink"):
        envs = naoisis.vector_env("FirstGoal", 2, control=control, autoreset_mode="same_step")
        envs.reset(seed=1, options=goal)
        over = False
        while not over:
            _, rewards, terminations, truncations, info = envs.step(np.zeros(envs.action_space.shape, np.float32))
            over = (terminations | truncations).all()
        success = control == scorer
        assert terminations.all() and (info["final_info"]["success"] == success).all()
        assert ((rewards > 0) == success).all()
    pytest.importorskip("pettingzoo")
    env = naoisis.parallel_env("FirstGoal", control=["blue", "pink"])
    env.reset(seed=1, options=goal)
    while env.agents:
        *_, infos = env.step(dict.fromkeys(env.agents, np.zeros(8, np.float32)))
    successes = {agent: info["success"] for agent, info in infos.items()}
    assert successes == {agent: agent.startswith(scorer) for agent in env.possible_agents}


@pytest.mark.skipif(not hasattr(signal, "setitimer"), reason="there are no timers that interrupt")
def test_an_interrupt_breaks_off_a_long_step():
    long = {"rules.half_s": 1e5}
    match = naoisis.Match("match3v3", control="blue", set=long)
    envs = naoisis.vector_env("match3v3", 2, control="blue", cycles_per_step=1_000_000, set=long)
    envs.reset(seed=1)
    stand = np.zeros(envs.action_space.shape, np.float32)
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    try:
        for step in (
            lambda: match.step({"blue1": {"walk": [0.001, 0, 0]}}, cycles=10_000_000),
            lambda: envs.step(stand),
        ):
            with pytest.raises(KeyboardInterrupt):
                signal.setitimer(signal.ITIMER_REAL, 0.2)
                step()
    finally:
        signal.signal(signal.SIGALRM, before)
    with pytest.raises(naoisis.MatchError, match="expected a reset before the next step"):
        envs.step(stand)
    envs.reset()
    cycle = match.cycle
    match.step()
    assert match.cycle == cycle + 1


def test_every_task_has_a_form_with_opponents_and_a_robot_that_are_held_out():
    for task in TASKS:
        name, version = task.split("-")
        assert f"naoisis/{name}_unseen-{version}" in gymnasium.registry
    env = gymnasium.make("naoisis/TwoOnTwo_unseen-v0", observation="belief")
    observation, _ = env.reset(seed=1)
    assert observation.shape == gymnasium.make("naoisis/TwoOnTwo-v0", observation="belief").observation_space.shape
