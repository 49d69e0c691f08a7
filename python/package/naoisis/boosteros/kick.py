"""The kick of ``SoccerKickManager``: the robot itself walks to the ball and kicks it.

It is that of naoisis' Booster robots over DDS (``naoisis_booster::visual_kick``); its walk is a guess.
"""

from __future__ import annotations

import math
from typing import Any

# The furthest ball that the robot goes to, m.
_FURTHEST_M = 4.0
# How long the robot goes to a ball of which it no longer hears, cycles.
_REMEMBERED_CYCLES = 30
# Greatest speeds on the way, m/s and rad/s, and velocity for each metre or radian that is left, 1/s.
_FASTEST_MPS, _FASTEST_RADPS, _GAIN_PER_S = 0.7, 1.2, 2.0
# How much further from the ball the robot stays while it faces elsewhere, m.
_AROUND_M = 0.3
# Greatest angle between the kick and its wanted direction, radians.
_PRECISION = 0.15
# The time from seeing the ball until the wind-up begins, s, and how long a kick may take to begin, cycles.
_LATENCY_S, _BEGINNING_CYCLES = 0.1, 10
# The power of a kick at full speed.
MOST_POWER = 10.0

Place = tuple[float, float]
Pose = tuple[float, float, float]


def wrap(angle: float) -> float:
    """The same angle between -pi and pi."""
    return math.remainder(angle, math.tau)


def to_world(pose: Pose, place: Place) -> Place:
    """A place in the frame of a robot, in the frame of its pose."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    return pose[0] + cos * place[0] - sin * place[1], pose[1] + sin * place[0] + cos * place[1]


def to_robot(pose: Pose, place: Place) -> Place:
    """A place in that frame, in the frame of the robot."""
    cos, sin = math.cos(pose[2]), math.sin(pose[2])
    dx, dy = place[0] - pose[0], place[1] - pose[1]
    return cos * dx + sin * dy, cos * dy - sin * dx


class Kick:
    """A kick that is on.

    Args:
        kicks: The kicks of the robot's model, as in the welcome of the match.
    """

    def __init__(self, kicks: dict[str, Any]):
        self._kicks = {name: kick for name, kick in kicks.items() if isinstance(kick, dict)} | kicks.get("own", {})
        self._heading: float | None = None
        self._power = MOST_POWER
        self._ball: Place | None = None
        self._age = 0
        self._wind_up_s = float(kicks.get("wind_up_s") or 0.0)
        self._velocity: Pose = (0.0, 0.0, 0.0)
        self._begins_within = 0

    def aim(self, heading: float, power: float) -> None:
        """Keeps where the ball shall go, in the frame of odometry, and how fast."""
        self._heading, self._power = heading, power

    def see(self, odometry: Pose, ball: Place) -> None:
        """Keeps where the ball is, in the frame of the robot."""
        self._ball, self._age = to_world(odometry, ball), 0

    def act(self, odometry: Pose, is_kicking: bool = False) -> tuple[Pose, dict[str, Any] | None]:
        """Velocity (m/s, m/s, rad/s) and kick of a cycle. In a kick in walking the robot keeps its velocity."""
        if is_kicking:
            self._begins_within = 0
            self._age += 1
            return self._velocity, None
        self._velocity, request = self._step(odometry)
        return self._velocity, request

    def _step(self, odometry: Pose) -> tuple[Pose, dict[str, Any] | None]:
        still = (0.0, 0.0, 0.0)
        if self._ball is None or self._age > _REMEMBERED_CYCLES:
            return still, None
        self._age += 1
        ball = to_robot(odometry, self._ball)
        chosen = self._choose(ball)
        if chosen is None or math.hypot(*ball) > _FURTHEST_M:
            return still, None
        name, region = chosen
        kick = self._kicks[name]
        going_on = self._velocity if kick.get("in_walk") else still
        until_s = (self._wind_up_s if kick.get("wind_up_s") is None else float(kick["wind_up_s"])) + _LATENCY_S
        struck = ball[0] - going_on[0] * until_s, ball[1] - going_on[1] * until_s
        spot_x, spot_y = region["best_m"]
        most = math.radians(region["direction"]["chosen"]["most_deg"]) if isinstance(region["direction"], dict) else 0.0
        straight_on = math.atan2(ball[1] - spot_y, ball[0])
        wanted = straight_on if self._heading is None else wrap(self._heading - odometry[2])
        (x0, x1), (y0, y1) = region["x_m"], region["y_m"]
        if x0 <= struck[0] <= x1 and y0 <= struck[1] <= y1 and abs(wanted) <= most + _PRECISION:
            if self._begins_within > 0:
                self._begins_within -= 1
                return going_on, None
            self._begins_within = _BEGINNING_CYCLES
            direction = math.degrees(min(max(wanted, -most), most))
            return going_on, {"type": name, "speed": self._power / MOST_POWER, "direction_deg": direction}
        # The robot turns to the ball on its way, and beside it in the direction of the kick.
        turn = wanted if math.hypot(*ball) < 0.8 else math.atan2(ball[1], ball[0])
        behind_m = spot_x + _AROUND_M * min(abs(turn), 1.0)
        x = (ball[0] - math.cos(turn) * behind_m) * _GAIN_PER_S
        y = (ball[1] - math.sin(turn) * behind_m - spot_y) * _GAIN_PER_S
        slower = min(1.0, _FASTEST_MPS / max(math.hypot(x, y), 1e-9))
        return (x * slower, y * slower, min(max(turn * _GAIN_PER_S, -_FASTEST_RADPS), _FASTEST_RADPS)), None

    def _choose(self, ball: Place) -> tuple[str, dict[str, Any]] | None:
        """The kick for a ball and where it may lie: `visual` if the robot has it, otherwise straight by the nearer foot."""
        name = "visual" if "visual" in self._kicks else "left_straight" if ball[1] > 0.0 else "right_straight"
        region = self._kicks.get(name, {}).get("region")
        return None if region is None else (name, region)
