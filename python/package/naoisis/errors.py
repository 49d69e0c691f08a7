"""The exceptions of the package."""

from __future__ import annotations

__all__ = ["MatchError", "NaoisisError", "ScenarioError", "SnapshotError", "TraceError"]


class NaoisisError(Exception):
    """The base class of the exceptions of the package."""


class _PlacedError(NaoisisError, ValueError):
    """An error at a place in a file.

    Attributes:
        file: The file as it was named, or the name of a built-in scenario.
        line: The line, from 1; None if the file could not be read at all.
        column: The column, from 1.
    """

    def __init__(self, message: str, file: str | None = None, line: int | None = None, column: int | None = None):
        super().__init__(message, file, line, column)
        self.file, self.line, self.column = file, line, column

    def __str__(self) -> str:
        return str(self.args[0])


class ScenarioError(_PlacedError):
    """A scenario, or a setting for it, is invalid.

    Attributes:
        field: The invalid field, such as ``robots[1].pose``; None for an error of the text itself.
        expected: What was expected.
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
    """Bytes are not a snapshot of a match."""


class MatchError(NaoisisError, RuntimeError):
    """An operation on a match is not possible: it is over, it was broken off, or another thread is using it."""
