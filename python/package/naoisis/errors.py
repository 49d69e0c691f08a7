"""The exceptions of the package."""

from __future__ import annotations

__all__ = ["MatchError", "NaoisisError", "ScenarioError", "SnapshotError", "TraceError"]


class NaoisisError(Exception):
    """The base of all of the package's own exceptions."""


class _PlacedError(NaoisisError, ValueError):
    """Something in a file is wrong.

    Attributes:
        file: The file as it was named, or the name of a built-in scenario.
        line: The line, from 1; None where the file could not be read at all.
        column: The column, from 1.
    """

    def __init__(self, message: str, file: str | None = None, line: int | None = None, column: int | None = None):
        super().__init__(message, file, line, column)
        self.file, self.line, self.column = file, line, column

    def __str__(self) -> str:
        return str(self.args[0])


class ScenarioError(_PlacedError):
    """A scenario, or something that is set in it, is wrong.

    Attributes:
        field: The field at fault, such as ``robots[1].pose``; None where the text as such is wrong.
        expected: What would be right.
    """

    def __init__(
        self,
        message: str,
        file: str | None = None,
        line: int | None = None,
        column: int | None = None,
        field: str | None = None,
        expected: str = "",
    ):
        super().__init__(message, file, line, column)
        self.args = (message, file, line, column, field, expected)
        self.field, self.expected = field, expected


class TraceError(_PlacedError):
    """A trace cannot be read."""


class SnapshotError(NaoisisError, ValueError):
    """Some bytes are no snapshot of a match."""


class MatchError(NaoisisError, RuntimeError):
    """A match cannot do what it is asked to: it is over, it was broken off, or somebody else is playing it."""
