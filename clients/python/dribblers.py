"""A small team: finds the ball, dribbles it, shoots, and tells its team-mates.

    naoisis run match3v3 --blue "exec:python3 clients/python/dribblers.py"

The same team in other languages plays the same match: all of its arithmetic is additions, products and comparisons of
numbers in double precision.
"""

from naoisis_agent import play

# How far a robot walks and turns in a cycle, m and degrees.
STEP_M = 0.006
TURN_DEG = 3.0
# A ball this near, and this far to one side, can be kicked.
REACH_M = 0.17
FOOT_M = 0.08
# What it looks at of what its robot perceives: the rest need not be sent.
FIELDS = ["body", "game.own_end", "game.penalised", "game.state", "percepts.ball", "percepts.goal_posts"]


def opponents_goal(perception):
    """The middle between the posts of the goal that is attacked, m, as far as they are seen."""
    own_end = perception["game"]["own_end"]
    colour = "yellow" if own_end == "negative_x" else "blue"
    posts = [post["position_m"] for post in perception["percepts"]["goal_posts"] if post["colour"] == colour]
    if not posts:
        return None
    return [sum(post[0] for post in posts) / len(posts), sum(post[1] for post in posts) / len(posts)]


def turn_towards(place):
    """Degrees of a cycle's turn to a place in the robot's frame."""
    x, y = place
    if x > 0.0 and -0.1 * x < y < 0.1 * x:
        return 0.0
    return TURN_DEG if y > 0.0 else -TURN_DEG


def decide(perception):
    if perception["game"]["penalised"] or perception["game"]["state"] != "playing":
        return {}
    if perception["body"] == "fallen":
        return {"posture": "get_up"}
    ball = perception["percepts"]["ball"]
    if ball is None:
        # Where a team-mate sees it, it will be looked for first.
        return {"walk": [0.0, 0.0, TURN_DEG], "head_deg": [0.0, 15.0]}
    x, y = ball["position_m"]
    say = {"intention": "dribble", "payload": "near" if x < 1.0 else "far"}
    # A ball at the feet is seen only with the head down.
    head = [0.0, 25.0 if x < 0.5 else 0.0]
    goal = opponents_goal(perception)
    if x < REACH_M and -FOOT_M < y < FOOT_M:
        if goal is not None and turn_towards(goal) == 0.0:
            foot = "left_straight" if y > 0.0 else "right_straight"
            return {"kick": {"type": foot, "speed": 1.0}, "head_deg": head, "say": say}
        if goal is None:
            # Around the ball, until the goal comes into view.
            return {"walk": [0.0, STEP_M / 2.0, -TURN_DEG], "head_deg": [0.0, 0.0], "say": say}
    return {"walk": [STEP_M, 0.0, turn_towards([x, y])], "head_deg": head, "say": say}


if __name__ == "__main__":
    play(decide, name="dribblers", fields=FIELDS)
