"""Reads traces and tables of matches."""

from __future__ import annotations

import os
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np

from naoisis import _naoisis
from naoisis._tables import Columns, columns_of

if TYPE_CHECKING:
    import pandas

__all__ = ["Trace", "read_beliefs", "read_tables", "read_trace", "trace_lines"]


class Trace(Columns):
    """A trace as columns: one entry per line, by the name of the robot and the quantity, such as ``"blue1.pose"``.

    ================================ =============== ==================================================================
    column                           shape           what it is
    ================================ =============== ==================================================================
    ``cycle``, ``time_s``            (n,)            cycles and seconds since the start
    ``ball.position_m``              (n, 3)          the ball's true centre, m
    ``ball.velocity_mps``            (n, 3)          its true velocity, m/s
    ``score``                        (n, 2)          goals of blue and pink
    ``state``                        (n,)            ``initial``, ``standby``, ``ready``, ``set``, ``playing``, ``finished``
    ``blue1.pose``                   (n, 3)          where the robot truly is: x m, y m, heading deg
    ``blue1.velocity``               (n, 3)          how it truly moves: m/s, m/s, deg/s
    ``blue1.head_deg``               (n, 2)          yaw and pitch of its head
    ``blue1.odometry``               (n, 3)          its way by its own steps: x m, y m, heading deg
    ``blue1.sonar_m``                (n, 2)          what its left and right sonar measured
    ``blue1.penalised``              (n,)            1 while it serves a penalty
    ``blue1.seen_ball_m``            (n, 2)          where it saw the ball, in its own frame
    ``blue1.belief_pose``            (n, 3)          where it believed to be, in its team's frame
    ``blue1.belief_ball_m``          (n, 2)          where it believed the ball to be, in its team's frame
    ``blue1.pitch_belief_pose``      (n, 3)          where it believed to be, in the frame of ``pose``
    ``blue1.pitch_belief_ball_m``    (n, 2)          where it believed the ball to be, in the frame of ``ball.position_m``
    ``blue1.own_end``                (n,)            the side of the goal that its team defends: -1 or 1, the sign of x
    ``blue1.walk``                   (n, 3)          the step that it wanted: m, m, deg
    ``blue1.kicks``                  (n,)            1 where it wanted to kick
    ================================ =============== ==================================================================

    Missing values are NaN; parts that the trace does not have get no column.

    Attributes:
        scenario: The scenario of the match.
        events: The events, each with its ``kind`` and ``time_s``.
        ending: Why the match ended, such as ``"final_whistle"``; None for an incomplete trace.
    """

    def __init__(
        self,
        columns: dict[str, np.ndarray],
        scenario: dict[str, Any],
        events: list[dict[str, Any]],
        ending: str | None,
    ):
        super().__init__({name: np.asarray(column) for name, column in columns.items()})
        self.scenario, self.events, self.ending = scenario, events, ending

    @property
    def robots(self) -> list[str]:
        """The names of the robots."""
        return list(dict.fromkeys(name.split(".")[0] for name in self if "." in name and not name.startswith("ball.")))

    def to_pandas(self) -> pandas.DataFrame:
        """A data frame (needs pandas) with one column per number, such as ``blue1.pose.0``."""
        import pandas

        flat = {}
        for name, column in self.items():
            if column.ndim == 1:
                flat[name] = column
            else:
                flat.update({f"{name}.{index}": column[:, index] for index in range(column.shape[1])})
        return pandas.DataFrame(flat)

    def __repr__(self) -> str:
        return f"<naoisis.Trace: {len(self['cycle'])} cycles, {len(self.robots)} robots>"


def read_trace(path: str | os.PathLike[str]) -> Trace:
    """Reads a trace (``.jsonl``, ``.jsonl.zst`` or ``.mcap``) as columns.

    Raises:
        TraceError: It cannot be read; the error has line and column.
    """
    return Trace(*_naoisis.read_trace(os.fspath(path)))


def read_tables(path: str | os.PathLike[str]) -> dict[str, dict[str, np.ndarray]]:
    """Reads a trace as the tables ``cycles``, ``robots``, ``percepts``, ``beliefs``, ``events`` and ``messages``: columns by name.

    The columns are those that ``naoisis convert TRACE --parquet DIR`` writes. Missing numbers are NaN, missing texts None.

    Raises:
        TraceError: It cannot be read; the error has line and column.
    """
    tables = _naoisis.read_tables(os.fspath(path))
    return {
        name: {
            column: np.array(values, dtype=object) if isinstance(values, list) else values
            for column, values in columns.items()
        }
        for name, columns in tables.items()
    }


def trace_lines(path: str | os.PathLike[str]) -> Iterator[dict[str, Any]]:
    """The cycles of a trace as dictionaries, one after the other, as :meth:`Match.truth` has them.

    Raises:
        TraceError: It cannot be read; the error has line and column.
    """
    return iter(_naoisis.TraceLines(os.fspath(path)))


def read_beliefs(path: str | os.PathLike[str]) -> dict[str, np.ndarray]:
    """Reads a table of the errors of beliefs, as written by ``naoisis run --beliefs``: columns by name."""
    # A number would be taken for an open file, and closed.
    with open(os.fspath(path), newline="", encoding="utf-8") as file:
        return columns_of(file)
