"""Proximal policy optimisation (PPO: Schulman and others, 2017) for the robots of both teams, with PyTorch, for ``self_play.py``.

The actor's input is computed from a robot's beliefs alone. The critic, which only training needs, also gets the true state.
"""

from __future__ import annotations

import copy
import os
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from team_policy import ADVICE_LOGITS, Senses, spread
from torch import nn

# What a rollout records of each step.
ROLLOUT = ("critic_input", "action", "log_prob", "reward", "value", "done")


@dataclass(frozen=True)
class Settings:
    """The hyperparameters of PPO.

    Attributes:
        steps: The number of steps of each world in a rollout.
        epochs: The number of passes through a rollout in an update.
        minibatch: The minibatch size; an entry is the decision of one robot in one step.
        rate: The initial learning rate.
        entropy: The initial weight of the entropy bonus.
        discount: The discount factor of a step.
        advantage_lambda: The lambda of generalised advantage estimation.
        clip: The clip range of the probability ratio.
        hidden: The number of units in each of the two hidden layers.
        critic_updates: The number of updates at the start in which only the critic is trained.
    """

    steps: int = 128
    epochs: int = 3
    minibatch: int = 2048
    rate: float = 5e-4
    entropy: float = 0.001
    discount: float = 0.995
    advantage_lambda: float = 0.95
    clip: float = 0.2
    hidden: int = 128
    critic_updates: int = 8


def network(inputs: int, outputs: int, gain: float, hidden: int) -> nn.Sequential:
    """Returns a network with two hidden layers of ``hidden`` units and orthogonal initial weights.

    ``gain`` is that of the output layer: a small one makes the initial outputs small.
    """
    layers = [nn.Linear(inputs, hidden), nn.Tanh(), nn.Linear(hidden, hidden), nn.Tanh(), nn.Linear(hidden, outputs)]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


class Truth:
    """Converts the true state of worlds to a critic's input for each robot: in its team's frame, first ball and game, then the robot
    itself, its team-mates, and its opponents.

    Args:
        names: The names of the state's columns, which are in the frame of team blue.
        agents: The robots of each world.
    """

    def __init__(self, names: list[str], agents: list[str]):
        turned = [name.split(".")[1] in ("x", "y", "vx", "vy", "cos", "sin", "lead") for name in names]
        robots = [name.split(".")[0] for name in names]

        def order(agent: str) -> list[int]:
            """Returns the columns of the state in the order for ``agent``: ball and game first, then the agent, its team-mates, and
            opponents."""
            rank = {robot: 1 + (robot != agent) + (robot[:4] != agent[:4]) for robot in agents}
            return sorted(range(len(names)), key=lambda index: rank.get(robots[index], 0))

        self.order = np.array([order(agent) for agent in agents])
        self.sign = np.where(
            np.array(turned)[self.order] & np.array([[agent.startswith("pink")] for agent in agents]), -1.0, 1.0
        )

    def __call__(self, state: np.ndarray) -> torch.Tensor:
        """Returns the critic's part of the input, one row for each robot, from ``state``, one row for each world."""
        return torch.from_numpy(spread((state[:, self.order] * self.sign).reshape(-1, state.shape[1])))


class Choices:
    """Several independent categorical distributions, one for each list of choices.

    Args:
        logits: The logits of all lists, one list after the other, one row for each robot.
        sizes: The number of choices in each list.
    """

    def __init__(self, logits: torch.Tensor, sizes: list[int]):
        self.logs = [part.log_softmax(1) for part in logits.split(sizes, 1)]

    def draw(self) -> torch.Tensor:
        """Returns a sample: the index of a choice for each row and list."""
        return torch.stack([(logs - torch.empty_like(logs).exponential_().log()).argmax(1) for logs in self.logs], 1)

    def log_prob(self, chosen: torch.Tensor) -> torch.Tensor:
        """Returns the log-probability of ``chosen``, summed over the lists, one number for each row."""
        return sum(logs.gather(1, chosen[:, index : index + 1]).squeeze(1) for index, logs in enumerate(self.logs))

    def entropy(self) -> torch.Tensor:
        """Returns the entropy, summed over the lists and averaged over the rows."""
        return -sum((logs.exp() * logs).sum(1).mean() for logs in self.logs)


class TeamLearner:
    """An actor, which decides for each robot, and a critic, with the worlds in which they are trained.

    Args:
        envs: The worlds. Both teams must be controlled, in the mode ``same_step``.
        seed: The seed of the first world and of the choice of opponents from the pool.
        mirrored: The number of worlds in which the current policy plays both teams and learns from both. In the others it learns only from
            blue, and an earlier policy from the opponent pool plays pink.
        settings: The hyperparameters.
    """

    def __init__(self, envs: Any, seed: int, mirrored: int, settings: Settings):
        self.envs, self.settings, self.updates = envs, settings, 0
        self.sizes = [int(size) for size in envs.single_action_space.nvec]
        self.senses, self.truth = Senses(envs.observation_names), Truth(envs.state_names, envs.agents)
        self.actor = network(self.senses.numbers, sum(self.sizes), 0.01, settings.hidden)
        self.critic = network(self.senses.numbers + 2 * len(envs.state_names), 1, 1.0, settings.hidden)
        self.parameters = [*self.actor.parameters(), *self.critic.parameters()]
        self.optimiser = torch.optim.Adam(self.parameters, settings.rate, eps=1e-5)
        world, pink = np.divmod(np.arange(envs.num_envs), len(envs.agents))
        is_opponent = (world >= mirrored) & np.array([agent.startswith("pink") for agent in envs.agents])[pink]
        self.learning_rows = np.flatnonzero(~is_opponent)
        # Two earlier policies in each rollout: more would mean many small batches.
        self.opponent_rows = np.array_split(np.flatnonzero(is_opponent), 2)
        self.advice_logits = torch.from_numpy(ADVICE_LOGITS)
        self.samples = settings.steps * len(self.learning_rows)
        self.pool: list[nn.Module] = []
        self.random = np.random.default_rng(seed)
        observations, _ = envs.reset(seed=seed)
        self._perceive(observations)

    def _perceive(self, observations: np.ndarray) -> None:
        """Sets the inputs of the actor and of the critic from ``observations`` and the true state, one row for each robot."""
        self.features = torch.from_numpy(self.senses(observations))
        self.critic_inputs = torch.cat([self.features, self.truth(self.envs.state())], 1)

    def _logits(self, policy: nn.Module, features: torch.Tensor) -> torch.Tensor:
        """Returns the logits of ``policy``, plus a constant for the advised choices, which are the last columns of ``features``."""
        return policy(features) + features[:, -len(ADVICE_LOGITS) :] * self.advice_logits

    def _values(self) -> torch.Tensor:
        """Returns the critic's values of the current states, one for each learning robot."""
        return self.critic(self.critic_inputs[self.learning_rows]).squeeze(1)

    def add_to_pool(self, most: int) -> None:
        """Adds a copy of the current policy to the opponent pool, which keeps only the latest ``most`` policies."""
        self.pool = [*self.pool, copy.deepcopy(self.actor)][-most:]

    @torch.no_grad()
    def play(self) -> list[bool]:
        """Collects a rollout of ``settings.steps`` steps of all worlds. Returns one entry for each robot of each episode that ended:
        whether the episode was decided by a goal before its time was up."""
        opponents = [self.pool[self.random.integers(len(self.pool))] for _ in self.opponent_rows]
        notes: dict[str, list[torch.Tensor]] = {name: [] for name in ROLLOUT}
        decided: list[bool] = []
        for _ in range(self.settings.steps):
            logits = self._logits(self.actor, self.features)
            for policy, rows in zip(opponents, self.opponent_rows):
                logits[rows] = self._logits(policy, self.features[rows])
            choices = Choices(logits, self.sizes)
            action = choices.draw()
            notes["critic_input"].append(self.critic_inputs[self.learning_rows])
            notes["value"].append(self._values())
            notes["action"].append(action[self.learning_rows])
            notes["log_prob"].append(choices.log_prob(action)[self.learning_rows])
            observations, rewards, terminated, truncated, _ = self.envs.step(action.numpy())
            over = terminated | truncated
            decided += terminated[over].tolist()
            notes["reward"].append(torch.from_numpy(rewards[self.learning_rows]))
            notes["done"].append(torch.from_numpy(over[self.learning_rows]).float())
            self._perceive(observations)
        notes["value"].append(self._values())
        self.batch = {name: torch.stack(parts) for name, parts in notes.items()}
        return decided

    def _advantages(self) -> torch.Tensor:
        """Returns the generalised advantage estimates of the rollout: shape (steps, learning robots)."""
        batch, settings = self.batch, self.settings
        advantages, advantage = torch.empty_like(batch["reward"]), torch.zeros(len(self.learning_rows))
        for step in reversed(range(settings.steps)):
            discount = settings.discount * (1 - batch["done"][step])
            error = batch["reward"][step] + discount * batch["value"][step + 1] - batch["value"][step]
            advantage = error + discount * settings.advantage_lambda * advantage
            advantages[step] = advantage
        return advantages

    def learn(self, remaining: float) -> None:
        """Updates actor and critic by PPO on the last rollout. ``remaining`` is the fraction of the training that remains: learning rate
        and entropy bonus are proportional to it."""
        settings = self.settings
        self.optimiser.param_groups[0]["lr"] = settings.rate * remaining
        advantages = self._advantages()
        values = self.batch.pop("value")[:-1]
        targets = (advantages + values).flatten()
        normalised = ((advantages - advantages.mean()) / (advantages.std() + 1e-8)).flatten()
        flat = {name: part.flatten(0, 1) for name, part in self.batch.items()}
        trains_actor = float(self.updates >= settings.critic_updates)
        for _ in range(settings.epochs):
            for rows in torch.randperm(len(targets)).split(settings.minibatch):
                critic_input, advantage = flat["critic_input"][rows], normalised[rows]
                choices = Choices(self._logits(self.actor, critic_input[:, : self.senses.numbers]), self.sizes)
                ratio = (choices.log_prob(flat["action"][rows]) - flat["log_prob"][rows]).exp()
                gain = torch.minimum(
                    ratio * advantage, ratio.clamp(1 - settings.clip, 1 + settings.clip) * advantage
                ).mean()
                error = (self.critic(critic_input).squeeze(1) - targets[rows]).pow(2).mean()
                loss = 0.5 * error - trains_actor * (gain + settings.entropy * remaining * choices.entropy())
                self.optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(self.parameters, 0.5)
                self.optimiser.step()
        self.updates += 1

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the actor's weights and biases to ``path`` (.npz) in half precision: about 75 kB."""
        linear = [layer for layer in self.actor if isinstance(layer, nn.Linear)]
        arrays = {
            f"weight{index}": layer.weight.detach().numpy().astype(np.float16) for index, layer in enumerate(linear)
        }
        arrays |= {f"bias{index}": layer.bias.detach().numpy().astype(np.float16) for index, layer in enumerate(linear)}
        np.savez_compressed(path, sizes=np.array(self.sizes), **arrays)
