"""Runs an agent for ``boosteros`` in a match: ``python -m naoisis.boosteros AGENT.py``."""

from __future__ import annotations

import argparse
import importlib
import os
import re
import runpy
import sys
import threading
import traceback
from pathlib import Path
from types import ModuleType
from typing import Any, TextIO

from naoisis.boosteros import _unknown, agent, brain, clock, robot, types
from naoisis.boosteros.link import Link


def main(arguments: list[str] | None = None) -> None:
    """Plays the robot that the match gives to this process until the match is over."""
    parser = argparse.ArgumentParser(
        prog="python -m naoisis.boosteros", description="Plays a robot of a naoisis match."
    )
    parser.add_argument("--images", metavar="CAMERA", help="render the images of this camera: head, for a K1 or T1")
    parser.add_argument("--click", action="append", default=[], metavar="ID", help="press this button at the start")
    parser.add_argument(
        "--thread-limit",
        type=float,
        default=4.0,
        metavar="S",
        help="the longest that a thread may run without waiting, s of real time; 0 for no limit [default: 4]",
    )
    parser.add_argument(
        "agent", help="a script, a file with an agent (also FILE:CLASS), or a folder with an agent.toml"
    )
    parser.add_argument("arguments", nargs=argparse.REMAINDER, help="what the script receives")
    options = parser.parse_args(arguments)

    link = Link(_take_streams(), options.thread_limit, options.images)
    robot._firmwares[:] = [robot.Firmware(link)]
    clock.install(link.clock)
    _name_modules()
    _name_robot()
    status = 0
    try:
        _run(options, link)
    except SystemExit as end:
        status = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except KeyboardInterrupt:
        status = 0 if link.is_over else 130
    except BaseException as error:
        traceback.print_exc()
        if isinstance(error, ModuleNotFoundError) and error.name == "rclpy":
            print("boosteros: naoisis has no topics of ROS, and tells no agent the truth", file=sys.stderr)
        status = 1
    if status == 0:
        _stand_until_the_end(link)
    clock.leave(status)


def _take_streams() -> tuple[TextIO, TextIO]:
    """The standard streams, for the match. The agent reads nothing, and what it prints goes to standard error."""
    streams = os.fdopen(os.dup(0)), os.fdopen(os.dup(1), "w")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    return streams


def _name_modules() -> None:
    """Gives the modules their names in the SDK."""
    packages = {
        name: ModuleType(name, "As in Booster's SDK, for naoisis.") for name in ("boosteros", "boosteros.robots")
    }
    modules = {"boosteros.robots.booster": robot, "boosteros.types": types, "boosteros.brain": brain}
    for name, package in packages.items():
        package.__path__ = []
        sys.modules[name] = package
    for name, module in [("boosteros.robots", packages["boosteros.robots"]), *modules.items()]:
        sys.modules[name] = module
        parent, _, own = name.rpartition(".")
        setattr(packages[parent], own, module)
    for name, package in packages.items():
        known = [own for own in vars(package) if not own.startswith("_")]
        package.__getattr__ = lambda own, name=name, known=known: _unknown.placeholder(name, own, known)  # type: ignore[method-assign, misc]
    sys.modules["booster_agent_framework"] = agent


def _name_robot() -> None:
    """Tells the agent its team and robot as the contest does: a team of one robot, as each has its own process."""
    own = os.environ.get("NAOISIS_ROBOT", "")
    os.environ.setdefault("SOCCER_TEAM_ID", "2" if own.startswith("pink") else "1")
    os.environ.setdefault("SOCCER_ROBOT_NAMES", own)


def _run(options: Any, link: Link) -> None:
    """Runs a script to its end, or an agent to the end of the match."""
    named, _, wanted = options.agent.partition(":")
    path = Path(named)
    if path.is_dir():
        names, wanted = _import(path, options.arguments)
    else:
        sys.argv = [named, *options.arguments]
        sys.path.insert(0, str(path.parent))
        names = runpy.run_path(named, run_name="__main__")
    classes = [names[wanted]] if wanted else _agents(names)
    if not classes:
        return
    if len(classes) > 1:
        raise SystemExit(f"boosteros: {path} has several agents; name one of them: {path}:{classes[0].__name__}")
    link.connect()
    own = classes[0]()
    robot.firmware().gets_up_itself = own.agent_features.enable_auto_getup
    own.agent_state = agent.AgentState.kActive
    own.on_agent_activated()
    for click in options.click:
        component = own.component_manager.get_component(click)
        if component is None or component.click_callback is None:
            known = ", ".join(own.component_manager.get_components())
            raise SystemExit(f"boosteros: there is no button {click!r}; there are: {known}")
        component.click_callback(component)
    try:
        link.clock.wait(lambda: link.is_over)
    finally:
        own.on_agent_close()
        own.agent_state = agent.AgentState.kFinalized


def _agents(names: dict[str, Any]) -> list[type[agent.AgentBase]]:
    """The agents that a module defines itself."""
    values = [value for value in names.values() if isinstance(value, type) and issubclass(value, agent.AgentBase)]
    return [value for value in values if value.__module__ == names["__name__"]]


def _import(folder: Path, arguments: list[str]) -> tuple[dict[str, Any], str]:
    """Imports the module that the agent.toml of a folder names. Returns the names in it, and that of the class."""
    text = (folder / "agent.toml").read_text(encoding="utf-8")
    entry = re.search(r'^\s*entry\s*=\s*"([^":]+):?([^"]*)"', text, re.MULTILINE)
    if entry is None:
        raise SystemExit(f"boosteros: {folder / 'agent.toml'} names no entry")
    sys.argv = [str(folder / entry[1]), *arguments]
    sys.path.insert(0, str(folder))
    return vars(importlib.import_module(".".join(Path(entry[1]).with_suffix("").parts))), entry[2]


def _stand_until_the_end(link: Link) -> None:
    """Answers for a robot whose script has ended: it stands, while the other threads of the script go on."""
    try:
        others = [thread for thread in threading.enumerate() if not thread.daemon and hasattr(thread, "_place")]
        link.clock.wait(lambda: link.is_over or not any(thread.is_alive() for thread in others))
        if not link.is_over:
            print("boosteros: the agent has ended; its robot stands", file=sys.stderr)
            robot.firmware().stop()
        link.clock.wait(lambda: link.is_over)
    except KeyboardInterrupt:
        pass
