"""A small team: finds the ball, walks around it until it lies before the opponents' goal, shoots, and tells its team-mates.

    naoisis run match3v3 --blue "exec:python3 clients/python/dribblers.py"
    naoisis run hsl2026_middle --blue "exec:python3 clients/python/dribblers.py"

It asks for the beliefs of the built-in estimator, so that it knows where it stands and which goal is which in every league, and
reads in the welcome how fast its robot walks and where its kicks reach. The same team in other languages plays the same match:
places are rounded to micrometres, because sines differ in their last digits.
"""

import math

from naoisis_agent import Agent

# How far a robot turns in a cycle at most, degrees.
TURN_DEG = 3.0
# A ball that was seen longer ago is searched, s.
LOST_S = 2.0
# What it looks at of what its robot perceives: the rest need not be sent.
FIELDS = ["body", "game.penalised", "game.state", "game.stopped", "game.whistles", "game.ready_signals"]


def rounded(number):
    return math.floor(1e6 * number + 0.5) / 1e6


def in_robot_frame(place, pose):
    """A place of the team's frame in the frame of the robot: x ahead, y to the left, m."""
    x, y = place[0] - pose[0], place[1] - pose[1]
    heading = math.radians(pose[2])
    cos, sin = math.cos(heading), math.sin(heading)
    return rounded(cos * x + sin * y), rounded(cos * y - sin * x)


def turn_towards(place):
    """Degrees of a cycle's turn to a place in the robot's frame: fewer if it is nearly ahead."""
    x, y = place
    turn = 30.0 * y / x if x > 0.1 else 1e9 * y
    return max(-TURN_DEG, min(TURN_DEG, turn))


class Dribbler:
    def __init__(self, welcome):
        kicks, motion = welcome["model"]["kicks"], welcome["model"]["motion"]
        self.goal = (welcome["field"]["length_m"] / 2.0, 0.0)
        # Its place for kick-offs: from where it starts, towards the middle of the pitch.
        start = welcome.get("pose", (-1.0, 0.0, 0.0))
        self.place = (start[0], 0.4 * start[1])
        # How far it walks in a cycle, m: nearly as fast as it can.
        self.step_m = rounded(0.9 * motion["max_linear_mps"] * welcome["cycle_s"])
        # Some robots have a kick whose direction is chosen.
        aimed = kicks.get("own", {}).get("visual")
        self.aims = aimed is not None
        region = (aimed or kicks["left_straight"])["region"]
        # How near, and how far to one side, a ball can be kicked, m.
        self.reach_m = (0.9 * region["x_m"][1], 0.9 * region["y_m"][1]) if region else (0.17, 0.08)
        # How far to one side the goal may be, as a share of its distance.
        self.aside = 0.8 if self.aims else 0.15
        # The state that it was told last, and the numbers of whistles and of signals for `ready` at that time.
        self.told = (None, 0, 0)

    def state(self, game):
        """The state of the game: a whistle or a signal of the referee comes before a late report."""
        heard = game.get("whistles", 0), game.get("ready_signals", 0)
        if game["state"] != self.told[0]:
            self.told = (game["state"], *heard)
        state, whistles, signals = self.told
        if state == "set" and heard[0] > whistles:
            return "playing"
        return "ready" if state == "standby" and heard[1] > signals else state

    def decide(self, perception, belief):
        game, pose = perception["game"], belief["pose"]
        state = self.state(game)
        if game["penalised"] or game["stopped"] or state not in ("ready", "playing"):
            return {}
        if perception["body"] == "fallen":
            return {"posture": "get_up"}
        if state == "ready":
            x, y = in_robot_frame(self.place, pose)
            if x * x + y * y > 0.04:
                return {"walk": [self.step_m if x > abs(y) else 0.0, 0.0, rounded(turn_towards((x, y)))]}
        if belief["ball"] is None or belief["ball"]["age_s"] > LOST_S:
            # It turns on the spot and looks near, then far.
            return {"walk": [0.0, 0.0, TURN_DEG], "head_deg": [0.0, 30.0 if pose[2] > 0.0 else 0.0]}
        ball = in_robot_frame(belief["ball"]["position_m"], pose)
        if state == "ready":
            # It faces the ball: the referee removes robots that stand and look elsewhere.
            return {"walk": [0.0, 0.0, rounded(0.3 * turn_towards(ball))]}
        goal = in_robot_frame(self.goal, pose)
        said = {
            # A ball at the feet is seen only with the head down.
            "head_deg": [0.0, 40.0 if ball[0] < 0.5 else 0.0],
            "say": {"intention": "dribble", "payload": "near" if ball[0] < 1.0 else "far"},
        }
        is_near = 0.0 < ball[0] < 0.5 and -0.25 < ball[1] < 0.25
        faces_goal = goal[0] > 0.0 and -self.aside * goal[0] < goal[1] < self.aside * goal[0]
        if is_near and not faces_goal:
            # Around the ball, which stays in front.
            side = -1.0 if goal[1] > 0.0 else 1.0
            turn = 0.3 * turn_towards(ball) - side * 28.0 * self.step_m / max(ball[0], 0.1)
            walk = [0.1 * (ball[0] - self.reach_m[0]), side * self.step_m / 2.0, turn]
            return {"walk": [rounded(part) for part in walk], **said}
        if is_near and ball[0] < self.reach_m[0] and -self.reach_m[1] < ball[1] < self.reach_m[1]:
            if self.aims:
                direction_deg = rounded(math.degrees(math.atan2(goal[1], goal[0])))
                return {"kick": {"type": "visual", "speed": 3.0, "direction_deg": direction_deg}, **said}
            foot = "left_straight" if ball[1] > 0.0 else "right_straight"
            return {"kick": {"type": foot, "speed": 1.0}, **said}
        if is_near:
            # Slowly, and sideways until the ball lies before the robot.
            walk = [0.1 * (ball[0] - 0.8 * self.reach_m[0]), 0.05 * ball[1], 0.3 * turn_towards(ball)]
            return {"walk": [rounded(part) for part in walk], **said}
        return {"walk": [self.step_m, 0.0, rounded(turn_towards(ball))], **said}


def main(fields=FIELDS, **options):
    """Plays a robot. `options` are those of `Agent`, such as `address`."""
    agent = Agent(name="dribblers", belief=True, fields=fields, **options)
    dribbler = Dribbler(agent.welcome)
    for turn in agent.turns():
        agent.answer(turn, dribbler.decide(turn["perception"], turn["belief"]))


if __name__ == "__main__":
    main()
