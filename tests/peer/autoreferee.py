#!/usr/bin/env python3
"""Compares naoisis' verdicts with the rules of the league's automatic referee, match by match.

    python3 tests/peer/autoreferee.py target/release/naoisis hsl2026_middle --matches 10

The crate `game_controller_autoreferee` of github.com/RoboCup-HumanoidSoccerLeague/GameController judges simulated games. Its distances and times,
as published at commit ad1cc83, are restated here; it is not that program. Positions, contacts and the state of the game are read from a trace, so each rule is
asked at the same moments by both. A verdict within `NEAR_S` of one of the other side is the same verdict.
"""

import argparse
import collections
import itertools
import json
import math
import subprocess
import sys
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field

# Times, s, and distances, m, of the automatic referee at ad1cc83.
BALL_FREE_AFTER_S = 0.5
BALL_CLEARLY_MOVED_M = 0.1
TOUCH_DEBOUNCE_S = 0.2
AVOIDANCE_GRACE_S = 10.0
GLOBAL_STUCK_M, GLOBAL_STUCK_S = 1.0, 30.0
LOCAL_STUCK_BALL_M, LOCAL_STUCK_NEAR_M, LOCAL_STUCK_S = 0.1, 0.5, 10.0
MOTION_SETTLE_S, MOTION_M, MOTION_RAD = 1.0, 0.1, 0.3
MOST_IN_GOAL_AREA = 3

# Verdicts that are apart by no more than this are the same, s.
NEAR_S = 2.0

DOUBLE_TOUCH = {"goal_kick", "corner_kick", "kick_in", "throw_in"}
INDIRECT = {"kick_in", "throw_in", "kick_off"}
FREE_KICKS = {*DOUBLE_TOUCH, "pushing_free_kick", "free_kick", "penalty_kick"}


@dataclass
class Pitch:
    """Dimensions, m, to the outer edges of the lines."""

    half_length: float
    half_width: float
    line: float
    border: float
    circle: float
    mark: float
    goal_half_width: float
    goal_height: float
    goal_area: tuple
    penalty_area: tuple
    penalty_mark: float
    ball: float

    @staticmethod
    def of(scenario):
        pitch, ball = scenario["field"], scenario["ball"]
        half_line = pitch["line_width_m"] / 2
        area = lambda name: (pitch[name]["depth_m"] + half_line, pitch[name]["width_m"] / 2 + half_line)
        return Pitch(
            half_length=pitch["length_m"] / 2 + half_line,
            half_width=pitch["width_m"] / 2 + half_line,
            line=pitch["line_width_m"],
            border=pitch["border_m"],
            circle=pitch["centre_circle_diameter_m"] / 2 + half_line,
            mark=pitch["penalty_mark_size_m"] / 2,
            goal_half_width=pitch["goal"]["width_m"] / 2 - pitch["goal"]["post_diameter_m"] / 2,
            goal_height=pitch["goal"]["height_m"] - pitch["goal"]["bar_diameter_m"],
            goal_area=area("goal_area"),
            penalty_area=area("penalty_area"),
            penalty_mark=pitch["penalty_mark_distance_m"],
            ball=ball["radius_m"],
        )


@dataclass
class Robot:
    x: float
    y: float
    theta: float
    playing: bool


def distance(one, other):
    return math.hypot(one[0] - other[0], one[1] - other[1])


@dataclass
class Peer:
    """The automatic referee's rules over the cycles of one match."""

    pitch: Pitch
    radius: float
    verdicts: list = field(default_factory=list)
    state: str = ""
    stopped: bool = False
    set_play: tuple | None = None
    began_s: float = 0.0
    state_began_s: float = 0.0
    last_contact: str | None = None
    last_touch: tuple | None = None
    restart: dict | None = None
    kicker: str | None = None
    left_avoidance: set = field(default_factory=set)
    in_goal_area: set = field(default_factory=set)
    returning: set = field(default_factory=set)
    near_ball_s: float = 0.0
    stuck: tuple | None = None
    still: dict | None = None
    said: set = field(default_factory=set)
    out: bool = False

    def say(self, time_s, rule, who, *, once=True):
        """Notes a verdict; of one that lasts only its beginning."""
        key = (rule, who)
        if once and key in self.said:
            return
        self.said.add(key)
        self.verdicts.append((time_s, rule, who, f"{self.state}, {self.set_play}"))

    def team_x(self, team, x, blue_end):
        own_is_negative = (team == "blue") == (blue_end == "negative_x")
        return x if own_is_negative else -x

    def cycle(self, time_s, game, ball, robots, touches):
        """One cycle. `game` is its state after the verdicts of the cycle, `ball` where the ball was before them."""
        for robot in touches:
            self.touch(time_s, robot, ball, robots)
        if self.state == "playing" and not self.stopped and not game.get("shoot_out"):
            self.ball_out(time_s, ball, game["blue_end"])
        blue_end = game["blue_end"]
        set_play = game["set_play"] and (game["set_play"]["kind"], game["set_play"]["team"])
        if game["state"] != self.state or bool(game.get("stopped")) != self.stopped:
            self.state_began_s, self.still = time_s, None
            self.said.clear()
        if set_play != self.set_play or (game["state"] == "set" and self.state != "set"):
            self.began_s, self.left_avoidance, self.kicker = time_s, set(), None
            self.said.clear()
            kind = set_play[0] if set_play else None
            if set_play and kind in FREE_KICKS:
                self.restart = {"kind": kind, "team": set_play[1], "kicker": None, "other": False, "moved": False}
            if game["state"] == "set" and not set_play and game["kicking_team"]:
                self.restart = {"kind": "kick_off", "team": game["kicking_team"], "kicker": None, "other": False, "moved": False}
        if game["state"] not in ("ready", "set", "playing"):
            self.restart = None
        self.state, self.stopped, self.set_play = game["state"], bool(game.get("stopped")), set_play
        if self.restart and self.restart["kicker"]:
            self.restart["moved"] |= distance(ball, self.restart["from"]) > BALL_CLEARLY_MOVED_M
        if game.get("shoot_out"):
            return
        for name, robot in robots.items():
            if not robot.playing:
                self.returning.add(name)
            elif abs(robot.x) <= self.pitch.half_length + self.radius and abs(robot.y) <= self.pitch.half_width + self.radius:
                self.returning.discard(name)
        self.leaving(time_s, robots)
        self.positions(time_s, game, ball, robots, blue_end)
        self.motion(time_s, robots)
        if self.state == "playing" and not self.stopped:
            self.stuck_games(time_s, ball, robots)

    def touch(self, time_s, robot, ball, robots):
        team = robot[:4]
        self.last_contact = team
        if (
            self.set_play
            and self.state == "playing"
            and self.set_play[1] == team
            and time_s >= max(self.began_s, self.state_began_s) + BALL_FREE_AFTER_S
        ):
            self.say(time_s, "ball_free", team)
        new = not (self.last_touch and self.last_touch[0] == robot and time_s <= self.last_touch[1] + TOUCH_DEBOUNCE_S)
        self.last_touch = (robot, time_s)
        if not new or not self.restart:
            return
        restart = self.restart
        if restart["kicker"] is None and team == restart["team"]:
            restart["kicker"], restart["from"] = robot, ball
        elif robot == restart["kicker"]:
            playing = sum(other.playing for name, other in robots.items() if name[:4] == team)
            if not restart["other"] and restart["moved"] and restart["kind"] in DOUBLE_TOUCH and playing >= 3:
                self.say(time_s, "double_touch", "pink" if team == "blue" else "blue")
                self.restart = None
        else:
            restart["other"] = True

    def leaving(self, time_s, robots):
        for name, robot in robots.items():
            beyond = (
                abs(robot.x) > self.pitch.half_length + self.pitch.border
                or abs(robot.y) > self.pitch.half_width + self.pitch.border
            )
            if robot.playing and beyond:
                self.say(time_s, "leaving_field", name)

    def positions(self, time_s, game, ball, robots, blue_end):
        if self.state not in ("set", "playing"):
            return
        pitch, radius = self.pitch, self.radius
        inside = collections.defaultdict(list)
        for name, robot in robots.items():
            if not robot.playing:
                continue
            team = name[:4]
            x = self.team_x(team, robot.x, blue_end)
            depth = min(pitch.goal_area[1] + radius - abs(robot.y), -pitch.half_length + pitch.goal_area[0] + radius - x)
            if depth >= 0:
                inside[team].append((name not in self.in_goal_area and self.state == "playing", -depth, name))
            if self.illegal(name, robot, x, game, ball, blue_end, time_s):
                self.say(time_s, "illegal_position", name)
        for names in inside.values():
            for _, _, name in sorted(names, reverse=True)[: max(0, len(names) - MOST_IN_GOAL_AREA)]:
                self.say(time_s, "illegal_position", name)
        self.in_goal_area = {name for names in inside.values() for _, _, name in names}

    def illegal(self, name, robot, x, game, ball, blue_end, time_s):
        pitch, radius, team = self.pitch, self.radius, name[:4]
        outside = abs(robot.x) > pitch.half_length + radius or abs(robot.y) > pitch.half_width + radius
        if self.state == "set" and outside and name not in self.returning:
            return True
        kicking = game["kicking_team"] == team
        is_timed = self.state == "set" or game.get("secondary_time_left_s") is not None
        kick_off = is_timed if self.set_play is None else self.set_play[0] == "kick_off"
        if kick_off:
            to_centre = math.hypot(robot.x, robot.y)
            in_half = x > -(pitch.line / 2 + radius)
            in_circle = to_centre < pitch.circle + radius
            if not kicking:
                return in_half or in_circle
            if self.state == "set" and to_centre < pitch.mark + radius:
                return True
            if not in_half:
                return False
            return not in_circle or self.not_kicker(name)
        if not self.set_play:
            return False
        kind, kicking_team = self.set_play
        in_area = lambda place_x: min(
            pitch.penalty_area[1] + radius - abs(robot.y), place_x - (pitch.half_length - pitch.penalty_area[0] - radius)
        ) > 0
        if kind == "penalty_kick":
            return self.illegal_at_penalty_kick(name, robot, x, kicking_team == team, in_area)
        if kicking_team == team or self.state != "playing" or self.stopped:
            return False
        on_goal_line = abs(robot.y) <= pitch.goal_half_width and abs(x + pitch.half_length - pitch.line / 2) <= radius
        ball_x = self.team_x(team, ball[0], blue_end)
        ball_in_area = ball_x <= -pitch.half_length + pitch.penalty_area[0] and abs(ball[1]) <= pitch.penalty_area[1]
        near = (
            distance((robot.x, robot.y), ball) < pitch.circle + radius
            or (kind == "goal_kick" and in_area(x))
            or (ball_in_area and in_area(-x))
        )
        if not near or on_goal_line:
            self.left_avoidance.add(name)
            return False
        return name in self.left_avoidance or time_s >= self.began_s + AVOIDANCE_GRACE_S

    def illegal_at_penalty_kick(self, name, robot, x, kicking, in_area):
        pitch, radius = self.pitch, self.radius
        mark_x = pitch.half_length - pitch.penalty_mark
        if kicking:
            to_mark = math.hypot(x - mark_x, robot.y)
            if (self.state == "set" and to_mark < pitch.mark + radius) or x > mark_x:
                return True
            return (in_area(x) or to_mark < pitch.circle + radius) and self.not_kicker(name)
        if name.endswith("1"):
            return False
        return in_area(-x) or x < -mark_x or math.hypot(x + mark_x, robot.y) < pitch.circle + radius

    def not_kicker(self, name):
        if self.kicker is None and self.state == "playing":
            self.kicker = name
        return self.state == "playing" and self.kicker != name

    def motion(self, time_s, robots):
        if not (self.state == "set" or self.stopped):
            return
        if time_s < self.state_began_s + MOTION_SETTLE_S:
            return
        if self.still is None:
            self.still = {name: robot for name, robot in robots.items() if robot.playing}
            return
        for name, before in list(self.still.items()):
            now = robots[name]
            turned = abs((now.theta - before.theta + math.pi) % (2 * math.pi) - math.pi)
            if now.playing and (math.hypot(now.x - before.x, now.y - before.y) > MOTION_M or turned > MOTION_RAD):
                self.say(time_s, "motion_in_stop" if self.stopped else "motion_in_set", name)
                del self.still[name]

    def stuck_games(self, time_s, ball, robots):
        if self.set_play:
            self.near_ball_s, self.stuck = time_s, None
            return
        away = {name: distance((robot.x, robot.y), ball) - self.radius for name, robot in robots.items() if robot.playing}
        if any(way <= GLOBAL_STUCK_M for way in away.values()):
            self.near_ball_s = time_s
        elif time_s >= self.near_ball_s + GLOBAL_STUCK_S:
            self.say(time_s, "game_stuck", "-", once=False)
            self.near_ball_s = time_s
        if self.stuck is None or distance(ball, self.stuck[0]) > LOCAL_STUCK_BALL_M:
            self.stuck = (ball, time_s)
        elif time_s >= self.stuck[1] + LOCAL_STUCK_S:
            near = [(way, name) for name, way in away.items() if way <= LOCAL_STUCK_NEAR_M]
            if near:
                self.say(time_s, "local_stuck", min(near)[1], once=False)
                self.stuck = None

    def ball_out(self, time_s, ball, blue_end):
        pitch = self.pitch
        over_goal_line = abs(ball[0]) > pitch.half_length + pitch.ball
        over_side = abs(ball[1]) > pitch.half_width + pitch.ball
        if not (over_goal_line or over_side):
            self.out = False
            return
        if self.out:
            return
        self.out = True
        defender = "blue" if (ball[0] > 0) == (blue_end == "positive_x") else "pink"
        attacker = "pink" if defender == "blue" else "blue"
        other = {"blue": "pink", "pink": "blue"}
        if over_goal_line and abs(ball[1]) + pitch.ball < pitch.goal_half_width and ball[2] + pitch.ball < pitch.goal_height:
            restart = self.restart
            if restart and not restart["other"] and restart["team"] == defender:
                return self.say(time_s, "corner_kick", attacker, once=False)
            if restart and not restart["other"] and restart["kind"] in INDIRECT:
                return self.say(time_s, "goal_kick", defender, once=False)
            return self.say(time_s, "goal", attacker, once=False)
        if over_goal_line:
            kicked_out = (self.last_contact or attacker) == attacker
            return self.say(time_s, "goal_kick" if kicked_out else "corner_kick", defender if kicked_out else attacker, once=False)
        self.say(time_s, "kick_in", other[self.last_contact] if self.last_contact else defender, once=False)


def ours(event):
    """The verdict of an event of the trace as (rule, who), if it is one that the automatic referee judges, too."""
    kind = event["kind"]
    if kind == "penalty":
        reason = {"game_stuck": "local_stuck", "leaving_the_field": "leaving_field"}.get(event["reason"], event["reason"])
        return (reason, event["robot"])
    if kind == "goal":
        return ("goal", event["team"])
    if kind == "free_kick":
        place = {"throw_in": "kick_in", "indirect_free_kick": "double_touch"}.get(event["set_play"], event["set_play"])
        return (place, event["team"])
    if kind == "free_kick_over" and event.get("taken"):
        return ("ball_free", event["team"])
    if kind == "game_stuck":
        return ("game_stuck", "-")
    return None


def context_of(verdict, record, peer):
    """The state of the game at a verdict of naoisis, and what it found."""
    events = [event for event in record.get("events") or [] if ours(event) == verdict and event.get("evidence")]
    since_s = record["time_s"] - max(peer.began_s, peer.state_began_s)
    words = [f"{peer.state}, {peer.set_play}, {since_s:.1f} s"]
    for event in events[:1]:
        evidence = event["evidence"]
        measured = evidence.get("measured")
        measure = [f"{measured['value']:.2f} {measured['what']} of {measured['limit']:.2f}"] if measured else []
        words += [evidence["rule"], evidence["otherwise"], *measure]
    return "; ".join(words)


COMPARED = [
    "goal", "kick_in", "goal_kick", "corner_kick", "ball_free", "double_touch", "game_stuck", "local_stuck",
    "leaving_field", "illegal_position", "motion_in_set", "motion_in_stop",
]


def play(program, scenario, seed, settings):
    """Yields the records of a match's trace."""
    fields = "ball,robots.pose,robots.penalised,game,events"
    command = [program, "run", scenario, "--seed", str(seed), "--trace", "-", "--trace-fields", fields]
    command += [word for setting in settings for word in ("--set", setting)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL) as process:
        for line in process.stdout:
            yield json.loads(line)
    if process.returncode:
        sys.exit(f"`{' '.join(command)}` ended with status {process.returncode}")


def compare(records):
    """The verdicts of both sides in one match: {rule: (both, only theirs, only ours)}, each a list."""
    records = iter(records)
    header = next(records)
    scenario = header["scenario"]
    base = scenario["body"]["base"]
    radius = math.sqrt((base["x_m"][1] - base["x_m"][0]) * 2 * base["half_width_m"] / math.pi)
    peer, own, before = Peer(Pitch.of(scenario), radius), [], {}
    for record in records:
        if record.get("type") != "cycle" or not record.get("ball"):
            continue
        time_s, events = record["time_s"], record.get("events") or []
        robots = {
            robot["id"]: Robot(*robot["pose"][:2], math.radians(robot["pose"][2]), robot["penalised"] is None)
            for robot in record["robots"]
        }
        # Who is penalised in this cycle has been taken away already, and is asked about where it was.
        for event in events:
            if event["kind"] == "penalty" and before.get(event["robot"]):
                robots[event["robot"]] = before[event["robot"]]
        before = {name: robot for name, robot in robots.items() if robot.playing}
        touches = [e["robot"] for e in events if e["kind"] == "kick" and e["result"] != "missed"]
        touches += [e["robot"] for e in events if e["kind"] == "collision" and e["with"] == "ball" and e["robot"]]
        ball = record["ball"]["position_m"]
        # The referee has put a ball that was out back: the evidence has where it was.
        for event in events:
            if event["kind"] in ("goal", "ball_out", "goal_disallowed") and event.get("evidence"):
                ball = [*event["evidence"]["ball_m"], ball[2]]
        peer.cycle(time_s, record["game"], ball, robots, touches)
        found = {verdict for verdict in map(ours, events) if verdict and verdict[0] in COMPARED}
        if any(rule == "local_stuck" for rule, _ in found):
            # The event that play is stuck comes with the penalty of the robot next to the ball.
            found.discard(("game_stuck", "-"))
        own += [(time_s, *verdict, context_of(verdict, record, peer)) for verdict in sorted(found)]
    result = {rule: ([], [], []) for rule in COMPARED}
    for time_s, rule, who, context in peer.verdicts:
        same = [v for v in own if v[1:3] == (rule, who) and abs(v[0] - time_s) <= NEAR_S]
        if same:
            own.remove(same[0])
        result[rule][0 if same else 1].append((time_s, f"{who} ({context})"))
    for time_s, rule, who, context in own:
        earlier = [v[0] for v in peer.verdicts if v[1:3] == (rule, who) and 0 < time_s - v[0] < 30]
        said = f", said by the other {time_s - earlier[-1]:.1f} s before" if earlier else ""
        result[rule][2].append((time_s, f"{who} ({context}{said})"))
    return result


def match(options, seed):
    """The verdicts of both sides in the match with this seed."""
    return compare(play(options.program, options.scenario, seed, options.set))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("program", help="the naoisis program")
    parser.add_argument("scenario", nargs="?", default="hsl2026_middle")
    parser.add_argument("--matches", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--show", type=int, default=3, help="differences of each rule that are listed with seed and time")
    parser.add_argument("--set", action="append", default=[], help="a setting of the scenario, as of `naoisis run`")
    options = parser.parse_args()
    total = {rule: ([], [], []) for rule in COMPARED}
    seeds = range(options.seed, options.seed + options.matches)
    with ProcessPoolExecutor() as pool:
        matches = pool.map(match, itertools.repeat(options), seeds)
        for seed, of_match in zip(seeds, matches):
            for rule, lists in of_match.items():
                for part, found in zip(total[rule], lists):
                    part += [(seed, *verdict) for verdict in found]
            print(f"match {seed} of {seeds[-1]}", file=sys.stderr)
    print(f"| verdict | both | automatic referee only | naoisis only |\n|---|---|---|---|")
    for rule, (both, theirs, own) in total.items():
        print(f"| {rule} | {len(both)} | {len(theirs)} | {len(own)} |")
    for rule, (_, theirs, own) in total.items():
        for name, part in (("automatic referee only", theirs), ("naoisis only", own)):
            for seed, time_s, who in part[: options.show]:
                print(f"{rule}, {name}: seed {seed}, {time_s:.2f} s, {who}")


if __name__ == "__main__":
    main()
