"""Simulated time for an agent: ``time`` and ``threading`` of the standard library, by the clock of the match.

One thread of the agent runs at a time, until it waits: for a time, a lock, an event, another thread. Then the next one runs, in the order in which
they began to wait. When all of them wait, the match goes on by a cycle. So threads are the same in each run, too.
"""

from __future__ import annotations

import _thread
import concurrent.futures.thread
import os
import queue
import sys
import threading
import time
import traceback
from collections.abc import Callable
from typing import Any

# What the clocks of the agent say at the start of the match, s. Agents take 0 for "long ago".
_MONOTONIC_S = 1000.0
_EPOCH_S = 1_767_225_600.0
# A wait may end this much before its time, s: for rounding.
_EARLY_S = 1e-4

# The real ones.
_sleep, _monotonic, _get_ident = time.sleep, time.monotonic, _thread.get_ident
_start, _bootstrap = threading.Thread.start, threading.Thread._bootstrap  # type: ignore[attr-defined]
_join, _is_alive = threading.Thread.join, threading.Thread.is_alive


class _Place:
    """A thread of the agent, as the clock knows it."""

    def __init__(self, thread: threading.Thread):
        self.thread = thread
        self.gate = _thread.allocate_lock()
        self.gate.acquire()
        self.is_done = False
        self.is_interrupted = False
        self.ready: Callable[[], bool] = lambda: True
        self.since_cycle = -1
        self.until_s: float | None = None


class Clock:
    """The clock of a match, and the threads that live by it.

    Args:
        next_cycle: Sends the commands of the cycle and receives the next one. Returns its time, s.
        limit_s: The longest that threads may run in a cycle, s of real time: the process ends then.
    """

    def __init__(self, next_cycle: Callable[[], float], limit_s: float):
        self.now_s = 0.0
        self.cycle = 0
        self._next_cycle = next_cycle
        self._limit_s = limit_s
        self._main = self._running = _Place(threading.current_thread())
        self._waiting: list[_Place] = []
        self._began_s: float | None = None

    def wait(self, ready: Callable[[], bool], timeout: float | None = None) -> bool:
        """Lets other threads run until `ready`, or until `timeout` seconds are over. Returns whether it is ready."""
        place = self._running
        if place.thread.ident != _get_ident():
            raise RuntimeError("boosteros: only threads that threading.Thread has started can wait in naoisis")
        place.ready, place.since_cycle = ready, self.cycle
        place.until_s = None if timeout is None else self.now_s + timeout
        self._waiting.append(place)
        self._run_next()
        if place.is_interrupted:
            place.is_interrupted = False
            raise KeyboardInterrupt
        return ready()

    def interrupt(self) -> None:
        """Wakes the main thread with a ``KeyboardInterrupt``, as Ctrl-C does."""
        self._main.is_interrupted = True

    def begin_cycle(self, now_s: float) -> None:
        """Sets the time, and counts the real time of threads from here."""
        self.now_s = now_s
        self.cycle += 1
        if self._began_s is None and self._limit_s > 0:
            _thread.start_new_thread(self._watch, ())
        self._began_s = _monotonic()

    def _run_next(self) -> None:
        """Gives the turn to the thread that may run next. Returns when this one has it, or at once if it is done."""
        place = self._running
        while (chosen := next(filter(self._may_run, self._waiting), None)) is None:
            try:
                self._began_s, now_s = float("inf"), self._next_cycle()
                self.begin_cycle(now_s)
            except BaseException:
                traceback.print_exc()
                leave(1)
        self._waiting.remove(chosen)
        self._running = chosen
        if chosen is not place:
            chosen.gate.release()
            if not place.is_done:
                place.gate.acquire()

    def _may_run(self, place: _Place) -> bool:
        is_late = place.until_s is not None and place.until_s <= self.now_s + _EARLY_S
        return place.is_interrupted or (is_late and place.since_cycle < self.cycle) or place.ready()

    def _watch(self) -> None:
        """Ends the process if a thread does not wait."""
        while True:
            _sleep(0.1)
            if self._began_s is not None and _monotonic() - self._began_s > self._limit_s:
                thread = self._running.thread
                print(
                    f"boosteros: the thread {thread.name!r} has run for {self._limit_s:g} s without waiting, at {self.now_s:.2f} s of the "
                    "match, which goes on only when every thread waits (time.sleep, Event.wait, ...). It is here:",
                    file=sys.stderr,
                )
                traceback.print_stack(sys._current_frames().get(thread.ident or 0))
                leave(1)

    def start(self, thread: threading.Thread) -> None:
        """Starts a thread, which first runs when the others wait."""
        place = _Place(thread)
        self._waiting.append(place)
        thread._place = place  # type: ignore[attr-defined]
        try:
            _start(thread)
        except BaseException:
            self._waiting.remove(place)
            raise

    def bootstrap(self, thread: threading.Thread) -> None:
        """What a started thread does first and last."""
        place: _Place = thread._place  # type: ignore[attr-defined]
        place.gate.acquire()
        try:
            _bootstrap(thread)
        finally:
            place.is_done = True
            self._run_next()

    def join(self, thread: threading.Thread, timeout: float | None = None) -> None:
        """Waits until a thread has ended."""
        place = getattr(thread, "_place", None)
        if place is None or place is self._running:
            return _join(thread, timeout)  # Which says what is wrong.
        self.wait(lambda: bool(place.is_done), None if timeout is None else max(timeout, 0.0))
        return None

    def lives(self, thread: threading.Thread) -> bool:
        """Whether a thread has started and not ended."""
        place = getattr(thread, "_place", None)
        return _is_alive(thread) if place is None else not place.is_done


class Lock:
    """A lock, as ``threading.Lock``."""

    def __init__(self) -> None:
        self._is_held = False

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        """Takes the lock. Returns whether it did."""
        if self._is_held:
            is_free = blocking and _clock().wait(lambda: not self._is_held, None if timeout < 0 else timeout)
            if not is_free:
                return False
        self._is_held = True
        return True

    def release(self) -> None:
        """Gives the lock back."""
        if not self._is_held:
            raise RuntimeError("release unlocked lock")
        self._is_held = False

    def locked(self) -> bool:
        """Whether a thread has it."""
        return self._is_held

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *error: object) -> None:
        self.release()

    def _at_fork_reinit(self) -> None:
        self._is_held = False


_installed: list[Clock] = []


def _clock() -> Clock:
    return _installed[0]


def install(clock: Clock) -> None:
    """Puts the clock in the place of real time, for this process."""
    _installed[:] = [clock]

    def sleep(seconds: float) -> None:
        if seconds < 0:
            raise ValueError("sleep length must be non-negative")
        clock.wait(lambda: False, seconds)

    def monotonic() -> float:
        return _MONOTONIC_S + clock.now_s

    def now() -> float:
        return _EPOCH_S + clock.now_s

    def in_ns(clock_s: Callable[[], float]) -> Callable[[], int]:
        return lambda: round(clock_s() * 1e9)

    # All other locks, events, queues and pools are made of these.
    replaced: dict[Any, dict[str, object]] = {
        time: {
            **{"sleep": sleep, "time": now, "time_ns": in_ns(now)},
            **{"monotonic": monotonic, "monotonic_ns": in_ns(monotonic)},
            **{"perf_counter": monotonic, "perf_counter_ns": in_ns(monotonic)},
        },
        threading: {
            **{"Lock": Lock, "_allocate_lock": Lock, "_time": monotonic},
            "RLock": threading._RLock,
        },
        threading.Thread: {
            "start": lambda thread: clock.start(thread),
            "_bootstrap": lambda thread: clock.bootstrap(thread),
            "join": lambda thread, timeout=None: clock.join(thread, timeout),
            "is_alive": lambda thread: clock.lives(thread),
        },
        queue: {"time": monotonic, "SimpleQueue": queue._PySimpleQueue},  # type: ignore[attr-defined]
        # It has a lock from before.
        concurrent.futures.thread: {"_global_shutdown_lock": Lock()},
    }
    for owner, names in replaced.items():
        for name, value in names.items():
            setattr(owner, name, value)


def leave(status: int) -> None:
    """Ends the process at once, whatever its threads do."""
    sys.stderr.flush()
    os._exit(status)
