"""A hand-written behaviour, which gives advice in training: a robot walks to the ball, round it until ball and goal are in line, and kicks.

This is a short version of the built-in team ``chasers``, with the actions ``velocities``. Needs only NumPy.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Kick:
    """A kick. Positions are complex numbers ``x + 1j * y``, robot frame, m.

    Attributes:
        x_m, y_m: The least and greatest coordinates of a ball that the foot reaches, m.
        foot: The position of the tip of the foot. The ball leaves in the direction from the tip to the ball.
        best: The best position of the ball.
        range_m: The distance that the ball rolls, m.
    """

    x_m: tuple[float, float]
    y_m: tuple[float, float]
    foot: complex
    best: complex
    range_m: float

    def reaches(self, ball: np.ndarray) -> np.ndarray:
        """Returns whether the foot reaches the ball, for each row."""
        return (
            (ball.real > self.x_m[0])
            & (ball.real < self.x_m[1])
            & (ball.imag > self.y_m[0])
            & (ball.imag < self.y_m[1])
        )


KICKS = {
    "left_straight": Kick((0.10, 0.20), (0.00, 0.10), 0.10 + 0.05j, 0.175 + 0.05j, 4.0),
    "right_straight": Kick((0.10, 0.20), (-0.10, 0.00), 0.10 - 0.05j, 0.175 - 0.05j, 4.0),
    "left_side": Kick((0.10, 0.22), (-0.15, 0.00), 0.10 + 0.05j, 0.17 - 0.07j, 2.0),
    "right_side": Kick((0.10, 0.22), (0.00, 0.15), 0.10 - 0.05j, 0.17 + 0.07j, 2.0),
}
# The greatest speed and turning speed, the duration of a step, and the fraction of the greatest speed of the slow choices.
SPEED_MPS, TURN_RADPS, STEP_S, SLOWLY = 0.2, np.pi / 2, 0.1, 0.3
# The five choices of `velocities` in each of the lists forward, left, and turn, as fractions of the greatest speed.
SHARES = np.array([0.0, 1.0, -1.0, SLOWLY, -SLOWLY])
# Half of the goal's width, and the aims: points on the goal line, as distances from the middle of the goal to the left, m.
HALF_GOAL_M, AIMS_M = 0.7, (0.0, 0.24, -0.24, 0.48, -0.48)
# The least distances to a ball that the robot walks round and to other robots, and half the width of a robot in the ball's path, m.
BALL_M, ROBOT_M, BLOCKED_M = 0.21, 0.36, 0.15
# The position of a supporting robot relative to the ball, m: the real part towards the opponents' goal, the imaginary part to the side.
SUPPORT = -0.8 + 0.7j
# The distance of a goalkeeper from the middle of its goal line, m.
KEEPER_M = 0.6
# The age from which the believed position of a robot is ignored, s.
OLD_S = 4.0


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Returns the scalar product of vectors that are complex numbers."""
    return (one * np.conj(other)).real


def cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """Returns the cross product of vectors that are complex numbers: positive where ``other`` is to the left of ``one``."""
    return (np.conj(one) * other).imag


def unit(numbers: np.ndarray) -> np.ndarray:
    """Returns complex numbers of length 1 with the same directions; 0 remains 0."""
    return numbers / np.maximum(np.abs(numbers), 1e-6)


@dataclass(frozen=True)
class Aim:
    """The target of a shot.

    Attributes:
        direction: The direction from the ball, a complex number of length 1.
        room_m: The least distance of the ball's path to a post or an opponent, minus a margin, m.
        far_m: The distance from the ball to the target, m.
    """

    direction: np.ndarray
    room_m: np.ndarray
    far_m: np.ndarray


class Adviser:
    """Returns the advised actions for observations of beliefs, one row for each robot. Positions are complex numbers ``x + 1j * y``, robot
    frame, m.

    Args:
        names: The names of the observation's columns.
    """

    def __init__(self, names: Sequence[str]):
        self.index = {name: index for index, name in enumerate(names)}
        self.others = [
            name[:-2] for name in names if name.startswith(("team_mate", "opponent")) and name.endswith(".x")
        ]
        self.mates = [name for name in self.others if name.startswith("team_mate")]
        ahead, aside = np.meshgrid(SHARES, SHARES, indexing="ij")
        ways = (ahead + 1j * aside).ravel()
        # The speed in any direction is at most the greatest speed ahead.
        self.ways = ways / np.maximum(np.abs(ways), 1)

    def __call__(self, seen: np.ndarray) -> np.ndarray:
        """Returns the index of the advised choice in each of the four lists of ``velocities``: shape (robots, 4)."""
        ball, goal = self._place(seen, "ball"), self._place(seen, "goal")
        # The direction from the own goal to the opponents' goal, a complex number of length 1.
        pitch = np.conj(self._place(seen, "own", "cos", "sin"))
        others = {
            name: (
                self._place(seen, name),
                (self._column(seen, f"{name}.known") > 0.5) & (self._column(seen, f"{name}.age") < OLD_S),
            )
            for name in self.others
        }
        opponents = [other for name, other in others.items() if name.startswith("opponent")]
        aim = self._aim(ball, goal, pitch, opponents)
        way, looks = self._way(seen, ball, goal, pitch, aim, others)
        searches = self._column(seen, "ball.known") < 0.5
        share = np.where(searches, 0, way) / (SPEED_MPS * STEP_S)
        share = share / np.maximum(np.abs(share), 1)
        pair = np.abs(share[:, None] - self.ways).argmin(axis=1)
        turn = np.where(searches, 0.4, np.angle(looks) / (TURN_RADPS * STEP_S))
        turn = np.abs(np.clip(turn, -1, 1)[:, None] - SHARES).argmin(axis=1)
        return np.stack([pair // 5, pair % 5, turn, self._kick(seen, ball, pitch, aim, opponents)], axis=1)

    def _column(self, seen: np.ndarray, name: str) -> np.ndarray:
        """Returns the column ``name`` of the observations."""
        return seen[:, self.index[name]]

    def _place(self, seen: np.ndarray, thing: str, x: str = "x", y: str = "y") -> np.ndarray:
        """Returns the position of ``thing``, or another pair of its columns, as complex numbers."""
        return self._column(seen, f"{thing}.{x}") + 1j * self._column(seen, f"{thing}.{y}")

    def _aim(self, ball: np.ndarray, goal: np.ndarray, pitch: np.ndarray, opponents: list) -> Aim:
        """Returns the aim with the most room. The middle of the goal is preferred to the others unless these have more than 2 cm more."""
        best = (np.zeros_like(goal), np.full(len(ball), -np.inf), np.ones(len(ball)))
        posts = [goal + 1j * y * pitch for y in (HALF_GOAL_M, -HALF_GOAL_M)]
        for y in AIMS_M:
            way = goal + 1j * y * pitch - ball
            far, direction = np.maximum(np.abs(way), 1e-3), unit(way)
            room = np.min([np.abs(cross(direction, post - ball)) - 0.08 for post in posts], axis=0)
            for place, known in opponents:
                along = dot(place - ball, direction)
                free = np.abs(cross(direction, place - ball)) - BLOCKED_M - 0.12 * along
                room = np.where(known & (along > 0) & (along < far + 0.2), np.minimum(room, free), room)
            room = np.minimum(room, 0.35)
            better = room > best[1] + (0.02 if y else 0)
            best = tuple(np.where(better, new, old) for new, old in zip((direction, room, far), best))
        return Aim(*best)

    def _way(
        self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, pitch: np.ndarray, aim: Aim, others: dict
    ) -> tuple[np.ndarray, np.ndarray]:
        """Returns the displacement to the robot's target and the direction to face there.

        The target is the stance for a kick, the supporting position, or the goalkeeper's position. Obstacles are walked round.
        """
        velocity = self._place(seen, "ball", "vx", "vy")
        # If the ball rolls, the stance is for its position one second later.
        place, facing = self._stand(ball + np.where(np.abs(velocity) > 0.15, velocity, 0), aim, others)
        offset = -place * np.conj(facing)
        behind = -offset.real
        is_in_line = (behind > -0.02) & (behind < 0.3) & (np.abs(offset.imag) < 0.02 + 0.3 * np.clip(behind, 0, 0.3))
        is_last = is_in_line & (facing.real > 0.96)
        goes = np.where(is_last, place, place - facing * 0.09)
        looks = np.where(is_last | (np.abs(ball) < 0.7), facing, unit(ball))
        side = np.where(self._column(seen, "own.y") > 0, 1, -1)
        supports = self._is_supporter(seen, ball, goal, others)
        goes = np.where(supports, ball + pitch * (SUPPORT.real + 1j * SUPPORT.imag * side), goes)
        keeps = self._is_keeper(seen, ball, goal, others)
        own_goal = self._place(seen, "own_goal")
        goes = np.where(keeps, own_goal + KEEPER_M * unit(ball - own_goal), goes)
        supports |= keeps
        obstacles = [(*other, ROBOT_M) for other in others.values()]
        return around(goes, [*obstacles, (ball, ~is_last, BALL_M)]), np.where(supports, unit(ball), looks)

    def _stand(self, ball: np.ndarray, aim: Aim, others: dict) -> tuple[np.ndarray, np.ndarray]:
        """Returns where to stand and the direction to face for the kick that the robot can make soonest."""
        least, place, facing = np.full(len(ball), np.inf), np.zeros_like(ball), np.ones_like(ball)
        for name, kick in KICKS.items():
            faces = aim.direction * np.conj(unit(np.array(kick.best - kick.foot)))
            stands = ball - faces * kick.best
            turn_s = np.abs(faces - 1) / 1.4
            passes = (dot(stands, ball) > 0) & (np.abs(stands) > np.abs(ball))
            beside = np.abs(cross(unit(stands), ball))
            time_s = np.maximum(np.abs(stands) / SPEED_MPS, turn_s) + 0.4 * turn_s
            time_s = time_s + np.where(passes, 0.8 * np.maximum(0.25 - beside, 0) / SPEED_MPS, 0)
            if name.endswith("side"):
                # Kicks to the side are weaker.
                time_s = time_s + 0.6 + np.where(aim.far_m > 0.7 * kick.range_m, 5.0, 0)
            for other, known in others.values():
                time_s = time_s + np.where(known & (np.abs(other - stands) < 0.29), 2.5, 0)
            is_sooner = time_s < least
            least = np.where(is_sooner, time_s, least)
            place, facing = np.where(is_sooner, stands, place), np.where(is_sooner, faces, facing)
        return place, facing

    def _is_team_mate_sooner(self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, others: dict) -> np.ndarray:
        """Returns whether a team-mate has a shorter way to a position behind the ball."""
        aim = unit(goal - ball)

        def way_m(place: np.ndarray) -> np.ndarray:
            """Returns the distance from ``place`` to the ball, m, plus up to 0.8 m if ``place`` is not behind the ball."""
            return np.abs(ball - place) + 0.4 * (1 - dot(unit(ball - place), aim))

        own_m, sooner = way_m(np.zeros_like(ball)), np.zeros(len(ball), bool)
        for name in self.mates:
            mate, known = others[name]
            sooner |= known & (self._column(seen, f"{name}.age") < 1) & (way_m(mate) < own_m)
        return sooner

    def _is_supporter(self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, others: dict) -> np.ndarray:
        """Returns whether a team-mate is sooner behind the ball while this robot is so near to the ball that it would be in the way."""
        return self._is_team_mate_sooner(seen, ball, goal, others) & (
            np.abs(ball) < (1.2 if len(self.mates) < 2 else 2.5)
        )

    def _is_keeper(self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, others: dict) -> np.ndarray:
        """Returns whether the robot is the goalkeeper: in a team of three or more, the robot nearest to the own goal, if a team-mate is
        sooner behind the ball."""
        keeps = self._is_team_mate_sooner(seen, ball, goal, others) & (len(self.mates) > 1)
        own_goal = self._place(seen, "own_goal")
        for name in self.mates:
            mate, known = others[name]
            keeps &= ~known | (np.abs(own_goal - mate) > np.abs(own_goal))
        return keeps

    def _kick(self, seen: np.ndarray, ball: np.ndarray, pitch: np.ndarray, aim: Aim, opponents: list) -> np.ndarray:
        """Returns the index of the kick to make now; 0 for none."""
        pressure_m = np.full(len(ball), np.inf)
        for place, known in opponents:
            pressure_m = np.where(known, np.minimum(pressure_m, np.abs(place - ball)), pressure_m)
        is_pressed = pressure_m < 0.5
        tolerance = np.clip(0.8 * np.maximum(aim.room_m, 0.05) / aim.far_m, 0.03, 0.3) * np.where(is_pressed, 2.5, 1)
        is_fresh = (self._column(seen, "ball.known") > 0.5) & (self._column(seen, "ball.age") < 0.4)
        choice, best = np.zeros(len(ball), int), np.full(len(ball), np.inf)
        for number, kick in enumerate(KICKS.values(), start=1):
            reached, leaves = kick.reaches(ball) & is_fresh, unit(ball - kick.foot)
            error = np.abs(cross(aim.direction, leaves))
            good = (
                reached
                & (dot(leaves, aim.direction) > 0.3)
                & (error < tolerance)
                & (kick.range_m > 1.1 * np.minimum(aim.far_m, 3.6))
            )
            # If an opponent is near the ball and no kick is accurate, any kick forwards that no opponent blocks will do.
            free = reached & is_pressed & (dot(leaves, pitch) > 0.3)
            for place, known in opponents:
                is_before = known & (np.abs(place - ball) < 0.8) & (dot(leaves, place - ball) > 0)
                free &= ~(is_before & (np.abs(cross(leaves, place - ball)) < BLOCKED_M))
            error = np.where(good, error, np.where(free, 10 - dot(leaves, pitch), np.inf))
            better = error < best
            choice, best = np.where(better, number, choice), np.where(better, error, best)
        return choice


def around(to: np.ndarray, obstacles: list[tuple[np.ndarray, np.ndarray, float]]) -> np.ndarray:
    """Returns the displacement to walk on the way to ``to``: along the tangent of the nearest obstacle in the way, or else ``to`` itself.

    Args:
        to: The target, robot frame, m.
        obstacles: Circles: centre, whether the obstacle counts (for each row), and radius, m.
    """
    distance, direction = np.abs(to), unit(to)
    nearest, way = np.full(len(to), np.inf), to
    for centre, counts, radius_m in obstacles:
        radius = np.minimum(radius_m, 0.9 * np.abs(centre - to))
        far, along = np.abs(centre), dot(direction, centre)
        blocks = counts & (far < 1.5) & (far < nearest) & (np.abs(cross(direction, centre)) < radius)
        blocks &= (along > 0) & (along - radius < distance)
        side = np.where(cross(to, centre) > 0, -1, 1)
        wide = radius * 1.02
        length = np.sqrt(np.maximum(far**2 - wide**2, 0))
        outside = (length + 1j * side * wide) / np.maximum(far, 1e-3) ** 2 * centre * length
        depth = (radius - far) / np.maximum(radius, 1e-3)
        # From inside a circle, the robot walks sideways and outwards.
        inside = unit(-unit(centre) * np.minimum(2 * depth, 1) + side * 1j * unit(centre)) * wide
        way = np.where(blocks, np.where(far > wide, outside, inside), way)
        nearest = np.where(blocks, far, nearest)
    return way
