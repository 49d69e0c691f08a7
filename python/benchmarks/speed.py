"""Measures how fast Python steps worlds, and prints each figure beside the required one, and VMAS's speed for comparison.

Run ``python benchmarks/speed.py [seconds]`` in the folder ``python``, with an optimised build (``pip install .``) on a machine that runs
nothing else. ``seconds`` is the duration of each measurement.
"""

from __future__ import annotations

import os
import resource
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import naoisis

SECONDS = float(sys.argv[1]) if len(sys.argv) > 1 else 1.5
CORES = os.cpu_count() or 1
IMAGE = {"cameras.render": "software", "cameras.which": "top"}


def rate(step: Callable[[], object], each: int = 1) -> float:
    """Returns how many units per second ``step`` does, if each call does ``each`` units: the best of three measurements."""
    step()
    best = 0.0
    for _ in range(3):
        begun, count = time.perf_counter(), 0
        while time.perf_counter() - begun < SECONDS:
            step()
            count += each
        best = max(best, count / (time.perf_counter() - begun))
    return best


class Timed:
    """Wraps the compiled part of an environment, and measures the time spent in its steps, ``busy_s``, s."""

    def __init__(self, inner: Any):
        self.inner, self.busy_s = inner, 0.0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.inner, name)

    def step(self, *arguments: Any) -> None:
        begun = time.perf_counter()
        self.inner.step(*arguments)
        self.busy_s += time.perf_counter() - begun


def vector_env(scenario: Any = "match3v3", worlds: int = 64, cycles: int = 3, **options: Any) -> tuple[float, float]:
    """Returns the simulated cycles per second, summed over ``worlds`` worlds, and the share of the time spent in Python.

    ``cycles`` is the number of cycles for each action.
    """
    env = naoisis.vector_env(scenario, worlds, cycles_per_step=cycles, autoreset_mode="same_step", **options)
    env.reset(seed=1)
    actions = np.random.default_rng(1).uniform(-1, 1, env.action_space.shape).astype(np.float32)
    timed = env._worlds.inner = Timed(env._worlds.inner)
    begun = time.perf_counter()
    figure = rate(lambda: env.step(actions), worlds * cycles)
    return figure, 1 - timed.busy_s / (time.perf_counter() - begun)


def match(cycles: int, scenario: Any = "match3v3", **options: Any) -> float:
    """Returns the duration of a cycle in a match that is stepped by ``cycles`` cycles at a time, s."""
    played = naoisis.Match(scenario, set={**options.pop("set", LONG)}, **options)
    return 1 / rate(lambda: played.step(cycles=cycles), cycles)


def megabytes() -> float:
    """Returns the resident memory of this process, MB."""
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * resource.getpagesize() / 1e6


def vmas() -> float | None:
    """Returns the steps per second of VMAS's football, three against three, summed over 1,024 worlds in a batch, or None if VMAS is not
    installed."""
    try:
        import torch
        import vmas as peer
    except ImportError:
        return None
    torch.set_num_threads(1)
    env = peer.make_env("football", 1024, device="cpu", n_blue_agents=3, n_red_agents=3, ai_red_agents=True)
    env.reset()
    actions = [torch.rand(1024, env.get_agent_action_size(agent)) * 2 - 1 for agent in env.agents]
    return rate(lambda: env.step(actions), 1024)


def say(name: str, figure: str, wanted: str = "") -> None:
    """Prints a row of the table: what was measured, the figure, and the required figure or a remark."""
    print(f"{name:68} {figure:>18}   {wanted}", flush=True)


def main() -> None:
    team = {"control": "blue", "opponents": "roles"}
    before = megabytes()
    kept = naoisis.vector_env("match3v3", 64, **team)
    kept.reset(seed=1)
    say("memory per world, 64 worlds of 3v3", f"{(megabytes() - before) / 64:.2f} MB", "at most 3 MB")
    del kept
    one, share = vector_env(threads=1, **team)
    say("vector_env, 3v3, 64 worlds, roles, perceptions, 1 thread", f"{one:,.0f} cycles/s", "at least 15,000")
    say("  share of the time spent in Python and in copying", f"{share:.1%}", "at most 15 %")
    many, _ = vector_env(threads=CORES, **team)
    say(f"  on {CORES} threads", f"{many:,.0f} cycles/s", f"{many / one:.2f} times one thread; at least 1.8 on two")
    figure, share = vector_env(STANDING, threads=1, control="blue", observation="truth")
    alone, _ = vector_env(threads=1, cycles=1, **team)
    say("  on 1 thread, one action per cycle (worlds do not stay in the cache)", f"{alone:,.0f} cycles/s")
    say(
        "  on 1 thread, standing robots, observation truth",
        f"{figure:,.0f} cycles/s",
        f"at least 30,000; Python {share:.1%}",
    )
    for observation in ("belief", "truth"):
        figure, _ = vector_env(threads=1, observation=observation, **team)
        say(f"vector_env, roles, observation {observation}, 1 thread", f"{figure:,.0f} cycles/s")
    for observation in ("perception", "belief", "truth"):
        for worlds in (1, 64, 256):
            figure, _ = vector_env(worlds=worlds, threads=1, control=["blue", "pink"], observation=observation)
            say(
                f"vector_env, six agents, {observation}, {worlds} worlds, 1 thread",
                f"{figure / 3:,.0f} steps/s",
                "of 0.1 s",
            )
    figure, share = vector_env("ScoreEmptyGoal", threads=1, observation="belief", action="continuous")
    say("vector_env, ScoreEmptyGoal, beliefs, 1 thread", f"{figure:,.0f} cycles/s", f"Python {share:.1%}")
    peer = vmas()
    say(
        "VMAS, football, 3v3, 1,024 worlds, perfect knowledge, 1 thread",
        "not installed" if peer is None else f"{peer:,.0f} steps/s",
    )
    for height, width in ((48, 64), (240, 320)):
        size = {"cameras.width": width, "cameras.height": height}
        alone = 1 / match(20, SEER, set={**IMAGE, **size})
        figure, _ = vector_env(SEER, 8, 1, threads=1, control="blue1", observation="image", image_size=(height, width))
        say(
            f"images of {width} x {height}, 1 thread",
            f"{figure:,.0f} images/s",
            f"{figure / alone:.0%} of the renderer alone ({alone:,.0f}); at least 80 %",
        )
    for name, options in (("roles against chasers", {}), ("robots without behaviour", {"control": ["blue", "pink"]})):
        alone, single = match(200, **options), match(1, **options)
        say(f"Match.step, {name}: a cycle in Rust", f"{1e6 * alone:.1f} µs")
        say("  additional time if called once per cycle", f"{1e6 * (single - alone):.1f} µs", "at most 10 µs")
    played = naoisis.Match("match3v3", control=["blue2"])
    played.step(cycles=100)
    for name, look in (("perception", lambda: played.perception("blue2")), ("truth", played.truth)):
        say(f"Match.{name}, as a dictionary", f"{1e6 / rate(look):.1f} µs")


LONG = {"rules.half_s": 1e5}
STANDING = {
    "rules": "free",
    "robots": [
        {"team": team, "number": number, "pose": [0.8 * side * number, 0.8 * number - 1.6, 90 * (1 + side)]}
        for team, side in (("blue", -1), ("pink", 1))
        for number in (1, 2, 3)
    ],
}
SEER = {
    "rules": "free",
    "duration_s": 1e5,
    "ball": {"position_m": [1.0, 0.2]},
    "robots": [{"team": "blue", "number": 1}],
}

if __name__ == "__main__":
    main()
