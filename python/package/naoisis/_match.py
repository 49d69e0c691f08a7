"""One match."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from naoisis import _naoisis
from naoisis._arguments import Scenario, control_of, count_of, match_of, seconds_of
from naoisis._pictures import png
from naoisis.errors import MatchError

__all__ = ["Match"]


class Match:
    """A match that is played cycle by cycle, and can be looked at in between.

    >>> import naoisis
    >>> match = naoisis.Match("kick_right_straight", seed=1)
    >>> match.step(cycles=30)
    >>> round(match.truth()["ball"]["position_m"][0], 1) > 1.0
    True

    Args:
        scenario: A built-in scenario's name (``naoisis list scenarios``), the path of a ``.ron`` or ``.json`` file, or a
            dictionary of the same shape.
        seed: The seed of all random numbers, instead of the scenario's.
        set: Fields of the scenario that are otherwise, such as ``{"messages.loss": 0.2, "robots[0].number": 7}``.
        blue: The team that plays in blue, such as ``"roles"``, where the scenario lines up teams.
        pink: The team that plays in pink.
        realism: How much of a real robot there is: ``"paper"``, ``"ideal"`` or ``"realistic"``.
        control: The robots that :meth:`step` decides for, such as ``["blue2"]``, or a whole team: ``"blue"``. The built-in
            estimator tells what they believe.

    Raises:
        ScenarioError: The scenario is wrong; it says in which file, line and column, and what was expected.

    All lengths are in metres, times in seconds, angles in degrees; places are in the pitch frame, those of percepts in the
    robot's own, those of beliefs in the team's. The dictionaries have the words of a trace.
    """

    def __init__(
        self,
        scenario: Scenario = "match3v3",
        *,
        seed: int | None = None,
        set: Mapping[str, Any] | None = None,
        blue: str | None = None,
        pink: str | None = None,
        realism: str | None = None,
        control: str | Iterable[str] = (),
    ):
        made = match_of(scenario, seed, set, blue, pink, realism)
        self._match = _naoisis.Match(made, control_of(control))

    @classmethod
    def restore(cls, snapshot: bytes) -> Match:
        """The match of a snapshot, which goes on bit for bit as the one that it was taken of.

        Raises:
            SnapshotError: These are no such bytes.
        """
        if not isinstance(snapshot, (bytes, bytearray, memoryview)):
            raise TypeError(f"snapshot: expected bytes, not {snapshot!r}")
        match = cls.__new__(cls)
        match._match = _naoisis.Match.restore(bytes(snapshot))
        return match

    def snapshot(self) -> bytes:
        """The whole state of the match, random numbers included: the bytes of a ``.naoisis`` file, too."""
        return self._match.snapshot()

    def branch(self) -> Match:
        """Another match that is now as this one is, and goes its own way from here."""
        return Match.restore(self.snapshot())

    def __reduce__(self) -> tuple[Any, ...]:
        return Match.restore, (self.snapshot(),)

    def step(self, commands: Mapping[str, Mapping[str, Any]] | None = None, cycles: int = 1) -> None:
        """Plays some cycles, with commands for the robots that are controlled.

        Args:
            commands: For each robot what it wants, in a trace's words, everything optional: ``{"blue2": {"walk": [dx m, dy m,
                dtheta deg], "head_deg": [yaw, pitch], "kick": {"type": "right_straight", "speed": 1.0}, "posture": …, "say":
                {…}}}``. A step is that of one cycle, and goes on in all cycles of the call; the rest is for the first. A robot
                without a command stands.

        What :meth:`perception` and :meth:`belief` said before is what robots perceived at the beginning of these cycles.

        Raises:
            MatchError: The match is over.
            ValueError: A command is wrong, or for a robot that is not controlled.
        """
        cycles = count_of(cycles, "cycles")
        if self.finished:
            raise MatchError(f"the match is over after {self.time_s:.2f} s; expected no step after its end")
        if not commands:
            self._match.play(cycles)
            return
        if not isinstance(commands, Mapping):
            raise TypeError(f"commands: expected a dictionary of robots and their commands, not {commands!r}")
        self._match.step(dict(commands), cycles)

    def run(self, seconds: float | None = None) -> int:
        """Plays to the end, or for some seconds of the match's own time. Ctrl-C stops it between two cycles.

        Returns:
            The number of cycles played.
        """
        if seconds is None:
            return self._match.play(2**63)
        return self._match.play(round(seconds_of(seconds, "seconds") / self._match.cycle_s))

    @property
    def cycle(self) -> int:
        """Cycles since the start."""
        return self._match.cycle

    @property
    def time_s(self) -> float:
        """Time since the start, s."""
        return self._match.time_s

    @property
    def cycle_s(self) -> float:
        """The duration of a cycle, s."""
        return self._match.cycle_s

    @property
    def score(self) -> dict[str, int]:
        """Goals: ``{"blue": 2, "pink": 1}``."""
        return self._match.score

    @property
    def finished(self) -> bool:
        """Whether the final whistle has gone, or the scenario's duration is over."""
        return self._match.finished

    @property
    def robots(self) -> list[str]:
        """The names of the robots, such as ``"blue1"``, in their order."""
        return self._match.robots

    @property
    def control(self) -> list[str]:
        """The robots that :meth:`step` decides for."""
        return self._match.control

    @property
    def events(self) -> list[dict[str, Any]]:
        """What happened in the last call of :meth:`step` or :meth:`run`, each with its ``kind`` and ``time_s``."""
        return self._match.events

    @property
    def scenario(self) -> dict[str, Any]:
        """Everything that the match started from, all robots listed: a scenario itself."""
        return self._match.scenario

    @property
    def realism(self) -> str:
        """How much of a real robot there is, in words, such as ``"realistic but for kicks"``."""
        return self._match.realism

    def truth(self) -> dict[str, Any]:
        """What is true after the last cycle, and what the robots perceived, believed and wanted in it: a trace's line.

        No robot can know this; it is for referees, rewards and people.
        """
        return self._match.truth()

    def perception(self, robot: str) -> dict[str, Any]:
        """What a robot, such as ``"blue2"``, perceives: its sensors, the messages that arrived, and what it is told.

        In a match with control it is of the cycle that the next :meth:`step` decides, otherwise of the last one.
        """
        return self._match.perception(robot)

    def belief(self, robot: str) -> dict[str, Any] | None:
        """What a robot believes, in its team's frame; None of a robot without beliefs."""
        return self._match.belief(robot)

    def image(self, robot: str, camera: str = "top") -> np.ndarray:
        """What a robot's camera sees: ``uint8``, rows from the top, columns, and red, green and blue.

        Cameras have the names that the robot's model gives them: those of a NAO are ``top`` and ``bottom``, other robots' not.
        The newest image that the match rendered for the robot, and drawn now where it renders none.
        """
        return self._match.image(robot, camera)

    def labels(self, robot: str, camera: str = "top") -> np.ndarray:
        """What each pixel of a robot's camera is: ``uint8``, rows and columns; the numbers of :data:`naoisis.LABELS`.

        Of the image that :meth:`image` returns where the scenario says ``cameras.labels``, else of what it would see now.
        """
        return self._match.labels(robot, camera)

    def depth(self, robot: str, camera: str = "top") -> np.ndarray:
        """How far each pixel of a robot's camera is along its axis, m: ``float32``, rows and columns; 0 is the sky.

        Of the image that :meth:`image` returns where the scenario says ``cameras.depth``, else of what it would see now.
        """
        return self._match.depth(robot, camera)

    def field_image(self, width: int = 960, height: int = 540) -> np.ndarray:
        """The whole field from above one side line: ``uint8`` (height, width, 3)."""
        return self._match.field_image(count_of(width, "width"), count_of(height, "height"))

    def record(
        self,
        *,
        trace: str | os.PathLike[str] | None = None,
        beliefs: str | os.PathLike[str] | None = None,
        video: str | os.PathLike[str] | None = None,
    ) -> None:
        """Writes the match down from now on, until :meth:`close`, which whoever records must call.

        Args:
            trace: A line of JSON a cycle, ``.jsonl``; compressed as ``.jsonl.zst``.
            beliefs: A table of beliefs against the truth, ``.csv``.
            video: A film of the field, ``.mp4``.
        """
        self._match.record(*(None if path is None else os.fspath(path) for path in (trace, beliefs, video)))

    def close(self) -> list[str]:
        """Ends what is being recorded, and returns what the records have to say, such as a summary of the beliefs."""
        return self._match.close()

    def __enter__(self) -> Match:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        score = self.score
        end = ", over" if self.finished else ""
        return f"<naoisis.Match: {self.time_s:.2f} s, blue {score['blue']} : {score['pink']} pink{end}>"

    def _repr_png_(self) -> bytes:
        return png(self.field_image(640, 360))
