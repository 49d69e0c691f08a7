"""One match."""

from __future__ import annotations

import base64
import os
from collections.abc import Iterable, Mapping
from html import escape
from typing import Any

import numpy as np

from naoisis import _naoisis
from naoisis._arguments import Scenario, control_of, count_of, match_of, seconds_of, text_of, word_of
from naoisis._names import refuse_task
from naoisis._pages import frame_of
from naoisis._pictures import png
from naoisis.errors import MatchError

__all__ = ["Match"]


class Match:
    """A match that is played cycle by cycle and can be inspected in between.

    >>> import naoisis
    >>> match = naoisis.Match("kick_right_straight", seed=1)
    >>> match.step(cycles=30)
    >>> round(match.truth()["ball"]["position_m"][0], 1) > 1.0
    True

    Args:
        scenario: A built-in scenario's name (``naoisis list scenarios``), the path of a ``.ron`` or ``.json`` file, or a
            dictionary of the same shape.
        seed: The seed of all random numbers, instead of the scenario's.
        set: Fields of the scenario to change, such as ``{"messages.loss": 0.2, "robots[0].number": 7}``.
        blue: The blue team, such as ``"roles"``, if the scenario has teams.
        pink: The pink team.
        realism: The level of realism: ``"paper"``, ``"ideal"`` or ``"realistic"``.
        control: The robots that :meth:`step` controls, such as ``["blue2"]``, or a whole team: ``"blue"``. :meth:`belief` returns the
            belief of the built-in estimator for them.

    Raises:
        ScenarioError: The scenario is invalid; the error has file, line and column, and what was expected.

    All lengths are in metres, times in seconds, angles in degrees; positions are in the pitch frame, those of percepts in the
    robot frame, those of beliefs in the team frame. The dictionaries have the names of a trace.
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
        refuse_task(scenario)
        made = match_of(scenario, seed, set, blue, pink, realism)
        self._match = _naoisis.Match(made, control_of(control))

    @classmethod
    def restore(cls, snapshot: bytes) -> Match:
        """The match of a snapshot. It continues bit for bit like the match of which the snapshot was taken.

        Raises:
            SnapshotError: The bytes are not a snapshot.
        """
        if not isinstance(snapshot, (bytes, bytearray, memoryview)):
            raise TypeError(f"snapshot: expected bytes, not {snapshot!r}")
        match = cls.__new__(cls)
        match._match = _naoisis.Match.restore(bytes(snapshot))
        return match

    def snapshot(self) -> bytes:
        """The whole state of the match, including random numbers, as the bytes of a ``.naoisis`` file."""
        return self._match.snapshot()

    def branch(self) -> Match:
        """An independent copy of the match in its current state."""
        return Match.restore(self.snapshot())

    def __reduce__(self) -> tuple[Any, ...]:
        return Match.restore, (self.snapshot(),)

    def step(self, commands: Mapping[str, Mapping[str, Any]] | None = None, cycles: int = 1) -> None:
        """Plays some cycles, with commands for the robots that are controlled.

        Args:
            commands: The command of each robot, with the names of a trace, everything optional: ``{"blue2": {"walk": [dx m, dy m,
                dtheta deg], "head_deg": [yaw, pitch], "kick": {"type": "right_straight", "speed": 1.0}, "posture": …, "say":
                {…}}}``. ``walk`` is the step of one cycle, and is repeated in all cycles of the call; the rest is for the first cycle. A robot
                without a command stands.

        What :meth:`perception` and :meth:`belief` returned before are the perceptions at the beginning of these cycles.

        Raises:
            MatchError: The match is over.
            ValueError: A command is invalid, or for a robot that is not controlled.
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
        """Plays to the end, or for some seconds of simulated time. Ctrl-C stops it between two cycles.

        Returns:
            The number of cycles played.
        """
        if seconds is None:
            return self._match.play(2**63)
        return self._match.play(round(min(seconds_of(seconds, "seconds") / self._match.cycle_s, 2.0**63)))

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
    def result(self) -> dict[str, Any]:
        """Score, winner (``None`` of a draw), what decided it (``"play"``, ``"extra_time"``, ``"shoot_out"`` or ``"coin"``) and, after a
        shoot-out, its goals."""
        return self._match.result

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
        """The complete scenario of the match, with all defaults and robots. It is a scenario itself."""
        return self._match.scenario

    @property
    def realism(self) -> str:
        """The realism of the match in words, such as ``"realistic but for kicks"``."""
        return self._match.realism

    def truth(self) -> dict[str, Any]:
        """The line of a trace after the last cycle: the truth, and what the robots perceived, believed and commanded.

        Robots cannot know this; it is for referees, rewards and people.
        """
        return self._match.truth()

    def perception(self, robot: str) -> dict[str, Any]:
        """The perception of a robot, such as ``"blue2"``: its sensors, received messages, and the game status that it received.

        In a match with controlled robots it is of the cycle that the next :meth:`step` plays, otherwise of the last one.
        """
        return self._match.perception(text_of(robot, "robot"))

    def belief(self, robot: str) -> dict[str, Any] | None:
        """The belief of a robot, in the frame of its team; None for a robot without beliefs."""
        return self._match.belief(text_of(robot, "robot"))

    def image(self, robot: str, camera: str | None = None) -> np.ndarray:
        """The image of a robot's camera [default: its first]: ``uint8``, rows from the top, columns, and red, green and blue.

        Cameras have the names of the robot's model, for example ``top`` and ``bottom`` for a NAO.
        It is the newest image that the match rendered for the robot; if the match renders none, it is rendered now.
        """
        return self._match.image(text_of(robot, "robot"), word_of(camera, "camera"))

    def labels(self, robot: str, camera: str | None = None) -> np.ndarray:
        """The class of each pixel of a robot's camera [default: its first]: ``uint8``; the numbers of :data:`naoisis.LABELS`.

        With ``cameras.labels`` in the scenario they belong to the image of :meth:`image`, else they are rendered now.
        """
        return self._match.labels(text_of(robot, "robot"), word_of(camera, "camera"))

    def depth(self, robot: str, camera: str | None = None) -> np.ndarray:
        """The depth of each pixel along the axis of a robot's camera [default: its first], m: ``float32``; 0 is the sky.

        With ``cameras.depth`` in the scenario it belongs to the image of :meth:`image`, else it is rendered now.
        """
        return self._match.depth(text_of(robot, "robot"), word_of(camera, "camera"))

    def field_image(self, width: int = 960, height: int = 540) -> np.ndarray:
        """The whole field from above one side line: ``uint8`` (height, width, 3)."""
        return self._match.field_image(count_of(width, "width"), count_of(height, "height"))

    def record(
        self,
        *,
        trace: str | os.PathLike[str] | None = None,
        beliefs: str | os.PathLike[str] | None = None,
        video: str | os.PathLike[str] | None = None,
        html: str | os.PathLike[str] | None = None,
        mcap: str | os.PathLike[str] | None = None,
    ) -> None:
        """Records the match from now on, until :meth:`close`, which must be called. Existing files are replaced.

        Args:
            trace: One line of JSON per cycle, ``.jsonl``; compressed as ``.jsonl.zst``.
            beliefs: A table of the errors of beliefs, ``.csv``.
            video: A video of the field, ``.mp4``.
            html: A page that plays the match in a browser, ``.html``. A notebook then shows the match up to now.
            mcap: The trace and what Foxglove and Lichtblick show, ``.mcap``.
        """
        paths = (trace, beliefs, video, html, mcap)
        self._match.record(*(None if path is None else os.fspath(path) for path in paths))

    def close(self) -> list[str]:
        """Ends the recordings, and returns their messages, such as a summary of the beliefs."""
        return self._match.close()

    def __enter__(self) -> Match:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()

    def __repr__(self) -> str:
        score = self.score
        end = ", over" if self.finished else ""
        return f"<naoisis.Match: {self.time_s:.2f} s, blue {score['blue']} : {score['pink']} pink{end}>"

    def _repr_html_(self) -> str:
        page = self._match.page()
        if page is not None:
            return frame_of(page)
        picture = base64.b64encode(self._repr_png_()).decode()
        hint = (
            "To see the match played here, call <code>record(html=&quot;match.html&quot;)</code> before it is played."
        )
        return f'<img alt="The field now" src="data:image/png;base64,{picture}"><p>{escape(repr(self))}. {hint}</p>'

    def _repr_png_(self) -> bytes:
        return png(self.field_image(640, 360))
