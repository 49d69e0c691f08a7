"""The data of ``boosteros.types``: what a robot says of itself."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, field
from typing import Any, Literal

import numpy as np

from naoisis.boosteros import _unknown

ImageType = Literal["rgb", "depth"]
TaskStatus = Literal["PENDING", "RUNNING", "CANCELLING", "SUCCEEDED", "FAILED", "CANCELLED"]


class Time:
    """A point in time, in nanoseconds; without them the time of the match."""

    def __init__(self, nanoseconds: int | None = None):
        self.nanoseconds = time.time_ns() if nanoseconds is None else nanoseconds
        self.seconds = self.nanoseconds / 1e9
        self.sec, self.nanosec = divmod(self.nanoseconds, 10**9)

    @classmethod
    def now(cls) -> Time:
        """The time of the match."""
        return cls()


class Header:
    """When data was taken, and in which frame it is."""

    def __init__(self, stamp: Time | None = None, frame_id: str = ""):
        self.stamp, self.frame_id = stamp or Time(), frame_id
        self.timestamp, self.sec, self.nanosec = self.stamp.seconds, self.stamp.sec, self.stamp.nanosec


@dataclass(kw_only=True)
class Stamped:
    """Data with a header."""

    header: Header = field(default_factory=Header)

    @property
    def timestamp(self) -> float:
        return self.header.timestamp

    @property
    def frame_id(self) -> str:
        return self.header.frame_id


def rpy_of(quaternion: np.ndarray) -> np.ndarray:
    """Roll, pitch and yaw of a quaternion `[x, y, z, w]`, radians."""
    x, y, z, w = (float(number) for number in quaternion)
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(min(max(2 * (w * y - z * x), -1.0), 1.0))
    return np.array([roll, pitch, math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))])


def quaternion_of(pitch: float, yaw: float, roll: float = 0.0) -> np.ndarray:
    """The quaternion `[x, y, z, w]` of a robot with these angles, radians: turned by the yaw, then the pitch, then the roll."""
    (sp, cp), (sy, cy), (sr, cr) = ((math.sin(angle / 2), math.cos(angle / 2)) for angle in (pitch, yaw, roll))
    return np.array(
        [
            cy * cp * sr - sy * sp * cr,
            cy * sp * cr + sy * cp * sr,
            sy * cp * cr - cy * sp * sr,
            cy * cp * cr + sy * sp * sr,
        ]
    )


@dataclass
class Image(Stamped):
    """An image, an array of height by width by colours."""

    data: np.ndarray
    encoding: str = "unknown"

    @property
    def width(self) -> int:
        return int(self.data.shape[1])

    @property
    def height(self) -> int:
        return int(self.data.shape[0])

    def size(self) -> tuple[int, int]:
        """Width and height."""
        return self.width, self.height

    def to_numpy(self) -> np.ndarray:
        """The array."""
        return self.data

    def to_pil(self) -> Any:
        """The same for Pillow, which must be installed."""
        import PIL.Image  # type: ignore[import-not-found, unused-ignore]

        return PIL.Image.fromarray(self.data)

    def save(self, path: str, **kwargs: Any) -> None:
        """Writes it to a file by Pillow."""
        self.to_pil().save(path, **kwargs)


AnyImage = Image


@dataclass(frozen=True)
class BoundingBox2D:
    """A box in an image, pixels."""

    x: int
    y: int
    width: int
    height: int

    @property
    def center_x(self) -> float:
        return self.x + self.width / 2

    @property
    def center_y(self) -> float:
        return self.y + self.height / 2

    @property
    def area(self) -> int:
        return self.width * self.height

    def to_dict(self) -> dict[str, int]:
        return asdict(self)


@dataclass(frozen=True)
class DetectionResult:
    """An object in an image."""

    class_name: str
    class_id: int
    confidence: float
    bbox: BoundingBox2D
    mask: object | None = None
    keypoints: object | None = None
    distance_m: float | None = None

    def to_dict(self) -> dict[str, Any]:
        """Class, confidence and box."""
        return {name: asdict(self)[name] for name in ("class_name", "class_id", "confidence", "bbox")}


@dataclass
class CameraInfo(Stamped):
    """The calibration of a camera."""

    width: int
    height: int
    k: np.ndarray
    d: np.ndarray
    r: np.ndarray
    p: np.ndarray
    distortion_model: str = "plumb_bob"


@dataclass
class IMUState(Stamped):
    """The readings of an inertial unit, m/s² and rad/s."""

    linear_acceleration: np.ndarray
    angular_velocity: np.ndarray
    orientation: np.ndarray

    @property
    def rpy(self) -> np.ndarray:
        return rpy_of(self.orientation)


@dataclass
class OdomState(Stamped):
    """Pose and velocity by odometry, m and radians."""

    child_frame_id: str
    position: np.ndarray
    orientation: np.ndarray
    linear_velocity: np.ndarray
    angular_velocity: np.ndarray

    @property
    def rpy(self) -> np.ndarray:
        return rpy_of(self.orientation)

    @property
    def pose_2d(self) -> np.ndarray:
        """x, y and yaw."""
        return np.array([self.position[0], self.position[1], self.rpy[2]])


@dataclass
class BatteryState(Stamped):
    """A full battery."""

    percentage: float = 100.0
    power_supply_status: str = "Full"
    is_charging: bool = False
    is_low: bool = False
    is_critical: bool = False


@dataclass
class FallDownState(Stamped):
    """Whether the robot has fallen: `normal`, `falling`, `fallen` or `getting_up`."""

    state: str
    recoverable: bool = False

    def __post_init__(self) -> None:
        self.is_normal, self.is_falling = self.state == "normal", self.state == "falling"
        self.has_fallen, self.is_getting_up = self.state == "fallen", self.state == "getting_up"


@dataclass
class JointState:
    """The state of a joint, radians, rad/s and Nm."""

    name: str
    position: float
    velocity: float = 0.0
    effort: float = 0.0


@dataclass
class JointStates(Stamped):
    """The states of all joints."""

    joints: list[JointState]

    @property
    def names(self) -> list[str]:
        return [joint.name for joint in self.joints]

    def get_joint(self, name: str) -> JointState | None:
        """The joint of this name."""
        return next((joint for joint in self.joints if joint.name == name), None)

    def __getitem__(self, name: str) -> JointState:
        return {joint.name: joint for joint in self.joints}[name]

    def __iter__(self) -> Iterator[JointState]:
        return iter(self.joints)

    def to_numpy(self) -> dict[str, Any]:
        """Names and arrays of numbers."""
        numbers = ("position", "velocity", "effort")
        return {"name": self.names, **{name: np.array([getattr(joint, name) for joint in self]) for name in numbers}}


@dataclass(frozen=True)
class RobotInfo:
    """The names of a robot."""

    manufacturer: str
    model: str
    name: str
    serial_number: str
    firmware_version: str


@dataclass(frozen=True)
class JointLimits:
    """Least and greatest angle of a joint, radians."""

    min: float
    max: float


@dataclass(frozen=True)
class JointInfo:
    """What does not change about a joint."""

    name: str
    limits: JointLimits
    max_torque: float | None = None
    max_velocity: float | None = None


class TaskHandle:
    """A task that runs. It cannot be cancelled."""

    def __init__(self, task_id: str, wait: Callable[[Callable[[], bool], float | None], bool]):
        self.task_id = self.type = task_id
        self.group = "motion"
        self.status: TaskStatus = "RUNNING"
        self.error: Exception | None = None
        self._wait = wait
        self._callbacks: list[Callable[[TaskHandle], None]] = []

    def __class_getitem__(cls, result: object) -> type[TaskHandle]:
        return cls

    def wait(self, timeout: float | None = None) -> TaskStatus:
        """Waits until it has ended. Returns its status then, or when the time is over."""
        self._wait(self.done, timeout)
        return self.status

    def cancel(self) -> bool:
        """Does nothing, and says so."""
        return False

    def done(self) -> bool:
        """Whether it has ended."""
        return self.status in ("SUCCEEDED", "FAILED", "CANCELLED")

    def running(self) -> bool:
        """Whether it runs."""
        return not self.done()

    def add_done_callback(self, fn: Callable[[TaskHandle], None]) -> None:
        """Calls this when it has ended."""
        if self.done():
            fn(self)
        else:
            self._callbacks.append(fn)

    def _finish(self, status: TaskStatus) -> None:
        self.status = status
        for callback in self._callbacks:
            callback(self)


class SensorSubscription:
    """Data that a callback receives until it is unsubscribed, or until the end of a ``with``."""

    def __init__(self) -> None:
        self._is_over = False

    def unsubscribe(self) -> None:
        """Ends it."""
        self._is_over = True

    def __enter__(self) -> SensorSubscription:
        return self

    def __exit__(self, *error: object) -> None:
        self.unsubscribe()


def __getattr__(name: str) -> Any:
    known = [word for word, value in globals().items() if isinstance(value, type) and value.__module__ == __name__]
    return _unknown.placeholder("boosteros.types", name, known)
