"""Names of tasks where scenarios are expected, and names that were probably meant."""

from __future__ import annotations

import difflib
import functools
import os
from collections.abc import Callable
from typing import Any, TypeVar, cast

from naoisis import _naoisis
from naoisis.errors import ScenarioError

Make = TypeVar("Make", bound=Callable[..., None])


def nearest_task(name: str) -> str | None:
    """The task whose name is nearest to this one, in either case of letters; None if none is near."""
    tasks = {task.lower(): task for task, _, _ in _naoisis.challenges()}
    near = difflib.get_close_matches(name.lower(), tasks, n=1, cutoff=0.7)
    return tasks[near[0]] if near else None


def refuse_task(scenario: Any) -> None:
    """Says of a task's name that it is no scenario, unless there is such a file."""
    if (
        not isinstance(scenario, str)
        or scenario not in {task for task, _, _ in _naoisis.challenges()}
        or os.path.exists(scenario)
    ):
        return
    expected = f"a scenario, or naoisis.MatchEnv({scenario!r})"
    raise ScenarioError(f"{scenario} is a task; expected {expected}", scenario, expected=expected)


def suggesting_tasks(make: Make) -> Make:
    """Makes the error about an unknown scenario name a task, too: those who make worlds often mean one."""

    @functools.wraps(make)
    def made(self: Any, scenario: Any, *arguments: Any, **options: Any) -> None:
        try:
            make(self, scenario, *arguments, **options)
        except ScenarioError as error:
            meant = nearest_task(scenario) if isinstance(scenario, str) else None
            # Errors within a scenario have a place, and one that is near to another scenario says that.
            if meant is None or error.line is not None or error.field is not None or "did you mean" in str(error):
                raise
            if not str(error).startswith(f"{scenario}: there is no built-in scenario"):
                raise
            expected = f"{error.expected}, or a task's name, see naoisis.tasks()"
            message = f"{scenario}: there is no built-in scenario of this name, and no such file: did you mean the task `{meant}`? expected {expected}"
            raise ScenarioError(message, error.file, expected=expected) from None

    return cast(Make, made)
