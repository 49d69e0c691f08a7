"""Every player against every other."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from naoisis import _naoisis, _players
from naoisis._arguments import LARGEST_SEED, Scenario, count_of, seed_of
from naoisis._batch import batch
from naoisis._players import AnyPolicy, Player
from naoisis._policies import Policy
from naoisis._statistics import Estimate, bootstrap, mean, mean_of_samples, share
from naoisis._tables import Columns
from naoisis._worlds import CommonOptions, Worlds
from naoisis.errors import MatchError

if TYPE_CHECKING:
    import pandas
    from typing_extensions import Unpack

__all__ = ["CrossPlay", "PairResult", "cross_play"]

# How the maximum-likelihood estimate of ratings ends, as in the command line.
ITERATIONS = 1000
END_CHANGE = 1e-6

COLUMNS = ("blue", "pink", "seed", "blue_goals", "pink_goals", "winner")


@dataclass(frozen=True)
class PairResult:
    """The matches of two players, as the first one sees them. Intervals are those of 95 % confidence.

    Attributes:
        first, second: Their names.
        matches: The number of matches, half of them from each side.
        repeated: Whether every seed played the same match, so that the intervals mean nothing.
        wins, draws, losses: The shares of the matches that the first one won, that nobody won, and that it lost.
        share_of_wins: Its share of the matches that somebody won.
        improvement: The probability of improvement: that it does better in a match, a draw being half of that.
        goals, goals_against, goal_difference: Its goals in a match, those of the second one, and their difference.
    """

    first: str
    second: str
    matches: int
    repeated: bool
    wins: Estimate
    draws: Estimate
    losses: Estimate
    share_of_wins: Estimate
    improvement: Estimate
    goals: Estimate
    goals_against: Estimate
    goal_difference: Estimate

    @property
    def is_first_better(self) -> bool | None:
        """Whether the first one is better, by its share of the wins; None if that is not sure."""
        if self.repeated or self.share_of_wins.low <= 0.5 <= self.share_of_wins.high:
            return None
        return self.share_of_wins.low > 0.5

    def reversed(self) -> PairResult:
        """The same matches as the second player sees them."""
        difference = self.goal_difference
        return replace(
            self,
            first=self.second,
            second=self.first,
            wins=self.losses,
            losses=self.wins,
            share_of_wins=_complement(self.share_of_wins),
            improvement=_complement(self.improvement),
            goals=self.goals_against,
            goals_against=self.goals,
            goal_difference=Estimate(-difference.value, -difference.high, -difference.low),
        )


@dataclass(frozen=True)
class CrossPlay:
    """The results of matches of each player against each other.

    Attributes:
        players: The names of the players.
        pairs: The results of each pair, in the order of their names.
        ratings: The ratings in Elo points, by the model of Bradley and Terry (1952), with the mean 0: a player with 400 points more than another scores
            10 times as much. One draw is added to each pair, so that a player without wins has a rating. They are those of
            ``naoisis batch --pairs``.
        table: A row for each match: the names of ``blue`` and ``pink``, ``seed``, ``blue_goals``, ``pink_goals``, and the name of the
            ``winner``, empty after a draw.
    """

    players: list[str]
    pairs: list[PairResult]
    ratings: dict[str, Estimate]
    table: Columns

    def against(self, first: str, second: str) -> PairResult:
        """The matches of two players as the first one sees them."""
        for pair in self.pairs:
            if (pair.first, pair.second) == (first, second):
                return pair
            if (pair.second, pair.first) == (first, second):
                return pair.reversed()
        raise KeyError(
            f"there are no matches of {first!r} against {second!r}; expected two of {', '.join(self.players)}"
        )

    def to_pandas(self) -> pandas.DataFrame:
        """The table of the matches as a data frame (needs pandas)."""
        import pandas

        return pandas.DataFrame(dict(self.table))

    def __str__(self) -> str:
        widest = max(len(name) for name in self.players)
        lines = []
        for pair in self.pairs:
            sure = {True: " beats ", False: " loses to ", None: " and "}[pair.is_first_better]
            shares = [f"{100.0 * each.value:.1f} %" for each in (pair.wins, pair.draws, pair.losses)]
            better = f"probability of improvement {pair.improvement:.2f}"
            played = f"{pair.matches} matches" + (", each seed the same" if pair.repeated else "")
            lines.append(
                f"{pair.first}{sure}{pair.second}: {played}, {shares[0]} wins, {shares[1]} draws, {shares[2]} losses; "
                f"{better}; goals {pair.goals.value:.2f} : {pair.goals_against.value:.2f}"
            )
        best = sorted(self.ratings.items(), key=lambda rated: -rated[1].value)
        lines += [f"{name:{widest}} {rating:+.0f}" for name, rating in best]
        return "\n".join(lines)


@dataclass(frozen=True)
class _Match:
    """A match that was played, and what tells it from others."""

    seed: int
    goals: tuple[int, int]
    winner: str
    end: Any


def cross_play(
    players: Mapping[str, AnyPolicy],
    scenario: Scenario = "match3v3",
    matches: int = 20,
    seed: int = 1,
    *,
    observation: str | None = None,
    num_envs: int | None = None,
    threads: int | None = None,
    **options: Unpack[CommonOptions],
) -> CrossPlay:
    """Plays matches of each player against each other, half of them from each side, with the same seeds.

    >>> results = naoisis.cross_play({"mine": "mine.onnx", "roles": "roles", "new": function}, matches=100, observation="belief")
    >>> print(results)
    >>> results.against("mine", "roles").goal_difference

    Matches of built-in teams and ONNX files are those of ``naoisis batch --pairs``. Those of functions are episodes of environments, whose seeds give
    other matches; but all matches of a pair are of one kind.

    Args:
        players: For each name a built-in team, such as ``"roles"``, an ONNX file or a :class:`naoisis.Policy`, which the match itself plays, or
            a function as of :func:`naoisis.evaluate`, which is called with the observations of its robots. In their frame each team attacks
            to the same side, so a function can play both colours.
        scenario: A scenario as of :class:`naoisis.Match`, whose teams are replaced; or a task's name, in which at least one of each two players
            has to be a policy or a function.
        matches: The number of matches of each pair: an even one.
        seed: The seed of the first match; each further one has the next seed. Every pair plays the same seeds from both sides.
        observation, options: What functions observe and do, and the realism and fields of the scenario, as of :class:`naoisis.MatchEnv`.
        num_envs, threads: As of :func:`naoisis.evaluate`.
    """
    if not isinstance(players, Mapping) or len(players) < 2:
        raise ValueError(f"players: expected a dictionary of at least two names and their players, not {players!r}")
    count = count_of(matches, "matches", least=2, most=10_000_000)
    if count % 2:
        raise ValueError(f"matches: {count} is odd; expected an even number, as half of the matches have changed sides")
    first = seed_of(seed)
    if first is None or first + count // 2 - 1 > LARGEST_SEED:
        raise ValueError(f"seed: {seed} cannot be the first of {count // 2}; expected 0 to {LARGEST_SEED}")
    if "control" in options or "opponents" in options:
        raise TypeError("control and opponents: both teams are played here; expected neither")
    if not all(isinstance(name, str) for name in players):
        raise TypeError(f"players: expected texts as names, not {list(players)!r}")
    unknown = [name for name in options if name not in CommonOptions.__annotations__]
    if unknown:
        raise TypeError(
            f"got an unexpected keyword argument {unknown[0]!r}; expected one of {', '.join(CommonOptions.__annotations__)}"
        )
    made: dict[str, Any] = {**options} if observation is None else {"observation": observation, **options}
    at_once = count_of(_players.MOST_WORLDS if num_envs is None else num_envs, "num_envs", most=1_000_000)
    table = _Table(scenario, first, count // 2, min(at_once, count // 2), threads, made)
    sides = {name: _side_of(player, name) for name, player in players.items()}
    rows: list[tuple[Any, ...]] = []
    pairs, scores = [], []
    for one, other in combinations(sides, 2):
        played = []
        for blue, pink in ((one, other), (other, one)):
            for match in table.play((blue, sides[blue]), (pink, sides[pink])):
                winner = {"blue": blue, "pink": pink}.get(match.winner, "")
                rows.append((blue, pink, match.seed, *match.goals, winner))
                played.append((match, blue == one))
        pair, score = _result_of(one, other, played)
        pairs.append(pair)
        scores.append(score)
    names = list(sides)
    of_pairs = list(combinations(range(len(names)), 2))
    ratings = bootstrap(scores, _elo_points(len(names), of_pairs, [len(score) for score in scores]))
    kinds = (object, object, np.uint64, np.int64, np.int64, object)
    columns = {name: np.array(cells, kind) for name, kind, cells in zip(COLUMNS, kinds, zip(*rows))}
    return CrossPlay(names, pairs, dict(zip(names, ratings)), Columns(columns))


@dataclass(frozen=True)
class _Side:
    """How a player plays: as a team by its name in a match, or by a policy in Python."""

    word: str | None
    policy: Any


def _side_of(player: AnyPolicy, name: str) -> _Side:
    if isinstance(player, (str, os.PathLike)):
        path = os.fspath(player)
        if not path.endswith(".onnx"):
            return _Side(path, None)
        policy: Any = Policy(path)
        return _Side(f"policy:{path}", policy)
    policy = _players.policy_of(player, f"players: {name}")
    return _Side(f"policy:{policy._path}" if isinstance(policy, Policy) else None, policy)


@dataclass(frozen=True)
class _Table:
    """Where two players meet."""

    scenario: Scenario
    first_seed: int
    matches: int
    worlds: int
    threads: int | None
    options: dict[str, Any]

    def play(self, blue: tuple[str, _Side], pink: tuple[str, _Side]) -> list[_Match]:
        """The matches of two players, each with its name, in the order of their seeds."""
        functions = [side for side in (blue, pink) if side[1].word is None]
        if functions:
            return self._with_functions(blue, pink, [name for name, _ in functions])
        if not self._is_task():
            return self._built_in(str(blue[1].word), str(pink[1].word))
        policies = [name for name, side in (blue, pink) if side.policy is not None]
        if not policies:
            raise ValueError(
                f"players: {blue[0]} and {pink[0]} are teams, and {self.scenario} is a task; expected a scenario, such as "
                "'match3v3', or a policy"
            )
        return self._with_functions(blue, pink, policies[:1])

    def _is_task(self) -> bool:
        if not isinstance(self.scenario, str):
            return False
        name = self.scenario
        for suffix in ("_unseen", "_images", "_unseen"):
            name = name.removesuffix(suffix)
        return any(name == task for task, _, _ in _naoisis.challenges())

    def _built_in(self, blue: str, pink: str) -> list[_Match]:
        # What functions observe and do says nothing of a match without them.
        ignored = [name for name in ("draws",) if self.options.get(name)]
        if ignored or not isinstance(self.options.get("realism"), (str, type(None))):
            name = ignored[0] if ignored else "realism"
            raise ValueError(
                f"{name}: matches of built-in teams and files have one scenario; expected no draws and one level of realism"
            )
        played = batch(
            self.scenario,
            self.matches,
            self.first_seed,
            self.options.get("set"),
            self.threads,
            blue=blue,
            pink=pink,
            realism=self.options.get("realism"),
        )
        summary = played.summary()[0]
        if summary["failed"]:
            note = next((str(note) for note in played["note"] if str(note) != "nan" and note), "see naoisis batch")
            raise MatchError(f"{summary['failed']} matches of {blue} and {pink} failed: {note}")
        columns = [played[name].tolist() for name in ("seed", "blue_goals", "pink_goals", "winner", "digest")]
        return [_Match(seed, (ours, theirs), str(won), end) for seed, ours, theirs, won, end in zip(*columns)]

    def _with_functions(
        self, blue: tuple[str, _Side], pink: tuple[str, _Side], controlled: Sequence[str]
    ) -> list[_Match]:
        sides = {"blue": blue, "pink": pink}
        control = [colour for colour, (name, _) in sides.items() if name in controlled]
        others = [str(side.word) for name, side in sides.values() if name not in controlled]
        policies = [sides[colour][1].policy for colour in control]
        # What the options do not say is as the first policy of a file wants it.
        layouts = [layout for layout in map(_players.layout_of, policies) if layout]
        options = {**(layouts[0] if layouts else {}), **self.options}
        worlds = Worlds(
            self.scenario,
            worlds=self.worlds,
            threads=self.threads,
            control=control,
            opponents=others[0] if others else None,
            **options,
        )
        deciding = {colour: Player(sides[colour][1].policy, f"players: {sides[colour][0]}") for colour in control}
        players = [deciding[robot[:4]] for robot in worlds.agents]
        matches: dict[int, _Match] = {}
        for ended in _players.play(worlds, players, self.first_seed, self.matches):
            game = ended.truth["game"]
            score, shots = game["score"], game["shoot_out"]
            goals = (int(score["blue"]), int(score["pink"]))
            decisive = (
                goals if goals[0] != goals[1] or shots is None else (shots["goals"]["blue"], shots["goals"]["pink"])
            )
            winner = "" if decisive[0] == decisive[1] else "blue" if decisive[0] > decisive[1] else "pink"
            end = repr((ended.steps, ended.truth["ball"], ended.truth["robots"]))
            matches[ended.number] = _Match(self.first_seed + ended.number, goals, winner, end)
        return [matches[number] for number in range(self.matches)]


def _result_of(first: str, second: str, played: list[tuple[_Match, bool]]) -> tuple[PairResult, np.ndarray]:
    """The result of the matches of two players, each with whether the first one was blue, and its scores in them."""
    goals = np.array([match.goals if is_blue else match.goals[::-1] for match, is_blue in played], float)
    mine = ["blue" if is_blue else "pink" for _, is_blue in played]
    won = [match.winner for match, _ in played]
    scores = np.array(
        [0.5 if winner not in ("blue", "pink") else float(winner == own) for winner, own in zip(won, mine)]
    )
    wins, losses, count = int((scores == 1.0).sum()), int((scores == 0.0).sum()), len(played)
    ends = [{match.end for match, is_blue in played if is_blue == side} for side in (True, False)]
    result = PairResult(
        first=first,
        second=second,
        matches=count,
        repeated=count > 2 and all(len(of_side) == 1 for of_side in ends),
        wins=share(wins, count),
        draws=share(count - wins - losses, count),
        losses=share(losses, count),
        share_of_wins=share(wins, wins + losses),
        improvement=bootstrap([scores], mean_of_samples)[0],
        goals=mean(goals[:, 0]),
        goals_against=mean(goals[:, 1]),
        goal_difference=mean(goals[:, 0] - goals[:, 1]),
    )
    return result, scores


def _complement(estimate: Estimate) -> Estimate:
    return Estimate(1.0 - estimate.value, 1.0 - estimate.high, 1.0 - estimate.low)


def _elo_points(
    players: int, pairs: Sequence[tuple[int, int]], matches: Sequence[int]
) -> Callable[[Sequence[np.ndarray]], np.ndarray]:
    """What computes ratings from the scores of the first player of each pair, for :func:`bootstrap`."""
    first, second = (np.array([pair[side] for pair in pairs]) for side in (0, 1))
    # One draw is added to each pair.
    counts = np.array(matches, float) + 1.0
    mine, theirs = (np.eye(players)[side] for side in (first, second))

    def points(scores: Sequence[np.ndarray]) -> np.ndarray:
        sums = np.stack([np.sum(score, axis=-1) for score in scores], axis=-1) + 0.5
        won = sums @ mine + (counts - sums) @ theirs
        strengths = np.ones_like(won)
        for _ in range(ITERATIONS):
            expected = (counts / (strengths[..., first] + strengths[..., second])) @ (mine + theirs)
            following = won / expected
            change = np.max(np.abs(following / strengths - 1.0))
            strengths = following
            if change < END_CHANGE:
                break
        rated = 400.0 * np.log10(strengths)
        centred: np.ndarray = rated - rated.mean(axis=-1, keepdims=True)
        return centred

    return points
