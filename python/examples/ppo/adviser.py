"""A behaviour by hand, whose advice a team is told: to the ball, round it, in line with the goal, and a kick. NumPy alone.

It is what the built-in ``chasers`` do, in short, as choices of the actions ``velocities``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Kick:
    """A kick. Places are complex numbers, robot frame, m.

    Attributes:
        x_m, y_m: Where the ball must lie: least and greatest.
        foot: The tip of the foot, from which the ball leaves.
        best: Where the ball lies best.
        range_m: How far it rolls.
    """

    x_m: tuple[float, float]
    y_m: tuple[float, float]
    foot: complex
    best: complex
    range_m: float

    def reaches(self, ball: np.ndarray) -> np.ndarray:
        """Whether the ball lies right for it."""
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
SPEED_MPS, TURN_RADPS, STEP_S, SLOWLY = 0.2, np.pi / 2, 0.1, 0.3
# The choices of `velocities`, as shares of the greatest speed.
SHARES = np.array([0.0, 1.0, -1.0, SLOWLY, -SLOWLY])
# Half of the goal's width, and how far to the side of its middle the ball may be aimed, m.
HALF_GOAL_M, AIMS_M = 0.7, (0.0, 0.24, -0.24, 0.48, -0.48)
# So near nobody comes to the ball that is passed, and to other robots, and so far to either side these block the ball's way, m.
BALL_M, ROBOT_M, BLOCKED_M = 0.21, 0.36, 0.15
# Who is not the nearest stays here as seen from the ball, ahead being towards the opponents' goal, m.
SUPPORT = -0.8 + 0.7j
# So far before the middle of the goal a keeper stands, m.
KEEPER_M = 0.6
# What was seen longer ago may be anywhere, s.
OLD_S = 4.0


def dot(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The scalar product."""
    return (one * np.conj(other)).real


def cross(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """The area between two: positive where the other is to the left."""
    return (np.conj(one) * other).imag


def unit(numbers: np.ndarray) -> np.ndarray:
    """Complex numbers of length 1 in the same directions."""
    return numbers / np.maximum(np.abs(numbers), 1e-6)


@dataclass(frozen=True)
class Aim:
    """Where the ball shall go: the direction, how much room there is to posts and opponents, m, and how far it is, m."""

    direction: np.ndarray
    room_m: np.ndarray
    far_m: np.ndarray


class Adviser:
    """Decides for robots from their beliefs, row by row. Places are complex numbers, robot frame, m.

    Args:
        names: The names of the numbers of an observation.
    """

    def __init__(self, names: Sequence[str]):
        self.index = {name: index for index, name in enumerate(names)}
        self.others = [
            name[:-2] for name in names if name.startswith(("team_mate", "opponent")) and name.endswith(".x")
        ]
        self.mates = [name for name in self.others if name.startswith("team_mate")]
        ahead, aside = np.meshgrid(SHARES, SHARES, indexing="ij")
        ways = (ahead + 1j * aside).ravel()
        # Nobody is faster than at full speed ahead.
        self.ways = ways / np.maximum(np.abs(ways), 1)

    def __call__(self, seen: np.ndarray) -> np.ndarray:
        """The four choices of each robot."""
        ball, goal = self._place(seen, "ball"), self._place(seen, "goal")
        # The direction of the opponents' goal line's middle from the own one's.
        pitch = np.conj(self._place(seen, "own", "cos", "sin"))
        others = {
            name: (
                self._place(seen, name),
                (self._of(seen, f"{name}.known") > 0.5) & (self._of(seen, f"{name}.age") < OLD_S),
            )
            for name in self.others
        }
        opponents = [other for name, other in others.items() if name.startswith("opponent")]
        aim = self._aim(ball, goal, pitch, opponents)
        way, looks = self._way(seen, ball, goal, pitch, aim, others)
        searches = self._of(seen, "ball.known") < 0.5
        share = np.where(searches, 0, way) / (SPEED_MPS * STEP_S)
        share = share / np.maximum(np.abs(share), 1)
        pair = np.abs(share[:, None] - self.ways).argmin(axis=1)
        turn = np.where(searches, 0.4, np.angle(looks) / (TURN_RADPS * STEP_S))
        turn = np.abs(np.clip(turn, -1, 1)[:, None] - SHARES).argmin(axis=1)
        return np.stack([pair // 5, pair % 5, turn, self._kick(seen, ball, pitch, aim, opponents)], axis=1)

    def _of(self, seen: np.ndarray, name: str) -> np.ndarray:
        return seen[:, self.index[name]]

    def _place(self, seen: np.ndarray, thing: str, x: str = "x", y: str = "y") -> np.ndarray:
        return self._of(seen, f"{thing}.{x}") + 1j * self._of(seen, f"{thing}.{y}")

    def _aim(self, ball: np.ndarray, goal: np.ndarray, pitch: np.ndarray, opponents: list) -> Aim:
        """To where in the goal there is most room."""
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
        """The way to go, m, and where to face: to where the ball can be kicked, or for who is not the nearest behind it."""
        velocity = self._place(seen, "ball", "vx", "vy")
        # A ball that rolls is met where it will be in a second.
        place, facing = self._stand(ball + np.where(np.abs(velocity) > 0.15, velocity, 0), aim, others)
        offset = -place * np.conj(facing)
        behind = -offset.real
        is_in_line = (behind > -0.02) & (behind < 0.3) & (np.abs(offset.imag) < 0.02 + 0.3 * np.clip(behind, 0, 0.3))
        is_last = is_in_line & (facing.real > 0.96)
        goes = np.where(is_last, place, place - facing * 0.09)
        looks = np.where(is_last | (np.abs(ball) < 0.7), facing, unit(ball))
        side = np.where(self._of(seen, "own.y") > 0, 1, -1)
        supports = self._supports(seen, ball, goal, others)
        goes = np.where(supports, ball + pitch * (SUPPORT.real + 1j * SUPPORT.imag * side), goes)
        keeps = self._keeps(seen, ball, goal, others)
        own_goal = self._place(seen, "own_goal")
        goes = np.where(keeps, own_goal + KEEPER_M * unit(ball - own_goal), goes)
        supports |= keeps
        obstacles = [(*other, ROBOT_M) for other in others.values()]
        return around(goes, [*obstacles, (ball, ~is_last, BALL_M)]), np.where(supports, unit(ball), looks)

    def _stand(self, ball: np.ndarray, aim: Aim, others: dict) -> tuple[np.ndarray, np.ndarray]:
        """Where to stand, and to face, for the kick that can be made soonest."""
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
                # It is the weaker.
                time_s = time_s + 0.6 + np.where(aim.far_m > 0.7 * kick.range_m, 5.0, 0)
            for other, known in others.values():
                time_s = time_s + np.where(known & (np.abs(other - stands) < 0.29), 2.5, 0)
            is_sooner = time_s < least
            least = np.where(is_sooner, time_s, least)
            place, facing = np.where(is_sooner, stands, place), np.where(is_sooner, faces, facing)
        return place, facing

    def _sooner(self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, others: dict) -> np.ndarray:
        """Whether a team-mate is sooner behind the ball."""
        aim = unit(goal - ball)

        def way_m(place: np.ndarray) -> np.ndarray:
            return np.abs(ball - place) + 0.4 * (1 - dot(unit(ball - place), aim))

        own_m, sooner = way_m(np.zeros_like(ball)), np.zeros(len(ball), bool)
        for name in self.mates:
            mate, known = others[name]
            sooner |= known & (self._of(seen, f"{name}.age") < 1) & (way_m(mate) < own_m)
        return sooner

    def _supports(self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, others: dict) -> np.ndarray:
        """Whether a team-mate is sooner behind the ball, and the robot so near that it would be in the way."""
        return self._sooner(seen, ball, goal, others) & (np.abs(ball) < (1.2 if len(self.mates) < 2 else 2.5))

    def _keeps(self, seen: np.ndarray, ball: np.ndarray, goal: np.ndarray, others: dict) -> np.ndarray:
        """Whether the robot is the keeper: of three or more the nearest to the own goal, unless it is the nearest to the ball."""
        keeps = self._sooner(seen, ball, goal, others) & (len(self.mates) > 1)
        own_goal = self._place(seen, "own_goal")
        for name in self.mates:
            mate, known = others[name]
            keeps &= ~known | (np.abs(own_goal - mate) > np.abs(own_goal))
        return keeps

    def _kick(self, seen: np.ndarray, ball: np.ndarray, pitch: np.ndarray, aim: Aim, opponents: list) -> np.ndarray:
        """The kick to make now: 0 for none."""
        pressure_m = np.full(len(ball), np.inf)
        for place, known in opponents:
            pressure_m = np.where(known, np.minimum(pressure_m, np.abs(place - ball)), pressure_m)
        is_pressed = pressure_m < 0.5
        tolerance = np.clip(0.8 * np.maximum(aim.room_m, 0.05) / aim.far_m, 0.03, 0.3) * np.where(is_pressed, 2.5, 1)
        is_fresh = (self._of(seen, "ball.known") > 0.5) & (self._of(seen, "ball.age") < 0.4)
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
            # For want of a better one under pressure: ahead, past who stands before it.
            free = reached & is_pressed & (dot(leaves, pitch) > 0.3)
            for place, known in opponents:
                is_before = known & (np.abs(place - ball) < 0.8) & (dot(leaves, place - ball) > 0)
                free &= ~(is_before & (np.abs(cross(leaves, place - ball)) < BLOCKED_M))
            error = np.where(good, error, np.where(free, 10 - dot(leaves, pitch), np.inf))
            better = error < best
            choice, best = np.where(better, number, choice), np.where(better, error, best)
        return choice


def around(to: np.ndarray, obstacles: list[tuple[np.ndarray, np.ndarray, float]]) -> np.ndarray:
    """The way to a place past what is in the way, circles of these middles and radii where they count: along the tangent of the nearest."""
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
        # Who is inside leaves it sideways, outwards.
        inside = unit(-unit(centre) * np.minimum(2 * depth, 1) + side * 1j * unit(centre)) * wide
        way = np.where(blocks, np.where(far > wide, outside, inside), way)
        nearest = np.where(blocks, far, nearest)
    return way
