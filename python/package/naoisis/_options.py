"""Checks of the options of worlds, and their forms for the compiled module."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np

from naoisis import _naoisis
from naoisis._arguments import check_set, count_of, word_of

CHANGES = ("set", "situation", "snapshot", "draws")
OPTIONS = (*CHANGES, "match_seed")


def changes_of(options: Mapping[str, Any]) -> dict[str, Any] | None:
    """The changes of episodes by the options of a reset; None if there are none."""
    changes: dict[str, Any] = dict.fromkeys(CHANGES)
    for name in ("set", "situation"):
        value = options.get(name)
        if value is not None and not isinstance(value, Mapping):
            raise TypeError(f"options: {name}: expected a dictionary, not {value!r}")
        changes[name] = None if value is None else dict(value)
    check_set(changes["set"])
    check_fields(changes["set"], "options: set")
    changes["draws"] = None if options.get("draws") is None else draws_of(options["draws"])
    snapshot = options.get("snapshot")
    if snapshot is not None:
        if not isinstance(snapshot, (bytes, bytearray)):
            raise TypeError(
                f"options: snapshot: expected the bytes of a match's snapshot, not {type(snapshot).__name__}"
            )
        if any(changes[name] is not None for name in ("set", "situation", "draws")):
            raise ValueError(
                "options: a snapshot cannot be changed; expected no `set`, `draws` and `situation` beside it"
            )
        changes["snapshot"] = bytes(snapshot)
    return changes if any(value is not None for value in changes.values()) else None


def check_options(options: Mapping[str, Any] | None, *more: str) -> None:
    """Checks that a reset knows all of its options."""
    if options is not None and not isinstance(options, Mapping):
        raise TypeError(f"options: expected a dictionary, not {options!r}")
    for name in options or ():
        if name not in (*OPTIONS, *more):
            raise ValueError(f"options: there is no {name!r}; expected {', '.join((*OPTIONS, *more))}")


def opponents_of(opponents: Any, control: list[str] | None) -> tuple[str, list[str]]:
    """The side of the opponents, and the names of the teams from which one is drawn for each episode."""
    side = "blue" if control and control[0].startswith("pink") else "pink"
    if opponents is None or isinstance(opponents, str):
        return side, [] if opponents is None else [opponents]
    if not isinstance(opponents, Sequence) or not opponents:
        raise TypeError(f"opponents: expected the name of a team, or a list of names, not {opponents!r}")
    for team in opponents:
        word_of(team, "opponents")
    return side, list(opponents)


def words_of(words: Any, name: str, what: str) -> list[str]:
    """One word, or a list of words; none for None."""
    if words is None or isinstance(words, str):
        return [] if words is None else [words]
    if not isinstance(words, Sequence) or not words or not all(isinstance(word, str) for word in words):
        raise TypeError(f"{name}: expected {what}, or a list of them, not {words!r}")
    return list(words)


def check_fields(fields: Any, name: str) -> None:
    """Checks that fields for episodes do not set the seed, which each episode has of its own, and that none is a part of another."""
    words = [field for field in fields or () if isinstance(field, str)]
    if "seed" in words:
        raise ValueError(f"{name}: episodes have seeds of their own; expected the seed of a reset")
    for field in words:
        part = next((other for other in words if other.startswith((f"{field}.", f"{field}["))), None)
        if part is not None:
            raise ValueError(f"{name}: {part} is a part of {field}; expected one of the two")


def draws_of(draws: Any) -> list[tuple[str, bool, list[Any]]]:
    """The fields that are drawn, whether each has a range, and its values."""
    if draws is None:
        return []
    if not isinstance(draws, Mapping):
        raise TypeError(f"draws: expected a dictionary of fields and what their values are drawn from, not {draws!r}")
    check_set(draws)
    check_fields(draws, "draws")
    if "realism" in draws:
        raise ValueError("draws: realism is an option of its own; expected a list of levels there")
    fields: list[tuple[str, bool, list[Any]]] = []
    for field, values in draws.items():
        if not isinstance(field, str):
            raise TypeError(f"draws: expected fields, such as 'messages.loss', not {field!r}")
        if isinstance(values, tuple):
            try:
                low, high = map(float, values)
            except (TypeError, ValueError):
                raise TypeError(f"draws: {field}: expected the least and the greatest number, not {values!r}") from None
            if not (np.isfinite(low) and np.isfinite(high) and low <= high):
                raise ValueError(f"draws: {field}: {values} is no range; expected the least and the greatest number")
            fields.append((field, True, [low, high]))
        elif isinstance(values, (list, np.ndarray, range)) and len(values):
            fields.append((field, False, list(values)))
        else:
            raise TypeError(
                f"draws: {field}: expected a tuple of the least and the greatest number, or a list or `range` of values, not {values!r}"
            )
    return fields


def robots_of(numbers: Any) -> list[int] | None:
    """The numbers of team-mates and of opponents in an observation."""
    if numbers is None:
        return None
    if not isinstance(numbers, Sequence) or len(numbers) != 2:
        raise TypeError(f"observed_robots: expected the numbers of team-mates and of opponents, not {numbers!r}")
    return [count_of(number, "observed_robots", least=0, most=63) for number in numbers]


EXTRAS = ("set_plays", "penalties", "messages", "tracked")


def extras_of(extras: Any, says: Any) -> dict[str, Any]:
    if isinstance(extras, str) or not isinstance(extras, Iterable):
        raise TypeError(f"extras: expected a list of {', '.join(EXTRAS)}, not {extras!r}")
    wanted = list(extras)
    for extra in wanted:
        if extra not in EXTRAS:
            raise ValueError(f"extras: there is no {extra!r}; expected {', '.join(EXTRAS)}")
    return {**{extra: extra in wanted for extra in EXTRAS}, "words": count_of(says, "says", least=0, most=8)}


def weights_of(reward: Mapping[str, float] | None) -> dict[str, float] | None:
    if reward is None:
        return None
    if not isinstance(reward, Mapping):
        names = ", ".join(name for name, _ in _naoisis.Environments.rewards())
        raise TypeError(f"reward: expected a dictionary of {names} and their weights, not {reward!r}")
    weights = {}
    for name, weight in reward.items():
        try:
            weights[name] = float(weight)
        except (TypeError, ValueError) as error:
            raise type(error)(f"reward: expected a number for {name}, not {weight!r}") from None
    return weights


# Memory of a world, and of each of its robots, MB: measured for 1, 6 and 14 robots, which take 1.5, 1.6 and 2.1 MB in all.
_WORLD_MB, _ROBOT_MB = 1.4, 0.045


def check_memory(worlds: int, robots: int = 1) -> None:
    """Raises a MemoryError if so many worlds cannot fit in memory. A failed allocation would end the whole interpreter."""
    needed, available = (_WORLD_MB + _ROBOT_MB * robots) * worlds, _available_mb()
    if available is not None and needed > available:
        raise MemoryError(
            f"num_envs: {worlds:,} worlds need more than {needed / 1000:,.1f} GB; {available / 1000:,.1f} GB are available"
        )


def _available_mb() -> float | None:
    """Returns the memory that this process can still allocate, MB; None on systems without ``/proc``."""
    try:
        with open("/proc/meminfo") as file:
            available = next(int(line.split()[1]) / 1000 for line in file if line.startswith("MemAvailable:"))
        import resource

        most = resource.getrlimit(resource.RLIMIT_AS)[0]
        if most != resource.RLIM_INFINITY:
            with open("/proc/self/statm") as file:
                used = int(file.read().split()[0]) * resource.getpagesize()
            available = min(available, max(0, most - used) / 1e6)
    except (OSError, StopIteration, ValueError, ImportError):
        return None
    return available
