"""Talks to team-mates over UDP as on a field: needs Python 3.8 and nothing else.

    messages = TeamMessages()                  # of a program that a match has started; or TeamMessages(team=5, player=2)
    messages.send(b"I have the ball")          # one a cycle, as long as the league allows
    for message in messages.received(): ...    # what team-mates have said since the last time

In a match each robot has an address of its own, as it has on a field, where `TeamMessages(5, 2, host="", to="10.0.255.255")`
hears and tells everybody of the team's network.
"""

import os
import socket


class TeamMessages:
    """What a robot says to its team-mates, and hears from them."""

    def __init__(self, team=None, player=None, port_offset=None, host=None, to="127.0.0.1"):
        """Numbers that are not given are those that the match tells the program in its environment."""
        if team is None:
            team = int(os.environ["NAOISIS_TEAM_NUMBER"])
        if player is None:
            player = int(os.environ["NAOISIS_ROBOT"].lstrip("bluepink"))
        if port_offset is None:
            port_offset = int(os.environ.get("NAOISIS_PORT_OFFSET", 0))
        port = 10000 + team + port_offset
        self._to = (to, port)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self._socket.bind((f"127.1.{team}.{player}" if host is None else host, port))
        self._socket.setblocking(False)

    def send(self, message):
        """Says these bytes."""
        self._socket.sendto(message, self._to)

    def received(self):
        """The messages that have come since the last time."""
        messages = []
        while True:
            try:
                messages.append(self._socket.recv(65507))
            except BlockingIOError:
                return messages
