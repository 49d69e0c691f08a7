"""Proximal policy optimisation in one file, with nothing but PyTorch: a robot learns to score.

``python main.py --observation belief --minutes 5``: prints how often it scores as it learns. The algorithm is that of Schulman and
others (2017), with generalised advantages; the batch of worlds is stepped in Rust.
"""

from __future__ import annotations

import argparse
import time

import numpy as np
import torch
from torch import nn
from torch.distributions import Categorical

import naoisis

STEPS, EPOCHS, MINIBATCHES = 128, 4, 8
DISCOUNT, TRACE, CLIP, ENTROPY, VALUE, RATE = 0.99, 0.95, 0.2, 0.01, 0.5, 5e-4


class Policy(nn.Module):
    """What to do, and what it is worth to be here."""

    def __init__(self, numbers: int, choices: int):
        super().__init__()
        self.body = nn.Sequential(nn.Linear(numbers, 128), nn.Tanh(), nn.Linear(128, 128), nn.Tanh())
        self.choice, self.value = nn.Linear(128, choices), nn.Linear(128, 1)

    def forward(self, observations: torch.Tensor) -> tuple[Categorical, torch.Tensor]:
        features = self.body(observations)
        return Categorical(logits=self.choice(features)), self.value(features).squeeze(-1)


def learn(observation: str, minutes: float, worlds: int, seed: int) -> float:
    """Learns for some minutes. The share of the last 200 episodes that were a success."""
    torch.manual_seed(seed)
    envs = naoisis.vector_env(
        "ScoreEmptyGoal", worlds, observation=observation, action="discrete", autoreset_mode="same_step"
    )
    space = envs.single_observation_space
    scale = torch.as_tensor(np.maximum(np.abs(space.low), np.abs(space.high)).clip(max=3.0))
    policy = Policy(space.shape[0], envs.single_action_space.n)
    optimiser = torch.optim.Adam(policy.parameters(), RATE, eps=1e-5)
    seen, _ = envs.reset(seed=seed)
    ends: list[bool] = []
    begun, steps = time.monotonic(), 0
    while time.monotonic() - begun < 60 * minutes:
        kept = {name: [] for name in ("seen", "action", "likelihood", "reward", "value", "end")}
        for _ in range(STEPS):
            with torch.no_grad():
                now = torch.as_tensor(seen) / scale
                choices, value = policy(now)
                action = choices.sample()
            seen, reward, terminated, truncated, info = envs.step(action.numpy())
            reward = torch.as_tensor(reward)
            if truncated.any():
                # What comes after the end of the time is worth something, and was not lost.
                last = torch.as_tensor(np.stack([info["final_obs"][row] for row in np.flatnonzero(truncated)])) / scale
                with torch.no_grad():
                    reward[truncated] += DISCOUNT * policy(last)[1]
            if "final_info" in info:
                ends += info["final_info"]["success"][info["_final_info"]].tolist()
            values = (now, action, choices.log_prob(action), reward, value, torch.as_tensor(terminated | truncated))
            for name, part in zip(kept, values):
                kept[name].append(part)
        steps += STEPS * worlds
        batch = {name: torch.stack(parts) for name, parts in kept.items()}
        with torch.no_grad():
            following, advantage = policy(torch.as_tensor(seen) / scale)[1], torch.zeros(worlds)
            advantages = torch.zeros_like(batch["reward"])
            for step in reversed(range(STEPS)):
                goes_on = 1.0 - batch["end"][step].float()
                error = batch["reward"][step] + DISCOUNT * goes_on * following - batch["value"][step]
                advantage = error + DISCOUNT * TRACE * goes_on * advantage
                advantages[step], following = advantage, batch["value"][step]
        flat = {name: part.flatten(0, 1) for name, part in batch.items()}
        advantages, targets = advantages.flatten(), (advantages + batch["value"]).flatten()
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(targets)).chunk(MINIBATCHES):
                choices, value = policy(flat["seen"][rows])
                ratio = (choices.log_prob(flat["action"][rows]) - flat["likelihood"][rows]).exp()
                weight = (advantages[rows] - advantages[rows].mean()) / (advantages[rows].std() + 1e-8)
                gain = torch.minimum(ratio * weight, ratio.clamp(1 - CLIP, 1 + CLIP) * weight).mean()
                loss = -gain + VALUE * (value - targets[rows]).pow(2).mean() - ENTROPY * choices.entropy().mean()
                optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(policy.parameters(), 0.5)
                optimiser.step()
        elapsed = time.monotonic() - begun
        print(f"{elapsed:6.0f} s {steps:>9,} steps {np.mean(ends[-200:] or [0]):6.1%} of the last 200 episodes scored", flush=True)
    return float(np.mean(ends[-200:] or [0]))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--observation", default="belief", choices=["perception", "belief", "truth"])
    parser.add_argument("--minutes", type=float, default=5.0)
    parser.add_argument("--worlds", type=int, default=32)
    parser.add_argument("--seed", type=int, default=1)
    learn(**vars(parser.parse_args()))
