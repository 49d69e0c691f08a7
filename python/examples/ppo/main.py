"""Trains a robot to score by proximal policy optimisation (PPO: Schulman and others, 2017), in one file, with PyTorch.

``python main.py --observation belief`` prints the success rate during training, and writes the policy and its learning curve to a folder.
The simulator steps all worlds together, in Rust.
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

# Worlds, steps of each world in a rollout, epochs of an update, and the minibatch size.
WORLDS, STEPS, EPOCHS, MINIBATCH = 64, 128, 4, 1024
# Discount factor, lambda of generalised advantage estimation, clip range, weight of the critic's loss, initial learning rate, and initial
# weight of the entropy bonus.
DISCOUNT, ADVANTAGE_LAMBDA, CLIP, VALUE, RATE, ENTROPY = 0.995, 0.95, 0.2, 0.5, 1e-3, 0.01
# The weights of the reward's terms. A goal counts more than all shaping rewards (robot to ball, ball to goal) together.
REWARD = {"success": 2.0, "ball_to_goal": 0.5, "to_ball": 0.3, "time": -0.01}


def network(numbers: int, outputs: int, gain: float, hidden: int = 64) -> nn.Sequential:
    """Returns a network with two hidden layers of ``hidden`` units and orthogonal initial weights.

    Args:
        numbers: The number of features before ``spread``, which doubles it.
        outputs: The number of outputs.
        gain: The gain of the output layer's initial weights: a small one makes the initial outputs small.
        hidden: The number of units in each hidden layer.
    """
    layers = [
        nn.Linear(2 * numbers, hidden),
        nn.Tanh(),
        nn.Linear(hidden, hidden),
        nn.Tanh(),
        nn.Linear(hidden, outputs),
    ]
    for layer in layers[::2]:
        nn.init.orthogonal_(layer.weight, gain if layer is layers[-1] else 2**0.5)
        nn.init.zeros_(layer.bias)
    return nn.Sequential(*layers)


def save(actor: nn.Sequential, path: Path) -> None:
    """Writes the actor's weights and biases to ``path`` (.npz) in single precision: about 50 kB."""
    linear = [layer for layer in actor if isinstance(layer, nn.Linear)]
    arrays = {f"weight{index}": layer.weight.detach().numpy() for index, layer in enumerate(linear)}
    arrays |= {f"bias{index}": layer.bias.detach().numpy() for index, layer in enumerate(linear)}
    np.savez_compressed(path, **arrays)


def learn(task: str, observation: str, steps: int, seed: int, out: Path) -> None:
    """Trains on ``task`` for ``steps`` environment steps, summed over all worlds, and writes policy and learning curve to ``out``."""
    torch.manual_seed(seed)
    torch.set_num_threads(1)
    envs = naoisis.vector_env(
        task, WORLDS, observation=observation, action="discrete", reward=REWARD, autoreset_mode="same_step", threads=1
    )
    senses = Senses(envs.observation_names)
    actor, critic = network(senses.numbers, envs.single_action_space.n, 0.01), network(senses.numbers, 1, 1.0)
    parameters = [*actor.parameters(), *critic.parameters()]
    optimiser = torch.optim.Adam(parameters, RATE, eps=1e-5)

    observations, _ = envs.reset(seed=seed)
    features, memory = senses(observations, senses.begin(WORLDS))
    successes: list[bool] = []
    curve = [("steps", "minutes", "success")]
    begun, updates = time.monotonic(), steps // (STEPS * WORLDS)
    for update in range(updates):
        remaining = 1 - update / updates
        optimiser.param_groups[0]["lr"] = RATE * remaining
        rollout: dict[str, list[torch.Tensor]] = {
            name: [] for name in ("features", "action", "log_prob", "reward", "value", "done")
        }
        for _ in range(STEPS):
            now = torch.from_numpy(spread(features))
            with torch.no_grad():
                choices, value = Categorical(logits=actor(now)), critic(now).squeeze(-1)
            action = choices.sample()
            observations, rewards, terminated, truncated, info = envs.step(action.numpy())
            reward, over = torch.from_numpy(rewards), terminated | truncated
            if over.any():
                successes += info["final_info"]["success"][over].tolist()
                # The last reward of a truncated episode includes the discounted value of its last observation.
                last, _ = senses(np.stack(info["final_obs"][over]), memory[over])
                with torch.no_grad():
                    reward[over] += (
                        DISCOUNT
                        * critic(torch.from_numpy(spread(last))).squeeze(-1)
                        * torch.from_numpy(~terminated[over])
                    )
                memory[over] = senses.begin(int(over.sum()))
            features, memory = senses(observations, memory)
            values = (now, action, choices.log_prob(action), reward, value, torch.from_numpy(over).float())
            for name, part in zip(rollout, values):
                rollout[name].append(part)

        batch = {name: torch.stack(parts) for name, parts in rollout.items()}
        with torch.no_grad():
            next_value = critic(torch.from_numpy(spread(features))).squeeze(-1)
        advantage, advantages = torch.zeros(WORLDS), torch.zeros(STEPS, WORLDS)
        for step in reversed(range(STEPS)):
            discount = DISCOUNT * (1 - batch["done"][step])
            error = batch["reward"][step] + discount * next_value - batch["value"][step]
            advantage = error + discount * ADVANTAGE_LAMBDA * advantage
            advantages[step], next_value = advantage, batch["value"][step]
        flat = {name: part.flatten(0, 1) for name, part in batch.items()}
        targets, weights = advantages.flatten() + flat["value"], advantages.flatten()
        weights = (weights - weights.mean()) / (weights.std() + 1e-8)
        for _ in range(EPOCHS):
            for rows in torch.randperm(len(targets)).split(MINIBATCH):
                choices, value = (
                    Categorical(logits=actor(flat["features"][rows])),
                    critic(flat["features"][rows]).squeeze(-1),
                )
                ratio = (choices.log_prob(flat["action"][rows]) - flat["log_prob"][rows]).exp()
                gain = torch.minimum(ratio * weights[rows], ratio.clamp(1 - CLIP, 1 + CLIP) * weights[rows]).mean()
                loss = (
                    VALUE * (value - targets[rows]).pow(2).mean()
                    - gain
                    - ENTROPY * remaining * choices.entropy().mean()
                )
                optimiser.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(parameters, 0.5)
                optimiser.step()

        if update % 10 == 9 or update == updates - 1:
            minutes, share = (time.monotonic() - begun) / 60, float(np.mean(successes[-400:] or [0]))
            curve.append(((update + 1) * STEPS * WORLDS, round(minutes, 2), round(share, 4)))
            print(
                f"{minutes:6.1f} min {curve[-1][0]:>9,} steps {share:6.1%} of the last 400 episodes were a success",
                flush=True,
            )
            save(actor, out / f"{task}-{observation}.npz")
            with open(out / f"{task}-{observation}.csv", "w", newline="") as file:
                csv.writer(file, lineterminator="\n").writerows(curve)
    policy = Learned(out / f"{task}-{observation}.npz", envs.observation_names)
    print(f"of 512 test episodes {success_rate(task, observation, policy, 512):.1%} were a success")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--task", default="ScoreEmptyGoal", choices=list(naoisis.tasks()))
    parser.add_argument("--observation", default="belief", choices=["perception", "belief", "truth"])
    parser.add_argument("--steps", type=int, default=2_500_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--out", type=Path, default=Path(__file__).parent / "policies")
    learn(**vars(parser.parse_args()))
