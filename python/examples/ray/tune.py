"""Optimises the parameters of a behaviour with Ray Tune, on all machines of Ray's cluster: ``python tune.py [tries]``.

The behaviour is that of ``by_hand.py``. The objective is its success rate: the share of episodes of ``ScoreEmptyGoal`` in which it scores
within 11 seconds. Needs ``pip install naoisis[tune]``.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import ray
from ray import tune
from ray.tune.search import BasicVariantGenerator

import naoisis

FOLDERS = [str(Path(__file__).resolve().parent), str(Path(__file__).resolve().parent.parent / "ppo")]
sys.path[:0] = FOLDERS
from by_hand import Kicker
from policy import success_rate

TASK, LIMIT_S = "ScoreEmptyGoal", 11
SPACE = {
    "behind_m": tune.uniform(0.0, 0.5),
    "aim_deg": tune.uniform(5, 45),
    "turn_deg": tune.uniform(15, 90),
    "goal_m": tune.uniform(0.1, 0.7),
}


def success(parameters: dict[str, float], episodes: int, seed: int) -> float:
    """Returns the success rate of the behaviour with ``parameters``, in at least ``episodes`` episodes. ``seed`` is the seed of the first
    world."""
    env = naoisis.MatchEnv(TASK, observation="belief", action="discrete")
    decide = Kicker(env.observation_names, env.action_names[0], **parameters)
    return success_rate(TASK, "belief", decide, episodes, seed, threads=1, set={"duration_s": LIMIT_S})


def main(tries: int = 20, episodes: int = 64, out: str | None = None) -> tuple[dict[str, float], float]:
    """Tests ``tries`` random sets of parameters in ``episodes`` episodes each. Returns the best set and its success rate in four times as
    many other episodes, which were not used for the choice. Ray Tune writes its results to the folder ``out``."""
    if not ray.is_initialized():
        # Ray's worker processes import `by_hand` and `policy` from the same folders as this process.
        found = {"env_vars": {"PYTHONPATH": os.pathsep.join(FOLDERS)}}
        ray.init(include_dashboard=False, log_to_driver=False, runtime_env=found)

    def attempt(parameters: dict[str, float]) -> dict[str, float]:
        return {"success": success(parameters, episodes, seed=1)}

    draw = BasicVariantGenerator(random_state=1)
    settings = tune.TuneConfig(metric="success", mode="max", num_samples=tries, search_alg=draw)
    files = tune.RunConfig(storage_path=out)
    tuner = tune.Tuner(
        tune.with_resources(attempt, {"cpu": 1}), param_space=SPACE, tune_config=settings, run_config=files
    )
    best = tuner.fit().get_best_result()
    tried = {"best": best.config, "default": {}}
    others = {name: success(parameters, 4 * episodes, 1_000_000) for name, parameters in tried.items()}
    print(
        f"the best of {tries} sets of parameters: "
        + ", ".join(f"{name} {value:.2f}" for name, value in best.config.items())
    )
    print(
        f"it scores in {best.metrics['success']:.1%} of {episodes} episodes, and in {others['best']:.1%} of {4 * episodes} test episodes;"
    )
    print(f"with its default parameters the behaviour scores in {others['default']:.1%} of the same test episodes")
    return best.config, others["best"]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("tries", type=int, nargs="?", default=20)
    parser.add_argument(
        "--episodes", type=int, default=64, help="the number of episodes for each set of parameters [%(default)s]"
    )
    parser.add_argument("--out", help="the folder for the results of Ray Tune [default: ~/ray_results]")
    main(**vars(parser.parse_args()))
