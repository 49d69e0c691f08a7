"""A program of the maker's SDK that hears the buttons of its robot and of the remote controller."""

import os
import time

import booster_robotics_sdk_python as booster

booster.ChannelFactory.Instance().Init(0, "127.0.0.1")
heard, remote = [], []
buttons = booster.B1ButtonEventSubscriber(lambda message: heard.append((str(message.event).split(".")[-1], message.button)))
controller = booster.B1RemoteControllerStateSubscriber(lambda message: remote.append((message.event, message.start)))
for subscriber in (buttons, controller):
    subscriber.InitChannel()
robot = booster.B1LocoClient()
robot.Init()
robot.WaitForService(10000)
robot.ChangeMode(booster.RobotMode.kWalking)
time.sleep(5.5)
assert heard == [("PRESS_DOWN", 1), ("PRESS_UP", 1)], heard
# Of a hundred cycles a second, every other one has a message: no event is lost.
events = [event for event, _ in remote if event]
assert events == [0x603, 0x604] and any(start for _, start in remote), (events, len(remote))
print("buttons of the robot and of the remote controller are heard", flush=True)
# Messages that arrive while Python ends crash the SDK: the program leaves without ending Python.
os._exit(0)
