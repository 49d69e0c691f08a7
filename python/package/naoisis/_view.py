"""Rendering of environments as pictures, or in a window."""

from __future__ import annotations

import importlib.util
import os
import sys
import time
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

from naoisis.errors import MatchError

if TYPE_CHECKING:
    import numpy as np

    from naoisis._worlds import Worlds

SIZE = (360, 640)


def modes_here() -> list[str]:
    """The modes that work on this machine: ``"human"`` needs Tk, and on Linux a display."""
    has_display = not sys.platform.startswith("linux") or bool(os.environ.get("DISPLAY"))
    has_window = has_display and importlib.util.find_spec("tkinter") is not None
    return ["rgb_array", "human"] if has_window else ["rgb_array"]


def check_render_mode(mode: str | None, modes: Iterable[str]) -> None:
    """Checks that this is one of the modes, or None."""
    if mode is not None and mode not in modes:
        raise ValueError(f"render_mode: there is no {mode!r}; expected one of {', '.join(modes)}, or None")


class View:
    """The display of an environment: in the mode ``"human"`` a window, at most at the speed of real time."""

    def __init__(self, mode: str | None, modes: Iterable[str]):
        check_render_mode(mode, modes)
        self.mode = mode
        self._window: Window | None = None
        self._shown_at = 0.0

    def __getstate__(self) -> dict[str, Any]:
        # A copy opens a window of its own.
        return {"mode": self.mode, "_window": None, "_shown_at": 0.0}

    def show(self, worlds: Worlds) -> None:
        """Shows the first world in the window, if the mode has one."""
        if self.mode != "human":
            return
        if self._window is None:
            self._window = Window("naoisis")
        time.sleep(max(0.0, self._shown_at + worlds.step_s - time.monotonic()))
        self._shown_at = time.monotonic()
        self._window.show(worlds.picture(SIZE))

    def close(self) -> None:
        """Closes the window."""
        if self._window is not None:
            self._window.close()
            self._window = None


class Window:
    """A window that shows pictures, by Tk, which is part of Python."""

    def __init__(self, title: str):
        advice = "expected a display and Tk, or render_mode 'rgb_array'"
        try:
            import tkinter
        except ImportError as error:
            raise MatchError(f"no window can be opened: {error}; {advice}") from None
        try:
            self._root = tkinter.Tk()
        except tkinter.TclError as error:
            raise MatchError(f"no window can be opened: {error}; {advice}") from None
        self._root.title(title)
        self._root.protocol("WM_DELETE_WINDOW", self.close)
        self._label = tkinter.Label(self._root, borderwidth=0)
        self._label.pack()
        self._make = tkinter.PhotoImage
        self._is_open = True

    def show(self, image: np.ndarray) -> None:
        """Shows a picture, ``uint8`` (height, width, 3); does nothing once the window has been closed."""
        if not self._is_open:
            return
        height, width, _ = image.shape
        # It must be kept: Tk does not.
        self._picture = self._make(
            master=self._root, data=b"P6 %d %d 255\n" % (width, height) + image.tobytes(), format="PPM"
        )
        self._label.configure(image=self._picture)
        self._root.update()

    def close(self) -> None:
        """Closes the window."""
        if self._is_open:
            self._is_open = False
            self._root.destroy()
