"""naoisis: a simulator of humanoid robot soccer with coarse motion and strict perception.

A match in three lines::

    import naoisis
    match = naoisis.Match("match3v3", seed=1)
    match.run(); match.score

Robots know only what their cameras, sonars, odometry and team messages tell them, in Python as in every other
interface. The truth is separate, in :meth:`Match.truth`.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from naoisis import environments
from naoisis._arguments import Scenario
from naoisis._batch import Batch, batch
from naoisis._cross_play import CrossPlay, PairResult, cross_play
from naoisis._evaluation import RECORD_SEED, Evaluation, evaluate
from naoisis._match import Match
from naoisis._naoisis import LABELS, Environments, __version__, challenges
from naoisis._pages import Page, show
from naoisis._policies import Policy, export_policy
from naoisis._rewards import BatchReward, Steps, batch_reward
from naoisis._statistics import Estimate
from naoisis._traces import Trace, read_beliefs, read_tables, read_trace, trace_lines
from naoisis.environments import MatchEnv, VectorEnv, vector_env
from naoisis.errors import MatchError, NaoisisError, ScenarioError, SnapshotError, TraceError

__all__ = [
    "LABELS",
    "RECORD_SEED",
    "Batch",
    "BatchReward",
    "CrossPlay",
    "Estimate",
    "Evaluation",
    "Match",
    "MatchEnv",
    "MatchError",
    "NaoisisError",
    "Page",
    "PairResult",
    "Policy",
    "ScenarioError",
    "SnapshotError",
    "Steps",
    "Trace",
    "TraceError",
    "VectorEnv",
    "__version__",
    "batch",
    "batch_reward",
    "cross_play",
    "evaluate",
    "export_policy",
    "parallel_env",
    "read_beliefs",
    "read_tables",
    "read_trace",
    "rewards",
    "show",
    "tasks",
    "trace_lines",
    "vector_env",
]

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from naoisis._worlds import CommonOptions
    from naoisis.parallel import MatchParallelEnv


def tasks() -> dict[str, str]:
    """The named tasks with their descriptions. Gymnasium knows them as ``naoisis/NAME-vN``."""
    return {name: description for name, _, description in challenges()}


def rewards() -> dict[str, str]:
    """The terms of rewards with their descriptions."""
    return dict(Environments.rewards())


def parallel_env(
    scenario: Scenario = "match3v3",
    control: str | Iterable[str] | None = None,
    opponents: str | Sequence[str] | None = None,
    observation: str = "perception",
    *,
    render_mode: str | None = None,
    **options: Unpack[CommonOptions],
) -> MatchParallelEnv:
    """The robots of a match, or of a task, as an environment of PettingZoo (needs ``naoisis[pettingzoo]``).

    >>> env = naoisis.parallel_env("match3v3", control="blue", opponents="roles", observation="belief")
    >>> observations, infos = env.reset(seed=1)

    Args:
        scenario: A task's name (:func:`tasks`), or a scenario as of :class:`Match`.
        control: A team, ``"blue"``, or robots, such as ``["blue1", "pink2"]`` [default: the task's].
        opponents: The name of the other team, if the scenario has teams; from a list of names one is drawn for each episode.
        observation, action, reward, cycles_per_step, set, realism, draws, extras, observed_robots, says, statistics, camera, image_size, render_mode: As of :class:`MatchEnv`.
    """
    from naoisis import parallel

    return parallel.parallel_env(scenario, control, opponents, observation, render_mode=render_mode, **options)


environments.register()
