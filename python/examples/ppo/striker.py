"""A striker learns to score against a goalkeeper, from its beliefs, and is written as ONNX: ``pip install "naoisis[torch]"``, then
``python striker.py --out striker.onnx``.

It first learns to do what ``adviser.py`` advises, in the situations that it gets into by itself, and then what scores, by proximal policy
optimisation (Schulman and others, 2017). ``naoisis challenge ScoreAgainstKeeper --policy striker.onnx`` measures it.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import torch
from adviser import Adviser
from torch import nn
from torch.distributions import Categorical

import naoisis

WORLDS, STEPS, EPOCHS, ROWS, HIDDEN = 256, 128, 4, 4096, 128
DISCOUNT, TRACE, CLIP, RATE, ENTROPY = 0.997, 0.95, 0.2, 7e-4, 0.003
# Rounds in which it imitates, of so many steps and updates; in the first ones the adviser walks more often than the striker.
ROUNDS, ROUND_STEPS, ROUND_UPDATES = 60, 16, 60
# In so many updates it learns only what situations are worth.
FIRST = 5
# When it plays, it draws its choices from these times the scores that it learned with: less is left to chance.
SHARPER = 4.0
# A goal is worth more than all the way to it.
REWARD = {"success": 2.0, "ball_to_goal": 0.3, "to_ball": 0.2, "time": -0.01}


class Spread(nn.Module):
    """Features as a network likes them: each once as it is, for far things, and once with its small values spread, for near ones."""

    def forward(self, features: torch.Tensor) -> torch.Tensor:
        size = features.abs()
        near = features * torch.log(1 + 20 * size) / (3 * size + 1e-6)
        return torch.cat([torch.clamp(features / 3, -3, 3), near], dim=-1)


class Sharper(nn.Module):
    """Scores with which less is left to chance."""

    def forward(self, scores: torch.Tensor) -> torch.Tensor:
        return SHARPER * scores


def network(numbers: int, answers: int, gain: float) -> nn.Sequential:
    """Two hidden layers. What comes out is small at first, by its gain."""
    layers = [
        nn.Linear(2 * numbers, HIDDEN),
        nn.Tanh(),
        nn.Linear(HIDDEN, HIDDEN),
        nn.Tanh(),
        nn.Linear(HIDDEN, answers),
    ]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(Spread(), *layers)


class Striker:
    """The network that decides, the one that says what is to be expected, and the worlds in which they learn.

    Args:
        envs: The worlds.
        seed: The seed of their episodes.
    """

    def __init__(self, envs: naoisis.VectorEnv, seed: int):
        self.envs, self.sizes = envs, [int(size) for size in envs.single_action_space.nvec]
        numbers = len(envs.observation_names)
        self.choice, self.worth = network(numbers, sum(self.sizes), 0.01), network(numbers, 1, 1.0)
        self.parameters = [*self.choice.parameters(), *self.worth.parameters()]
        self.optimiser = torch.optim.Adam(self.parameters, RATE, eps=1e-5)
        self.ends: list[bool] = []
        self.seen = envs.reset(seed=seed)[0]
        self.random = np.random.default_rng(seed)

    def choices(self, seen: torch.Tensor) -> list[Categorical]:
        """The choices in these situations, one list after the other."""
        return [Categorical(logits=scores) for scores in self.choice(seen).split(self.sizes, -1)]

    def expected(self, seen: torch.Tensor) -> torch.Tensor:
        """What is to be expected in these situations."""
        return self.worth(seen).squeeze(-1)

    def step(self, action: np.ndarray) -> tuple[torch.Tensor, np.ndarray]:
        """Rewards, and which episodes are over. A reward after the end of the time is what would have come."""
        self.seen, rewards, terminated, truncated, info = self.envs.step(action)
        over, reward = terminated | truncated, torch.from_numpy(rewards.astype(np.float32))
        if over.any():
            self.ends += info["final_info"]["success"][over].tolist()
            last = torch.from_numpy(np.stack(info["final_obs"][over]).astype(np.float32))
            with torch.no_grad():
                reward[over] += DISCOUNT * self.expected(last) * torch.from_numpy(~terminated[over])
        return reward, over

    def imitate(self) -> None:
        """Learns what the adviser advises, where the striker comes by its own decisions."""
        adviser, optimiser = Adviser(self.envs.observation_names), torch.optim.Adam(self.choice.parameters(), 1e-3)
        seen, advised = [], []
        for turn in range(ROUNDS):
            for _ in range(ROUND_STEPS):
                now, advice = torch.from_numpy(self.seen.copy()), adviser(self.seen)
                with torch.no_grad():
                    own = torch.stack([choice.sample() for choice in self.choices(now)], -1).numpy()
                follows = self.random.random((len(own), 1)) < 1 - turn / 20
                seen.append(now)
                advised.append(torch.from_numpy(advice))
                self.step(np.where(follows, advice, own).astype(np.int64))
            all_seen, all_advised = torch.cat(seen), torch.cat(advised)
            for _ in range(ROUND_UPDATES):
                rows = torch.randint(len(all_seen), (ROWS,))
                loss = -likelihood(self.choices(all_seen[rows]), all_advised[rows]).mean()
                optimiser.zero_grad()
                loss.backward()
                optimiser.step()
        self.ends.clear()

    @torch.no_grad()
    def play(self) -> dict[str, torch.Tensor]:
        """Plays so many steps in all worlds, and returns what is learned from them, a row for each decision."""
        names = ("seen", "action", "likelihood", "reward", "worth", "over")
        notes: dict[str, list[torch.Tensor]] = {name: [] for name in names}
        for _ in range(STEPS):
            now = torch.from_numpy(self.seen.copy())
            choices, worth = self.choices(now), self.expected(now)
            action = torch.stack([choice.sample() for choice in choices], -1)
            reward, over = self.step(action.numpy())
            noted = (now, action, likelihood(choices, action), reward, worth, torch.from_numpy(over).float())
            for name, part in zip(names, noted):
                notes[name].append(part)
        batch = {name: torch.stack(parts) for name, parts in notes.items()}
        following = self.expected(torch.from_numpy(self.seen))
        advantage, advantages = torch.zeros(WORLDS), torch.zeros(STEPS, WORLDS)
        for step in reversed(range(STEPS)):
            goes_on = DISCOUNT * (1 - batch["over"][step])
            error = batch["reward"][step] + goes_on * following - batch["worth"][step]
            advantage = error + goes_on * TRACE * advantage
            advantages[step], following = advantage, batch["worth"][step]
        flat = {name: part.flatten(0, 1) for name, part in batch.items()}
        flat["target"], weight = advantages.flatten() + flat["worth"], advantages.flatten()
        flat["weight"] = (weight - weight.mean()) / (weight.std() + 1e-8)
        return flat

    def learn(self, batch: dict[str, torch.Tensor], left: float, decides: bool) -> None:
        """Learns from what was played, when so much of the time is left."""
        self.optimiser.param_groups[0]["lr"] = RATE * max(left, 0.05)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(batch["seen"])).split(ROWS):
                part = {name: numbers[rows] for name, numbers in batch.items()}
                loss = 0.5 * (self.expected(part["seen"]) - part["target"]).pow(2).mean()
                if decides:
                    choices, weight = self.choices(part["seen"]), part["weight"]
                    ratio = (likelihood(choices, part["action"]) - part["likelihood"]).exp()
                    gain = torch.minimum(ratio * weight, ratio.clamp(1 - CLIP, 1 + CLIP) * weight).mean()
                    loss = loss - gain - ENTROPY * left * sum(choice.entropy() for choice in choices).mean()
                self.optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(self.parameters, 0.5)
                self.optimiser.step()


def likelihood(choices: list[Categorical], action: torch.Tensor) -> torch.Tensor:
    """How likely all that was chosen is, as a logarithm."""
    return sum(choice.log_prob(action[..., index]) for index, choice in enumerate(choices))


def learn(task: str, realism: str, steps: int, seed: int, out: Path) -> None:
    """Learns for so many steps of all worlds together, and writes the policy, its layout, and the curve."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    envs = naoisis.vector_env(
        task,
        WORLDS,
        observation="belief",
        action="velocities",
        realism=realism,
        reward=REWARD,
        autoreset_mode="same_step",
        threads=1,
    )
    begun, updates, curve = time.monotonic(), steps // (STEPS * WORLDS), [("steps", "minutes", "success")]
    striker = Striker(envs, seed)
    striker.imitate()
    for update in range(updates):
        striker.learn(striker.play(), 1 - update / updates, update >= FIRST)
        if update % 5 == 4 or update == updates - 1:
            minutes, share = (time.monotonic() - begun) / 60, float(np.mean(striker.ends[-500:] or [0]))
            curve.append(((update + 1) * STEPS * WORLDS, round(minutes, 2), round(share, 4)))
            print(
                f"{minutes:6.1f} min {curve[-1][0]:>9,} steps {share:6.1%} of the last 500 episodes are a success",
                flush=True,
            )
    naoisis.export_policy(nn.Sequential(striker.choice, Sharper()), out, envs, choice="drawn")
    with open(out.with_suffix(".csv"), "w", newline="") as file:
        csv.writer(file, lineterminator="\n").writerows(curve)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ScoreAgainstKeeper", choices=["ScoreEmptyGoal", "ScoreAgainstKeeper"])
    parser.add_argument("--realism", default="realistic", choices=["paper", "ideal", "realistic"])
    parser.add_argument("--steps", type=int, default=5_000_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path("striker.onnx"))
    learn(**vars(parser.parse_args()))
