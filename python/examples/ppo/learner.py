"""Trains the policies of ``striker.py`` and ``team.py``, which observe beliefs: first by imitation of ``adviser.py`` (DAgger: Ross and
others, 2011), then by proximal policy optimisation (PPO: Schulman and others, 2017). The critic, which only training needs, also gets the
true state."""

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
    """The hyperparameters of imitation (the first six) and of PPO (the others).

    Attributes:
        rounds: The number of rounds of imitation. In the first third of them, the probability that a robot executes the advised action
            instead of its own falls linearly from 1 to 0.
        round_steps: The number of steps of each world in a round.
        round_updates: The number of gradient updates in a round.
        round_minibatch: The minibatch size of imitation; an entry is the decision of one robot in one step.
        logit_scale: The factor by which imitation scales the logits at its end; it grows linearly from 1. A factor above 1 makes the policy
            less random than maximum likelihood alone.
        near_m: The distance to the ball below which a decision counts as near the ball, m. Half of each minibatch of imitation are such
            decisions, because they are difficult.
        steps: The number of steps of each world in a rollout.
        epochs: The number of passes through a rollout in an update.
        minibatch: The minibatch size of PPO; an entry is the decision of one robot in one step.
        rate: The initial learning rate of PPO.
        entropy: The initial weight of the entropy bonus.
        discount: The discount factor of a step.
        advantage_lambda: The lambda of generalised advantage estimation.
        clip: The clip range of the probability ratio.
        critic_updates: The number of updates at the start in which only the critic is trained.
    """

    rounds: int = 60
    round_steps: int = 24
    round_updates: int = 60
    round_minibatch: int = 4096
    logit_scale: float = 1.0
    near_m: float = 0.35
    steps: int = 128
    epochs: int = 3
    minibatch: int = 4096
    rate: float = 5e-4
    entropy: float = 0.002
    discount: float = 0.997
    advantage_lambda: float = 0.95
    clip: float = 0.2
    critic_updates: int = 5


class Worlds:
    """Worlds that are stepped together, with the observations and the true state for each learning robot.

    Args:
        scenario: The scenario or task.
        count: The number of worlds.
        seed: The seed of the first world; the other worlds have the following seeds.
        options: Options of :func:`naoisis.vector_env`.

    Attributes:
        observations: The current observations, one row for each learning robot.
        successes: Whether the episode was a success, for each finished episode and each learning robot.
    """

    def __init__(self, scenario: str, count: int, seed: int, **options: Any):
        same: Mapping[str, Any] = {"observation": "belief", "action": "velocities", "autoreset_mode": "same_step"}
        self.envs = naoisis.vector_env(scenario, count, threads=1, **same, **options)
        names = list(self.envs.state_names)
        robots = [name.split(".")[0] for name in names]
        turned = np.array([name.split(".")[1] in ("x", "y", "vx", "vy", "cos", "sin", "lead") for name in names])

        def order(agent: str) -> list[int]:
            """Returns the columns of the state in the order for ``agent``: ball and game first, then the agent, its team-mates, and
            opponents."""
            rank = {robot: 1 + (robot != agent) + (robot[:4] != agent[:4]) for robot in robots if robot[-1].isdigit()}
            return sorted(range(len(names)), key=lambda index: rank.get(robots[index], 0))

        self._order = np.array([order(agent) for agent in self.envs.agents])
        is_pink = np.array([[agent.startswith("pink")] for agent in self.envs.agents])
        self._sign = np.where(turned[self._order] & is_pink, -1.0, 1.0)
        self._lead, self.count = names.index("game.lead"), count
        self.observations = self.envs.reset(seed=seed)[0]
        self.successes: list[bool] = []
        self.goals, self.steps = np.zeros(2), 0
        self.interactions = 0

    def privileged_state(self) -> np.ndarray:
        """Returns the true state, one row for each learning robot, in the frame of its team."""
        state = self.envs.state()
        return (state[:, self._order] * self._sign).reshape(-1, state.shape[1]).astype(np.float32)

    def step(self, action: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Steps all worlds, and returns for each learning robot its reward and whether its episode is over."""
        before = self.envs.state()[:, self._lead].copy()
        self.observations, rewards, terminated, truncated, info = self.envs.step(action)
        self.interactions += len(rewards)
        over = terminated | truncated
        if over.any():
            self.successes += info["final_info"]["success"][over].tolist()
        scored = np.where(over.reshape(self.count, -1)[:, 0], 0, self.envs.state()[:, self._lead] - before)
        self.goals += [np.maximum(scored, 0).sum(), np.maximum(-scored, 0).sum()]
        self.steps += self.count
        return rewards.astype(np.float32), over

    def goals_per_match(self, match_steps: int) -> np.ndarray:
        """Returns the goals of blue and of pink per match of ``match_steps`` steps, averaged over all steps since the last call."""
        goals, self.goals, steps, self.steps = self.goals, np.zeros(2), self.steps, 0
        return goals * match_steps / max(steps, 1)


class Learner:
    """An actor and a critic, with the worlds in which they are trained.

    Args:
        worlds: The worlds. Their observations and states have the same columns.
        seed: The seed of the random choice in imitation between the advised action and the robot's own.
        settings: The hyperparameters.
    """

    def __init__(self, worlds: Sequence[Worlds], seed: int, settings: Settings):
        envs = worlds[0].envs
        self.worlds, self.settings, self.names = worlds, settings, envs.observation_names
        self.sizes = [int(size) for size in envs.single_action_space.nvec]
        self.actor, self.critic = actor(self.names, sum(self.sizes)), Critic(self.names, len(envs.state_names))
        self.parameters = [*self.actor.parameters(), *self.critic.parameters()]
        self.optimiser = torch.optim.Adam(self.parameters, settings.rate, eps=1e-5)
        self.random = np.random.default_rng(seed)
        self._ball = [list(self.names).index(f"ball.{name}") for name in ("known", "x", "y")]

    def _observations(self) -> torch.Tensor:
        return torch.from_numpy(np.concatenate([worlds.observations for worlds in self.worlds]))

    def _critic_inputs(self, observations: torch.Tensor) -> torch.Tensor:
        """Returns the observations with the true state appended, one row for each learning robot."""
        return torch.cat(
            [observations, torch.from_numpy(np.concatenate([worlds.privileged_state() for worlds in self.worlds]))], 1
        )

    def distributions(self, observations: torch.Tensor, logit_scale: float = 1.0) -> list[Categorical]:
        """Returns the policy's distribution over each of the four lists of choices, with logits multiplied by ``logit_scale``."""
        logits = (logit_scale * self.actor(observations)).split(self.sizes, -1)
        return [Categorical(logits=of_list, validate_args=False) for of_list in logits]

    @torch.no_grad()
    def act(self, observations: np.ndarray, logit_scale: float = 1.0) -> np.ndarray:
        """Returns actions that are drawn from the policy's distributions, one row for each robot."""
        choices = self.distributions(torch.from_numpy(observations), logit_scale)
        return torch.stack([choice.sample() for choice in choices], -1).numpy()

    def step(self, action: np.ndarray) -> tuple[torch.Tensor, torch.Tensor]:
        """Steps all worlds, and returns for each learning robot its reward and whether its episode is over."""
        rows = np.cumsum([len(worlds.observations) for worlds in self.worlds])[:-1]
        parts = [worlds.step(part) for worlds, part in zip(self.worlds, np.split(action, rows))]
        rewards, over = (np.concatenate(of_all) for of_all in zip(*parts))
        return torch.from_numpy(rewards), torch.from_numpy(over)

    @property
    def interactions(self) -> int:
        """The number of steps so far, counted for each learning robot."""
        return sum(worlds.interactions for worlds in self.worlds)

    def imitate(self) -> None:
        """Trains the actor by imitation of the adviser, in states that the actor's own decisions lead to."""
        settings, adviser = self.settings, Adviser(self.names)
        optimiser = torch.optim.Adam(self.actor.parameters(), 1e-3)
        observed, advised = [], []
        for turn in range(settings.rounds):
            share = turn / settings.rounds
            optimiser.param_groups[0]["lr"] = 1e-3 * (1 - share) + 3e-5
            logit_scale = 1 + (settings.logit_scale - 1) * share
            for _ in range(settings.round_steps):
                now = self._observations()
                advice = adviser(now.numpy())
                own = self.act(now.numpy(), logit_scale)
                follows = self.random.random((len(own), 1)) < 1 - 3 * share
                observed.append(now)
                advised.append(torch.from_numpy(advice))
                self.step(np.where(follows, advice, own).astype(np.int64))
            all_observed, all_advised = torch.cat(observed), torch.cat(advised)
            ball = all_observed[:, self._ball]
            near = torch.nonzero((ball[:, 0] > 0.5) & (torch.hypot(ball[:, 1], ball[:, 2]) < settings.near_m)).squeeze(
                1
            )
            for _ in range(settings.round_updates):
                rows = torch.randint(len(all_observed), (settings.round_minibatch,))
                if len(near) > 0:
                    half = settings.round_minibatch // 2
                    rows[:half] = near[torch.randint(len(near), (half,))]
                loss = -log_prob(self.distributions(all_observed[rows]), all_advised[rows]).mean()
                optimiser.zero_grad()
                loss.backward()
                optimiser.step()
        with torch.no_grad():
            for parameter in self.actor[-1][-1].parameters():
                parameter *= settings.logit_scale
        for worlds in self.worlds:
            worlds.successes.clear()
            worlds.goals_per_match(1)

    @torch.no_grad()
    def play(self) -> dict[str, torch.Tensor]:
        """Collects a rollout of ``settings.steps`` steps of all worlds, and returns it as a batch: one row for each decision of a robot,
        with normalised advantages (generalised advantage estimation) and the critic's targets. A time limit counts as the end of the
        episode, as a goal does: what is not done by then is not done."""
        settings = self.settings
        names = ("observation", "critic_input", "action", "log_prob", "reward", "value", "done")
        notes: dict[str, list[torch.Tensor]] = {name: [] for name in names}
        for _ in range(settings.steps):
            now = self._observations()
            critic_input = self._critic_inputs(now)
            choices, value = self.distributions(now), self.critic(critic_input)
            action = torch.stack([choice.sample() for choice in choices], -1)
            reward, over = self.step(action.numpy())
            noted = (now, critic_input, action, log_prob(choices, action), reward, value, over.float())
            for name, part in zip(names, noted):
                notes[name].append(part)
        batch = {name: torch.stack(parts) for name, parts in notes.items()}
        next_value = self.critic(self._critic_inputs(self._observations()))
        advantage, advantages = torch.zeros_like(next_value), torch.zeros_like(batch["reward"])
        for step in reversed(range(settings.steps)):
            discount = settings.discount * (1 - batch["done"][step])
            error = batch["reward"][step] + discount * next_value - batch["value"][step]
            advantage = error + discount * settings.advantage_lambda * advantage
            advantages[step], next_value = advantage, batch["value"][step]
        flat = {name: part.flatten(0, 1) for name, part in batch.items()}
        unscaled = advantages.flatten()
        flat["target"], flat["advantage"] = (
            unscaled + flat["value"],
            (unscaled - unscaled.mean()) / (unscaled.std() + 1e-8),
        )
        return flat

    def learn(self, batch: dict[str, torch.Tensor], remaining: float, trains_actor: bool) -> None:
        """Updates the critic and, if ``trains_actor``, the actor by PPO on ``batch``.

        Args:
            batch: A rollout, as :meth:`play` returns it.
            remaining: The fraction of the training that remains. Learning rate and entropy bonus are proportional to it, but the learning
                rate does not fall below 5 % of its initial value.
            trains_actor: Whether the actor is trained, too.
        """
        settings = self.settings
        self.optimiser.param_groups[0]["lr"] = settings.rate * max(remaining, 0.05)
        for _ in range(settings.epochs):
            for rows in torch.randperm(len(batch["observation"])).split(settings.minibatch):
                part = {name: numbers[rows] for name, numbers in batch.items()}
                loss = 0.5 * (self.critic(part["critic_input"]) - part["target"]).pow(2).mean()
                if trains_actor:
                    choices, advantage = self.distributions(part["observation"]), part["advantage"]
                    ratio = (log_prob(choices, part["action"]) - part["log_prob"]).exp()
                    clipped = ratio.clamp(1 - settings.clip, 1 + settings.clip)
                    entropy = sum(choice.entropy() for choice in choices)
                    loss = loss - torch.minimum(ratio * advantage, clipped * advantage).mean()
                    loss = loss - settings.entropy * remaining * entropy.mean()
                self.optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(self.parameters, 0.5)
                self.optimiser.step()


def log_prob(choices: list[Categorical], action: torch.Tensor) -> torch.Tensor:
    """Returns the log-probability of ``action``: the sum over its independent ``choices``, one number for each row."""
    return sum(choice.log_prob(action[..., index]) for index, choice in enumerate(choices))
