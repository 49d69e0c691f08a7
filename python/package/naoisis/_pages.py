"""Pages that play a match in a browser or a notebook."""

from __future__ import annotations

import os
from html import escape
from pathlib import Path

from naoisis import _naoisis

__all__ = ["Page", "show"]

HEIGHT_PX = 680


def frame_of(page: str) -> str:
    """A page as a frame of a notebook, in which its scripts reach nothing of the notebook."""
    style = f"width:100%;height:{HEIGHT_PX}px;border:0"
    return (
        f'<iframe title="A match of naoisis" sandbox="allow-scripts" style="{style}" srcdoc="{escape(page)}"></iframe>'
    )


class Page:
    """A match as a page for a browser: one file that loads nothing. A notebook shows it.

    Attributes:
        html: The page.
    """

    def __init__(self, html: str):
        self.html = html

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the page to a file, in place of what is there."""
        Path(path).write_text(self.html, encoding="utf-8", newline="\n")

    def __repr__(self) -> str:
        return f"<naoisis.Page: {len(self.html) / 1e6:.1f} MB>"

    def _repr_html_(self) -> str:
        return frame_of(self.html)


def show(trace: str | os.PathLike[str]) -> Page:
    """The match of a trace (``.jsonl`` or ``.jsonl.zst``), as a page that a notebook shows.

    Raises:
        TraceError: It cannot be read; the error has line and column.
    """
    return Page(_naoisis.page_of_trace(os.fspath(trace)))
