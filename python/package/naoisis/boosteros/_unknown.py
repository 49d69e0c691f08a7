"""What is said of names of the SDK that naoisis does not know."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any, NoReturn


class UnknownName(NotImplementedError, AttributeError):
    """A name of the SDK that naoisis does not know. ``hasattr`` and ``getattr`` with a default find nothing."""


def refuse(name: str, known: Iterable[str]) -> NoReturn:
    """Says that a name is not known, and which are."""
    public = sorted(word for word in known if not word.startswith("_"))
    raise UnknownName(f"boosteros: {name} is not known to naoisis; known are {', '.join(public)}")


def placeholder(module: str, name: str, known: Iterable[str]) -> Any:
    """A class that can be imported and named in annotations, and says that it is not known when it is used."""
    if name.startswith("_"):
        raise AttributeError(name)
    known = list(known)

    class Unknown(type):
        def __call__(cls, *arguments: object, **named: object) -> NoReturn:
            refuse(f"{module}.{name}", known)

        def __getattr__(cls, attribute: str) -> NoReturn:
            if attribute.startswith("__"):
                raise AttributeError(attribute)
            refuse(f"{module}.{name}.{attribute}", known)

    return Unknown(name, (), {"__module__": module})
