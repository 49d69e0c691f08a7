"""A match as Python plays it."""

import json
import pickle
import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import naoisis

KICK = "kick_right_straight"


def test_a_match_is_that_of_the_command_line(tmp_path):
    """The same bytes in the trace, and its dictionaries in Python."""
    by_command, by_python = tmp_path / "command.jsonl", tmp_path / "python.jsonl"
    command = ["naoisis", "run", "match3v3", "--seed", "3", "--duration", "2", "--trace", by_command, "--quiet"]
    subprocess.run(command, check=True)
    match = naoisis.Match("match3v3", seed=3, set={"duration_s": 2})
    lines = [match.truth()]
    with match:
        match.record(trace=by_python)
        while not match.finished:
            match.step()
            lines.append(match.truth())
    assert by_python.read_bytes() == by_command.read_bytes()
    header, *cycles, end = map(json.loads, by_python.read_text().splitlines())
    assert cycles == lines
    assert header["scenario"] == match.scenario
    assert end["reason"] == "duration"
    # Without a record the dictionaries are the same.
    again = naoisis.Match("match3v3", seed=3)
    assert again.truth() == lines[0]
    again.step(cycles=60)
    assert again.truth() == lines[60]


def test_what_a_robot_perceives_and_believes_is_that_of_its_line():
    match = naoisis.Match("match3v3", seed=1)
    match.step(cycles=40)
    robot = next(robot for robot in match.truth()["robots"] if robot["id"] == "blue2")
    perception = match.perception("blue2")
    assert perception == {name: robot[name] for name in perception}
    assert not {"pose", "velocity", "belief"} & set(perception)
    assert match.belief("blue2") == robot["belief"]
    assert match.robots == ["blue1", "blue2", "blue3", "pink1", "pink2", "pink3"]


def test_a_match_is_run_to_its_end_and_no_further():
    match = naoisis.Match(KICK)
    cycles = match.run(1.5)
    assert (cycles, match.cycle, match.time_s) == (45, 45, pytest.approx(1.5))
    kicks = [event for event in match.events if event["kind"] == "kick"]
    assert [(kick["robot"], kick["result"]) for kick in kicks] == [("blue1", "kicked")]
    match.run()
    assert match.finished and match.score == {"blue": 0, "pink": 0}
    assert match.run() == 0
    with pytest.raises(naoisis.MatchError, match="over after"):
        match.step()


def test_a_snapshot_goes_on_bit_for_bit_and_pickles():
    match = naoisis.Match("match3v3", seed=5)
    match.step(cycles=50)
    others = [match.branch(), pickle.loads(pickle.dumps(match)), naoisis.Match.restore(match.snapshot())]
    match.step(cycles=25)
    for other in others:
        assert other.cycle == 50
        other.step(cycles=25)
        assert other.truth() == match.truth()
        assert other.snapshot() == match.snapshot()
    with pytest.raises(naoisis.SnapshotError, match="expected the bytes of a snapshot"):
        naoisis.Match.restore(b"something else")


def test_a_scenario_is_a_name_a_path_or_a_dictionary(tmp_path):
    scenario = {"rules": "free", "robots": [{"team": "pink", "number": 4, "pose": [1, -0.5, 90]}]}
    path = tmp_path / "one.json"
    path.write_text(json.dumps(scenario))
    for match in (naoisis.Match(scenario), naoisis.Match(path), naoisis.Match(str(path))):
        assert match.truth()["robots"][0]["pose"] == [1.0, -0.5, 90.0]
    # What a match says that it started from is a scenario.
    match = naoisis.Match("match3v3", seed=7, blue="passers", realism="ideal", set={"messages.loss": np.float32(0.5)})
    assert (match.scenario["seed"], match.realism) == (7, "ideal but for messages")
    assert naoisis.Match(match.scenario).scenario == match.scenario


def test_what_is_wrong_with_a_scenario_is_said_with_its_place(tmp_path):
    path = tmp_path / "typo.ron"
    path.write_text("(\n  sede: 2,\n)\n")
    with pytest.raises(naoisis.ScenarioError, match="did you mean `seed`") as error:
        naoisis.Match(path)
    assert (error.value.file, error.value.line, error.value.column) == (str(path), 2, 3)
    copy = pickle.loads(pickle.dumps(error.value))
    assert (str(copy), copy.line, copy.expected) == (str(error.value), 2, error.value.expected)
    for wrong in ({"scenario": "match3v4"}, {"set": {"messages.los": 0.1}}, {"blue": "rolles"}, {"realism": "real"}):
        with pytest.raises(naoisis.ScenarioError, match="expected"):
            naoisis.Match(**wrong)
    with pytest.raises(naoisis.ScenarioError) as error:
        naoisis.Match({"robots": [{"number": 1, "pose": [0, 0]}]})
    assert error.value.field == "robots[0].pose"


@pytest.mark.parametrize(
    ("arguments", "exception", "words"),
    [
        ({"seed": -1}, ValueError, "seed: -1 is out of range"),
        ({"seed": 1.5}, TypeError, "seed: expected a whole number"),
        ({"scenario": 3}, TypeError, "scenario: expected"),
        ({"set": [1]}, TypeError, "set: expected a dictionary"),
        ({"set": {"a=b": 1}}, ValueError, "is no field"),
        ({"set": {"messages.loss": float("nan")}}, ValueError, "messages.loss: the number is NaN"),
        ({"set": {"messages.loss": object()}}, TypeError, "messages.loss: a `object` has no place here"),
        ({"scenario": KICK, "blue": "roles"}, ValueError, "places its robots itself"),
    ],
)
def test_bad_arguments_are_clear_exceptions(arguments, exception, words):
    with pytest.raises(exception, match=words):
        naoisis.Match(**arguments)


def test_bad_questions_are_clear_exceptions():
    match = naoisis.Match(KICK)
    for ask in (match.perception, match.belief, match.image):
        with pytest.raises(ValueError, match="is not a robot"):
            ask("green1")
        with pytest.raises(naoisis.MatchError, match="there is no robot `pink7`; expected one of blue1"):
            ask("pink7")
        with pytest.raises(TypeError, match="robot: expected a text, not 3"):
            ask(3)
    assert 0 < match.run(1e300) < 10_000, "to the end"
    for wrong, exception in ((0, ValueError), (-3, ValueError), (1.5, TypeError)):
        with pytest.raises(exception, match="cycles"):
            match.step(cycles=wrong)
    for seconds in (-1, float("nan"), float("inf")):
        with pytest.raises(ValueError, match="is no duration"):
            match.run(seconds)
    with pytest.raises(ValueError, match="expected 'top' or 'bottom'"):
        match.image("blue1", "left")
    with pytest.raises(ValueError, match="cannot be drawn"):
        match.field_image(100_000, 10)


def test_pictures_are_arrays_of_one_moment():
    settings = {"cameras.render": "software", "cameras.labels": True, "cameras.depth": True}
    match = naoisis.Match(KICK, set=settings)
    match.step()
    image, labels, depth = (
        match.image("blue1", "bottom"),
        match.labels("blue1", "bottom"),
        match.depth("blue1", "bottom"),
    )
    assert (image.shape, image.dtype) == ((240, 320, 3), np.uint8)
    assert (labels.shape, labels.dtype, depth.shape, depth.dtype) == ((240, 320), np.uint8, (240, 320), np.float32)
    ball = labels == naoisis.LABELS["ball"]
    assert 100 < ball.sum() < 5000
    red, green, blue = image[ball].mean(axis=0)
    assert red > green > blue
    assert 0.3 < depth[ball].min() < depth[ball].max() < 0.6
    # Without images of its own the match draws them when they are asked for.
    drawn = naoisis.Match(KICK)
    assert drawn.image("blue1").shape == (240, 320, 3)
    field = drawn.field_image(320, 180)
    assert field.shape == (180, 320, 3) and field.std() > 10
    assert drawn._repr_png_().startswith(b"\x89PNG") and "0.00 s, blue 0 : 0 pink" in repr(drawn)


def test_a_second_thread_on_a_busy_match_is_told_so():
    match = naoisis.Match("match3v3")
    thread = threading.Thread(target=match.run, args=(20,))
    thread.start()
    refused = 0
    while thread.is_alive():
        try:
            match.cycle
        except naoisis.MatchError as error:
            assert "another thread" in str(error)
            refused += 1
    thread.join()
    assert refused > 0 and match.time_s == pytest.approx(20)


@pytest.mark.skipif(sys.platform == "win32", reason="signals are sent otherwise there")
def test_ctrl_c_stops_a_long_run_between_two_cycles():
    program = (
        # Who is started in the background of a shell ignores it.
        "import naoisis, signal\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "match = naoisis.Match('match7v7')\n"
        "print('on', flush=True)\n"
        "try:\n    match.run()\n"
        "except KeyboardInterrupt:\n    cycle = match.cycle; match.step(); print(match.cycle - cycle)\n"
    )
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout.readline() == "on\n"
    time.sleep(0.3)
    process.send_signal(signal.SIGINT)
    rest, _ = process.communicate(timeout=60)
    assert (rest, process.returncode) == ("1\n", 0)


def test_the_command_comes_with_the_package():
    listed = subprocess.run(["naoisis", "list", "scenarios"], capture_output=True, text=True, check=True)
    assert "match3v3" in listed.stdout
    wrong = subprocess.run(["naoisis", "run", "no_such"], capture_output=True, text=True)
    assert wrong.returncode == 2 and "there is no built-in scenario of this name" in wrong.stderr


def test_a_notebook_shows_the_match_as_it_was_recorded(tmp_path):
    """Up to now, in a frame that reaches nothing of the notebook; the file is whole after `close`."""
    path = tmp_path / "match.html"
    match = naoisis.Match("match3v3", seed=3, set={"duration_s": 3})
    assert "record(html=" in match._repr_html_() and "data:image/png;base64," in match._repr_html_()
    match.record(html=path)
    match.run(1.0)
    shown = match._repr_html_()
    assert shown.startswith("<iframe") and 'sandbox="allow-scripts"' in shown and "<script" not in shown
    match.run()
    match.close()
    page = path.read_text()
    assert page.startswith("<!doctype html>")
    assert match._match.page() == page


def test_a_trace_is_shown_as_a_page(tmp_path):
    trace, path = tmp_path / "t.jsonl.zst", tmp_path / "t.html"
    match = naoisis.Match("match3v3", seed=3, set={"duration_s": 1})
    with match:
        match.record(trace=trace)
        match.run()
    page = naoisis.show(trace)
    assert page._repr_html_().startswith("<iframe") and "MB" in repr(page)
    page.save(path)
    assert path.read_text() == page.html
    with pytest.raises(naoisis.TraceError, match="expected a trace"):
        naoisis.show(tmp_path / "nowhere.jsonl")
