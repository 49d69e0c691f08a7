"""Programs in Python that play: the client comes with the package, and starts without the simulator."""

import json
import subprocess
import sys

TEAM = """
import sys
from naoisis_agent import play
assert "naoisis" not in sys.modules and "numpy" not in sys.modules
play(lambda perception: {"walk": [0.005, 0.0, 0.0]}, name="walkers", encoding=sys.argv[1])
"""


def test_a_program_plays_with_the_client_of_the_package(tmp_path):
    (tmp_path / "walkers.py").write_text(TEAM)
    places = []
    for encoding in ["json", "msgpack"]:
        team = f"exec:{sys.executable} walkers.py {encoding}"
        match = [
            "run",
            "match3v3",
            "--duration",
            "2",
            "--force",
            "--agent-start-timeout",
            "120",
            "--trace",
            "match.jsonl",
        ]
        subprocess.run([sys.executable, "-m", "naoisis._command", *match, "--blue", team], cwd=tmp_path, check=True)
        cycles = [json.loads(line) for line in (tmp_path / "match.jsonl").read_text().splitlines()]
        assert not any(event["kind"] == "agent_lost" for cycle in cycles[1:-1] for event in cycle["events"])
        places.append([robot["pose"] for robot in cycles[-2]["robots"]])
        assert places[-1] != [robot["pose"] for robot in cycles[1]["robots"]]
    assert places[0] == places[1]
