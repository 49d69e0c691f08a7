"""The connection of an agent to its match: what the robot perceives, and the commands of each cycle."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable
from typing import Any, NamedTuple, TextIO

import naoisis_agent
from naoisis.boosteros.clock import Clock, leave
from naoisis.boosteros.kick import Pose, to_robot, wrap


class Camera(NamedTuple):
    """The camera of a robot: the size of its image, its focal lengths and its principal point, pixels, and its distortion. The middle of
    the first pixel is at (0.5, 0.5).
    """

    name: str
    width: int
    height: int
    focal: tuple[float, float]
    centre: tuple[float, float]
    distortion: list[float]
    distortion_model: str


class Link:
    """Connects when the agent first needs its robot, so that it may load for longer than a cycle may last.

    Args:
        streams: Where the match is heard and told.
        limit_s: The longest that threads may run in a cycle, s of real time.
        camera: The camera whose images the match renders.
    """

    def __init__(self, streams: tuple[TextIO, TextIO], limit_s: float, camera: str | None = None):
        self.clock = Clock(self._next_cycle, limit_s)
        self.command: Callable[[], dict[str, Any]] = dict
        self.perception: dict[str, Any] = {}
        self.odometry: Pose = (0.0, 0.0, 0.0)
        self.speed: Pose = (0.0, 0.0, 0.0)
        self.image: dict[str, Any] | None = None
        self.image_time_s = 0.0
        self.is_over = False
        self._streams, self._images = streams, [] if camera is None else [camera]
        self._agent: Any = None
        self._turn: Any = None
        self._left_s = 10.0

    def connect(self) -> None:
        """Says hello and receives the first cycle, if that was not done before."""
        if self._agent is not None:
            return
        streams = sys.stdin, sys.stdout
        sys.stdin, sys.stdout = self._streams
        try:
            fields = ["body", "game", "head_deg", "odometry", "percepts", "sensors"]
            agent: Any = naoisis_agent.Agent("boosteros", images=self._images, fields=fields)
        except naoisis_agent.Refused as refusal:
            print(f"boosteros: the match refuses the agent: {refusal}", file=sys.stderr)
            leave(1)
        finally:
            sys.stdin, sys.stdout = streams
        self._agent, self._turns = agent, agent.turns()
        self.robot: str = agent.robot
        self.cycle_s: float = agent.welcome["cycle_s"]
        self.model: dict[str, Any] = agent.welcome["model"]
        self.camera = _camera(self.model["cameras"])
        self._receive()
        self.clock.begin_cycle(self.clock.now_s)

    def _next_cycle(self) -> float:
        if self._agent is None:
            self.connect()
        elif self.is_over:
            # Time goes on for what the agent still does.
            self._left_s -= self.cycle_s
            if self._left_s < 0:
                leave(0)
            return self.clock.now_s + self.cycle_s
        else:
            self._agent.answer(self._turn, self.command())
            self._receive()
        return self.clock.now_s

    def _receive(self) -> None:
        """Receives a cycle, or the end, which interrupts the agent as Ctrl-C does."""
        self._turn = next(self._turns, None)
        if self._turn is None:
            self.is_over = True
            self.clock.interrupt()
            return
        is_first = not self.perception
        self.clock.now_s, self.perception = self._turn["time_s"], self._turn["perception"]
        x, y, heading_deg = self.perception["odometry"]
        before, self.odometry = self.odometry, (x, y, math.radians(heading_deg))
        if not is_first:
            forward, left = to_robot(before, (x, y))
            turn = wrap(self.odometry[2] - before[2])
            self.speed = (forward / self.cycle_s, left / self.cycle_s, turn / self.cycle_s)
        self.image = next(iter(self._turn.get("images", {}).values()), self.image)
        self.image_time_s = (self.image or self.perception["percepts"])["time_s"]


def _camera(settings: dict[str, Any]) -> Camera:
    """The first camera of a robot's model."""
    mount = settings["mounts"][0]
    width, height = mount.get("size") or (settings["width"], settings["height"])
    has_own_view = mount.get("diagonal_fov_deg") is not None
    calibration = mount.get("intrinsics") or (None if has_own_view else settings.get("intrinsics"))
    if calibration is not None:
        # It may be that of images of another size, and counts pixels from the middle of the first one.
        usual = (width, height) if mount.get("intrinsics") else (settings["width"], settings["height"])
        across, down = (now / then for now, then in zip((width, height), calibration.get("size") or usual))
        focal = calibration["fx"] * across, calibration["fy"] * down
        centre = (calibration["cx"] + 0.5) * across, (calibration["cy"] + 0.5) * down
        distortion: Any = calibration.get("distortion") or []
    else:
        half_fov = math.radians(mount.get("diagonal_fov_deg") or settings["diagonal_fov_deg"]) / 2
        focal = (math.hypot(width, height) / 2 / math.tan(half_fov),) * 2
        centre = width / 2, height / 2
        distortion = mount.get("distortion") or settings["lens"].get("distortion") or []
    is_fisheye = isinstance(distortion, dict)
    numbers = [float(number) for number in (distortion["fisheye"] if is_fisheye else distortion)]
    numbers += [0.0] * ((4 if is_fisheye else 5) - len(numbers))
    return Camera(mount["name"], width, height, focal, centre, numbers, "equidistant" if is_fisheye else "plumb_bob")
