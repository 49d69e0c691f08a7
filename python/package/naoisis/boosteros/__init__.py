"""Agents for Booster's Python SDK ``boosteros`` play in naoisis, in lock-step and without ROS or DDS.

    naoisis run hsl2026_middle --blue "exec:python3 -m naoisis.boosteros agent.py"

The runner gives the agent modules with the names of the SDK, which speak to the match, and the time of the match. The guide's page on Booster programs
says what is known of the SDK.
"""

from __future__ import annotations

from typing import Any

__all__ = ["game"]


def game() -> dict[str, Any]:
    """The state of the game as the robot is told it, for agents that are written for naoisis: the SDK has none.

    It has the fields of ``perception.game`` in the protocol of programs, such as ``state``, ``set_play``, ``kick_off_team`` and ``penalised``.
    """
    from naoisis.boosteros.robot import firmware

    return dict(firmware().link.perception["game"])
