"""Agents for Booster's Python SDK ``boosteros`` play, by the time of the match."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

STRIKER = Path(__file__).parent.parent / "examples" / "boosteros"
SEES = {
    "league": "hsl2026_middle",
    "rules": "free",
    "duration_s": 4.0,
    "ball": {"position_m": [1.5, 0.0]},
    "robots": [{"team": "blue", "number": 1, "pose": [0, 0, 0]}],
}


def _play(folder, agent, *options, scenario=SEES, runner=()):
    """Plays an agent, which is a text or a path. Returns the trace's lines and what was printed."""
    if isinstance(agent, str):
        (folder / "agent.py").write_text(agent)
        agent = "agent.py"
    (robot,) = scenario["robots"]
    program = [sys.executable, "-m", "naoisis.boosteros", *runner, str(agent)]
    played = {**scenario, "robots": [{**robot, "behaviour": {"program": program}}]}
    (folder / "scenario.json").write_text(json.dumps(played))
    match = [*"run scenario.json --force --agent-start-timeout 120 --trace match.jsonl".split(), *options]
    run = subprocess.run(
        [sys.executable, "-m", "naoisis._command", *match], cwd=folder, capture_output=True, text=True, timeout=300
    )
    text = (folder / "match.jsonl").read_text()
    cycles = [json.loads(line) for line in text.splitlines()][1:-1]
    said = [line.removeprefix("[blue1] ") for line in (run.stdout + run.stderr).splitlines() if "[blue1]" in line]
    return cycles, said, text


def _losses(cycles):
    return [event["message"] for cycle in cycles for event in cycle["events"] if event["kind"] == "agent_lost"]


def test_an_agent_finds_the_ball_and_scores_the_same_each_time(tmp_path):
    scenario = json.loads((STRIKER / "goal.json").read_text())
    scenario["duration_s"] = 12.0
    texts = []
    for _ in range(2):
        cycles, said, text = _play(tmp_path, STRIKER / "striker.py", scenario=scenario)
        assert any(event["kind"] == "goal" for cycle in cycles for event in cycle["events"]), said
        assert not _losses(cycles)
        texts.append(text)
    assert texts[0] == texts[1]


def test_names_that_are_not_known_are_said_when_they_are_used(tmp_path):
    agent = """
from boosteros.robots.booster import BoosterRobot, current_weather
from boosteros.types import TrajectoryData
from boosteros.brain import Detection, Speech
from booster_agent_framework import AgentBase, ToastIcon
import boosteros

robot = BoosterRobot()
assert not hasattr(robot, "speak") and getattr(robot, "say", None) is None
for use in [
    lambda: robot.somersault(),
    lambda: current_weather(),
    lambda: TrajectoryData.load("a.btraj"),
    lambda: Speech(robot),
    lambda: ToastIcon.kNONE,
    lambda: boosteros.Kettle(),
    lambda: AgentBase().storage_manager,
    lambda: Detection(),
]:
    try:
        use()
    except (NotImplementedError, ValueError) as error:
        print(error)
"""
    cycles, said, _ = _play(tmp_path, agent)
    told = [line.split(";")[0].removeprefix("boosteros: ") for line in said]
    names = [
        "BoosterRobot.somersault",
        "boosteros.robots.booster.current_weather",
        "boosteros.types.TrajectoryData.load",
    ]
    names += ["boosteros.brain.Speech", "booster_agent_framework.ToastIcon.kNONE", "boosteros.Kettle"]
    names += ["AgentBase.storage_manager", "the detection model 'default'"]
    assert told[:-1] == [f"{name} is not known to naoisis" for name in names]
    assert "known are BoosterRobot, " in said[1] and "set_velocity" in said[0]
    assert told[-1] == "the agent has ended" and not _losses(cycles)


def test_modes_limits_and_refusals(tmp_path):
    agent = """
import time
from naoisis.boosteros import game
from boosteros.robots.booster import BoosterRobot, SoccerKickManager, LocoClientInitError

robot = BoosterRobot(virtual_robot_name="robot1", enable_tf_listener=False, timeout=10.0, use_sim_time=True)
kick = SoccerKickManager(robot)

def refused(call, error):
    try:
        call()
    except error:
        return True
    return False

assert game()["state"] == "playing" and not game()["penalised"]
assert robot.get_mode() == "walk" and robot.list_gaits() == ["default", "soccer"] and robot.get_gait() == "default"
assert refused(lambda: robot.set_mode("fly"), ValueError) and refused(lambda: robot.set_mode("custom"), RuntimeError)
assert refused(lambda: robot.set_gait("gallop"), ValueError) and refused(lambda: robot.get_up(), RuntimeError)
assert refused(lambda: robot.set_velocity(float("nan"), 0, 0), ValueError)
assert refused(lambda: robot.do_action("bow"), ValueError) and refused(lambda: robot.audio_manager, RuntimeError)
assert refused(lambda: kick.update_command(direction=0.0, power=0.5), ValueError)
assert refused(lambda: BoosterRobot(virtual_robot_name="robot2"), LocoClientInitError)
assert robot.robot_info.model == "Booster K1" and len(robot.list_joints()) == len(robot.get_joint_states().names) == 22

robot.set_velocity(vx=0.5, vy=0.0, vyaw=0.0)
time.sleep(1.0)
x, y, yaw = robot.get_odom().pose_2d
assert 0.2 < x < 0.7 and robot.get_odom().linear_velocity[0] > 0.2, (x, y)
robot.reset_odom()
assert abs(robot.get_odom().pose_2d).max() < 1e-9
robot.set_head_angle(pitch=0.3, yaw=0.5)
time.sleep(0.5)
head = robot.get_joint_states().to_numpy()["position"][:2]
assert abs(head - [0.5, 0.3]).max() < 0.05, head
robot.set_mode("prepare")
assert robot.get_mode() == "prepare" and refused(lambda: robot.set_head_angle(0.0, 0.0), RuntimeError)
robot.set_velocity(0.5, 0.0, 0.0)
time.sleep(1.2)
before = robot.get_odom().pose_2d
time.sleep(0.3)
assert abs(robot.get_odom().pose_2d - before).max() < 0.02
assert robot.get_fall_down_state().is_normal and robot.get_battery().percentage == 100.0
print("as expected")
"""
    _, said, _ = _play(tmp_path, agent)
    assert "as expected" in said, said
    assert "boosteros: set_velocity has no effect in mode prepare" in said


def test_a_robot_that_has_fallen_gets_up(tmp_path):
    agent = """
import time
from boosteros.robots.booster import BoosterRobot

robot, done = BoosterRobot(), []
robot.set_velocity(0.9, 0.0, 0.0)
while not robot.get_fall_down_state().has_fallen:
    time.sleep(0.05)
assert robot.get_mode() == "damping" and robot.get_fall_down_state().recoverable
task = robot.get_up(on_done=done.append)
assert task.running() and not task.cancel()
assert task.wait(timeout=0.1) == "RUNNING"
assert task.wait() in ("SUCCEEDED", "FAILED") and done == [task]
print(task.status, robot.get_mode())
"""
    falls = "--set falls.falls_per_min=60 --set falls.get_up_failure=0".split()
    _, said, _ = _play(tmp_path, agent, *falls, scenario={**SEES, "duration_s": 40.0})
    assert "SUCCEEDED walk" in said, said


THREADS = """
import queue, threading, time
from concurrent.futures import ThreadPoolExecutor
from booster_agent_framework import AgentBase, AgentFeatures, DefaultStateIconComponent, LocaleString
from boosteros.robots.booster import BoosterRobot

class Walker(AgentBase):
    def __init__(self):
        super().__init__(AgentFeatures(enable_auto_getup=True))
        self.robot = BoosterRobot()
        self.stop, self.wake, self.lock, self.orders = threading.Event(), threading.Event(), threading.Lock(), queue.Queue()
        self.seen = 0
        button = DefaultStateIconComponent("go", LocaleString("Go"), "go.png", False, self.on_go)
        self.component_manager.add_component(button)

    def on_agent_activated(self):
        self.logger.info("activated")

    def on_agent_close(self):
        self.stop.set()
        self.worker.join(timeout=2.0)
        self.logger.info(f"closed {self.worker.is_alive()}")

    def on_go(self, component):
        self.worker = threading.Thread(target=self.work, name="worker", daemon=True)
        self.worker.start()
        threading.Thread(target=self.think, daemon=True).start()
        self.robot.subscribe_odom(self.on_odom)
        threading.Timer(1.0, lambda: self.logger.info(f"timer at {time.monotonic():.2f}")).start()

    def on_odom(self, odom):
        with self.lock:
            self.seen += 1

    def think(self):
        begin = time.time()
        with ThreadPoolExecutor(2) as pool:
            self.logger.info(str(list(pool.map(lambda s: (time.sleep(s), s)[1], [0.2, 0.1]))))
        while not self.stop.wait(1 / 30):
            if time.time() - begin > 0.5:
                self.orders.put((0.5, 0.0, 0.0))

    def work(self):
        while not self.stop.is_set():
            try:
                self.robot.set_velocity(*self.orders.get(timeout=0.5))
            except queue.Empty:
                self.logger.info(f"nothing to do at {time.monotonic():.2f}")
"""


def test_threads_live_by_the_time_of_the_match(tmp_path):
    texts = []
    for _ in range(2):
        cycles, said, text = _play(tmp_path, THREADS, runner=["--click", "go"])
        assert not _losses(cycles), said
        expected = [
            "[info] activated",
            "[info] [0.2, 0.1]",
            "[info] nothing to do at 1000.50",
            "[info] timer at 1001.00",
        ]
        assert said[:4] == expected, said
        assert cycles[-1]["robots"][0]["pose"][0] > 0.4
        texts.append(text)
    assert texts[0] == texts[1]


def test_a_thread_that_does_not_wait_is_named(tmp_path):
    agent = """
import threading, time
from boosteros.robots.booster import BoosterRobot

def spin():
    while True:
        pass

robot = BoosterRobot()
time.sleep(0.5)
threading.Thread(target=spin, name="thinker").start()
time.sleep(10.0)
"""
    cycles, said, _ = _play(tmp_path, agent, runner=["--thread-limit", "0.5"])
    assert any("the thread 'thinker' has run for 0.5 s without waiting, at 0.50 s" in line for line in said), said
    assert any("in spin" in line for line in said)
    assert len(_losses(cycles)) == 1 and len(cycles) > 80


def test_an_error_is_shown_and_the_match_goes_on(tmp_path):
    cycles, said, _ = _play(tmp_path, "from boosteros.robots.booster import BoosterRobot\nBoosterRobot()\n1 / 0\n")
    assert said[-1] == "ZeroDivisionError: division by zero"
    assert len(_losses(cycles)) == 1 and len(cycles) > 80


def test_an_agent_in_a_folder_is_found_by_its_agent_toml(tmp_path):
    source = tmp_path / "team" / "src"
    source.mkdir(parents=True)
    (tmp_path / "team" / "agent.toml").write_text('id = "team"\nentry = "src/main.py:Team"\n')
    (source / "words.py").write_text('HELLO = "hello"\n')
    (source / "main.py").write_text("""
import os
from booster_agent_framework import AgentBase
from .words import HELLO

class Mixin:
    pass

class Other(AgentBase):
    pass

class Team(Mixin, AgentBase):
    def on_agent_activated(self):
        self.logger.warn(f"{HELLO} {os.environ['SOCCER_TEAM_ID']} {os.environ['SOCCER_ROBOT_NAMES']}")
""")
    cycles, said, _ = _play(tmp_path, Path("team"))
    assert said == ["[warn] hello 1 blue1"] and not _losses(cycles)
    (source / "words.py").write_text("import rclpy\n")
    cycles, said, _ = _play(tmp_path, Path("team"))
    assert said[-1] == "boosteros: naoisis has no topics of ROS, and tells no agent the truth" and _losses(cycles)


@pytest.mark.parametrize("images", [False, True])
def test_boxes_lie_where_things_are_in_the_image(tmp_path, images):
    agent = """
import time
from boosteros.brain import Detection
from boosteros.robots.booster import BoosterRobot

robot = BoosterRobot()
frames = []
subscription = robot.subscribe_image(lambda image: frames.append(image.size()), img_type="rgb", queue_size=1)
robot.set_head_angle(pitch=0.3, yaw=0.0)
time.sleep(1.0)
subscription.unsubscribe()
image = robot.get_image()
(ball,) = [seen for seen in Detection("soccer").detect(image.to_numpy()) if seen.class_name == "Ball"]
assert ball.class_id == 0 and 1.2 < ball.distance_m < 1.8 and ball.to_dict()["bbox"]["width"] == ball.bbox.width
size = robot.get_camera_info().k[0, 0] * 0.2 / ball.distance_m
assert 0.7 * size < ball.bbox.width < 1.1 * size, (size, ball)
box = image.data[ball.bbox.y : ball.bbox.y + ball.bbox.height, ball.bbox.x : ball.bbox.x + ball.bbox.width]
red, green, blue = box.reshape(-1, 3).mean(axis=0)
print(len(frames), frames[0], bool(green < 1.2 * red and red > 40))
"""
    _, said, _ = _play(tmp_path, agent, runner=["--images", "head"] if images else [])
    assert any(line.endswith(f"(640, 360) {images}") for line in said), said


def test_the_inertial_unit_and_the_calibration_are_those_of_the_robot(tmp_path):
    agent = """
import time
from boosteros.robots.booster import BoosterRobot

robot = BoosterRobot()
robot.set_velocity(0.3, 0.0, 0.0)
turns = []
for _ in range(30):
    time.sleep(0.02)
    turns.append(robot.get_imu().angular_velocity.tolist())
info = robot.get_camera_info()
print("rocks", any(abs(turn[0]) > 0.01 for turn in turns), round(float(robot.get_imu().linear_acceleration[2])))
print("camera", info.k.round(1).tolist(), info.d.tolist(), info.distortion_model)
"""
    _, said, _ = _play(tmp_path, agent, "--set", "sensors.imu={}")
    assert "rocks True 10" in said, said
    assert (
        "camera [[264.3, 0.0, 319.5], [0.0, 264.3, 179.5], [0.0, 0.0, 1.0]] [0.0, 0.0, 0.0, 0.0, 0.0] plumb_bob" in said
    )
    calibration = '{"fx": 500, "fy": 510, "cx": 639.5, "cy": 359.5, "size": [1280, 720], "distortion": [-0.1, 0.02]}'
    _, said, _ = _play(tmp_path, agent, "--set", f"cameras.intrinsics={calibration}")
    assert (
        "camera [[250.0, 0.0, 319.5], [0.0, 255.0, 179.5], [0.0, 0.0, 1.0]] [-0.1, 0.02, 0.0, 0.0, 0.0] plumb_bob"
        in said
    )
