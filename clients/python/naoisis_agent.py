"""Plays a robot of a naoisis match. Needs only Python 3.8.

    from naoisis_agent import play

    def decide(perception):
        ball = perception["percepts"]["ball"]
        if ball is None:
            return {"walk": [0.0, 0.0, 3.0]}
        x, y = ball["position_m"]
        return {"walk": [0.006, 0.0, 3.0 if y > 0.1 else -3.0 if y < -0.1 else 0.0]}

    play(decide, name="my team")

    $ naoisis run match3v3 --blue "exec:python3 my_team.py" --trace match.jsonl

`decide` receives the perception of the robot in a cycle, a dictionary as in a trace, and returns a command with the names
of a trace's `command`, or None to stand still. To say what it thinks, it returns a whole answer instead:
`{"command": {...}, "belief": {...}, "intention": "...", "reasons": {...}, "drawings": [...], "values": {...}}`. Prints go to standard error, because standard output belongs to the match.
`play(decide, fields=["percepts.ball", "game.state"])` receives only these parts, which takes less time.
`encoding="msgpack"` uses MessagePack, by `naoisis_message_pack.py` beside this file. It is faster for images,
and if the package `msgpack` is installed; without it Python reads JSON several times as fast.
"""

import base64
import json
import os
import socket
import sys


_to_json = json.JSONEncoder(allow_nan=False, separators=(",", ":")).encode


class Refused(Exception):
    """The match refuses the program, with a reason."""


class Agent:
    """The connection to the match. `welcome` describes the match: robot, pose, cycle_s, field, rules, model."""

    def __init__(self, name="", images=(), belief=False, address=None, robot=None, token=None, encoding="json", fields=()):
        """Connects over standard input and output, or to `naoisis serve` at `address`: "tcp:HOST:PORT" or "unix:PATH", with its
        token. `fields` are the parts of perceptions to receive, named as in traces; all by default."""
        self._message_pack = None
        if address is None:
            self._from_match, self._to_match = sys.stdin.buffer, sys.stdout.buffer
            sys.stdout = sys.stderr
        else:
            connection = _connect(address)
            self._from_match = self._to_match = connection.makefile("rwb")
        hello = {"protocol": 1, "name": name, "encoding": encoding, "images": list(images), "belief": belief}
        robot = robot or os.environ.get("NAOISIS_ROBOT")
        if robot:
            hello["robot"] = robot
        if token:
            hello["token"] = token
        if fields:
            hello["fields"] = list(fields)
        self._send({"hello": hello})
        if encoding == "msgpack":
            if __package__:
                from . import naoisis_message_pack as message_pack
            else:
                import naoisis_message_pack as message_pack
            self._message_pack = message_pack
        answer = self._receive()
        if answer is None or "welcome" not in answer:
            raise Refused((answer or {}).get("refused", {}).get("reason", "the match has hung up"))
        self.welcome = answer["welcome"]
        self.robot = self.welcome["robot"]
        self.end = None

    def turns(self):
        """The cycles of the match until its end, each with "cycle", "time_s" and "perception", and "refused" if commands of the
        last cycle were refused. Each must be answered."""
        while True:
            turn = self._receive()
            if turn is None:
                return
            if "end" in turn:
                self.end = turn["end"]
                return
            if self._message_pack is None:
                for image in turn.get("images", {}).values():
                    for layer in image.keys() & {"rgb", "depth_mm"}:
                        image[layer] = base64.b64decode(image[layer])
            yield turn

    def answer(self, turn, command=None):
        """Sends the command for this cycle, or a whole answer, which has a "command"."""
        answer = command or {}
        self._send({"cycle": turn["cycle"], **(answer if "command" in answer else {"command": answer})})

    def _send(self, message):
        if self._message_pack is None:
            self._to_match.write(_to_json(message).encode() + b"\n")
        else:
            packed = self._message_pack.pack(message)
            self._to_match.write(len(packed).to_bytes(4, "big") + packed)
        self._to_match.flush()

    def _receive(self):
        if self._message_pack is None:
            line = self._from_match.readline()
            return json.loads(line) if line else None
        length = self._from_match.read(4)
        if length.startswith(b"{"):
            # A match that does not understand the hello says so in JSON.
            return json.loads(length + self._from_match.readline())
        packed = self._from_match.read(int.from_bytes(length, "big"))
        return self._message_pack.unpack(packed) if packed else None


def play(decide, **hello):
    """Plays until the match is over. Returns its end and score, or None if the match was broken off."""
    agent = Agent(**hello)
    for turn in agent.turns():
        agent.answer(turn, decide(turn["perception"]))
    return agent.end


def _connect(address):
    kind, _, where = address.partition(":")
    if kind == "unix":
        connection = socket.socket(socket.AF_UNIX)
        connection.connect(where)
    elif kind == "tcp":
        host, _, port = where.rpartition(":")
        connection = socket.create_connection((host, int(port)))
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    else:
        raise ValueError(f"{address!r} is not an address; expected tcp:HOST:PORT or unix:PATH")
    return connection
