"""How often policies succeed in tasks."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from naoisis import _players
from naoisis._arguments import LARGEST_SEED, Scenario, count_of, seed_of
from naoisis._players import AnyPolicy
from naoisis._statistics import Estimate, bootstrap, mean_of_samples, share
from naoisis._tables import Columns
from naoisis._worlds import Worlds

if TYPE_CHECKING:
    import pandas
    from typing_extensions import Unpack

    from naoisis._worlds import WorldOptions

__all__ = ["RECORD_SEED", "Evaluation", "evaluate"]

DEVELOPMENT_SEED = 1

RECORD_SEED = 1_000_000_001
"""The seed of the first episode of results that are published. Policies must not be developed with the seeds from here on."""


@dataclass(frozen=True)
class Evaluation:
    """How a policy did in a task.

    Attributes:
        task: The task's name, or None if the scenario has none.
        episodes: The number of episodes.
        successes: The number of episodes that ended with success.
        success_rate: The share of these, with Wilson's interval, as ``naoisis challenge`` prints it.
        mean_return: The mean return, with the interval of a bootstrap over episodes. The return of an episode is the sum of the rewards; of
            several agents it is their mean.
        mean_steps: The mean number of steps of an episode.
        mean_time_s: The mean duration of an episode, s.
        mean_success_s: The mean duration of an episode with success, s, as ``naoisis challenge`` prints it; None if there was none.
        table: A row for each episode, in the order of their seeds: ``seed``, ``success``, ``return``, ``steps`` and ``seconds``.
    """

    task: str | None
    episodes: int
    successes: int
    success_rate: Estimate
    mean_return: Estimate
    mean_steps: float
    mean_time_s: float
    mean_success_s: float | None
    table: Columns

    def to_pandas(self) -> pandas.DataFrame:
        """The table as a data frame (needs pandas)."""
        import pandas

        return pandas.DataFrame(dict(self.table))

    def __str__(self) -> str:
        rate = self.success_rate
        value, low, high = (100.0 * share for share in (rate.value, rate.low, rate.high))
        after = "" if self.mean_success_s is None else f", after {self.mean_success_s:.1f} s on average"
        name = "" if self.task is None else f"{self.task}: "
        return (
            f"{name}{value:.1f} % of {self.episodes} succeed ({low:.1f} to {high:.1f}){after}; "
            f"mean return {self.mean_return:.3f}"
        )


def evaluate(
    policy: AnyPolicy,
    task: Scenario = "ScoreEmptyGoal",
    episodes: int = 100,
    seed: int | None = None,
    *,
    record: bool = False,
    num_envs: int | None = None,
    threads: int | None = None,
    **options: Unpack[WorldOptions],
) -> Evaluation:
    """Plays episodes of a task with a policy, and says how many succeed.

    >>> policy = naoisis.Policy("score.onnx")
    >>> print(naoisis.evaluate(policy, "ScoreEmptyGoal", episodes=200, realism="realistic"))
    >>> naoisis.evaluate(lambda seen: model.predict(seen, deterministic=True)[0], "ScoreEmptyGoal", observation="belief")

    It plays exactly the episodes with the seeds from ``seed`` on, each to its end. They start as those of ``naoisis challenge`` with
    the same seeds, and as those of environments that are reset with them. The result does not depend on ``num_envs`` and ``threads``: a
    :class:`naoisis.Policy` that draws its choices has random numbers of its own for each robot of an episode.

    Args:
        policy: An ONNX file or a :class:`naoisis.Policy`, which is played with its own observation, action and cycles per step; or a function
            of the observations of some robots, one row each, to their actions. The robots differ from step to step, so a policy with a
            memory has to be a :class:`naoisis.Policy`, or an object that has no ``__call__``, but the method ``act`` of one.
        task: A task's name (:func:`naoisis.tasks`), or a scenario as of :class:`naoisis.Match`.
        episodes: The number of episodes.
        seed: The seed of the first one; each further one has the next seed [default: 1, as of ``naoisis challenge``].
        record: Plays the seeds for results that are published, from ``naoisis.RECORD_SEED``.
        num_envs: How many are played at the same time [default: 16].
        threads: The number of threads [default: one per core].
        options: As of :class:`naoisis.MatchEnv`. By default all robots of the task are controlled, as in ``naoisis challenge``.

    Returns:
        The success rate, the mean return and others, and a table of the episodes.
    """
    count = count_of(episodes, "episodes", most=10_000_000)
    if record and seed is not None:
        raise ValueError(f"seed: {seed}, and record, which has its own seeds; expected only one of the two")
    begun = seed_of(seed)
    first = RECORD_SEED if record else DEVELOPMENT_SEED if begun is None else begun
    if first + count - 1 > LARGEST_SEED:
        raise ValueError(f"seed: {first} and {count - 1} further ones are out of range; expected 0 to {LARGEST_SEED}")
    at_once = count_of(_players.MOST_WORLDS if num_envs is None else num_envs, "num_envs", most=1_000_000)
    decides = _players.policy_of(policy)
    made: Any = {**_players.layout_of(decides), **options}
    worlds = Worlds(task, worlds=min(at_once, count), threads=threads, **made)
    player = _players.Player(decides)
    successes, steps = np.zeros(count, np.bool_), np.zeros(count, np.int64)
    returns, seconds = np.zeros(count), np.zeros(count)
    for ended in _players.play(worlds, [player] * len(worlds.agents), first, count):
        successes[ended.number], steps[ended.number] = bool(ended.successes[0]), ended.steps
        returns[ended.number], seconds[ended.number] = float(ended.returns.mean()), ended.truth["time_s"]
    seeds = np.arange(count, dtype=np.uint64) + np.uint64(first)
    return Evaluation(
        task=task if isinstance(task, str) else None,
        episodes=count,
        successes=int(successes.sum()),
        success_rate=share(int(successes.sum()), count),
        mean_return=bootstrap([returns], mean_of_samples)[0],
        mean_steps=float(steps.mean()),
        mean_time_s=float(seconds.mean()),
        mean_success_s=float(seconds[successes].mean()) if successes.any() else None,
        table=Columns(
            {"seed": seeds, "success": successes, "return": returns, "steps": steps, "seconds": seconds},
        ),
    )
