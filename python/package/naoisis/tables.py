"""The page of observations, actions, rewards and tasks, generated from the lists that fill the arrays.

``python -m naoisis.tables > OBSERVATIONS.md`` writes the page of the repository.
"""

from __future__ import annotations

from naoisis import _naoisis
from naoisis.environments import MatchEnv

__all__ = ["page"]

KINDS = {
    "perception": "What its sensors say now, and what it is told. Places are in the robot's own frame: x ahead, y to the left.",
    "belief": "What the built-in estimator makes of that. Its own pose is in its team's frame: the own goal is at -x. Robots that observe"
    "\ntheir beliefs tell team-mates where they are and where they see the ball, as the built-in teams do (`messages.loss` 1: nobody hears).",
    "truth": "What no robot can know: for critics, and to see what perfect knowledge is worth.",
    "image": "What a robot knows besides its camera image: the part `body` of the observation.",
}


def page() -> str:
    """The page in Markdown, for a robot with one team-mate against two."""
    parts = [
        "# Observations, actions, rewards and tasks",
        "",
        "Made by `python -m naoisis.tables` of the lists that fill the arrays. The observations are those of `TwoOnTwo`, with a",
        "team-mate and two opponents; in other matches there are as many as play.",
    ]
    for kind, says in KINDS.items():
        env = MatchEnv("TwoOnTwo", observation=kind)
        entries = env.observation_entries
        parts += ["", f"## Observation `{kind}`: {len(entries)} numbers", "", says, ""]
        parts += ["| index | name | least | greatest | what it says |", "|---|---|---|---|---|"]
        parts += [
            f"| {index} | `{name}` | {low:.4g} | {high:.4g} | {text} |"
            for index, (name, low, high, text) in enumerate(entries)
        ]
    parts += [
        "",
        "## Actions `continuous`: 8 numbers from -1 to 1",
        "",
        "| index | name | what it does |",
        "|---|---|---|",
    ]
    parts += [
        f"| {index} | `{name}` | {says} |" for index, (name, says) in enumerate(_naoisis.Environments.continuous())
    ]
    for kind in ("multi_discrete", "discrete", "velocities"):
        lists = MatchEnv("TwoOnTwo", action=kind).action_names
        parts += ["", f"## Actions `{kind}`", ""]
        parts += [f"{index + 1}. " + ", ".join(f"`{name}`" for name in names) for index, names in enumerate(lists)]
    parts += [
        "",
        "With `discrete` the head looks at the ball, and searches where the robot sees none; with `velocities` it looks where the ball is",
        "believed to be, if beliefs are observed, and now and then at a goal post, if the robot has not seen landmarks recently.",
    ]
    parts += ["", "## Rewards", "", "| part | what it counts |", "|---|---|"]
    parts += [f"| `{name}` | {says} |" for name, says in _naoisis.Environments.rewards()]
    parts += ["", "## Tasks", "", "| Gymnasium's name | what is to be done | rewards by default |", "|---|---|---|"]
    for name, version, says in _naoisis.challenges():
        weights = MatchEnv(name).reward_weights
        of_task = ", ".join(f"{weight:g} `{part}`" for part, weight in weights.items() if weight)
        parts.append(f"| `naoisis/{name}-v{version}` | {says} | {of_task} |")
    return "\n".join(parts) + "\n"


if __name__ == "__main__":
    print(page(), end="")
