"""A program for Booster's SDK (PyPI `booster_robotics_sdk_python`), which knows nothing of naoisis: it counts what the robot publishes and whether
every call is answered, and then scores. It ends when the robot is gone, or with status 1 if something was not as on a robot."""

import math
import os
import sys
import time

import booster_robotics_sdk_python as booster

CALLS = 1000
LISTEN_S = 4.0
RATE_HZ = 50.0


class Counter:
    """Counts the messages of a topic, and keeps what `read` takes from the last one: the SDK's messages live no longer than its calls."""

    def __init__(self, subscriber, read=lambda message: None):
        self.count, self.last, self.read = 0, None, read
        self.subscriber = subscriber(self.receive)
        self.subscriber.InitChannel()

    def receive(self, message):
        self.count, self.last = self.count + 1, self.read(message)


def expect(what, holds):
    print(("ok      " if holds else "FAILED  ") + what, flush=True)
    if not holds:
        sys.exit(1)


def refused(call):
    """The code of a refusal; 0 if there was none."""
    try:
        call()
    except Exception as error:
        digits = [word for word in str(error).replace(":", " ").replace(",", " ").split() if word.lstrip("-").isdigit()]
        return int(digits[-1]) if digits else -1
    return 0


def ball_of(vision):
    """The ball that the robot sees, m, robot frame."""
    for seen in vision.GetDetectionObject(1.0):
        if seen.tag == "Ball":
            return seen.position[0], seen.position[1]
    return None


def goal_direction(vision):
    """The direction of the middle of the goal posts that the robot sees, radians."""
    posts = [math.atan2(seen.position[1], seen.position[0]) for seen in vision.GetDetectionObject(1.0) if seen.tag == "Goalpost"]
    return sum(posts) / len(posts) if len(posts) == 2 else None


booster.ChannelFactory.Instance().Init(0, "127.0.0.1")
robot, vision = booster.B1LocoClient(), booster.VisionClient()
robot.Init()
vision.Init()
topics = {
    "odometer_state": Counter(booster.B1OdometerStateSubscriber, lambda odometer: (odometer.x, odometer.y, odometer.theta)),
    "low_state": Counter(booster.B1LowStateSubscriber, lambda state: [motor.q for motor in state.motor_state_serial]),
    "fall_down": Counter(booster.B1FallDownStateSubscriber),
    "battery_state": Counter(booster.B1BatteryStateSubscriber),
    "robot_states": Counter(booster.B1RobotStatesSubscriber),
}
expect("the robot's service is found", robot.WaitForService(20000))
while any(topic.count == 0 for topic in topics.values()):
    time.sleep(0.05)

start, before = time.monotonic(), {name: topic.count for name, topic in topics.items()}
time.sleep(LISTEN_S)
elapsed_s = time.monotonic() - start
for name, topic in topics.items():
    rate_hz = (topic.count - before[name]) / elapsed_s
    expect(f"{name}: {rate_hz:.1f} messages a second", abs(rate_hz - RATE_HZ) < 2.0)
expect("the head is in two of 22 motors", len(topics["low_state"].last) == 22)

expect("the robot is prepared", refused(lambda: robot.ChangeMode(booster.RobotMode.kPrepare)) == 0)
expect("it does not walk then", refused(lambda: robot.Move(0.5, 0.0, 0.0)) != 0)
expect("it does not dance", refused(lambda: robot.Dance(booster.DanceId.kNewYear)) != 0)
robot.ChangeMode(booster.RobotMode.kWalking)
expect("it says its mode", robot.GetMode().mode == booster.RobotMode.kWalking)
expect("it says its model", robot.GetRobotInfo().model == "booster_k1")

start, lost = time.monotonic(), 0
for _ in range(CALLS):
    lost += refused(lambda: robot.Move(0.0, 0.0, 0.0)) != 0
expect(f"{CALLS} calls, {lost} lost, {(time.monotonic() - start) / CALLS * 1000:.2f} ms each", lost == 0)

robot.RotateHead(0.5, 0.3)
time.sleep(1.0)
yaw, pitch = topics["low_state"].last[:2]
expect(f"the head turns: yaw {yaw:.2f}, pitch {pitch:.2f}", abs(yaw - 0.3) < 0.05 and abs(pitch - 0.5) < 0.05)
robot.RotateHead(0.3, 0.0)
robot.ResetOdometry()

# Walks to the ball by what it sees, and kicks from one metre.
vision.StartVisionService(True, False, False)
aim = booster.B1VisualKickReferencePublisher()
aim.InitChannel()
heading, seen_s = None, time.monotonic()
while True:
    ball, direction = ball_of(vision), goal_direction(vision)
    if direction is not None:
        heading = topics["odometer_state"].last[2] + direction
    if ball is None:
        robot.Move(0.0, 0.0, 0.6 if time.monotonic() - seen_s > 1.0 else 0.0)
        expect("the ball is found", time.monotonic() - seen_s < 15.0)
        time.sleep(0.05)
        continue
    seen_s, (x, y) = time.monotonic(), ball
    if math.hypot(x, y) < 1.0:
        break
    robot.Move(0.6, 0.0, 1.5 * math.atan2(y, x))
    time.sleep(0.05)
walked_m = topics["odometer_state"].last[0]
expect(f"it has walked: {walked_m:.2f} m ahead by odometry", walked_m > 0.3)
robot.VisualKick(True)
for _ in range(600):
    if heading is not None:
        kick = booster.Kick()
        kick.dir = heading - topics["odometer_state"].last[2]
        aim.Write(kick)
    if refused(robot.GetMode) != 0:
        break
    time.sleep(0.05)
# Messages that arrive while Python ends crash the SDK: the program leaves without ending Python.
os._exit(0)
