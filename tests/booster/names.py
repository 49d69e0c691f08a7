"""Two robots of a match are told apart by their names: each walks as its own program says."""

import os
import sys
import time

import booster_robotics_sdk_python as booster

name, forward_mps = sys.argv[1], float(sys.argv[2])
booster.ChannelFactory.Instance().Init(0, "127.0.0.1")
robot, last = booster.B1LocoClient(), []
robot.InitWithName(name)
odometer = booster.B1OdometerStateSubscriber(lambda message: last.append(message.x))
odometer.InitChannelWithName(name)
if not robot.WaitForService(20000):
    sys.exit(f"{name} is not found")
# The robot is found by one topic after the other: a call before that may have no answer.
while not last:
    time.sleep(0.05)
robot.ChangeMode(booster.RobotMode.kWalking)
robot.Move(forward_mps, 0.0, 0.0)
time.sleep(3.0)
robot.Move(0.0, 0.0, 0.0)
walked_m = last[-1] - last[0]
print(f"{name} walked {walked_m:.2f} m ahead", flush=True)
# Messages that arrive while Python ends crash the SDK: the program leaves without ending Python.
os._exit(0 if 0.5 < walked_m / (3.0 * forward_mps) < 1.3 else 1)
