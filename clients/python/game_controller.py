"""Speaks with the league's GameController, or with a naoisis match that stands in for it: needs Python 3.8 and nothing else.

    controller = GameController(team=5, player=2)
    game = controller.game()                          # what was told last, a dictionary; None before the first packet
    controller.report(fallen=False, pose=(0.0, 0.0, 0.0), ball=None)

Nothing in it knows of naoisis: what plays with it here plays with it on a field. Control packets of versions 18 (Standard
Platform League, 2025), 19 and 20 (Humanoid Soccer League, German Open and RoboCup 2026) are understood, and return packets of version 4 are sent.
"""

import socket
import struct

STATES = {0: "initial", 1: "ready", 2: "set", 3: "playing", 4: "finished", 5: "standby"}
HEAD = struct.Struct("<4s10B2h")
TEAM = struct.Struct("<6B2H")
PLAYERS = 20
# Bytes that a version has for a player.
PLAYER_BYTES = {18: 2, 19: 4, 20: 3}
# Since 19 play can be stopped for a moment; its byte follows that of the division.
FIRST_WITH_STOP = 19


class GameController:
    """What is told to one robot. Several robots of one machine hear broadcast packets."""

    def __init__(self, team, player, port_offset=0, host="127.0.0.1"):
        self.team, self.player = team, player
        self._reports_to = (host, 3939 + port_offset)
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind(("", 3838 + port_offset))
        self._socket.setblocking(False)
        self._game = None

    def game(self):
        """The game as it was told last, from this team's side; None if nothing was told yet."""
        while True:
            try:
                packet = self._socket.recv(1024)
            except BlockingIOError:
                return self._game
            self._game = self._read(packet) or self._game

    def report(self, fallen=False, pose=(0.0, 0.0, 0.0), ball=None, ball_age_s=0.0):
        """Reports where the robot believes to be, (x m, y m, heading rad) with +x towards the opponents' goal, and where it
        sees the ball from itself, (x m, y m)."""
        x, y = ball or (0.0, 0.0)
        numbers = (pose[0] * 1e3, pose[1] * 1e3, pose[2], -1.0 if ball is None else ball_age_s, x * 1e3, y * 1e3)
        packet = struct.pack("<4s4B6f", b"RGrt", 4, self.player, self.team, int(fallen), *numbers)
        self._socket.sendto(packet, self._reports_to)

    def _read(self, packet):
        if len(packet) < HEAD.size:
            return None
        header, version, _, _, _, stopped, phase, state, set_play, first_half, kicking_team, left, secondary = HEAD.unpack_from(packet)
        player_bytes = PLAYER_BYTES.get(version)
        if header != b"RGme" or player_bytes is None:
            return None
        team_bytes = TEAM.size + PLAYERS * player_bytes
        if len(packet) != HEAD.size + 2 * team_bytes:
            return None
        starts = [HEAD.size, HEAD.size + team_bytes]
        teams = [TEAM.unpack_from(packet, start) for start in starts]
        numbers = [team[0] for team in teams]
        if self.team not in numbers:
            return None
        mine = numbers.index(self.team)
        player = starts[mine] + TEAM.size + (self.player - 1) * player_bytes
        return {
            "state": STATES.get(state, "initial"),
            "is_shoot_out": phase == 1,
            "is_timeout": phase == 3,
            "is_stopped": version >= FIRST_WITH_STOP and stopped == 1,
            "set_play": set_play,
            "is_first_half": first_half == 1,
            "is_kicking": kicking_team == self.team,
            "time_left_s": left,
            "secondary_time_left_s": secondary,
            # The team that is named first defends the goal on the left.
            "is_left": mine == 0,
            "goals": teams[mine][4],
            "opponents_goals": teams[1 - mine][4],
            "messages_left": teams[mine][7],
            "penalty": packet[player],
            "penalty_left_s": packet[player + 1],
        }
