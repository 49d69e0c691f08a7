"""Trains a team by multi-agent PPO with TorchRL: ``python team.py [frames] [worlds] [task]``.

All robots of the task share one policy, which observes what each of them believes; the critic knows the true state. The groups of the environment are
the teams, so the same program is that of any other multi-agent environment of TorchRL.
"""

from __future__ import annotations

import sys

import torch
from tensordict.nn import TensorDictModule
from torch import nn
from torch.distributions import Categorical
from torchrl.envs import RewardSum, TransformedEnv
from torchrl.modules import MultiAgentMLP, ProbabilisticActor
from torchrl.objectives import ClipPPOLoss

from naoisis.torchrl import MatchEnv

STEPS = 128


def main(frames: int = 200_000, worlds: int = 32, task: str = "TwoOnTwo") -> list[float]:
    """Plays ``frames`` steps, summed over the worlds. Returns the mean reward of a step in each batch."""
    torch.manual_seed(1)
    env = MatchEnv(task, worlds, observation="belief", action="discrete")
    robots, numbers = len(env.group_map["blue"]), len(env.observation_names)
    team = [("blue", "reward")], [("blue", "episode_reward")]
    env = TransformedEnv(env, RewardSum(*team, reset_keys=["_reset"]))
    sizes = {"n_agents": robots, "centralized": False, "share_params": True, "depth": 2, "num_cells": 128}
    actor = ProbabilisticActor(
        TensorDictModule(
            MultiAgentMLP(numbers, len(env.action_names[0]), **sizes),
            in_keys=[("blue", "observation")],
            out_keys=[("blue", "logits")],
        ),
        in_keys=[("blue", "logits")],
        out_keys=[("blue", "action")],
        distribution_class=Categorical,
        return_log_prob=True,
        log_prob_key=("blue", "log_prob"),
    )
    # A value for each robot.
    values = nn.Sequential(nn.LazyLinear(128), nn.Tanh(), nn.Linear(128, robots), nn.Unflatten(-1, (robots, 1)))
    critic = TensorDictModule(values, in_keys=["state"], out_keys=[("blue", "state_value")])
    critic(env.reset())
    loss = ClipPPOLoss(
        actor, critic, entropy_coeff=0.01, normalize_advantage=True, normalize_advantage_exclude_dims=(-2,)
    )
    loss.set_keys(
        reward=("blue", "reward"),
        action=("blue", "action"),
        sample_log_prob=("blue", "log_prob"),
        value=("blue", "state_value"),
        advantage=("blue", "advantage"),
        value_target=("blue", "value_target"),
        done=("blue", "done"),
        terminated=("blue", "terminated"),
    )
    loss.make_value_estimator(gamma=0.99, lmbda=0.95)
    optimizer = torch.optim.Adam(loss.parameters(), 3e-4)
    rewards, after = [], None
    for _ in range(frames // (worlds * STEPS)):
        with torch.no_grad():
            data = env.rollout(STEPS, actor, break_when_any_done=False, auto_reset=after is None, tensordict=after)
            # The next batch begins where this one ended.
            after = env.step_mdp(data[:, -1])
            after = env.maybe_reset(after)
            # An episode ends for all robots at once.
            for end in ("done", "terminated"):
                data["next", "blue", end] = data["next", end].unsqueeze(-2).expand_as(data["next", "blue", "reward"])
            loss.value_estimator(
                data, params=loss.critic_network_params, target_params=loss.target_critic_network_params
            )
        steps = data.reshape(-1)
        for _ in range(4):
            for some in torch.randperm(len(steps)).chunk(4):
                parts = loss(steps[some])
                sum(parts[name] for name in ("loss_objective", "loss_critic", "loss_entropy")).backward()
                nn.utils.clip_grad_norm_(loss.parameters(), 1.0)
                optimizer.step()
                optimizer.zero_grad()
        rewards.append(float(data["next", "blue", "reward"].mean()))
        ended = data["next", "done"].squeeze(-1)
        # Each robot of a team has the success of its team.
        won, over = int(data["next", "blue", "info", "success"][ended][:, 0].sum()), int(ended.sum())
        print(f"{len(rewards) * worlds * STEPS} steps, mean reward {rewards[-1]:.4f}, {won} of {over} episodes won")
    return rewards


if __name__ == "__main__":
    main(*map(int, sys.argv[1:3]), *sys.argv[3:])
