"""Reads messages that naoisis wrote (FOLDER/*.cdr) with a decoder that is not its own, `rosbags`, by the `.msg` definitions of Booster's SDK and demo,
and compares them with what was written (FOLDER/*.json)."""

import json
import sys
from pathlib import Path

import numpy
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

# As in booster_ros2_interface, booster_msgs, vision_interface and brain, June 2026; those without a .msg file as in the SDK's IDL.
DEFINITIONS = {
    "booster_msgs/msg/RpcReqMsg": "string uuid\nstring header\nstring body",
    "booster_msgs/msg/RpcRespMsg": "string uuid\nstring header\nstring body",
    "booster_interface/msg/Odometer": "float32 x\nfloat32 y\nfloat32 theta",
    "booster_interface/msg/ImuState": "float32[3] rpy\nfloat32[3] gyro\nfloat32[3] acc",
    "booster_interface/msg/MotorState": "int8 mode\nfloat32 q\nfloat32 dq\nfloat32 ddq\nfloat32 tau_est\nint8 temperature\nuint32 lost\nuint32[2] reserve",
    "booster_interface/msg/LowState": "ImuState imu_state\nMotorState[] motor_state_parallel\nMotorState[] motor_state_serial",
    "booster_interface/msg/FallDownState": "uint32 fall_down_state\nbool is_recovery_available",
    "booster_interface/msg/RawBytesMsg": "uint8[] msg",
    "booster_interface/msg/BatteryState": "float32 voltage\nfloat32 current\nfloat32 soc\nfloat32 average_voltage",
    "booster_interface/msg/RobotStatesMsg": "int32 current_mode\nint32 current_body_control\nint32[] current_actions",
    "booster_interface/msg/ButtonEventMsg": "int32 button\nint32 event",
    "booster_interface/msg/RemoteControllerState": "uint32 event\nfloat32 lx\nfloat32 ly\nfloat32 rx\nfloat32 ry\n"
    + "\n".join(f"bool {name}" for name in "a b x y lb rb lt rt ls rs back start hat_c hat_u hat_d hat_l hat_r hat_lu hat_ld hat_ru hat_rd".split())
    + "\nuint8 reserved",
    "vision_interface/msg/DetectedObject": "string label\nstring color\nfloat64 confidence\nint64 xmin\nint64 ymin\nint64 xmax\nint64 ymax\nfloat32[] target_uv\n"
    "float32[] received_pos\nfloat32[] position\nfloat32[] position_projection\nfloat32[] position_cam\nint32 position_confidence",
    "vision_interface/msg/Detections": "std_msgs/Header header\nDetectedObject[] detected_objects\nfloat32[] radar_x\nfloat32[] radar_y\nfloat32[] corner_pos",
    "vision_interface/msg/LineSegments": "std_msgs/Header header\nfloat32[] coordinates\nfloat32[] coordinates_uv",
    "brain/msg/Kick": "std_msgs/Header header\nfloat64 x\nfloat64 y\nfloat64 dir\nfloat64 goal_x\nfloat64 goal_y\nfloat64 robot_theta_to_field\nfloat64 power",
}


def plain(value):
    """A message as numbers, texts, lists and dictionaries."""
    if isinstance(value, numpy.ndarray):
        return value.tolist()
    if isinstance(value, list):
        return [plain(item) for item in value]
    if hasattr(value, "__dataclass_fields__"):
        return {name: plain(getattr(value, name)) for name in value.__dataclass_fields__ if name != "__msgtype__"}
    return value


def same(ours, theirs):
    if isinstance(ours, dict):
        return ours.keys() == theirs.keys() and all(same(ours[name], theirs[name]) for name in ours)
    if isinstance(ours, list):
        return len(ours) == len(theirs) and all(map(same, ours, theirs))
    if isinstance(ours, float):
        return abs(ours - theirs) <= 1e-6 * max(1.0, abs(ours))
    return ours == theirs


store = get_typestore(Stores.ROS2_HUMBLE)
for name, definition in DEFINITIONS.items():
    store.register(get_types_from_msg(definition, name))
files = sorted(Path(sys.argv[1]).glob("*.cdr"))
for file in files:
    kind = file.stem.replace("::msg::dds_::", "/msg/").rstrip("_")
    ours, theirs = json.loads(file.with_suffix(".json").read_text()), plain(store.deserialize_cdr(file.read_bytes(), kind))
    if not same(ours, theirs):
        sys.exit(f"{kind} was written as {ours} and read as {theirs}")
    # What was read is written again to the same bytes: nothing was left over.
    again = bytes(store.serialize_cdr(store.deserialize_cdr(file.read_bytes(), kind), kind))
    if again != file.read_bytes():
        sys.exit(f"{kind}: {len(file.read_bytes())} bytes were read as {len(again)}")
print(f"{len(files)} kinds of messages are read by rosbags as they were written")
if len(files) < 16:
    sys.exit("expected more of them")
