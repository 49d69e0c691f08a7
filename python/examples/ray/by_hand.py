"""A behaviour by hand, with parameters that can be tuned: to the ball, round it, and a kick at the goal. NumPy alone.

``tune.py`` tunes it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# Where the ball must lie for each kick, robot frame, m: the least and the greatest x and y; and the tip of the foot, from which it leaves.
KICKS = {
    "left_straight": ((0.10, 0.20), (0.00, 0.10), 0.10 + 0.05j),
    "right_straight": ((0.10, 0.20), (-0.10, 0.00), 0.10 - 0.05j),
    "left_side": ((0.10, 0.22), (-0.15, 0.00), 0.10 + 0.05j),
    "right_side": ((0.10, 0.22), (0.00, 0.15), 0.10 - 0.05j),
}


class Kicker:
    """Decides for robots from their beliefs, row by row, as discrete actions. Places are complex numbers, robot frame, m.

    Args:
        names: The names of the numbers of an observation.
        actions: The names of the actions.
        behind_m: How far behind the ball it gets into line with ball and goal, m.
        aim_deg: How well it must be in line before it walks up to the ball, deg.
        turn_deg: From which angle on it turns on the spot, deg.
        goal_m: How far to either side of the goal's middle a kick may go, m.
    """

    def __init__(
        self,
        names: Sequence[str],
        actions: Sequence[str],
        behind_m: float = 0.3,
        aim_deg: float = 20.0,
        turn_deg: float = 40.0,
        goal_m: float = 0.5,
    ):
        self.index = {name: index for index, name in enumerate(names)}
        self.action = {name: index for index, name in enumerate(actions)}
        self.behind_m, self.aim, self.turn = behind_m, np.radians(aim_deg), np.radians(turn_deg)
        self.goal_m = goal_m

    def begin(self, over: np.ndarray) -> None:
        """It remembers nothing of episodes that are over."""

    def _place(self, observations: np.ndarray, thing: str) -> np.ndarray:
        return observations[:, self.index[f"{thing}.x"]] + 1j * observations[:, self.index[f"{thing}.y"]]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        ball, goal = self._place(observations, "ball"), self._place(observations, "goal")
        known = observations[:, self.index["ball.known"]] > 0.5
        way = goal - ball
        ahead = way / np.maximum(np.abs(way), 1e-6)
        ball_ahead = ball * ahead.conj()
        # Where it stands in line: the ball before one of its feet.
        foot = np.where(ball_ahead.imag > 0, 0.05, -0.05)
        off = np.angle(ball_ahead)
        stance = ball - ahead * (0.17 + 1j * foot)
        behind = ball - ahead * (0.17 + self.behind_m + 1j * foot)
        beside = ball - 1j * np.sign(off) * ahead * self.behind_m
        gap = stance * ahead.conj()
        in_line = (np.abs(np.angle(ahead)) < self.aim) & (np.abs(gap.imag) < 0.04) & (gap.real > -0.03)
        place = np.where(np.abs(off) > np.pi / 2, beside, behind)
        facing = np.where(np.abs(ball) < 0.6, np.angle(ahead), np.angle(place))
        # Far away it walks where it looks; near the ball it looks where it will kick, and steps to any side.
        choice = self._walk(place, facing, np.abs(ball) < 0.6)
        choice = np.where(in_line, self._walk(stance, np.angle(ahead), np.ones_like(in_line)), choice)
        choice = self._kick(ball, way, choice)
        return np.where(known, choice, self.action["turn_left"])

    def _walk(self, place: np.ndarray, facing: np.ndarray, sideways: np.ndarray) -> np.ndarray:
        """A walk to a place, and to face there: of those that step to any side the one along the greater part of the way."""
        turn = np.where(facing > 0, self.action["turn_left"], self.action["turn_right"])
        curve = np.where(facing > 0, self.action["forward_turn_left"], self.action["forward_turn_right"])
        on = np.where(np.abs(facing) > self.turn / 3, curve, self.action["forward"])
        straight = np.where(np.abs(facing) > self.turn, turn, on)
        along = np.where(place.real > 0, self.action["forward"], self.action["backward"])
        across = np.where(place.imag > 0, self.action["left"], self.action["right"])
        step = np.where(np.abs(place.real) > np.abs(place.imag), along, across)
        return np.where(sideways, np.where(np.abs(facing) > self.aim / 2, turn, step), straight)

    def _kick(self, ball: np.ndarray, way: np.ndarray, choice: np.ndarray) -> np.ndarray:
        """A kick where the ball lies right for one that goes into the goal: the best of them."""
        best = np.arctan2(self.goal_m, np.abs(way))
        for name, ((nearest, farthest), (right, left), foot) in KICKS.items():
            reached = (ball.real > nearest) & (ball.real < farthest) & (ball.imag > right) & (ball.imag < left)
            error = np.abs(np.angle((ball - foot) * way.conj()))
            better = reached & (error < best)
            choice, best = np.where(better, self.action[name], choice), np.where(better, error, best)
        return choice
