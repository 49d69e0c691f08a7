"""How fast worlds are stepped, from Python: prints the figures of the README's table.

``python benchmarks/speed.py`` in this folder, with an optimised build (``pip install .``) and nothing else running.
"""

from __future__ import annotations

import os
import time

import numpy as np

import naoisis

SECONDS = 4.0


def rate(step, cycles: int) -> float:
    """Cycles a second, the best of three measurements of at least a second."""
    step()
    best = 0.0
    for _ in range(3):
        start, count = time.perf_counter(), 0
        while time.perf_counter() - start < SECONDS / 3:
            step()
            count += cycles
        best = max(best, count / (time.perf_counter() - start))
    return best


def vector_env(**options) -> float:
    """World cycles a second of 64 worlds of three against three, one team controlled."""
    env = naoisis.vector_env("match3v3", 64, control="blue", cycles_per_step=1, autoreset_mode="same_step", **options)
    env.reset(seed=1)
    random = np.random.default_rng(1)
    actions = random.uniform(-1, 1, env.action_space.shape).astype(np.float32)
    return rate(lambda: env.step(actions), 64)


def match(**options) -> float:
    """Cycles a second of one match, ten at a time."""
    played = naoisis.Match("match3v3", **options)
    return rate(lambda: played.step(cycles=10), 10)


def main() -> None:
    cores = os.cpu_count() or 1
    rows = [
        ("vector_env, 64 worlds, roles, perceptions, 1 thread", vector_env(opponents="roles", threads=1)),
        (f"the same on {cores} threads", vector_env(opponents="roles", threads=cores)),
        ("the same with beliefs, 1 thread", vector_env(opponents="roles", observation="belief", threads=1)),
        ("the same with the truth, 1 thread", vector_env(opponents="roles", observation="truth", threads=1)),
        ("images of 48 x 64, 1 thread", vector_env(opponents="roles", observation="image", threads=1)),
        ("Match.step, roles against chasers", match()),
        ("Match.step, nobody decides", match(control=["blue", "pink"])),
    ]
    for name, figure in rows:
        print(f"{name:55} {figure:>10,.0f} cycles/s")
    played = naoisis.Match("match3v3", control=["blue2"])
    for name, look in (("perception", lambda: played.perception("blue2")), ("truth", played.truth)):
        print(f"{'Match.' + name + ', as a dictionary':55} {1e6 / rate(look, 1):>10,.1f} µs")


if __name__ == "__main__":
    main()
