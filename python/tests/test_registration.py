"""Gymnasium finds the tasks in a new process."""

import subprocess
import sys

import pytest


def printed(program):
    words = [sys.executable, "-W", "error", "-c", program]
    done = subprocess.run(words, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert not done.stderr
    return done.stdout.split()


@pytest.mark.parametrize("task", ["ScoreEmptyGoal-v0", "TwoOnTwo_unseen-v0"])
def test_the_name_of_the_module_imports_it(task):
    program = f"""
import gymnasium, sys
assert "naoisis" not in sys.modules
env = gymnasium.make("naoisis:naoisis/{task}", observation="truth")
envs = gymnasium.make_vec("naoisis:naoisis/{task}", num_envs=2, vectorization_mode="vector_entry_point")
import naoisis
print(type(env.unwrapped).__name__, type(envs).__name__)
"""
    assert printed(program) == ["MatchEnv", "VectorEnv"]


def test_an_import_of_the_package_registers_every_task():
    program = """
import gymnasium, naoisis
gymnasium.register_envs(naoisis)
print(*(name.split("-v")[0] for name in gymnasium.registry if name.startswith("naoisis/")))
"""
    import naoisis

    forms = ("", "_unseen", "_images", "_images_unseen")
    assert sorted(printed(program)) == sorted(f"naoisis/{task}{form}" for task in naoisis.tasks() for form in forms)


def test_a_misspelt_name_is_answered_with_the_nearest():
    program = """
import gymnasium
try:
    gymnasium.make("naoisis:naoisis/ScoreEmptyGaol-v0")
except gymnasium.error.NameNotFound as error:
    print(error)
"""
    assert "`ScoreEmptyGoal`" in " ".join(printed(program))
