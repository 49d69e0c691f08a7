"""What the package offers has types and a documentation."""

import importlib
import inspect
import typing
from pathlib import Path

import pytest

import naoisis

# What these need is not installed everywhere.
NEEDING = {f"naoisis.{name}" for name in ("benchmarl", "cluster", "parallel", "rllib", "sb3", "torchrl")}
FILES = Path(naoisis.__file__).parent.glob("*.py")
MODULES = ["naoisis", *sorted(f"naoisis.{file.stem}" for file in FILES if not file.stem.startswith("_"))]


def methods(owner):
    """Yields the public functions of a class that are its own, with their names."""
    for name, member in vars(owner).items():
        function = getattr(member, "__func__", None) or getattr(member, "fget", None) or member
        if inspect.isfunction(function) and function.__module__ == owner.__module__ and not name.startswith("_"):
            yield name, function


def without_types(function):
    """Returns the arguments of a function that have no type, and `return` if its result has none."""
    signature = inspect.signature(function)
    arguments = signature.parameters.items()
    names = [
        name for name, argument in arguments if argument.annotation is argument.empty and name not in ("self", "cls")
    ]
    return names + ["return"] * (signature.return_annotation is signature.empty)


@pytest.mark.parametrize("name", MODULES)
def test_what_a_module_offers_has_types_and_a_documentation(name):
    if name in NEEDING:
        try:
            module = importlib.import_module(name)
        except ModuleNotFoundError as error:
            pytest.skip(str(error))
    else:
        module = importlib.import_module(name)
    assert module.__doc__ and len(set(module.__all__)) == len(module.__all__)
    for offered in (getattr(module, each) for each in module.__all__):
        if inspect.isfunction(offered):
            assert offered.__doc__ and not without_types(offered), (offered, without_types(offered))
        elif inspect.isclass(offered):
            assert offered.__doc__, offered
            inherited = {each for base in offered.__mro__[1:] for each in vars(base)}
            for each, function in methods(offered):
                assert not without_types(function), (function, without_types(function))
                # A method that a library asks for is documented there.
                assert function.__doc__ or each in inherited, function


def test_types_can_be_read_where_the_program_runs():
    """Libraries that make command lines and forms of functions read them."""
    from typing_extensions import Unpack

    from naoisis._worlds import CommonOptions, WorldOptions

    # These are imported for type checkers only.
    names = {"Unpack": Unpack, "CommonOptions": CommonOptions, "WorldOptions": WorldOptions}
    for function in (naoisis.evaluate, naoisis.cross_play, naoisis.batch, naoisis.vector_env, naoisis.tasks):
        assert "return" in typing.get_type_hints(function, localns=names)


def test_every_argument_is_documented():
    documented = 0
    for name in naoisis.__all__:
        offered = getattr(naoisis, name)
        words = getattr(offered, "__doc__", None) or ""
        # Those of an environment are documented once, and others refer to it.
        if "Args:" in words and "other arguments" not in words:
            documented += 1
            for argument in inspect.signature(offered).parameters:
                assert argument in words or argument == "options", f"{name}: {argument} is not documented"
    assert documented > 5
