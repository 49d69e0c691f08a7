"""Proximal policy optimisation in one file, with PyTorch: a robot learns to score.

``python main.py --observation belief``: prints how often it scores as it learns, and writes the policy and its curve to a folder. The
algorithm is that of Schulman and others (2017), with generalised advantages; the batch of worlds is stepped in Rust.
"""

from __future__ import annotations

import argparse
import csv
import time
from pathlib import Path

import numpy as np
import torch
from policy import Learned, Senses, spread, success_rate
from torch import nn
from torch.distributions import Categorical

import naoisis

WORLDS, STEPS, EPOCHS, ROWS = 64, 128, 4, 1024
DISCOUNT, TRACE, CLIP, VALUE, RATE, ENTROPY = 0.995, 0.95, 0.2, 0.5, 1e-3, 0.01
# Near the ball is better than far from it, and the ball near the goal; a goal is worth more than all of that.
REWARD = {"success": 2.0, "ball_to_goal": 0.5, "to_ball": 0.3, "time": -0.01}


def network(numbers: int, answers: int, gain: float, hidden: int = 64) -> nn.Sequential:
    """Two hidden layers. What comes out is small at first, by its gain."""
    layers = [
        nn.Linear(2 * numbers, hidden),
        nn.Tanh(),
        nn.Linear(hidden, hidden),
        nn.Tanh(),
        nn.Linear(hidden, answers),
    ]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


def save(choice: nn.Sequential, path: Path) -> None:
    """Writes the network that decides, in single precision: some 50 kB."""
    linear = [layer for layer in choice if isinstance(layer, nn.Linear)]
    arrays = {f"weight{index}": layer.weight.detach().numpy() for index, layer in enumerate(linear)}
    arrays |= {f"bias{index}": layer.bias.detach().numpy() for index, layer in enumerate(linear)}
    np.savez_compressed(path, **arrays)


def learn(task: str, observation: str, steps: int, seed: int, out: Path) -> None:
    """Learns for so many steps of all worlds together, and writes the policy and the curve."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    envs = naoisis.vector_env(
        task, WORLDS, observation=observation, action="discrete", reward=REWARD, autoreset_mode="same_step", threads=1
    )
    senses = Senses(envs.observation_names)
    choice, worth = network(senses.numbers, envs.single_action_space.n, 0.01), network(senses.numbers, 1, 1.0)
    parameters = [*choice.parameters(), *worth.parameters()]
    optimiser = torch.optim.Adam(parameters, RATE, eps=1e-5)

    observations, _ = envs.reset(seed=seed)
    features, memory = senses(observations, senses.begin(WORLDS))
    ends: list[bool] = []
    curve = [("steps", "minutes", "success")]
    begun, updates = time.monotonic(), steps // (STEPS * WORLDS)
    for update in range(updates):
        left = 1 - update / updates
        optimiser.param_groups[0]["lr"] = RATE * left
        kept: dict[str, list[torch.Tensor]] = {
            name: [] for name in ("seen", "action", "likelihood", "reward", "worth", "end")
        }
        for _ in range(STEPS):
            now = torch.from_numpy(spread(features))
            with torch.no_grad():
                choices, value = Categorical(logits=choice(now)), worth(now).squeeze(-1)
            action = choices.sample()
            observations, rewards, terminated, truncated, info = envs.step(action.numpy())
            reward, over = torch.from_numpy(rewards), terminated | truncated
            if over.any():
                ends += info["final_info"]["success"][over].tolist()
                # What would have come after the end of the time is worth something.
                last, _ = senses(np.stack(info["final_obs"][over]), memory[over])
                with torch.no_grad():
                    reward[over] += (
                        DISCOUNT
                        * worth(torch.from_numpy(spread(last))).squeeze(-1)
                        * torch.from_numpy(~terminated[over])
                    )
                memory[over] = senses.begin(int(over.sum()))
            features, memory = senses(observations, memory)
            values = (now, action, choices.log_prob(action), reward, value, torch.from_numpy(over).float())
            for name, part in zip(kept, values):
                kept[name].append(part)

        batch = {name: torch.stack(parts) for name, parts in kept.items()}
        with torch.no_grad():
            following = worth(torch.from_numpy(spread(features))).squeeze(-1)
        advantage, advantages = torch.zeros(WORLDS), torch.zeros(STEPS, WORLDS)
        for step in reversed(range(STEPS)):
            goes_on = DISCOUNT * (1 - batch["end"][step])
            error = batch["reward"][step] + goes_on * following - batch["worth"][step]
            advantage = error + goes_on * TRACE * advantage
            advantages[step], following = advantage, batch["worth"][step]
        flat = {name: part.flatten(0, 1) for name, part in batch.items()}
        targets, weights = advantages.flatten() + flat["worth"], advantages.flatten()
        weights = (weights - weights.mean()) / (weights.std() + 1e-8)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(targets)).split(ROWS):
                choices, value = Categorical(logits=choice(flat["seen"][rows])), worth(flat["seen"][rows]).squeeze(-1)
                ratio = (choices.log_prob(flat["action"][rows]) - flat["likelihood"][rows]).exp()
                gain = torch.minimum(ratio * weights[rows], ratio.clamp(1 - CLIP, 1 + CLIP) * weights[rows]).mean()
                loss = VALUE * (value - targets[rows]).pow(2).mean() - gain - ENTROPY * left * choices.entropy().mean()
                optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(parameters, 0.5)
                optimiser.step()

        if update % 10 == 9 or update == updates - 1:
            minutes, share = (time.monotonic() - begun) / 60, float(np.mean(ends[-400:] or [0]))
            curve.append(((update + 1) * STEPS * WORLDS, round(minutes, 2), round(share, 4)))
            print(
                f"{minutes:6.1f} min {curve[-1][0]:>9,} steps {share:6.1%} of the last 400 episodes are a success",
                flush=True,
            )
            save(choice, out / f"{task}-{observation}.npz")
            with open(out / f"{task}-{observation}.csv", "w", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(curve)
    policy = Learned(out / f"{task}-{observation}.npz", envs.observation_names)
    print(f"in 512 other episodes {success_rate(task, observation, policy, 512):.1%} are a success")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ScoreEmptyGoal", choices=list(naoisis.tasks()))
    parser.add_argument("--observation", default="belief", choices=["perception", "belief", "truth"])
    parser.add_argument("--steps", type=int, default=2_500_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "policies")
    learn(**vars(parser.parse_args()))
