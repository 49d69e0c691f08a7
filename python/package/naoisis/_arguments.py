"""Checks of the arguments of the package's functions."""

from __future__ import annotations

import math
import operator
import os
from collections.abc import Iterable, Mapping
from typing import Any

from naoisis.errors import ScenarioError

Scenario = str | os.PathLike[str] | Mapping[str, Any]
"""A built-in scenario's name, the path of a ``.ron`` or ``.json`` file, or the scenario itself."""

LARGEST_SEED = 2**64 - 1


def seed_of(seed: Any, name: str = "seed") -> int | None:
    """The seed as a number of 64 bits, or None."""
    if seed is None:
        return None
    try:
        number = operator.index(seed)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, not {seed!r}") from None
    if not 0 <= number <= LARGEST_SEED:
        raise ValueError(f"{name}: {number} is out of range; expected 0 to {LARGEST_SEED}")
    return number


def count_of(count: Any, name: str, least: int = 1, most: int = 2**32) -> int:
    """A whole number within a range."""
    try:
        number = operator.index(count)
    except TypeError:
        raise TypeError(f"{name}: expected a whole number, not {count!r}") from None
    if not least <= number <= most:
        raise ValueError(f"{name}: {number} is out of range; expected {least} to {most}")
    return number


def seconds_of(seconds: Any, name: str) -> float:
    """A duration, s: finite, from 0 on."""
    try:
        number = float(seconds)
    except (TypeError, ValueError):
        raise TypeError(f"{name}: expected a number of seconds, not {seconds!r}") from None
    if not (math.isfinite(number) and number >= 0):
        raise ValueError(f"{name}: {seconds} is no duration; expected a number from 0 on")
    return number


def text_of(text: Any, name: str) -> str:
    """A text."""
    if isinstance(text, str):
        return text
    raise TypeError(f"{name}: expected a text, not {text!r}")


def word_of(word: Any, name: str) -> str | None:
    """A word, or None."""
    if word is None or isinstance(word, str):
        return word
    raise TypeError(f"{name}: expected a text, not {word!r}")


def match_of(
    scenario: Scenario,
    seed: Any = None,
    set: Mapping[str, Any] | None = None,
    blue: str | None = None,
    pink: str | None = None,
    realism: str | None = None,
) -> dict[str, Any]:
    """The arguments of a match in the form of the compiled module."""
    if set is not None and not isinstance(set, Mapping):
        raise TypeError(f"set: expected a dictionary of fields and their values, not {set!r}")
    check_set(set)
    if isinstance(scenario, (str, os.PathLike)) and os.fspath(scenario).endswith(".naoisis"):
        expected = (
            f"a scenario that goes on from it, {{'from': {os.fspath(scenario)!r}}}, or Match.restore of its bytes"
        )
        words = f"{os.fspath(scenario)} is a saved match; expected {expected}"
        raise ScenarioError(words, os.fspath(scenario), expected=expected)
    return {
        "scenario": dict(scenario) if isinstance(scenario, Mapping) else scenario,
        "seed": seed_of(seed),
        "set": None if set is None else dict(set),
        "blue": word_of(blue, "blue"),
        "pink": word_of(pink, "pink"),
        "realism": word_of(realism, "realism"),
    }


def check_set(set: Mapping[str, Any] | None) -> None:
    """Checks that the fields of ``set`` can be set; only a scenario itself can have ``from``."""
    if set is not None and any(field == "from" for field in set):
        expected = "a scenario that goes on from the saved match, {'from': 'moment.naoisis'}"
        raise ScenarioError(f"set: `from` cannot be set; expected {expected}", field="from", expected=expected)


def control_of(control: str | Iterable[str]) -> list[str]:
    """The names of the controlled robots or teams."""
    if not isinstance(control, Iterable):
        raise TypeError(f"control: expected robots such as 'blue2', or a team, not {control!r}")
    words = [control] if isinstance(control, str) else list(control)
    for word in words:
        if not isinstance(word, str):
            raise TypeError(f"control: expected robots such as 'blue2', or a team, not {word!r}")
    return words
