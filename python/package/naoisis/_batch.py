"""Many seeded matches and their results."""

from __future__ import annotations

import copy
import io
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from naoisis import _naoisis
from naoisis._arguments import Scenario, count_of, match_of, seconds_of
from naoisis._names import refuse_task
from naoisis._tables import Columns, columns_of

if TYPE_CHECKING:
    import pandas

__all__ = ["Batch", "batch"]


class Batch(Columns):
    """The results of a batch: columns by name, with one entry per match, in the order of the matches.

    The columns are those of the table that ``naoisis batch --csv`` writes: ``seed``, the settings that were swept,
    ``outcome``, ``duration_s``, ``blue_goals``, ``pink_goals`` and so on. Missing values are NaN.
    """

    def __init__(self, played: _naoisis.Batch):
        self._played: _naoisis.Batch | None = played
        self._summaries: list[dict[str, Any]] = []
        self._table = played.table()
        super().__init__(columns_of(io.StringIO(self._table)))

    def __getstate__(self) -> dict[str, Any]:
        return {**vars(self), "_played": None, "_summaries": self.summary()}

    @property
    def matches(self) -> int:
        """The number of matches."""
        return len(self["seed"])

    def to_csv(self) -> str:
        """The table, byte for byte as ``naoisis batch --csv`` writes it."""
        return self._table

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a data frame (needs pandas)."""
        import pandas

        return pandas.DataFrame(self._columns)

    def summary(self) -> list[dict[str, Any]]:
        """The results of each combination of settings.

        Returns:
            For each combination a dictionary with ``settings``, ``realism``, ``matches``, ``failed``, ``repeated`` (whether every seed plays the
            same match, so that intervals are meaningless) and the estimates: shares of wins and draws, goals, penalties,
            possession, each as ``{"value": …, "low": …, "high": …}``, the interval being that of 95 % confidence,
            or None without data.
        """
        if self._played is None:
            return copy.deepcopy(self._summaries)
        summaries = self._played.summaries()
        return [{"settings": dict(settings), "realism": realism, **summary} for settings, realism, summary in summaries]

    def __repr__(self) -> str:
        return f"<naoisis.Batch: {self.matches} matches>"


def batch(
    scenario: Scenario = "match3v3",
    matches: int = 1,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    threads: int | None = None,
    *,
    sweep: Mapping[str, Sequence[Any]] | None = None,
    blue: str | None = None,
    pink: str | None = None,
    realism: str | None = None,
    duration_s: float | None = None,
    csv: str | os.PathLike[str] | None = None,
) -> Batch:
    """Plays matches with consecutive seeds from ``seed`` on all cores. The results do not depend on the number of threads.

    Ctrl-C finishes the running matches, and raises KeyboardInterrupt; with ``csv`` the same call continues from there.

    Args:
        scenario: As of :class:`Match`; so are ``set``, ``blue``, ``pink`` and ``realism``.
        matches: The number of matches for each combination of settings.
        seed: The seed of the first match [default: the scenario's].
        threads: The number of threads [default: one per core].
        sweep: Fields of the scenario with several values each; every combination of them is played.
        duration_s: The duration of each match.
        csv: Writes the table to this file; an existing file of the same batch is continued.

    Raises:
        ScenarioError: The scenario, or one of the combinations, is wrong.
        ValueError: Another table is in the file.
    """
    refuse_task(scenario)
    made = match_of(scenario, seed, set, blue, pink, realism)
    values = {}
    if sweep is not None and not isinstance(sweep, Mapping):
        raise TypeError(f"sweep: expected a dictionary of fields and lists of values, not {sweep!r}")
    for field, several in (sweep or {}).items():
        if isinstance(several, str) or not hasattr(several, "__iter__"):
            raise TypeError(f"sweep: {field!r} has {several!r}; expected a list of values")
        values[field] = list(several)
    if duration_s is not None and seconds_of(duration_s, "duration_s") == 0:
        raise ValueError(f"duration_s: {duration_s} is no duration; expected a positive number")
    if threads is not None:
        threads = count_of(threads, "threads", most=1024)
    count = count_of(matches, "matches", most=10_000_000)
    return Batch(_naoisis.Batch(made, count, values, duration_s, threads, None if csv is None else os.fspath(csv)))
