"""Learned policies: written as files that naoisis plays, and computed as in a match."""

from __future__ import annotations

import inspect
import json
import os
import tempfile
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import gymnasium
import numpy as np

from naoisis import _naoisis

if TYPE_CHECKING:
    from torch import nn

CHOICES = ("likeliest", "drawn")

# A network of single precision has sums in another order in every library.
GREATEST_DIFFERENCE = 1e-3

# Wrappers in which a module means something else by its actions, or sees something else.
CHANGING: dict[type, str] = {
    gymnasium.ActionWrapper: "actions",
    gymnasium.ObservationWrapper: "observations",
    gymnasium.vector.VectorActionWrapper: "actions",
    gymnasium.vector.VectorObservationWrapper: "observations",
}


class Policy:
    """A learned policy as matches play it: the network of an ONNX file and the layout beside it, without the library that trained it.

    >>> policy = naoisis.Policy("score.onnx")
    >>> action = policy(observation)                 # of one robot, or of several, one row each

    It can be an opponent in :meth:`naoisis.self_play.SelfPlay.add`, which keeps the recurrent state of each
    robot. Like all of naoisis, it computes the same numbers on every machine.

    Args:
        path: The ONNX file. Its layout, ``score.json``, is beside it.
        seed: The seed of a policy that draws its choices.

    Attributes:
        layout: The layout: observation, action, cycles_per_step, choice.
    """

    def __init__(self, path: str | os.PathLike[str], seed: int = 0):
        self._path = os.fspath(path)
        self._inner = _naoisis.Policy(path)
        self._seed, self._random = seed, np.random.default_rng(seed)
        self._states: list[list[list[float]]] = []
        self.layout = self._inner.layout()

    def __getstate__(self) -> dict[str, Any]:
        return {name: value for name, value in self.__dict__.items() if name != "_inner"}

    def __setstate__(self, state: dict[str, Any]) -> None:
        self.__dict__.update(state)
        self._inner = _naoisis.Policy(self._path)

    def reset(self) -> None:
        """Sets the recurrent state to zero, as at the start of an episode."""
        self._states = []

    def scores(self, observation: Any) -> np.ndarray:
        """The outputs of the network: the numbers of a continuous action, or the scores of the choices, all lists in a row.

        A recurrent policy keeps its state from call to call until :meth:`reset`; then the rows must be the same robots in each call.
        """
        observed = np.asarray(observation, np.float32)
        if observed.ndim not in (1, 2):
            raise ValueError(
                f"observation: expected one row of numbers, or several, not an array of shape {observed.shape}"
            )
        rows = np.atleast_2d(observed)
        states = self._states or [[] for _ in rows]
        if len(states) != len(rows) and any(states):
            raise ValueError(
                f"observation: {len(rows)} rows after {len(states)}; expected as many as before, or `reset` first"
            )
        if len(states) != len(rows):
            states = [[] for _ in rows]
        outputs, self._states = self._outputs(rows, states)
        return outputs if observed.ndim == 2 else outputs[0]

    def _outputs(self, rows: np.ndarray, states: list[list[list[float]]]) -> tuple[np.ndarray, list[list[list[float]]]]:
        answers = [self._inner.outputs(np.ascontiguousarray(row), state) for row, state in zip(rows, states)]
        return np.stack([outputs for outputs, _ in answers]), [state for _, state in answers]

    def __call__(self, observation: Any) -> np.ndarray:
        """The action for an observation, or one for each row of observations, as the environments take them."""
        return self._actions(self.scores(observation))

    def act(
        self,
        observations: Any,
        states: list[list[list[float]]],
        randoms: Sequence[np.random.Generator] | None = None,
    ) -> tuple[np.ndarray, list[list[list[float]]]]:
        """Returns the actions of several robots, and their recurrent states after them.

        Args:
            observations: One row for each robot.
            states: The state of each robot after its last action; empty at the start of an episode, and for policies without a state.
            randoms: The random numbers of each robot, for a policy that draws its choices [default: those of the policy for all robots].
        """
        outputs, states = self._outputs(np.asarray(observations, np.float32), states)
        return self._actions(outputs, randoms), states

    def random_of(self, episode: int, robot: int) -> np.random.Generator:
        """Returns the random numbers of a robot in the episode with this seed, for :meth:`act`. They depend on the policy's seed, too."""
        return np.random.default_rng([self._seed, episode, robot])

    def _actions(self, scores: np.ndarray, randoms: Sequence[np.random.Generator] | None = None) -> np.ndarray:
        counts, numbers, length = self._inner.choices(), self._inner.numbers(), scores.shape[-1]
        if length not in (numbers, sum(counts)):
            expected = f"{sum(counts)} scores, or {numbers} choices" if counts else f"{numbers} numbers"
            raise ValueError(
                f"the policy answers {length} numbers; expected {expected} of the action {self.layout['action']!r}"
            )
        if not counts:
            return scores
        if length == numbers:
            chosen = scores.astype(np.int64)
        else:
            lists = np.split(scores, np.cumsum(counts)[:-1], axis=-1)
            chosen = np.stack([self._choose(scores, randoms) for scores in lists], axis=-1)
        return chosen[..., 0] if self.layout["action"] == "discrete" else chosen

    def check_choices(self, scores: np.ndarray) -> None:
        """Raises a ValueError if ``scores``, rows of :meth:`scores`, are choices themselves and not all of them are choices of the action."""
        counts = self._inner.choices()
        if not counts or scores.shape[-1] != self._inner.numbers():
            return
        if not np.all((scores >= 0) & (scores < counts) & (scores == np.floor(scores))):
            raise ValueError(
                f"module: it answers {scores[0]}; expected {sum(counts)} scores, or {len(counts)} choices, whole numbers below {counts}"
            )

    def _choose(self, scores: np.ndarray, randoms: Sequence[np.random.Generator] | None) -> np.ndarray:
        if self._inner.draws():
            # The largest of scores with Gumbel noise is a draw from their softmax.
            if randoms is None:
                scores = scores + self._random.gumbel(size=scores.shape)
            else:
                scores = scores + [random.gumbel(size=scores.shape[-1]) for random in randoms]
        chosen: np.ndarray = np.argmax(scores, axis=-1)
        return chosen


def export_policy(
    module: nn.Module,
    path: str | os.PathLike[str],
    env: Any,
    *,
    choice: str = "likeliest",
    state: Mapping[str, Sequence[int]] | None = None,
    interactions: int | None = None,
    note: str = "",
) -> Policy:
    """Writes a module of PyTorch as a policy that naoisis plays: ``NAME.onnx`` and its layout ``NAME.json`` (needs ``naoisis[torch]``).

    >>> policy = naoisis.export_policy(network, "score.onnx", env)

    Then ``naoisis challenge ScoreEmptyGoal --policy score.onnx`` measures it, and in a scenario ``"behaviour": {"policy": "score.onnx"}``
    plays it. The written policy is compared with the module on observations of ``env``; if they differ, a :class:`ValueError` says so.

    Args:
        module: It is called with observations, one row each, and returns the numbers of a continuous action, or the scores (logits) of
            the choices, all lists in a row.
        path: The ONNX file to write.
        env: The environment in which it was trained, of any library of this package: it knows observation, action and cycles per step.
        choice: ``"likeliest"``, or ``"drawn"`` with the probabilities of a softmax of the scores.
        state: The names and shapes of recurrent states. The module is called with the observations and then with each of them, and
            returns the outputs and each of them after the step. Their first value is 0.
        interactions: The number of interactions that it was trained with: steps of environments or of demonstrations, counted for each
            agent. Leaderboards show it.
        note: How the policy was made, for people.

    Returns:
        The policy, read back.
    """
    import torch

    path = Path(path)
    if path.suffix != ".onnx":
        raise ValueError(f"path: expected a name that ends in .onnx, not {str(path)!r}")
    if choice not in CHOICES:
        raise ValueError(f"choice: there is no {choice!r}; expected {' or '.join(CHOICES)}")
    worlds = _worlds_of(env)
    if worlds.image_shape:
        raise ValueError("env: its observation is an image; expected `perception`, `belief` or `body`")
    names = dict(state or {})
    observations = _observations(worlds)
    states = [torch.zeros(*shape) for shape in names.values()]
    layout = {
        "observation": worlds.observation,
        "action": worlds.action,
        **({"extras": worlds.extras} if worlds.extras else {}),
        "cycles_per_step": worlds.inner.cycles_per_step,
        "choice": choice,
        "state": [{"input": name, "output": f"{name}_after"} for name in names],
        **_others(worlds.observation_names),
        **({} if interactions is None else {"interactions": interactions}),
        "note": note,
    }
    # The exporter by default needs one more package.
    has_dynamo = "dynamo" in inspect.signature(torch.onnx.export).parameters
    exporter: dict[str, Any] = {"dynamo": False} if has_dynamo else {}
    if not names:
        # One run for all robots of a team.
        exporter["dynamic_axes"] = {"observation": {0: "robots"}, "action": {0: "robots"}}
    # An earlier policy of this name stays until this one has been checked.
    with (
        _resting(module),
        warnings.catch_warnings(),
        tempfile.TemporaryDirectory(prefix=".export", dir=path.parent) as folder,
    ):
        written = Path(folder) / path.name
        # Of the exporter's own changes in later versions.
        warnings.simplefilter("ignore")
        torch.onnx.export(
            module,
            (torch.from_numpy(observations[:1]), *states),
            str(written),
            input_names=["observation", *names],
            output_names=["action", *(f"{name}_after" for name in names)],
            opset_version=17,
            **exporter,
        )
        written.with_suffix(".json").write_text(json.dumps(layout, indent=2) + "\n")
        _compare(_written(written), module, observations, states)
        for suffix in (".onnx", ".json"):
            os.replace(written.with_suffix(suffix), path.with_suffix(suffix))
    return Policy(path)


def _written(path: Path) -> Policy:
    """The policy of files that have just been written. Errors are of the module, not of the files."""
    try:
        return Policy(path)
    except ValueError as error:
        of_files = (f"{path.with_suffix(suffix)}: " for suffix in (".onnx", ".json"))
        problem = str(error)
        for prefix in of_files:
            problem = problem.removeprefix(prefix)
        raise ValueError(f"module: {problem}") from None


def _others(names: Sequence[str]) -> dict[str, int]:
    """How many robots of both teams are in an observation, so that the policy plays in matches with other numbers, too."""
    groups = {name.split(".")[0] for name in names}
    if "ball" not in groups:
        return {}
    return {f"{other}s": sum(group.startswith(other) for group in groups) for other in ("team_mate", "opponent")}


@contextmanager
def _resting(module: nn.Module) -> Iterator[None]:
    """A module in its mode for use, on the processor; afterwards it is as it was, and so are its parts."""
    device = next((parameter.device for parameter in module.parameters()), None)
    was_training = {part: part.training for part in module.modules()}
    module.cpu().eval()
    try:
        yield
    finally:
        module.to(device)
        for part, training in was_training.items():
            part.training = training


def _worlds_of(env: Any) -> Any:
    """The worlds of an environment, under all wrappers, none of which may change observations or actions."""
    for _ in range(100):
        if getattr(env, "obs_rms", None) is not None:
            raise ValueError(
                f"env: {type(env).__name__} normalises observations; expected a module that does it itself"
            )
        for kind, what in CHANGING.items():
            if isinstance(env, kind):
                raise ValueError(f"env: {type(env).__name__} changes {what}; expected a module that does it itself")
        if hasattr(env, "_worlds"):
            return env._worlds
        inner = next((getattr(env, name) for name in ("envs", "venv", "unwrapped", "env") if hasattr(env, name)), env)
        if inner is env:
            break
        env = inner
    raise TypeError(f"env: expected an environment of naoisis, not {env!r}")


def _observations(worlds: Any) -> np.ndarray:
    """Some observations, one row each, of all that there can be."""
    space = worlds.observation_space
    least, greatest = np.maximum(space.low, -10.0), np.minimum(space.high, 10.0)
    return np.random.default_rng(0).uniform(least, greatest, (16, *space.shape)).astype(np.float32)


def _compare(policy: Policy, module: nn.Module, observations: np.ndarray, states: list[Any]) -> None:
    """Plays some steps with the written policy and with its module.

    Raises:
        ValueError: Their outputs differ, or have another length than the action.
    """
    import torch

    policy.reset()
    answers = []
    with torch.no_grad():
        for step, row in enumerate(observations):
            answer = module(torch.from_numpy(row[None]), *states)
            expected, *after = answer if isinstance(answer, tuple) else (answer,)
            # Without a recurrent state, each step stands for itself.
            states = after if states else states
            own = policy.scores(row)
            answers.append(own)
            if not _is_near(own, expected.numpy()[0]):
                raise ValueError(f"step {step}: the module answers {expected.numpy()[0]}, and what was written {own}")
        # Matches ask for all robots of a policy at once.
        if not states and not _is_near(np.stack(answers), module(torch.from_numpy(observations)).numpy()):
            raise ValueError(
                "module: it answers otherwise for several rows than for each of them; expected rows of their own"
            )
    policy.check_choices(np.stack(answers))
    policy(observations[0])
    policy.reset()


def _is_near(own: np.ndarray, expected: np.ndarray) -> bool:
    """Whether answers are the same but for rounding, and numbers."""
    return bool(np.abs(own - expected).max() <= GREATEST_DIFFERENCE * (1.0 + np.abs(own).max()))
