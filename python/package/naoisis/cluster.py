"""Many matches on many machines, by Ray. Needs ``pip install naoisis[ray]``.

>>> import naoisis.cluster
>>> table = naoisis.cluster.batch("match3v3", matches=100_000)   # on the cluster that Ray is connected to, or on this machine

The table is that of :func:`naoisis.batch`, byte for byte: each match depends on its scenario and seed alone. Work is sent in blocks of
about ten seconds; blocks of a lost machine are repeated elsewhere.
"""

from __future__ import annotations

import csv as tables
import io
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import ray

import naoisis
from naoisis._arguments import Scenario, count_of, seed_of

__all__ = ["batch", "map"]

Result = TypeVar("Result")

BLOCK_S = 10.0
# A block that is lost with its machine is played again so often.
MOST_LOSSES = 20


def batch(
    scenario: Scenario = "match3v3",
    matches: int = 1,
    seed: int | None = None,
    set: Mapping[str, Any] | None = None,
    *,
    sweep: Mapping[str, Sequence[Any]] | None = None,
    csv: str | os.PathLike[str] | None = None,
    in_flight: int | None = None,
    progress: bool | None = None,
    **options: Any,
) -> naoisis.Batch:
    """Plays matches on all machines of the cluster: the same table as :func:`naoisis.batch` plays on one.

    The machines need only the package, and the files of the scenario at the same paths. Ctrl-C leaves the finished rows in ``csv``, and
    the same call continues from there.

    Args:
        scenario, matches, seed, set, sweep, csv, options: As of :func:`naoisis.batch`, but for ``threads``: a core plays a block.
        in_flight: The most blocks that run or wait at the same time [default: two per core].
        progress: Whether to show a progress bar on standard error [default: if that is a terminal].

    Raises:
        ScenarioError: The scenario, or one of the combinations, is wrong.
    """
    matches = count_of(matches, "matches", most=10_000_000)
    scenario = _from_anywhere(scenario)
    # What is wrong is said before anything goes out; it also tells the seed, and the scenario as files have it.
    first = naoisis.batch(scenario, 1, seed, set, 1, sweep=sweep, **{**options, "duration_s": 0.001})
    begin = seed_of(seed)
    if begin is None:
        begin = int(first["seed"][0])
    variants = first.matches
    given = {"scenario": scenario, "set": set, "sweep": sweep, "threads": 1, **options}

    def play(block: range) -> list[str]:
        return records(naoisis.batch(matches=len(block), seed=begin + block.start, **given).to_csv())[1:]

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "table.csv" if csv is None else Path(csv)
        header = records(first.to_csv())[0]
        done = records(_text(path)) if path.exists() else [header]
        # It says so if the table that is there is not this one's.
        if len(done) > 1:
            naoisis.batch(scenario, (len(done) - 1) // variants or 1, begin, set, 1, sweep=sweep, csv=path, **options)
            done = records(_text(path))
        earlier = (len(done) - 1) // variants
        with open(path, "w", encoding="utf-8", newline="") as file:
            file.writelines(done[: 1 + earlier * variants])
            number = earlier * variants
            for rows in _in_blocks(range(earlier, matches), play, in_flight, progress, "matches"):
                for row in rows:
                    number += 1
                    file.write(f"{number},{row.split(',', 1)[1]}")
                file.flush()
        # Nothing is left to play: the whole table is read, and checked.
        return naoisis.batch(scenario, matches, begin, set, 1, sweep=sweep, csv=path, **options)


def map(
    function: Callable[[Any, int], Result],
    scenarios: Iterable[Any],
    seeds: Iterable[int],
    *,
    in_flight: int | None = None,
    progress: bool | None = None,
) -> list[Result]:
    """Calls a function for each scenario with each seed, on all machines of the cluster.

    >>> def lead(scenario, seed):
    ...     match = naoisis.Match(scenario, seed=seed)
    ...     match.run()
    ...     return match.score["blue"] - match.score["pink"]
    >>> naoisis.cluster.map(lead, ["match3v3"], range(1000))

    Args:
        function: A function of a scenario and a seed. Its exceptions are raised here.
        scenarios: The scenarios: names, dictionaries, anything that can be pickled.
        seeds: The seeds, for each of the scenarios.
        in_flight, progress: As of :func:`batch`.

    Returns:
        The results, those of the first scenario with all seeds first.
    """
    if not callable(function):
        raise TypeError(f"function: expected a function of a scenario and a seed, not {function!r}")
    seeds = list(seeds)
    calls = [(scenario, seed) for scenario in scenarios for seed in seeds]

    def play(block: range) -> list[Result]:
        return [function(*calls[index]) for index in block]

    results: list[Result] = []
    for some in _in_blocks(range(len(calls)), play, in_flight, progress, "calls"):
        results += some
    return results


def _in_blocks(
    work: range,
    play: Callable[[range], list[Result]],
    in_flight: int | None,
    progress: bool | None,
    unit: str,
) -> Iterator[list[Result]]:
    """Runs all work in blocks, and yields their results in order. The first blocks have one item each, to measure the time."""
    if not ray.is_initialized():
        ray.init(include_dashboard=False, log_to_driver=False)
    most = in_flight or max(2, 2 * int(ray.cluster_resources().get("CPU", 1)))
    most = count_of(most, "in_flight")
    with _Bar(len(work), unit, progress) as bar:
        begun: dict[Any, int] = {}
        blocks: list[range] = []
        finished: dict[int, list[Result]] = {}
        expected, next_one, size, taken = 0, work.start, 1, []
        task = _task(play)
        try:
            while next_one < work.stop or begun:
                while next_one < work.stop and len(begun) < most:
                    block = range(next_one, min(next_one + size, work.stop))
                    begun[task.remote(block)] = len(blocks)
                    blocks.append(block)
                    next_one = block.stop
                ready, _ = ray.wait(list(begun), num_returns=1)
                for reference in ready:
                    index = begun.pop(reference)
                    finished[index], seconds = ray.get(reference)
                    bar.add(len(blocks[index]))
                    taken.append(seconds / len(blocks[index]))
                    size = max(1, round(BLOCK_S / max(sum(taken) / len(taken), 1e-6)))
                    # Blocks of one row of machines should not keep all others waiting in the end.
                    size = min(size, max(1, (work.stop - next_one) // most))
                while expected in finished:
                    yield finished.pop(expected)
                    expected += 1
        finally:
            for reference in begun:
                ray.cancel(reference)


def _task(play: Callable[[range], list[Result]]) -> Any:
    """Runs a block as a task of Ray. Returns the results, and the time, s."""

    @ray.remote(num_cpus=1, max_retries=MOST_LOSSES)
    def timed(block: range) -> tuple[list[Result], float]:
        begun = time.perf_counter()
        return play(block), time.perf_counter() - begun

    return timed


def _from_anywhere(scenario: Scenario) -> Scenario:
    """The scenario with absolute paths of its files."""
    if isinstance(scenario, Mapping):
        saved = scenario.get("from")
        return {**scenario, "from": os.path.abspath(saved)} if isinstance(saved, (str, os.PathLike)) else scenario
    # Else it is a built-in scenario's name, or wrong, and then its error names what was given.
    return (
        os.path.abspath(scenario) if isinstance(scenario, (str, os.PathLike)) and os.path.isfile(scenario) else scenario
    )


def _text(path: Path) -> str:
    """The text of a file, including its line ends."""
    with open(path, encoding="utf-8", newline="") as file:
        return file.read()


def records(table: str) -> list[str]:
    """The records of a table as written, including the header and line ends. Cells may contain line ends."""
    lines = io.StringIO(table, newline="").readlines()
    reader = tables.reader(iter(lines))
    found, before = [], 0
    for _ in reader:
        found.append("".join(lines[before : reader.line_num]))
        before = reader.line_num
    return found


class _Bar:
    """A progress bar on standard error."""

    def __init__(self, total: int, unit: str, shown: bool | None):
        self.total, self.unit, self.done = total, unit, 0
        self.shown = sys.stderr.isatty() if shown is None else shown
        self.begun = time.monotonic()

    def add(self, count: int) -> None:
        self.done += count
        if self.shown:
            rate = self.done / max(time.monotonic() - self.begun, 1e-9)
            print(f"\r{self.done}/{self.total} {self.unit}, {rate:.1f} a second", end="", file=sys.stderr, flush=True)

    def __enter__(self) -> _Bar:
        return self

    def __exit__(self, *exception: object) -> None:
        if self.shown and self.done:
            print(file=sys.stderr)
