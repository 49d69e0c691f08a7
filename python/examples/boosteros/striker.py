"""An agent for Booster's Python SDK ``boosteros``: the robot looks for the ball, walks to it and kicks it at the goal.

``naoisis run goal.json --expect "blue.goals >= 1"`` plays a match with it, and checks that it scores.
"""

import math
import time

from boosteros.brain import Detection
from boosteros.robots.booster import BoosterRobot, SoccerKickManager

RATE_HZ = 30.0
KICK_FROM_M = 1.5

robot = BoosterRobot()
kick = SoccerKickManager(robot)
detector = Detection(model="soccer")
camera = robot.get_camera_info()


def bearing(seen):
    """Returns the direction of the detection ``seen`` in the robot frame, rad, positive to the left."""
    head_yaw = robot.get_joint_states()["AAHead_Yaw"].position
    return head_yaw - math.atan2(seen.bbox.center_x - camera.k[0, 2], camera.k[0, 0])


robot.set_gait("soccer")
robot.set_mode("walk")
robot.set_head_angle(pitch=0.4, yaw=0.0)
kicks, goal, unseen = False, None, 0
while True:
    seen = detector.detect(robot.get_image().to_numpy(), confidence=0.4)
    yaw = robot.get_odom().rpy[2]
    ball = next((one for one in seen if one.class_name == "Ball"), None)
    posts = [bearing(one) for one in seen if one.class_name == "Goalpost"]
    if len(posts) == 2:
        goal = yaw + sum(posts) / 2
    unseen = 0 if ball is not None else unseen + 1
    if robot.get_fall_down_state().has_fallen:
        robot.get_up().wait()
        kicks = False
    elif ball is None:
        if unseen > RATE_HZ:
            if kicks:
                kick.stop()
                kicks = False
            robot.set_velocity(0.0, 0.0, -0.8)
    elif kicks or ball.distance_m < KICK_FROM_M:
        if not kicks:
            kick.start()
            kicks = True
        place = ball.distance_m * math.cos(bearing(ball)), ball.distance_m * math.sin(bearing(ball))
        kick.update_command(direction=bearing(ball) if goal is None else goal - yaw, power=8.0)
        kick.update_ball(*place)
    else:
        robot.set_velocity(0.6, 0.0, 1.5 * bearing(ball))
    time.sleep(1.0 / RATE_HZ)
