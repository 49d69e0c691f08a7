"""Learning to play from beliefs, for ``striker.py`` and ``team.py``: imitation of ``adviser.py`` in the situations that the learner gets into
by itself, and then proximal policy optimisation (Schulman and others, 2017). The critic, which is needed for learning only, knows the truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from adviser import Adviser
from networks import Critic, actor
from torch import nn
from torch.distributions import Categorical

import naoisis


@dataclass(frozen=True)
class Settings:
    """How something is learned.

    Attributes:
        rounds: Rounds of imitation; in the first third of them the adviser walks more often than the learner.
        round_steps: Steps of each world in a round.
        round_updates: Updates of the network in a round.
        round_rows: How many decisions an update of imitation learns from.
        sharper: The factor of all scores at the end of imitation, in which it grows from 1: less is left to chance than imitation doubts.
        near_m: Half of the decisions that imitation learns from are of robots that are nearer to the ball, where they are difficult.
        steps: Steps of each world between two updates.
        epochs: How often an update goes through them.
        rows: How many decisions are learned from at once.
        rate: How fast it learns at first.
        entropy: What it is worth at first to decide by chance.
        discount: What a reward is worth a step later.
        trace: How far rewards are told back to decisions: the lambda of generalised advantages.
        clip: How much likelier or less likely an update may make a decision.
        first: In so many updates only the critic learns.
    """

    rounds: int = 60
    round_steps: int = 24
    round_updates: int = 60
    round_rows: int = 4096
    sharper: float = 1.0
    near_m: float = 0.35
    steps: int = 128
    epochs: int = 3
    rows: int = 4096
    rate: float = 5e-4
    entropy: float = 0.002
    discount: float = 0.997
    trace: float = 0.95
    clip: float = 0.2
    first: int = 5


class Worlds:
    """Worlds that are stepped together, and the true state as each of their robots that learn sees it.

    Args:
        scenario: The scenario or task.
        count: The number of worlds.
        seed: The seed of their episodes.
        options: Options of :func:`naoisis.vector_env`.
    """

    def __init__(self, scenario: str, count: int, seed: int, **options: Any):
        same: Mapping[str, Any] = {"observation": "belief", "action": "velocities", "autoreset_mode": "same_step"}
        self.envs = naoisis.vector_env(scenario, count, threads=1, **same, **options)
        names = list(self.envs.state_names)
        robots = [name.split(".")[0] for name in names]
        turned = np.array([name.split(".")[1] in ("x", "y", "vx", "vy", "cos", "sin", "lead") for name in names])

        def order(agent: str) -> list[int]:
            """What is of no robot first, then the agent, its team-mates, and the others."""
            rank = {robot: 1 + (robot != agent) + (robot[:4] != agent[:4]) for robot in robots if robot[-1].isdigit()}
            return sorted(range(len(names)), key=lambda index: rank.get(robots[index], 0))

        self._order = np.array([order(agent) for agent in self.envs.agents])
        is_pink = np.array([[agent.startswith("pink")] for agent in self.envs.agents])
        self._sign = np.where(turned[self._order] & is_pink, -1.0, 1.0)
        self._lead, self.count = names.index("game.lead"), count
        self.seen = self.envs.reset(seed=seed)[0]
        self.ends: list[bool] = []
        self.goals, self.steps = np.zeros(2), 0

    def truth(self) -> np.ndarray:
        """The true state, a row for each robot, in the frame of its team."""
        state = self.envs.state()
        return (state[:, self._order] * self._sign).reshape(-1, state.shape[1]).astype(np.float32)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rewards, and which episodes are over."""
        before = self.envs.state()[:, self._lead].copy()
        self.seen, rewards, terminated, truncated, info = self.envs.step(action)
        over = terminated | truncated
        if over.any():
            self.ends += info["final_info"]["success"][over].tolist()
        scored = np.where(over.reshape(self.count, -1)[:, 0], 0, self.envs.state()[:, self._lead] - before)
        self.goals += [np.maximum(scored, 0).sum(), np.maximum(-scored, 0).sum()]
        self.steps += self.count
        return rewards.astype(np.float32), over

    def goals_per_match(self, match_steps: int) -> np.ndarray:
        """Goals of blue and of pink in so many steps, since the last call."""
        goals, self.goals, steps, self.steps = self.goals, np.zeros(2), self.steps, 0
        return goals * match_steps / max(steps, 1)


class Learner:
    """A network that decides for robots, a critic, and the worlds in which they learn.

    Args:
        worlds: The worlds; their observations and states have the same numbers.
        seed: The seed of chance in imitation.
        settings: How it learns.
    """

    def __init__(self, worlds: Sequence[Worlds], seed: int, settings: Settings):
        envs = worlds[0].envs
        self.worlds, self.settings, self.names = worlds, settings, envs.observation_names
        self.sizes = [int(size) for size in envs.single_action_space.nvec]
        self.choice, self.worth = actor(self.names, sum(self.sizes)), Critic(self.names, len(envs.state_names))
        self.parameters = [*self.choice.parameters(), *self.worth.parameters()]
        self.optimiser = torch.optim.Adam(self.parameters, settings.rate, eps=1e-5)
        self.random = np.random.default_rng(seed)
        self._ball = [list(self.names).index(f"ball.{name}") for name in ("known", "x", "y")]

    def _seen(self) -> torch.Tensor:
        return torch.from_numpy(np.concatenate([worlds.seen for worlds in self.worlds]))

    def _known(self, seen: torch.Tensor) -> torch.Tensor:
        return torch.cat([seen, torch.from_numpy(np.concatenate([worlds.truth() for worlds in self.worlds]))], 1)

    def choices(self, seen: torch.Tensor, sharper: float = 1.0) -> list[Categorical]:
        """The choices in these situations, one list after the other."""
        scores = (sharper * self.choice(seen)).split(self.sizes, -1)
        return [Categorical(logits=of_list, validate_args=False) for of_list in scores]

    def step(self, action: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
        """Rewards of all robots, and which episodes are over."""
        rows = np.cumsum([len(worlds.seen) for worlds in self.worlds])[:-1]
        parts = [worlds.step(part) for worlds, part in zip(self.worlds, np.split(action, rows))]
        rewards, over = (np.concatenate(of_all) for of_all in zip(*parts))
        return torch.from_numpy(rewards), torch.from_numpy(over)

    def imitate(self) -> None:
        """Learns what the adviser advises, where the learner comes by its own decisions."""
        settings, adviser = self.settings, Adviser(self.names)
        optimiser = torch.optim.Adam(self.choice.parameters(), 1e-3)
        seen, advised = [], []
        for turn in range(settings.rounds):
            share = turn / settings.rounds
            optimiser.param_groups[0]["lr"] = 1e-3 * (1 - share) + 3e-5
            sharper = 1 + (settings.sharper - 1) * share
            for _ in range(settings.round_steps):
                now = self._seen()
                advice = adviser(now.numpy())
                with torch.no_grad():
                    own = torch.stack([choice.sample() for choice in self.choices(now, sharper)], -1).numpy()
                follows = self.random.random((len(own), 1)) < 1 - 3 * share
                seen.append(now)
                advised.append(torch.from_numpy(advice))
                self.step(np.where(follows, advice, own).astype(np.int64))
            all_seen, all_advised = torch.cat(seen), torch.cat(advised)
            ball = all_seen[:, self._ball]
            near = torch.nonzero((ball[:, 0] > 0.5) & (torch.hypot(ball[:, 1], ball[:, 2]) < settings.near_m)).squeeze(
                1
            )
            for _ in range(settings.round_updates):
                rows = torch.randint(len(all_seen), (settings.round_rows,))
                if len(near) > 0:
                    half = settings.round_rows // 2
                    rows[:half] = near[torch.randint(len(near), (half,))]
                loss = -likelihood(self.choices(all_seen[rows]), all_advised[rows]).mean()
                optimiser.zero_grad()
                loss.backward()
                optimiser.step()
        with torch.no_grad():
            for parameter in self.choice[-1][-1].parameters():
                parameter *= settings.sharper
        for worlds in self.worlds:
            worlds.ends.clear()
            worlds.goals_per_match(1)

    @torch.no_grad()
    def play(self) -> dict[str, torch.Tensor]:
        """Plays so many steps in all worlds, and returns what is learned from them, a row for each decision."""
        settings = self.settings
        names = ("seen", "known", "action", "likelihood", "reward", "worth", "over")
        notes: dict[str, list[torch.Tensor]] = {name: [] for name in names}
        for _ in range(settings.steps):
            now = self._seen()
            known = self._known(now)
            choices, worth = self.choices(now), self.worth(known)
            action = torch.stack([choice.sample() for choice in choices], -1)
            reward, over = self.step(action.numpy())
            noted = (now, known, action, likelihood(choices, action), reward, worth, over.float())
            for name, part in zip(names, noted):
                notes[name].append(part)
        batch = {name: torch.stack(parts) for name, parts in notes.items()}
        following = self.worth(self._known(self._seen()))
        advantage, advantages = torch.zeros_like(following), torch.zeros_like(batch["reward"])
        for step in reversed(range(settings.steps)):
            goes_on = settings.discount * (1 - batch["over"][step])
            error = batch["reward"][step] + goes_on * following - batch["worth"][step]
            advantage = error + goes_on * settings.trace * advantage
            advantages[step], following = advantage, batch["worth"][step]
        flat = {name: part.flatten(0, 1) for name, part in batch.items()}
        weight = advantages.flatten()
        flat["target"], flat["weight"] = weight + flat["worth"], (weight - weight.mean()) / (weight.std() + 1e-8)
        return flat

    def learn(self, batch: dict[str, torch.Tensor], left: float, decides: bool) -> None:
        """Learns from what was played, when so much of the time is left."""
        settings = self.settings
        self.optimiser.param_groups[0]["lr"] = settings.rate * max(left, 0.05)
        for _ in range(settings.epochs):
            for rows in torch.randperm(len(batch["seen"])).split(settings.rows):
                part = {name: numbers[rows] for name, numbers in batch.items()}
                loss = 0.5 * (self.worth(part["known"]) - part["target"]).pow(2).mean()
                if decides:
                    choices, weight = self.choices(part["seen"]), part["weight"]
                    ratio = (likelihood(choices, part["action"]) - part["likelihood"]).exp()
                    clipped = ratio.clamp(1 - settings.clip, 1 + settings.clip)
                    chance = sum(choice.entropy() for choice in choices)
                    loss = loss - torch.minimum(ratio * weight, clipped * weight).mean()
                    loss = loss - settings.entropy * left * chance.mean()
                self.optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(self.parameters, 0.5)
                self.optimiser.step()


def likelihood(choices: list[Categorical], action: torch.Tensor) -> torch.Tensor:
    """How likely all that was chosen is, as a logarithm."""
    return sum(choice.log_prob(action[..., index]) for index, choice in enumerate(choices))
