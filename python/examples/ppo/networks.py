"""The networks of ``striker.py`` and ``team.py``: features computed from an observation of beliefs, and layers. The actor, features
included, is exported as ONNX."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import torch
from adviser import AIMS_M, BLOCKED_M, HALF_GOAL_M, KICKS
from torch import nn

# The number of units in each of the two hidden layers.
HIDDEN = 256
# The factor of features in which centimetres matter, such as the position relative to a kick's stance.
FINE = 5.0
# The slope, 1/m, of the softmax that selects the aim with the most room, and of the sigmoid that says whether an opponent is near.
AIMING = 100.0


class Geometry(nn.Module):
    """Appends geometric features to an observation of beliefs: the best direction for a shot, the stance (where to stand and face) for each
    kick, and for each other robot its distances to the ball and to the own goal, compared with this robot's, and its position relative to
    the shot.

    Positions are in the robot frame, m. ``forward`` takes and returns one row for each robot.

    Args:
        names: The names of the observation's columns.
    """

    def __init__(self, names: Sequence[str]):
        super().__init__()
        groups = list(dict.fromkeys(name.split(".")[0] for name in names))
        others = [group for group in groups if group.startswith(("team_mate", "opponent"))]
        columns = {"ball": ["ball"], "goal": ["goal"], "own_goal": ["own_goal"], "others": others}
        for thing, of in columns.items():
            for axis in "xy":
                indices = [list(names).index(f"{group}.{axis}") for group in of]
                self.register_buffer(f"{thing}_{axis}", torch.tensor(indices, dtype=torch.long))
        known = [list(names).index(f"{group}.known") for group in others]
        self.register_buffer("known", torch.tensor(known, dtype=torch.long))
        self.mates = sum(group.startswith("team_mate") for group in others)
        for name in ("cos", "sin"):
            self.register_buffer(name, torch.tensor([list(names).index(f"own.{name}")], dtype=torch.long))
        self.register_buffer("aims", torch.tensor([AIMS_M], dtype=torch.float32))
        # The middle of the goal counts as if it had 2 cm more room.
        self.register_buffer("prefers", torch.tensor([[0.02 * (aim == 0) for aim in AIMS_M]], dtype=torch.float32))
        best = np.array([kick.best for kick in KICKS.values()])
        # The robot's heading, as a unit vector, for which each kick sends the ball along the x axis.
        heading = np.conj(best - np.array([kick.foot for kick in KICKS.values()]))
        heading /= np.abs(heading)
        foot = np.array([kick.foot for kick in KICKS.values()])
        least, most = (np.array([kick.x_m[end] + 1j * kick.y_m[end] for kick in KICKS.values()]) for end in (0, 1))
        reach = {"middle": (least + most) / 2, "half": (most - least) / 2}
        for name, places in {"best": best, "heading": heading, "foot": foot, **reach}.items():
            self.register_buffer(f"{name}_x", torch.tensor(places.real[None], dtype=torch.float32))
            self.register_buffer(f"{name}_y", torch.tensor(places.imag[None], dtype=torch.float32))

    def _place(self, seen: torch.Tensor, thing: str) -> tuple[torch.Tensor, torch.Tensor]:
        """Returns the x and y coordinates of ``thing``, each with the shape (rows, objects)."""
        x, y = getattr(self, f"{thing}_x"), getattr(self, f"{thing}_y")
        return torch.index_select(seen, 1, x), torch.index_select(seen, 1, y)

    def forward(self, seen: torch.Tensor) -> torch.Tensor:
        (ball_x, ball_y), (goal_x, goal_y) = self._place(seen, "ball"), self._place(seen, "goal")
        (own_x, own_y), (other_x, other_y) = self._place(seen, "own_goal"), self._place(seen, "others")
        known = torch.index_select(seen, 1, self.known)
        from_ball_x, from_ball_y = other_x - ball_x, other_y - ball_y
        others_ball = length(from_ball_x, from_ball_y)
        # The directions from the ball to the aims on the goal line, and the room of each: the least distance of the ball's path to a post
        # or an opponent, minus a margin, at most 0.35 m.
        cos, sin = torch.index_select(seen, 1, self.cos), torch.index_select(seen, 1, self.sin)
        aim_x = goal_x + sin * self.aims - ball_x
        aim_y = goal_y + cos * self.aims - ball_y
        fars = length(aim_x, aim_y)
        aim_x, aim_y = aim_x / fars, aim_y / fars
        room = 0.35 + 0 * fars
        for post in (HALF_GOAL_M, -HALF_GOAL_M):
            post_x, post_y = goal_x + sin * post - ball_x, goal_y + cos * post - ball_y
            room = torch.minimum(room, torch.abs(aim_x * post_y - aim_y * post_x) - 0.08)
        opponents = range(self.mates, known.shape[1])
        for other in opponents:
            x, y = from_ball_x[:, other : other + 1], from_ball_y[:, other : other + 1]
            along_aim = aim_x * x + aim_y * y
            free = torch.abs(aim_x * y - aim_y * x) - BLOCKED_M - 0.12 * along_aim
            # The added term makes the free distance large, so that opponents behind the ball or the goal and unknown ones do not count.
            free = free + 10 * (
                torch.relu(-along_aim) + torch.relu(along_aim - fars - 0.2) + 1 - known[:, other : other + 1]
            )
            room = torch.minimum(room, free)
        weights = torch.softmax(AIMING * (room + self.prefers), dim=1)
        way_x, way_y = (weights * aim_x).sum(1, keepdim=True), (weights * aim_y).sum(1, keepdim=True)
        way = length(way_x, way_y)
        way_x, way_y = way_x / way, way_y / way
        room, to_goal = (weights * room).sum(1, keepdim=True), (weights * fars).sum(1, keepdim=True)
        # The stance for each kick: where to stand, and in which direction to face.
        face_x = way_x * self.heading_x - way_y * self.heading_y
        face_y = way_x * self.heading_y + way_y * self.heading_x
        stand_x = ball_x - face_x * self.best_x + face_y * self.best_y
        stand_y = ball_y - face_x * self.best_y - face_y * self.best_x
        # How far the robot is behind and beside this stance. Then, for each kick from the present position: how far the ball is inside the
        # area that the kick reaches (negative outside), and the sine and cosine of the angle between the ball's direction and the aim.
        behind, aside = stand_x * face_x + stand_y * face_y, stand_y * face_x - stand_x * face_y
        inside_x = self.half_x - torch.abs(ball_x - self.middle_x)
        inside_y = self.half_y - torch.abs(ball_y - self.middle_y)
        leaves_x, leaves_y = ball_x - self.foot_x, ball_y - self.foot_y
        leaves = length(leaves_x, leaves_y)
        error = (way_x * leaves_y - way_y * leaves_x) / leaves
        straight = (way_x * leaves_x + way_y * leaves_y) / leaves
        pressure = 1 + 0 * to_goal
        for other in opponents:
            distance = others_ball[:, other : other + 1] + 10 * (1 - known[:, other : other + 1])
            pressure = torch.minimum(pressure, distance)
        pressed = torch.sigmoid(AIMING * (0.5 - pressure))
        tolerance = torch.clamp(0.8 * torch.clamp(room, min=0.05) / to_goal, 0.03, 0.3) * (1 + 1.5 * pressed)
        exact = tolerance - torch.abs(error)
        reach = torch.minimum(inside_x, inside_y)
        near = [
            FINE * number
            for number in (behind, aside, inside_x, inside_y, error, exact, reach, torch.minimum(reach, exact))
        ]
        near += [room, pressed]
        to_ball, own_goal = length(ball_x, ball_y), length(own_x, own_y)
        ball_home = length(ball_x - own_x, ball_y - own_y)
        # The other robots, relative to the ball, to the shot and to the own goal.
        others_home = length(other_x - own_x, other_y - own_y)
        along, beside = way_x * from_ball_x + way_y * from_ball_y, way_x * from_ball_y - way_y * from_ball_x
        of_others = [to_ball - others_ball, others_ball, along, beside, own_goal - others_home]
        of_ball = [way_x, way_y, to_goal, to_ball, ball_x / to_ball, ball_y / to_ball, own_goal, ball_home]
        home = [(ball_x - own_x) / ball_home, (ball_y - own_y) / ball_home]
        kicks = [face_x, face_y, stand_x, stand_y, length(stand_x, stand_y), straight, *near]
        return torch.cat([seen, *of_ball, *home, *kicks, *(number * known for number in of_others)], dim=-1)


def length(x: torch.Tensor, y: torch.Tensor) -> torch.Tensor:
    """Returns the lengths of vectors; the least is 0.001, so that they can be divided by."""
    return torch.sqrt(x * x + y * y + 1e-6)


class Spread(nn.Module):
    """Maps each feature to two: linear and clipped, to resolve large values, and logarithmically compressed, to resolve small ones."""

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        size = features.abs()
        near = features * torch.log(1 + 20 * size) / (3 * size + 1e-6)
        return torch.cat([torch.clamp(features / 3, -3, 3), near], dim=-1)


class Sharper(nn.Module):
    """Multiplies logits by a constant. A factor above 1 makes a policy less random.

    Args:
        by: The factor.
    """

    def __init__(self, by: float):
        super().__init__()
        self.by = by

    def forward(self, scores: torch.Tensor) -> torch.Tensor:
        return self.by * scores


class Critic(nn.Module):
    """The critic: returns the value of each row, which has a robot's observation and then the true state (privileged state).

    Args:
        names: The names of the observation's columns.
        truths: The number of columns of the true state.
    """

    def __init__(self, names: Sequence[str], truths: int):
        super().__init__()
        self.geometry, self.numbers = Geometry(names), len(names)
        count = self.geometry(torch.zeros(1, len(names))).shape[1] + truths
        self.layers = layers(count, 1, 1.0)

    def forward(self, known: torch.Tensor) -> torch.Tensor:
        features = torch.cat([self.geometry(known[:, : self.numbers]), known[:, self.numbers :]], dim=1)
        return self.layers(features).squeeze(-1)


def actor(names: Sequence[str], scores: int) -> nn.Sequential:
    """Returns the actor: a network from observations to the logits of all choices, ``scores`` in number."""
    geometry = Geometry(names)
    return nn.Sequential(geometry, layers(geometry(torch.zeros(1, len(names))).shape[1], scores, 0.01))


def layers(numbers: int, answers: int, gain: float) -> nn.Sequential:
    """Returns a network with two hidden layers of ``HIDDEN`` units and orthogonal initial weights.

    Args:
        numbers: The number of features before :class:`Spread`, which doubles it.
        answers: The number of outputs.
        gain: The gain of the output layer's initial weights: a small one makes the initial outputs small.
    """
    linear = [nn.Linear(2 * numbers, HIDDEN), nn.Linear(HIDDEN, HIDDEN), nn.Linear(HIDDEN, answers)]
    for layer in linear:
        nn.init.orthogonal_(layer.weight, gain if layer is linear[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(Spread(), linear[0], nn.Tanh(), linear[1], nn.Tanh(), linear[2])
