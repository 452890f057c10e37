"""Values of every message type that a record holds, for our encoder and for another one."""

from typing import Any

import numpy as np

from formation.arrays import FloatArray
from records import messages

STAMP = 1_700_000_000_123_456_789
POSE: FloatArray = np.array([0.25, -1.5, 0.5])
VELOCITY: FloatArray = np.array([0.125, -0.75])
PATH: FloatArray = np.array([[0.0, 0.0, 0.0], [0.5, 0.25, 1.0], [1.0, -0.125, -3.0]])
STAMPS = [STAMP, STAMP + 10**8, STAMP + 2 * 10**8]
LINES = messages.Lines("edges", np.array([[0.0, 0.5], [1.0, -2.0]]), [(1.0, 0.5, 0.25, 1.0)], 0.0078125)
"""All are exact in binary, so that rounding pictures does not change them."""

ENCODED: dict[str, tuple[str, bytes]] = {
    "twist": ("geometry_msgs/Twist", messages.twist(VELOCITY)),
    "twist_stamped": ("geometry_msgs/TwistStamped", messages.twist_stamped(STAMP, "robot1", VELOCITY)),
    "odometry": ("nav_msgs/Odometry", messages.odometries(STAMP, ["robot12"], POSE[None], VELOCITY[None])[0]),
    "transforms": ("tf2_msgs/TFMessage", messages.transforms(STAMP, ["robot1", "slot2"], PATH[[0, 0]])),
    "path": ("nav_msgs/Path", messages.path(STAMP, np.zeros((3, 3)), STAMPS)),
    "empty_path": ("nav_msgs/Path", messages.path(STAMP, np.zeros((0, 3)), [])),
    "markers": ("visualization_msgs/MarkerArray", messages.markers(STAMP, [LINES, LINES._replace(namespace="slots")])),
    "no_lines": (
        "visualization_msgs/MarkerArray",
        messages.markers(STAMP, [messages.Lines("none", np.zeros((0, 2)), [], 0.5)]),
    ),
    "log": ("rcl_interfaces/Log", messages.log(STAMP, "warning", "fault", "1->2: Ausfall für 3 s")),
}
"""What is sent, by name: type and bytes."""


def time(stamp: int) -> dict[str, int]:
    return {"sec": stamp // 10**9, "nanosec": stamp % 10**9}


def header(stamp: int = STAMP, frame: str = "map") -> dict[str, Any]:
    return {"stamp": time(stamp), "frame_id": frame}


def pose(x: float, y: float, theta: float) -> dict[str, Any]:
    turn = {"x": 0.0, "y": 0.0, "z": float(np.sin(theta / 2)), "w": float(np.cos(theta / 2))}
    return {"position": {"x": x, "y": y, "z": 0.0}, "orientation": turn}


def twist(v: float, omega: float) -> dict[str, Any]:
    return {"linear": {"x": v, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": omega}}


def transform(child: str) -> dict[str, Any]:
    still = {"translation": {"x": 0.0, "y": 0.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {"header": header(), "child_frame_id": child, "transform": still}


def marker(namespace: str, points: list[list[float]], colour: list[float], width: float) -> dict[str, Any]:
    rgba = dict(zip("rgba", colour, strict=False))
    return {
        "header": header(),
        "ns": namespace,
        "id": 0,
        "type": 5,
        "action": 0,
        "pose": pose(0.0, 0.0, 0.0),
        "scale": {"x": width, "y": 0.0, "z": 0.0},
        "color": dict.fromkeys("rgba", 1.0),
        "lifetime": {"sec": 0, "nanosec": 0},
        "frame_locked": False,
        "points": [{"x": x, "y": y, "z": 0.0} for x, y in points],
        "colors": [rgba for _ in points],
        "texture_resource": "",
        "texture": {"header": {"stamp": time(0), "frame_id": ""}, "format": "", "data": []},
        "uv_coordinates": [],
        "text": "",
        "mesh_resource": "",
        "mesh_file": {"filename": "", "data": []},
        "mesh_use_embedded_materials": False,
    }


def _marker(namespace: str) -> dict[str, Any]:
    return marker(namespace, [[0.0, 0.5], [1.0, -2.0]], [1.0, 0.5, 0.25, 1.0], 0.0078125)


NOTHING = [0.0] * 36
VALUES: dict[str, dict[str, Any]] = {
    "twist": twist(0.125, -0.75),
    "twist_stamped": {"header": header(frame="robot1"), "twist": twist(0.125, -0.75)},
    "pose_stamped": {"header": header(frame="a long frame"), "pose": pose(0.25, -1.5, 0.5)},
    "odometry": {
        "header": header(),
        "child_frame_id": "robot12",
        "pose": {"pose": pose(0.25, -1.5, 0.5), "covariance": NOTHING},
        "twist": {"twist": twist(0.125, -0.75), "covariance": NOTHING},
    },
    "transforms": {"transforms": [transform("robot1"), transform("slot2")]},
    "path": {"header": header(), "poses": [{"header": header(at), "pose": pose(0.0, 0.0, 0.0)} for at in STAMPS]},
    "empty_path": {"header": header(), "poses": []},
    "markers": {"markers": [_marker("edges"), _marker("slots")]},
    "no_lines": {"markers": [marker("none", [], [], 0.5)]},
    "log": {
        "stamp": time(STAMP),
        "level": 30,
        "name": "fault",
        "msg": "1->2: Ausfall für 3 s",
        "file": "",
        "function": "",
        "line": 0,
    },
}
"""By name: the same as fields, and what is only read."""
TYPES = {name: kind for name, (kind, _) in ENCODED.items()} | {"pose_stamped": "geometry_msgs/PoseStamped"}
"""By name."""
