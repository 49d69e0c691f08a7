"""A hand-written behaviour: the robot walks to the ball, round it, and kicks it at the goal. ``tune.py`` optimises its parameters.

Needs only NumPy.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

# For each kick, robot frame, m: the least and greatest x and the least and greatest y of a ball that the foot reaches, and the position of
# the tip of the foot as x + 1j * y. The ball leaves in the direction from the tip to the ball.
KICKS = {
    "left_straight": ((0.10, 0.20), (0.00, 0.10), 0.10 + 0.05j),
    "right_straight": ((0.10, 0.20), (-0.10, 0.00), 0.10 - 0.05j),
    "left_side": ((0.10, 0.22), (-0.15, 0.00), 0.10 + 0.05j),
    "right_side": ((0.10, 0.22), (0.00, 0.15), 0.10 - 0.05j),
}


class Kicker:
    """Returns discrete actions for observations of beliefs, one row for each robot. Positions are complex numbers ``x + 1j * y``, robot
    frame, m.

    Args:
        names: The names of the observation's columns.
        actions: The names of the actions.
        behind_m: The distance behind its stance at the ball at which the robot aligns itself with ball and goal, m.
        aim_deg: The greatest angle between the robot's heading and the direction from ball to goal with which it walks up to the ball,
            degrees.
        turn_deg: The angle to its target from which the robot turns on the spot, degrees.
        goal_m: The greatest distance of a kick's target from the middle of the goal, m.
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
        """Does nothing: the behaviour has no memory. ``over`` is a mask of the rows whose episodes are over."""

    def _place(self, observations: np.ndarray, thing: str) -> np.ndarray:
        """Returns the believed position of ``thing``."""
        return observations[:, self.index[f"{thing}.x"]] + 1j * observations[:, self.index[f"{thing}.y"]]

    def __call__(self, observations: np.ndarray) -> np.ndarray:
        """Returns the index of the action of each robot."""
        ball, goal = self._place(observations, "ball"), self._place(observations, "goal")
        known = observations[:, self.index["ball.known"]] > 0.5
        way = goal - ball
        ahead = way / np.maximum(np.abs(way), 1e-6)
        ball_ahead = ball * ahead.conj()
        # The stance from which the robot kicks at the goal: one of its feet is behind the ball.
        foot = np.where(ball_ahead.imag > 0, 0.05, -0.05)
        off = np.angle(ball_ahead)
        stance = ball - ahead * (0.17 + 1j * foot)
        behind = ball - ahead * (0.17 + self.behind_m + 1j * foot)
        beside = ball - 1j * np.sign(off) * ahead * self.behind_m
        gap = stance * ahead.conj()
        in_line = (np.abs(np.angle(ahead)) < self.aim) & (np.abs(gap.imag) < 0.04) & (gap.real > -0.03)
        place = np.where(np.abs(off) > np.pi / 2, beside, behind)
        facing = np.where(np.abs(ball) < 0.6, np.angle(ahead), np.angle(place))
        # Far from the ball, the robot faces its target and walks forwards; near the ball, it faces the goal and walks in any direction.
        choice = self._walk(place, facing, np.abs(ball) < 0.6)
        choice = np.where(in_line, self._walk(stance, np.angle(ahead), np.ones_like(in_line)), choice)
        choice = self._kick(ball, way, choice)
        return np.where(known, choice, self.action["turn_left"])

    def _walk(self, place: np.ndarray, facing: np.ndarray, sideways: np.ndarray) -> np.ndarray:
        """Returns the walking action towards ``place`` and the direction ``facing``, rad.

        Where ``sideways`` is true, the robot turns on the spot to this direction, and then walks along the greater component of its way:
        forwards, backwards, or to a side. Elsewhere it turns on the spot if the angle is large, walks in a curve if it is smaller, or else
        walks straight on.
        """
        turn = np.where(facing > 0, self.action["turn_left"], self.action["turn_right"])
        curve = np.where(facing > 0, self.action["forward_turn_left"], self.action["forward_turn_right"])
        on = np.where(np.abs(facing) > self.turn / 3, curve, self.action["forward"])
        straight = np.where(np.abs(facing) > self.turn, turn, on)
        along = np.where(place.real > 0, self.action["forward"], self.action["backward"])
        across = np.where(place.imag > 0, self.action["left"], self.action["right"])
        step = np.where(np.abs(place.real) > np.abs(place.imag), along, across)
        return np.where(sideways, np.where(np.abs(facing) > self.aim / 2, turn, step), straight)

    def _kick(self, ball: np.ndarray, way: np.ndarray, choice: np.ndarray) -> np.ndarray:
        """Returns the most accurate kick that reaches the ball and goes into the goal, or else ``choice``."""
        best = np.arctan2(self.goal_m, np.abs(way))
        for name, ((nearest, farthest), (right, left), foot) in KICKS.items():
            reached = (ball.real > nearest) & (ball.real < farthest) & (ball.imag > right) & (ball.imag < left)
            error = np.abs(np.angle((ball - foot) * way.conj()))
            better = reached & (error < best)
            choice, best = np.where(better, self.action[name], choice), np.where(better, error, best)
        return choice
