"""Batches as Python plays them."""

import subprocess

import numpy as np
import pytest

import naoisis

SHORT = {"matches": 4, "seed": 3, "duration_s": 4}


def test_the_table_is_that_of_the_command_whatever_the_number_of_threads(tmp_path):
    path = tmp_path / "table.csv"
    arguments = ["--matches", "4", "--seed", "3", "--duration", "4", "--set", "messages.loss=0,0.5", "--csv", path]
    subprocess.run(["naoisis", "batch", "match3v3", "--quiet", *arguments], check=True)
    one, two = (
        naoisis.batch("match3v3", **SHORT, sweep={"messages.loss": [0, 0.5]}, threads=threads) for threads in (1, 2)
    )
    assert one.to_csv() == two.to_csv() == path.read_text()
    # A file of the same batch is gone on with.
    again = naoisis.batch("match3v3", **SHORT, sweep={"messages.loss": [0, 0.5]}, csv=path)
    assert again.to_csv() == one.to_csv()
    with pytest.raises(ValueError, match="expected the table of an earlier batch"):
        naoisis.batch("match3v3", **SHORT, csv=path)


def test_columns_are_arrays_and_the_summary_has_intervals():
    batch = naoisis.batch("match3v3", **SHORT, realism="ideal")
    assert list(batch["seed"]) == [3, 4, 5, 6] and batch["blue_goals"].dtype == np.int64
    assert batch.matches == 4 and set(batch["outcome"]) == {"duration"}
    assert batch["duration_s"] == pytest.approx([4, 4, 4, 4]) and batch["blue_possession"].dtype == np.float64
    [summary] = batch.summary()
    assert (summary["matches"], summary["failed"], summary["realism"]) == (4, 0, "ideal")
    draws = summary["draws"]
    assert 0 <= draws["low"] <= draws["value"] == np.mean(batch["blue_goals"] == batch["pink_goals"]) <= draws["high"]
    pandas = pytest.importorskip("pandas")
    frame = batch.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and list(frame.columns) == list(batch)


@pytest.mark.parametrize(
    ("arguments", "exception", "words"),
    [
        ({"matches": 0}, ValueError, "matches: 0 is out of range"),
        ({"threads": 0}, ValueError, "threads"),
        ({"duration_s": -1}, ValueError, "is no duration"),
        ({"sweep": {"messages.loss": 0.5}}, TypeError, "expected a list of values"),
        ({"sweep": {"messages.loss": []}}, ValueError, "has no values"),
        ({"sweep": {"messages.loss": [0, 2]}}, naoisis.ScenarioError, "expected"),
        ({"csv": "/"}, OSError, "no ordinary file"),
    ],
)
def test_bad_arguments_are_clear_exceptions(arguments, exception, words):
    with pytest.raises(exception, match=words):
        naoisis.batch("match3v3", **{"matches": 1, "duration_s": 1, **arguments})
