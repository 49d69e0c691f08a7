"""Proximal policy optimisation for the robots of both teams, with PyTorch: what ``self_play.py`` learns with.

The algorithm is that of Schulman and others (2017), with generalised advantages. What robots decide is learned from their beliefs alone;
who reckons what situations are worth is needed for learning only, and knows the truth as well.
"""

from __future__ import annotations

import copy
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from team_policy import LEANING, Senses, spread
from torch import nn

NOTES = ("known", "action", "likelihood", "reward", "worth", "end")


@dataclass(frozen=True)
class Settings:
    """How something is learned.

    Attributes:
        steps: Steps of each world between two updates.
        epochs: How often an update goes through them.
        rows: How many of them it learns from at once.
        rate: How fast it learns at first.
        entropy: How much it is worth at first to decide by chance.
        discount: What a reward is worth a step later.
        trace: How far rewards are told back to decisions: the lambda of generalised advantages.
        clip: How much likelier or less likely an update may make a decision.
        hidden: Units of each of the two hidden layers.
        first: For so many updates it learns only what situations are worth.
    """

    steps: int = 128
    epochs: int = 3
    rows: int = 2048
    rate: float = 5e-4
    entropy: float = 0.001
    discount: float = 0.995
    trace: float = 0.95
    clip: float = 0.2
    hidden: int = 128
    first: int = 8


def network(numbers: int, answers: int, gain: float, hidden: int) -> nn.Sequential:
    """Two hidden layers. What comes out is small at first, by its gain."""
    layers = [nn.Linear(numbers, hidden), nn.Tanh(), nn.Linear(hidden, hidden), nn.Tanh(), nn.Linear(hidden, answers)]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


class Truth:
    """The state of worlds as each of their robots sees it: in its team's frame, itself first, then its team-mates, then the others.

    Args:
        names: The names of the numbers of a state, which are in the frame of blue's team.
        agents: The robots of each world.
    """

    def __init__(self, names: list[str], agents: list[str]):
        turned = [name.split(".")[1] in ("x", "y", "vx", "vy", "cos", "sin", "lead") for name in names]
        robots = [name.split(".")[0] for name in names]

        def order(agent: str) -> list[int]:
            """What is of no robot first, as it is."""
            rank = {robot: 1 + (robot != agent) + (robot[:4] != agent[:4]) for robot in agents}
            return sorted(range(len(names)), key=lambda index: rank.get(robots[index], 0))

        self.order = np.array([order(agent) for agent in agents])
        self.sign = np.where(
            np.array(turned)[self.order] & np.array([[agent.startswith("pink")] for agent in agents]), -1.0, 1.0
        )

    def __call__(self, state: np.ndarray) -> torch.Tensor:
        """What is true, a row for each robot."""
        return torch.from_numpy(spread((state[:, self.order] * self.sign).reshape(-1, state.shape[1])))


class Choices:
    """Several choices, each by chance.

    Args:
        logits: How likely each is, row by row.
        sizes: How many there are to choose from, choice by choice.
    """

    def __init__(self, logits: torch.Tensor, sizes: list[int]):
        self.logs = [part.log_softmax(1) for part in logits.split(sizes, 1)]

    def draw(self) -> torch.Tensor:
        """A choice of each, row by row."""
        return torch.stack([(logs - torch.empty_like(logs).exponential_().log()).argmax(1) for logs in self.logs], 1)

    def likelihood(self, chosen: torch.Tensor) -> torch.Tensor:
        """How likely all that was chosen is, as a logarithm."""
        return sum(logs.gather(1, chosen[:, index : index + 1]).squeeze(1) for index, logs in enumerate(self.logs))

    def entropy(self) -> torch.Tensor:
        """How much is left to chance, on average."""
        return -sum((logs.exp() * logs).sum(1).mean() for logs in self.logs)


class TeamLearner:
    """A network that decides for robots, and one that says what is to be expected: both learn from what comes of decisions in many worlds.

    Args:
        envs: The worlds, in which the robots of both teams are controlled, and whose episodes begin in the mode ``same_step``.
        seed: The seed of their episodes, and of the draw of opponents.
        mirrored: In so many of them the policy plays both teams, and learns from both; in the others an earlier one plays pink.
        settings: How it learns.
    """

    def __init__(self, envs: Any, seed: int, mirrored: int, settings: Settings):
        self.envs, self.settings, self.updates = envs, settings, 0
        self.sizes = [int(size) for size in envs.single_action_space.nvec]
        self.senses, self.truth = Senses(envs.observation_names), Truth(envs.state_names, envs.agents)
        self.choice = network(self.senses.numbers, sum(self.sizes), 0.01, settings.hidden)
        self.worth = network(self.senses.numbers + 2 * len(envs.state_names), 1, 1.0, settings.hidden)
        self.parameters = [*self.choice.parameters(), *self.worth.parameters()]
        self.optimiser = torch.optim.Adam(self.parameters, settings.rate, eps=1e-5)
        world, pink = np.divmod(np.arange(envs.num_envs), len(envs.agents))
        is_other = (world >= mirrored) & np.array([agent.startswith("pink") for agent in envs.agents])[pink]
        self.learns = np.flatnonzero(~is_other)
        # Two earlier policies at a time: more would be many small batches.
        self.others = np.array_split(np.flatnonzero(is_other), 2)
        self.leaning = torch.from_numpy(LEANING)
        self.samples = settings.steps * len(self.learns)
        self.pool: list[nn.Module] = []
        self.random = np.random.default_rng(seed)
        observations, _ = envs.reset(seed=seed)
        self._perceive(observations)

    def _perceive(self, observations: np.ndarray) -> None:
        """Takes in what robots observe, and beside it what is true."""
        self.signal = torch.from_numpy(self.senses(observations))
        self.known = torch.cat([self.signal, self.truth(self.envs.state())], 1)

    def _logits(self, policy: nn.Module, signal: torch.Tensor) -> torch.Tensor:
        """How likely a policy thinks each choice."""
        return policy(signal) + signal[:, -len(LEANING) :] * self.leaning

    def _expected(self) -> torch.Tensor:
        """What is to be expected now, for the robots that learn."""
        return self.worth(self.known[self.learns]).squeeze(1)

    def remember(self, most: int) -> None:
        """Adds the policy as it is to the pool of opponents, and keeps the latest ones."""
        self.pool = [*self.pool, copy.deepcopy(self.choice)][-most:]

    @torch.no_grad()
    def play(self) -> list[bool]:
        """Plays so many steps, and notes what came of them. Whether the episodes that ended were decided."""
        opponents = [self.pool[self.random.integers(len(self.pool))] for _ in self.others]
        notes: dict[str, list[torch.Tensor]] = {name: [] for name in NOTES}
        decided: list[bool] = []
        for _ in range(self.settings.steps):
            logits = self._logits(self.choice, self.signal)
            for policy, rows in zip(opponents, self.others):
                logits[rows] = self._logits(policy, self.signal[rows])
            choices = Choices(logits, self.sizes)
            action = choices.draw()
            notes["known"].append(self.known[self.learns])
            notes["worth"].append(self._expected())
            notes["action"].append(action[self.learns])
            notes["likelihood"].append(choices.likelihood(action)[self.learns])
            observations, rewards, terminated, truncated, _ = self.envs.step(action.numpy())
            over = terminated | truncated
            decided += terminated[over].tolist()
            notes["reward"].append(torch.from_numpy(rewards[self.learns]))
            notes["end"].append(torch.from_numpy(over[self.learns]).float())
            self._perceive(observations)
        notes["worth"].append(self._expected())
        self.batch = {name: torch.stack(parts) for name, parts in notes.items()}
        return decided

    def _advantages(self) -> torch.Tensor:
        """How much better what was decided has turned out than was to be expected."""
        batch, settings = self.batch, self.settings
        advantages, advantage = torch.empty_like(batch["reward"]), torch.zeros(len(self.learns))
        for step in reversed(range(settings.steps)):
            goes_on = settings.discount * (1 - batch["end"][step])
            error = batch["reward"][step] + goes_on * batch["worth"][step + 1] - batch["worth"][step]
            advantage = error + goes_on * settings.trace * advantage
            advantages[step] = advantage
        return advantages

    def learn(self, left: float) -> None:
        """Learns from what was noted, when so much of the time is left."""
        settings = self.settings
        self.optimiser.param_groups[0]["lr"] = settings.rate * left
        advantages = self._advantages()
        worths = self.batch.pop("worth")[:-1]
        targets = (advantages + worths).flatten()
        weights = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).flatten()
        flat = {name: part.flatten(0, 1) for name, part in self.batch.items()}
        decides = float(self.updates >= settings.first)
        for _ in range(settings.epochs):
            for rows in torch.randperm(len(targets)).split(settings.rows):
                known, weight = flat["known"][rows], weights[rows]
                choices = Choices(self._logits(self.choice, known[:, : self.senses.numbers]), self.sizes)
                ratio = (choices.likelihood(flat["action"][rows]) - flat["likelihood"][rows]).exp()
                gain = torch.minimum(ratio * weight, ratio.clamp(1 - settings.clip, 1 + settings.clip) * weight).mean()
                error = (self.worth(known).squeeze(1) - targets[rows]).pow(2).mean()
                loss = 0.5 * error - decides * (gain + settings.entropy * left * choices.entropy())
                self.optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(self.parameters, 0.5)
                self.optimiser.step()
        self.updates += 1

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the network that decides, in half precision: some 75 kB."""
        linear = [layer for layer in self.choice if isinstance(layer, nn.Linear)]
        arrays = {
            f"weight{index}": layer.weight.detach().numpy().astype(np.float16) for index, layer in enumerate(linear)
        }
        arrays |= {f"bias{index}": layer.bias.detach().numpy().astype(np.float16) for index, layer in enumerate(linear)}
        np.savez_compressed(path, sizes=np.array(self.sizes), **arrays)
