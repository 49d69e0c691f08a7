"""The name that was probably meant."""

import pytest

import naoisis


@pytest.mark.parametrize(
    ("name", "meant"), [("GoToBal", "GoToBall"), ("scoreemptygoal", "ScoreEmptyGoal"), ("KepGoal", "KeepGoal")]
)
def test_a_misspelt_task_is_answered_with_the_nearest(name, meant):
    makers = (naoisis.MatchEnv, naoisis.VectorEnv, lambda task: naoisis.evaluate(lambda seen: seen, task, 1))
    for make in makers:
        with pytest.raises(
            naoisis.ScenarioError,
            match=f"{name}: there is no built-in scenario .*: did you mean the task `{meant}`. expected",
        ) as error:
            make(name)
        assert error.value.file == name and "naoisis.tasks()" in error.value.expected


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (
            {"scenario": "nothing_like_it"},
            "^nothing_like_it: there is no built-in scenario of this name, and no such file; expected",
        ),
        ({"scenario": "match3v"}, "did you mean `match3v3`"),
        ({"scenario": "GoToBal.json"}, "GoToBal.json"),
        ({"scenario": "GoToBall", "set": {"duration": 5}}, "duration"),
    ],
)
def test_other_errors_stay_as_they_are(arguments, words):
    with pytest.raises(naoisis.ScenarioError, match=words) as error:
        naoisis.MatchEnv(**arguments)
    assert "the task" not in str(error.value)


def test_a_task_is_no_scenario_of_a_match():
    for make in (naoisis.Match, lambda task: naoisis.batch(task, matches=1)):
        with pytest.raises(
            naoisis.ScenarioError, match=r"^GoToBall is a task; expected a scenario, or naoisis.MatchEnv\('GoToBall'\)$"
        ):
            make("GoToBall")
