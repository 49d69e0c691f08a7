"""The robot of ``boosteros.robots.booster``: what it can be asked, and what it does then in the match."""

from __future__ import annotations

import math
import sys
import threading
import traceback
from collections.abc import Callable
from functools import partial
from typing import Any, Literal, NoReturn, get_args

import numpy as np

from naoisis.boosteros import _unknown
from naoisis.boosteros.kick import MOST_POWER, Kick, Place, Pose, to_robot, wrap
from naoisis.boosteros.link import Link
from naoisis.boosteros.types import (
    BatteryState,
    CameraInfo,
    FallDownState,
    Header,
    Image,
    ImageType,
    IMUState,
    JointInfo,
    JointLimits,
    JointState,
    JointStates,
    OdomState,
    RobotInfo,
    SensorSubscription,
    TaskHandle,
    quaternion_of,
)

RobotModeName = Literal["damping", "prepare", "walk", "custom"]
RobotGaitName = Literal["default", "soccer"]

# The joints of a K1. The head's are the first two; the others are at rest.
_SIDES = ("Left", "Right")
_ARM = ("Shoulder_Pitch", "Shoulder_Roll", "Elbow_Pitch", "Elbow_Yaw")
_LEG = ("Hip_Pitch", "Hip_Roll", "Hip_Yaw", "Knee_Pitch", "Ankle_Pitch", "Ankle_Roll")
_JOINTS = (
    *("AAHead_Yaw", "Head_Pitch"),
    *(f"{'A' if joint == 'Shoulder_Pitch' else ''}{side}_{joint}" for side in _SIDES for joint in _ARM),
    *(f"{side}_{joint}" for side in _SIDES for joint in _LEG),
)
_GRAVITY_MPS2 = 9.81
# What the SDK has and the simulated robot has not.
_ABSENT = {
    **dict.fromkeys(("list_frames", "get_transform"), "frames"),
    **dict.fromkeys(("set_joints", "upper_body_control", "execute_trajectory"), "joints that can be commanded"),
    **dict.fromkeys(("hand_guiding_manager", "audio_manager", "play_sound"), "hands, microphones and loudspeakers"),
    "get_active_tasks": "list of tasks",
}


class LocoClientInitError(RuntimeError):
    """There is no such robot."""


class DataNotReadyError(RuntimeError):
    """There is no such data."""


class Firmware:
    """What the robot's own software keeps: its mode, and what the agent wants of it. One for each process."""

    def __init__(self, link: Link):
        self.link = link
        self.name: str | None = None
        self.mode: RobotModeName = "walk"
        self.gait: RobotGaitName = "default"
        self.velocity: Pose = (0.0, 0.0, 0.0)
        self.head: Place | None = None
        self.kick: Kick | None = None
        self.wants_up = False
        self.gets_up_itself = False
        self.zero: Pose = (0.0, 0.0, 0.0)
        self._said: set[str] = set()
        link.command = self.command

    @property
    def body(self) -> str:
        """The state of the body, as in perceptions."""
        return str(self.link.perception["body"])

    @property
    def is_upright(self) -> bool:
        return self.body not in ("fallen", "getting_up", "diving")

    @property
    def odometry(self) -> Pose:
        """The pose by odometry, from the start of the match."""
        return self.link.odometry

    def say_once(self, what: str) -> None:
        """Says something on the terminal if it was not said before."""
        if what not in self._said:
            self._said.add(what)
            print(f"boosteros: {what}", file=sys.stderr)

    def stop(self) -> None:
        """Forgets what the agent wants of the legs."""
        self.velocity, self.kick, self.wants_up = (0.0, 0.0, 0.0), None, False

    def command(self) -> dict[str, Any]:
        """The command of a cycle."""
        command: dict[str, Any] = {}
        if self.head is not None:
            command["head_deg"] = [math.degrees(angle) for angle in self.head]
        if self.body == "fallen" and (self.wants_up or self.gets_up_itself):
            command["posture"] = "get_up"
        if not self.is_upright or self.body == "penalised" or self.mode != "walk":
            self.stop()
            return command
        velocity = self.velocity
        if self.kick is not None:
            velocity, request = self.kick.act(self.odometry, self.body == "kicking")
            if request is not None and self.body in ("standing", "walking"):
                command["kick"] = request
        if any(velocity):
            x, y, turn = (speed * self.link.cycle_s for speed in velocity)
            command["walk"] = [x, y, math.degrees(turn)]
        return command


# The robot of this process; the runner puts it here.
_firmwares: list[Firmware] = []


def firmware() -> Firmware:
    """The robot of this process, in its match."""
    if not _firmwares:
        raise LocoClientInitError("boosteros: no match; start the agent with `python -m naoisis.boosteros AGENT.py`")
    _firmwares[0].link.connect()
    return _firmwares[0]


def _one_of(name: str, value: str, words: Any) -> None:
    if value not in get_args(words):
        raise ValueError(f"{name} is {value!r}, and must be one of {', '.join(get_args(words))}")


def _finite(name: str, value: float) -> float:
    number = float(value)
    if not math.isfinite(number):
        raise ValueError(f"{name} is {value}, and must be finite")
    return number


class BoosterRobot:
    """The robot of this process.

    `virtual_robot_name` may be any name, but the same in the whole process: each robot of a match has a process of its own.
    """

    def __init__(
        self,
        network_interface: str = "",
        virtual_robot_name: str = "",
        *,
        timeout: float = 5.0,
        callback_workers: int = 4,
        enable_tf_listener: bool = True,
        **kwargs: Any,
    ):
        self._firmware = own = firmware()
        if virtual_robot_name and own.name not in (None, virtual_robot_name):
            raise LocoClientInitError(
                f"boosteros: this process plays {own.link.robot}, as {own.name!r}, and no robot {virtual_robot_name!r}: "
                "in naoisis each robot has its own process"
            )
        own.name = virtual_robot_name or own.name

    def __getattr__(self, name: str) -> Any:
        if name in _ABSENT:
            raise RuntimeError(f"boosteros: BoosterRobot.{name}: the simulated robot has no {_ABSENT[name]}")
        _unknown.refuse(f"BoosterRobot.{name}", dir(type(self)))

    def _close(self) -> None:
        self._firmware.stop()

    # What it is and how it is.

    @property
    def robot_info(self) -> RobotInfo:
        """Manufacturer, model and names."""
        link = self._firmware.link
        maker, _, model = str(link.model["name"]).partition("_")
        maker = maker.title()
        return RobotInfo(f"{maker} Robotics", f"{maker} {model.upper()}", link.robot, link.robot, "naoisis")

    def get_mode(self) -> RobotModeName:
        """The mode. A robot that lies or gets up is in `damping`, a guess; then it is in the mode from before."""
        return self._firmware.mode if self._firmware.is_upright else "damping"

    def list_gaits(self) -> list[RobotGaitName]:
        """The names of gaits."""
        return list(get_args(RobotGaitName))

    def get_gait(self) -> RobotGaitName:
        """The gait that was set."""
        return self._firmware.gait

    def list_actions(self) -> list[Any]:
        """No actions: the simulated robot has no arms that move."""
        return []

    def list_joints(self) -> list[JointInfo]:
        """The joints. Those that do not move in naoisis have limits of 0."""
        head = self._firmware.link.model["head"]
        limits = [np.radians(head[name]) for name in ("yaw_deg", "pitch_deg")] + [[0.0, 0.0]] * (len(_JOINTS) - 2)
        return [JointInfo(name, JointLimits(float(least), float(most))) for name, (least, most) in zip(_JOINTS, limits)]

    # What it senses.

    def get_image(self, camera_id: str = "", img_type: ImageType = "rgb") -> Image:
        """The newest image: black if images are not rendered (option `--images` of the runner)."""
        _one_of("img_type", img_type, ImageType)
        if img_type == "depth":
            raise DataNotReadyError("boosteros: the simulated robot has no depth image")
        link = self._firmware.link
        if link.image is not None:
            width, height, rgb = (link.image[name] for name in ("width", "height", "rgb"))
            pixels = np.frombuffer(rgb, np.uint8).reshape(height, width, 3).copy()
        else:
            self._firmware.say_once("images are black without the option `--images head`; detections need none")
            pixels = np.zeros((link.camera.height, link.camera.width, 3), np.uint8)
        return Image(pixels, "rgb8", header=Header(frame_id="head_color_optical_frame"))

    def get_camera_info(self, camera_id: str = "") -> CameraInfo:
        """The calibration."""
        camera = self._firmware.link.camera
        (fx, fy), (cx, cy) = camera.focal, camera.centre
        # In ROS the middle of the first pixel is at (0, 0).
        k = np.array([[fx, 0, cx - 0.5], [0, fy, cy - 0.5], [0, 0, 1]])
        p = np.hstack([k, np.zeros((3, 1))])
        return CameraInfo(
            camera.width, camera.height, k, np.array(camera.distortion), np.eye(3), p, camera.distortion_model
        )

    def get_imu(self, imu_id: str = "") -> IMUState:
        """The inertial unit, with the yaw by odometry. A robot without one is upright and its speed is even, or it lies on its face."""
        own = self._firmware
        unit = (own.link.perception.get("sensors") or {}).get("imu")
        if unit is not None:
            roll, pitch = np.radians(unit["tilt_deg"])
            orientation = quaternion_of(float(pitch), own.odometry[2], float(roll))
            return IMUState(np.array(unit["acceleration_mps2"]), np.radians(unit["turn_degps"]), orientation)
        lies = self._firmware.body == "fallen"
        acceleration = np.array([-_GRAVITY_MPS2, 0.0, 0.0] if lies else [0.0, 0.0, _GRAVITY_MPS2])
        orientation = quaternion_of(math.pi / 2 if lies else 0.0, self._firmware.odometry[2])
        return IMUState(acceleration, np.array([0.0, 0.0, self._firmware.link.speed[2]]), orientation)

    def get_odom(self) -> OdomState:
        """The pose by odometry since the start or `reset_odom`, with its errors."""
        own = self._firmware
        x, y = to_robot(own.zero, own.odometry[:2])
        forward, left, turn = own.link.speed
        return OdomState(
            child_frame_id="base_link",
            position=np.array([x, y, 0.0]),
            orientation=quaternion_of(0.0, own.odometry[2] - own.zero[2]),
            linear_velocity=np.array([forward, left, 0.0]),
            angular_velocity=np.array([0.0, 0.0, turn]),
            header=Header(frame_id="odom"),
        )

    def reset_odom(self) -> None:
        """Begins odometry here."""
        self._firmware.zero = self._firmware.odometry

    def get_joint_states(self) -> JointStates:
        """The joints: the head's as they are, the others at rest."""
        head = [math.radians(angle) for angle in self._firmware.link.perception["head_deg"]]
        angles = [*head, *[0.0] * (len(_JOINTS) - 2)]
        return JointStates([JointState(name, angle) for name, angle in zip(_JOINTS, angles)])

    def get_battery(self) -> BatteryState:
        """A full battery."""
        return BatteryState()

    def get_fall_down_state(self) -> FallDownState:
        """Whether it has fallen, which it knows at once."""
        states = {"diving": "falling", "fallen": "fallen", "getting_up": "getting_up"}
        state = states.get(self._firmware.body, "normal")
        return FallDownState(state, state == "fallen")

    # `queue` are `queue_size` and `overflow`: what comes while a callback waits is dropped but for the newest.

    def subscribe_image(
        self, callback: Callable[[Image], None], *, camera_id: str = "", img_type: ImageType = "rgb", **queue: Any
    ) -> SensorSubscription:
        """Calls `callback` for each image, or what the robot recognises in it."""
        link = self._firmware.link
        return self._subscribe(callback, lambda: self.get_image(camera_id, img_type), lambda: link.image_time_s)

    def subscribe_imu(
        self, callback: Callable[[IMUState], None], *, imu_id: str = "", **queue: Any
    ) -> SensorSubscription:
        """Calls `callback` in each cycle."""
        return self._subscribe(callback, self.get_imu)

    def subscribe_odom(self, callback: Callable[[OdomState], None], **queue: Any) -> SensorSubscription:
        """Calls `callback` in each cycle."""
        return self._subscribe(callback, self.get_odom)

    def subscribe_battery(self, callback: Callable[[BatteryState], None], **queue: Any) -> SensorSubscription:
        """Calls `callback` in each cycle."""
        return self._subscribe(callback, self.get_battery)

    def subscribe_fall_down_state(self, callback: Callable[[FallDownState], None], **queue: Any) -> SensorSubscription:
        """Calls `callback` in each cycle."""
        return self._subscribe(callback, self.get_fall_down_state)

    def _subscribe(
        self, callback: Callable[[Any], None], read: Callable[[], object], number: Callable[[], float] | None = None
    ) -> SensorSubscription:
        clock, subscription = self._firmware.link.clock, SensorSubscription()
        newest = number or (lambda: clock.cycle)

        def is_due(last: float | None) -> bool:
            return subscription._is_over or newest() != last

        def deliver() -> None:
            last: float | None = None
            while clock.wait(partial(is_due, last)) and not subscription._is_over:
                last = newest()
                try:
                    callback(read())
                except Exception:
                    traceback.print_exc()

        threading.Thread(target=deliver, name="subscription", daemon=True).start()
        return subscription

    # What it does.

    def set_mode(self, mode_name: RobotModeName) -> None:
        """Changes the mode, at once. A robot that lies can only go to `damping`; there is no `custom` mode."""
        own = self._firmware
        _one_of("mode_name", mode_name, RobotModeName)
        if mode_name == "custom":
            raise RuntimeError("boosteros: the simulated robot has no joints that can be commanded, and no custom mode")
        if mode_name != "damping" and not own.is_upright:
            raise RuntimeError(f"boosteros: the robot is {own.body} and cannot change to mode {mode_name}")
        if mode_name != own.mode:
            own.stop()
        own.mode = mode_name

    def set_gait(self, gait: RobotGaitName) -> None:
        """Keeps the gait, which changes nothing."""
        _one_of("gait", gait, RobotGaitName)
        self._firmware.gait = gait

    def set_velocity(self, vx: float, vy: float, vyaw: float) -> None:
        """Walks with this velocity, m/s and rad/s, until it is told otherwise, falls or is penalised.

        Without effect in other modes than `walk`, for a robot that lies, and during a kick; the terminal says so once.
        """
        own = self._firmware
        velocity = (_finite("vx", vx), _finite("vy", vy), _finite("vyaw", vyaw))
        if self.get_mode() != "walk":
            own.say_once(f"set_velocity has no effect in mode {self.get_mode()}")
        elif own.kick is not None:
            own.say_once("set_velocity has no effect during a kick")
        else:
            own.velocity = velocity

    def set_head_angle(self, pitch: float, yaw: float) -> None:
        """Turns the head: `pitch` down and `yaw` to the left, radians."""
        if self.get_mode() != "walk":
            raise RuntimeError(f"boosteros: the head cannot be turned in mode {self.get_mode()}")
        self._firmware.head = (_finite("yaw", yaw), _finite("pitch", pitch))

    def get_up(self, *, on_done: Callable[[TaskHandle], None] | None = None) -> TaskHandle:
        """Gets up. The task fails if the robot lies again."""
        own = self._firmware
        if own.body != "fallen":
            raise RuntimeError(f"boosteros: the robot is {own.body} and cannot get up")
        own.wants_up = True
        wait = own.link.clock.wait
        task = TaskHandle("get_up", wait)
        if on_done is not None:
            task.add_done_callback(on_done)

        def watch() -> None:
            wait(lambda: own.body != "fallen", 1.0)
            wait(lambda: own.body != "getting_up")
            task._finish("FAILED" if own.body == "fallen" else "SUCCEEDED")

        threading.Thread(target=watch, name="get_up", daemon=True).start()
        return task

    def do_action(self, action_id: str, **callbacks: Any) -> NoReturn:
        """Says that there is no such action."""
        raise ValueError(f"boosteros: the simulated robot has no action {action_id!r}, and no others")


class SoccerKickManager:
    """The kick that goes to the ball by itself, within 4 m. It has the legs until it is stopped."""

    def __init__(self, robot: BoosterRobot):
        self._firmware = robot._firmware

    def __getattr__(self, name: str) -> Any:
        _unknown.refuse(f"SoccerKickManager.{name}", dir(type(self)))

    def start(self) -> None:
        """Changes to the soccer gait and the mode `walk`, and begins."""
        own = self._firmware
        if not own.is_upright:
            raise RuntimeError(f"boosteros: the robot is {own.body} and cannot begin to kick")
        own.mode, own.gait, own.velocity = "walk", "soccer", (0.0, 0.0, 0.0)
        own.kick = own.kick or Kick(own.link.model["kicks"])

    def update_command(self, direction: float, power: float) -> None:
        """Where the ball shall go from the robot, radians to the left of ahead; and how fast, from 1 to 10, which is the fastest kick."""
        direction = _finite("direction", direction)
        if not 1.0 <= power <= MOST_POWER:
            raise ValueError(f"power is {power}, and must be from 1 to {MOST_POWER:g}")
        self._on().aim(wrap(self._firmware.odometry[2] + direction), power)

    def update_ball(self, x: float, y: float) -> None:
        """Where the ball is from the robot, m. Without it the robot stands; it goes on for a second without another one."""
        ball = (_finite("x", x), _finite("y", y))
        self._on().see(self._firmware.odometry, ball)

    def stop(self) -> None:
        """Ends it, and stands."""
        self._firmware.kick = None

    def _on(self) -> Kick:
        """The kick, or one that does nothing."""
        if self._firmware.kick is None:
            self._firmware.say_once(
                "the kick is not on: it ends when the robot falls, is penalised or leaves the mode walk"
            )
        return self._firmware.kick or Kick({})


def current_debug_trace() -> None:
    """No trace: messages are not traced."""


def __getattr__(name: str) -> Any:
    return _unknown.placeholder("boosteros.robots.booster", name, __all__)


__all__ = [
    "BoosterRobot",
    "DataNotReadyError",
    "FallDownState",
    "LocoClientInitError",
    "RobotGaitName",
    "RobotModeName",
    "SoccerKickManager",
    "current_debug_trace",
]
