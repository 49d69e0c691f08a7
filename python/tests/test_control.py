"""Robots that Python decides for."""

import json
import sys

import numpy as np
import pytest

import naoisis

BALL_AND_ROBOT = {
    "rules": "free",
    "ball": {"position_m": [1.0, 0.2]},
    "robots": [{"team": "blue", "number": 1}, {"team": "pink", "number": 2, "pose": [2, 1, 180]}],
}


def test_commands_play_the_match_that_a_script_plays(tmp_path):
    """The same bytes in the trace but for the header, which names the behaviour."""
    script = [
        {"from_s": 0.0, "until_s": 0.5, "walk": [0.004, 0.001, 2.0]},
        {"from_s": 0.2, "head_deg": [20, 10]},
        {"from_s": 0.6, "kick": {"type": "right_straight", "speed": 0.5}},
        {"from_s": 0.3, "until_s": 0.4, "say": {"ball_m": [1.0, 0.5]}},
    ]
    robots = [{**BALL_AND_ROBOT["robots"][0], "behaviour": {"script": script}}, BALL_AND_ROBOT["robots"][1]]
    traces = [tmp_path / "script.jsonl", tmp_path / "commands.jsonl"]
    scripted = naoisis.Match({**BALL_AND_ROBOT, "robots": robots})
    commanded = naoisis.Match(BALL_AND_ROBOT, control=["blue1"])
    commands = []
    with scripted:
        scripted.record(trace=traces[0])
        for _ in range(40):
            scripted.step()
            commands.append(scripted.truth()["robots"][0]["command"])
    with commanded:
        commanded.record(trace=traces[1])
        for command in commands:
            commanded.step({"blue1": command})
    lines = [[json.loads(line) for line in trace.read_text().splitlines()[1:-1]] for trace in traces]
    for of_script, of_commands in zip(*lines):
        # The built-in estimator runs for commanded robots.
        of_commands["robots"][0]["belief"] = of_script["robots"][0]["belief"]
    assert lines[0] == lines[1] and len(lines[0]) == 41


def test_what_is_perceived_is_what_the_next_command_answers():
    match = naoisis.Match(BALL_AND_ROBOT, control="blue")
    assert match.control == ["blue1"]
    start = match.truth()
    before = match.perception("blue1")
    assert before["percepts"]["ball"]["position_m"] == pytest.approx([1.0, 0.2], abs=0.1)
    # Nothing has happened by looking.
    assert (match.cycle, match.time_s, match.truth()) == (0, 0.0, start)
    match.step({"blue1": {"walk": [0.005, 0, 0]}}, cycles=3)
    robot = match.truth()["robots"][0]
    assert match.cycle == 3 and robot["pose"][0] == pytest.approx(0.015, abs=1e-4)
    assert match.perception("blue1")["odometry"][0] == pytest.approx(0.015, abs=0.02)
    assert match.belief("blue1")["pose"][0] == pytest.approx(-0.0 + 0.015, abs=0.05)
    # Without a command it stands.
    match.step(cycles=10)
    assert match.truth()["robots"][0]["pose"] == robot["pose"]
    # A snapshot between perceiving and acting goes on, too.
    match.perception("blue1")
    other = match.branch()
    for each in (match, other):
        each.step({"blue1": {"walk": np.array([0.004, 0.0, 1.0])}})
    assert other.control == ["blue1"] and other.cycle == match.cycle == 14 and other.truth() == match.truth()


@pytest.mark.parametrize(
    ("commands", "exception", "words"),
    [
        ({"blue1": {"wlak": [0, 0, 0]}}, ValueError, "did you mean `walk`"),
        ({"blue1": {"walk": [0, 0]}}, ValueError, "blue1.walk"),
        ({"blue1": {"walk": [float("nan"), 0, 0]}}, ValueError, r"blue1.walk\[0\]: the number is NaN"),
        ({"pink2": {}}, ValueError, "`pink2` is not controlled; expected commands for blue1"),
        ({"blue": {}}, ValueError, "is not a robot"),
        ([1], TypeError, "commands: expected a dictionary"),
    ],
)
def test_bad_commands_are_clear_exceptions_and_change_nothing(commands, exception, words):
    match = naoisis.Match(BALL_AND_ROBOT, control=["blue1"])
    with pytest.raises(exception, match=words):
        match.step(commands)
    assert match.cycle == 0


def test_only_robots_that_there_are_can_be_controlled():
    with pytest.raises(ValueError, match="there is no robot `blue9` in the match; expected `blue1`, `blue2`"):
        naoisis.Match("match3v3", control=["blue9"])
    with pytest.raises(TypeError, match="control: expected robots"):
        naoisis.Match("match3v3", control=[1])
    assert naoisis.Match("match3v3", control=["pink", "blue2"]).control == ["blue2", "pink1", "pink2", "pink3"]


PROGRAM = """
import json, sys
print(json.dumps({"hello": {"protocol": 1, "name": "walkers"}}), flush=True)
for line in sys.stdin:
    message = json.loads(line)
    if "cycle" in message:
        print(json.dumps({"cycle": message["cycle"], "command": {"walk": [0.004, 0, 0]}}), flush=True)
"""


def test_programs_play_beside_python(tmp_path):
    program = tmp_path / "team.py"
    program.write_text(PROGRAM)
    match = naoisis.Match("match3v3", blue=f"exec:{sys.executable} {program}", control=["pink2"])
    assert match.control == ["pink2"]
    for _ in range(5):
        match.perception("pink2")
        match.step({"pink2": {"walk": [0.004, 0, 0]}}, cycles=2)
    commands = {robot["id"]: robot["command"].get("walk") for robot in match.truth()["robots"]}
    assert all(commands[robot] == [0.004, 0.0, 0.0] for robot in ("blue1", "blue2", "blue3", "pink2"))
