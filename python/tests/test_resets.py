"""What a reset may want, against whom one plays, and how it is shown."""

import gymnasium
import numpy as np
import pytest

import naoisis
from naoisis._view import View
from naoisis.self_play import SelfPlay

STAND = np.zeros(8, np.float32)


def _task(**options):
    return gymnasium.make("naoisis/ScoreEmptyGoal-v0", observation="truth", **options).unwrapped


def test_a_reset_changes_the_scenario_until_the_next_one():
    env = _task()
    place = {"ball": {"x_m": [1.5, 1.5], "y_m": [0.25, 0.25]}, "robots": {}}
    env.reset(seed=1, options={"situation": place, "set": {"robots[0].pose": [0.5, 0.0, 0.0], "duration_s": 0.2}})
    truth = env.truth()
    assert truth["ball"]["position_m"][:2] == [1.5, 0.25] and truth["robots"][0]["pose"] == [0.5, 0.0, 0.0]
    assert [env.step(STAND)[3] for _ in range(2)] == [False, True]
    env.reset(seed=1)
    assert env.truth()["ball"]["position_m"] != truth["ball"]["position_m"] and not env.step(STAND)[3]


def test_options_hold_for_all_episodes_that_follow_by_themselves():
    envs = naoisis.vector_env("ScoreEmptyGoal", 3, observation="truth", autoreset_mode="same_step")
    place = {"ball": {"x_m": [2, 2], "y_m": [0, 0]}}
    envs.reset(seed=1, options={"situation": place, "set": {"duration_s": 0.2}})
    x = envs.state_names.index("ball.x")
    for step in range(6):
        _, _, _, truncations, _ = envs.step(np.zeros(envs.action_space.shape, np.float32))
        assert truncations.all() == (step % 2 == 1) and (envs.state()[:, x] == 2.0).all()


@pytest.mark.parametrize("task", ["FindBall", "TwoOnTwo"])
def test_a_moment_of_any_seed_is_one_to_begin_from(task):
    env = naoisis.parallel_env(task)
    for seed in range(40):
        env.reset(seed=seed)
        state = env.state()
        env.reset(options={"snapshot": env.snapshot()})
        assert np.array_equal(env.state(), state), seed


@pytest.mark.parametrize("perceived", [False, True])
def test_episodes_begin_from_a_moment_with_other_chance_each_time(perceived):
    match = naoisis.Match("match3v3", seed=3, control=["blue2"])
    match.step(cycles=400)
    if perceived:
        match.perception("blue2")
    now = match.truth()
    env = gymnasium.make("naoisis/Match3v3-v0", control="blue2", observation="perception").unwrapped
    ends = []
    for seed in (1, 1, 2):
        first, _ = env.reset(seed=seed, options={"snapshot": match.snapshot()})
        assert env.truth()["ball"] == now["ball"]
        # It has not walked since it observed last: there was no last time.
        assert first[env.observation_names.index("step.x")] == 0.0
        for _ in range(50):
            env.step(STAND)
        ends.append(env.truth()["robots"])
    assert ends[0] == ends[1] != ends[2]
    # A moment of an environment does, too, in many worlds.
    envs = naoisis.vector_env("match3v3", 2, control="blue2")
    envs.reset(seed=1, options={"snapshot": env.snapshot()})
    assert np.array_equal(envs.state()[0], env.state()) and np.array_equal(envs.state()[0], envs.state()[1])


@pytest.mark.parametrize(
    ("options", "exception", "words"),
    [
        ({"sets": {}}, ValueError, "options: there is no 'sets'; expected set, situation, snapshot"),
        ({"set": 3}, TypeError, "set: expected a dictionary"),
        ({"set": {"ball.colour": 1}}, naoisis.ScenarioError, "colour"),
        ({"situation": {"ball": {"x": [1, 2]}}}, ValueError, "situation: .*x_m"),
        ({"situation": {"balls": {}}}, ValueError, "situation: unknown field"),
        ({"situation": {"ball": {"x_m": [30, 30], "y_m": [0, 0]}}}, ValueError, "situation: no start is possible"),
        (
            {"situation": {"robots": {"blue9": {"x_m": [0, 0], "y_m": [0, 0], "heading_deg": [0, 0]}}}},
            ValueError,
            "situation: there is no blue9",
        ),
        ({"snapshot": b"no"}, naoisis.SnapshotError, "expected the bytes of a snapshot"),
        ({"snapshot": "file"}, TypeError, "snapshot: expected the bytes"),
        ({"snapshot": b"", "set": {}}, ValueError, "expected no `set`"),
        ({"snapshot": naoisis.Match("match3v3", control="pink").snapshot()}, ValueError, "`blue1` is not decided for"),
        ({"snapshot": naoisis.Match("match3v3", control="blue").snapshot()}, ValueError, "as many robots"),
        ([1], TypeError, "options: expected a dictionary"),
    ],
)
def test_bad_options_of_a_reset_are_clear_exceptions(options, exception, words):
    env = _task()
    with pytest.raises(exception, match=words):
        env.reset(seed=1, options=options)
    # It can be used all the same.
    env.reset(seed=1)
    env.step(STAND)


def test_a_pool_of_opponents_gives_each_episode_one():
    """The teams differ in what they say to each other from the first cycle on."""
    plays = {}
    for opponents in (["roles", "passers", "chasers"], "roles", "passers", "chasers"):
        env = gymnasium.make(
            "naoisis/Match3v3-v0", control="blue2", opponents=opponents, set={"duration_s": 20}
        ).unwrapped
        ways = []
        for seed in range(8):
            env.reset(seed=seed)
            for _ in range(60):
                env.step(STAND)
            ways.append(str([robot["pose"] for robot in env.truth()["robots"] if robot["id"].startswith("pink")]))
        plays[str(opponents)] = ways
    pool = plays.pop(str(["roles", "passers", "chasers"]))
    drawn = [next(team for team, ways in plays.items() if ways[episode] == way) for episode, way in enumerate(pool)]
    assert len(set(drawn)) > 1, drawn
    with pytest.raises(naoisis.ScenarioError, match="there is no team `nobody`"):
        naoisis.vector_env("match3v3", 1, control="blue", opponents=["roles", "nobody"])
    for wrong in ([], 3, ["roles", 3]):
        with pytest.raises(TypeError, match="opponents"):
            naoisis.vector_env("match3v3", 1, control="blue", opponents=wrong)


def test_earlier_policies_play_the_other_team():
    envs = SelfPlay("TwoOnTwo", 6, observation="truth", action="discrete", set={"duration_s": 1})
    forward = envs.action_names[0].index("forward")
    envs.add(lambda observations: np.full(len(observations), forward))
    observations, _ = envs.reset(seed=5)
    assert observations.shape == (12, len(envs.observation_names)) and envs.agents == ["blue1", "blue2"]
    drawn = envs.drawn.copy()
    assert set(drawn) == {0, 1}
    names = [f"{robot}.{axis}" for robot in ("pink1", "pink2") for axis in "xy"]
    places = [envs.envs.state_names.index(name) for name in names]
    before = envs.envs.state()[:, places]
    stand = np.zeros(12, int)
    for _ in range(9):
        *_, truncations, info = envs.step(stand)
        assert not truncations.any() and not info
    way = np.abs(envs.envs.state()[:, places] - before).max(axis=1)
    assert ((way > 0.1) == (drawn == 1)).all()
    *_, truncations, info = envs.step(stand)
    assert truncations.all() and len(info["final_obs"]) == 12 == len(info["final_info"]["success"])
    # A reset of one world draws for this world alone.
    drawn = envs.drawn.copy()
    for _ in range(5):
        envs.reset(options={"reset_mask": np.arange(24) < 4})
        assert (envs.drawn[1:] == drawn[1:]).all()
    with pytest.raises(ValueError, match="actions: there is a number that is not whole"):
        envs.step(np.full(12, 0.5))
    with pytest.raises(ValueError, match=r"actions: the shape is \(5,\)"):
        envs.step(stand[:5])
    for wrong in ({"team": "red"}, {"control": "blue"}):
        with pytest.raises((ValueError, TypeError), match="team|control"):
            SelfPlay("TwoOnTwo", 1, **wrong)


def test_ones_own_reward_is_reckoned_in_many_worlds():
    own = {"reward": lambda truth, robot: truth["cycle"] + 1000 * (robot == "blue2"), "set": {"duration_s": 0.2}}
    envs = naoisis.vector_env("TwoOnTwo", 2, control="blue", **own)
    envs.reset(seed=1)
    actions = np.zeros(envs.action_space.shape, np.float32)
    assert [list(envs.step(actions)[1]) for _ in range(3)] == [[3, 1003] * 2, [6, 1006] * 2, [0] * 4]
    with pytest.raises(ValueError, match="autoreset_mode"):
        naoisis.vector_env("TwoOnTwo", 2, autoreset_mode="same_step", **own)


def test_a_window_shows_what_happens(monkeypatch):
    shown = []

    class Window:
        def __init__(self, title):
            shown.append(title)

        def show(self, image):
            shown.append(image.shape)

        def close(self):
            shown.append("closed")

    monkeypatch.setattr("naoisis._view.Window", Window)
    monkeypatch.setattr("time.sleep", lambda seconds: shown.append(0 <= seconds < 0.11))
    env = _task(render_mode="human")
    env.reset(seed=1)
    env.step(STAND)
    assert env.render() is None
    env.close()
    env.close()
    assert shown == ["naoisis", True, (360, 640, 3), True, (360, 640, 3), "closed"]
    with pytest.raises(ValueError, match="render_mode: there is no 'ascii'; expected one of rgb_array, human"):
        _task(render_mode="ascii")


def test_a_window_that_cannot_be_opened_says_so(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":nowhere")
    env = _task(render_mode="human")
    with pytest.raises(naoisis.MatchError, match="no window can be opened: .*expected a display"):
        env.reset(seed=1)
    assert View(None, ()).close() is None


def _two():
    env = naoisis.vector_env("ScoreEmptyGoal", 2)
    env.reset(seed=1)
    return env


def _began(env):
    env.reset(seed=1)
    return env


def _pair():
    env = naoisis.parallel_env("TwoOnTwo")
    env.reset(seed=1)
    return env


@pytest.mark.parametrize(
    ("act", "exception", "words"),
    [
        (lambda: _two().step(np.zeros((8, 2))), ValueError, r"shape \(8, 2\); expected \(2, 8\)"),
        (lambda: _two().step(np.zeros((2, 8), complex)), TypeError, "they are complex"),
        (lambda: _two().reset(seed=[]), ValueError, "expected the first one only"),
        (lambda: _two().reset(seed=[1, 2, 3]), ValueError, "expected the first one only"),
        (lambda: _two().step_into(np.zeros((2, 8)), [1], [2], [3], [4]), TypeError, "observations: expected an array"),
        (lambda: _two().snapshot(7), IndexError, "no world 7"),
        (lambda: _pair().step(None), TypeError, "actions: expected a dictionary"),
        (lambda: _pair().step({"blue_1": STAND, "blue_2": STAND[:3]}), TypeError, "2 rows of 8"),
        (lambda: _pair().step({"blue_1": STAND, "blue_2": STAND, "pink_1": STAND}), ValueError, "no agent 'pink_1'"),
        (lambda: naoisis.vector_env("match3v3", 2, control=3), TypeError, "control: expected robots"),
        (lambda: naoisis.vector_env("match3v3", 2, camera=3), TypeError, "camera: expected a text"),
        (lambda: naoisis.vector_env("match3v3", 2, image_size=3), TypeError, "image_size: expected height and width"),
        (
            lambda: naoisis.vector_env("match3v3", 2, observations="x"),
            TypeError,
            "unexpected keyword argument 'observations'",
        ),
        (lambda: naoisis.read_beliefs(3), TypeError, "not int"),
        (lambda: naoisis.parallel_env("TwoOnTwo").reset(options="x"), TypeError, "options: expected a dictionary"),
        (lambda: SelfPlay("TwoOnTwo", 2).step(np.zeros((4, 8))), naoisis.MatchError, "has not begun"),
        (lambda: _began(_task()).step(np.zeros((2, 4))), ValueError, r"shape \(2, 4\); expected \(1, 8\)"),
        (lambda: _began(_task(reward=lambda truth, robot: None)).step(STAND), TypeError, "returned None for blue1"),
        (lambda: naoisis.Match("match3v3").run("long"), TypeError, "seconds: expected a number"),
        (lambda: naoisis.Match.restore("file"), TypeError, "snapshot: expected bytes"),
        (lambda: naoisis.batch("match3v3", duration_s="long"), TypeError, "duration_s: expected a number"),
        (lambda: naoisis.batch("match3v3", sweep=[1]), TypeError, "sweep: expected a dictionary"),
        (lambda: naoisis.read_beliefs("/dev/null"), ValueError, "nothing in the table"),
    ],
)
def test_what_is_wrong_is_said_clearly(act, exception, words):
    with pytest.raises(exception, match=words):
        act()
