"""Collects experience from a batch of worlds with TorchRL: ``python main.py [frames]``.

TorchRL resets finished episodes itself, and therefore needs ``autoreset_mode="disabled"``.
"""

from __future__ import annotations

import sys

import torch
from tensordict.nn import TensorDictModule
from torch import nn
from torchrl.collectors import Collector
from torchrl.envs import GymWrapper
from torchrl.modules import OneHotCategorical, ProbabilisticActor

import naoisis


def main(frames: int = 8192) -> int:
    """Collects ``frames`` environment steps, summed over 16 worlds, with an untrained policy. Returns the number of finished episodes."""
    torch.manual_seed(1)
    envs = naoisis.vector_env(
        "ScoreEmptyGoal", 16, observation="belief", action="discrete", autoreset_mode="disabled", set={"duration_s": 5}
    )
    env = GymWrapper(envs)
    logits = nn.Sequential(nn.LazyLinear(64), nn.Tanh(), nn.Linear(64, envs.single_action_space.n))
    policy = ProbabilisticActor(
        TensorDictModule(logits, in_keys=["observation"], out_keys=["logits"]),
        in_keys=["logits"],
        out_keys=["action"],
        distribution_class=OneHotCategorical,
    )
    collector = Collector(env, policy, frames_per_batch=2048, total_frames=frames)
    ends = 0
    for data in collector:
        ends += int(data["next", "done"].sum())
        print(
            f"{data.numel()} steps, {ends} episodes over, mean reward {data['next', 'reward'].mean():.4f}", flush=True
        )
    collector.shutdown()
    return ends


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
