"""The detections of ``boosteros.brain``: what the robot of naoisis recognises in its newest image."""

from __future__ import annotations

import math
from typing import Any

from naoisis.boosteros import _unknown
from naoisis.boosteros.link import Camera
from naoisis.boosteros.robot import firmware
from naoisis.boosteros.types import BoundingBox2D, DetectionResult

# The names of classes, by their numbers: those of Booster's demo.
_CLASSES = ("Ball", "Goalpost", "Person", "LCross", "TCross", "XCross", "PenaltyPoint", "Opponent")
# The confidence of percepts that have none.
_CONFIDENCE = 0.99
# Width and height of what is seen, m. Marks are squares on the ground.
_BALL_M, _POST_M, _ROBOT_M, _MARK_M = (0.2, 0.2), (0.1, 1.6), (0.4, 0.95), (0.1, 0.1)
_MODEL = "soccer"


class Detection:
    """The model `soccer`. Other models are not known."""

    def __init__(self, model: str = "default", backend: str = "local", **kwargs: Any):
        self.load_model(model)

    def __getattr__(self, name: str) -> Any:
        _unknown.refuse(f"Detection.{name}", dir(type(self)))

    @staticmethod
    def list_models() -> list[dict[str, Any]]:
        """The model `soccer`."""
        return [{"id": _MODEL, "name": "percepts of naoisis", "type": "detection", "backend": ["local"]}]

    def load_model(self, model: str) -> None:
        """Checks that this is the model `soccer`."""
        if model != _MODEL:
            raise ValueError(f"boosteros: the detection model {model!r} is not known to naoisis; known is {_MODEL!r}")

    def detect(
        self, image: Any, confidence: float = 0.5, iou_threshold: float = 0.45, **kwargs: Any
    ) -> list[DetectionResult]:
        """What the robot recognises in its newest image, whatever `image` is. Every robot is an `Opponent`."""
        link = firmware().link
        percepts = link.perception["percepts"]
        seen = [("Ball", percept, _BALL_M) for percept in [percepts["ball"]] if percept is not None]
        seen += [("Goalpost", percept, _POST_M) for percept in percepts["goal_posts"]]
        seen += [("Opponent", percept, _ROBOT_M) for percept in percepts["robots"]]
        marks = [(_mark(percept), percept, _MARK_M) for percept in percepts["landmarks"]]
        seen += [(name, percept, size) for name, percept, size in marks if name is not None]
        results = [_result(*one, link.camera) for one in seen]
        return [result for result in results if result.confidence >= confidence]


def _mark(percept: dict[str, Any]) -> str | None:
    """The class of a mark on the ground."""
    if percept["kind"] == "junction":
        return f"{percept['shape'].upper()}Cross"
    return "PenaltyPoint" if percept["kind"] == "penalty_cross" else None


def _result(name: str, percept: dict[str, Any], size_m: tuple[float, float], camera: Camera) -> DetectionResult:
    """A percept as a detection. Its box has the size that the object has at its distance."""
    u, v = percept["pixel"]
    distance_m = math.hypot(*percept["position_m"])
    aside, below = ((at - centre) / focal for at, centre, focal in zip((u, v), camera.centre, camera.focal))
    depth_m = distance_m / math.sqrt(1.0 + aside * aside + below * below)
    width, height = (focal * metres / max(depth_m, 0.05) for focal, metres in zip(camera.focal, size_m))
    # Pixels of robots and posts are at their feet, others in the middle.
    lowest = v if name in ("Goalpost", "Opponent") else v + height / 2
    left, right = (round(min(max(x, 0), camera.width)) for x in (u - width / 2, u + width / 2))
    top, bottom = (round(min(max(y, 0), camera.height)) for y in (lowest - height, lowest))
    box = BoundingBox2D(left, top, right - left, bottom - top)
    confidence = percept.get("confidence", _CONFIDENCE)
    return DetectionResult(name, _CLASSES.index(name), confidence, box, distance_m=distance_m)


def __getattr__(name: str) -> Any:
    return _unknown.placeholder("boosteros.brain", name, __all__)


__all__ = ["Detection"]
