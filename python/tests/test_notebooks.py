"""The notebooks for lecturers, from the first cell to the last."""

import json
from pathlib import Path

import numpy as np
import pytest

pyplot = pytest.importorskip("matplotlib.pyplot")

FOLDER = Path(__file__).parent.parent / "notebooks"


def _run(name):
    """Everything that the cells define."""
    pyplot.switch_backend("agg")
    notebook = json.loads((FOLDER / f"{name}.ipynb").read_text(encoding="utf-8"))
    assert all(not cell.get("outputs") for cell in notebook["cells"]), "clear all outputs before it is committed"
    defined = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), name, "exec"), defined)
    pyplot.close("all")
    return defined


def test_a_particle_filter_knows_where_the_robot_is():
    errors = _run("localisation")["errors"]
    assert np.median(errors["particles"][200:]) < 0.25 < np.median(errors["steps alone"][200:])


def test_a_first_team_plays():
    defined = _run("first_team")
    assert len(defined["ball"]) > 1000 and np.isfinite(defined["lead"])
