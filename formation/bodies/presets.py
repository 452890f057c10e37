"""Named values for [bodies], and the robots that one can buy among them.

Lags, delays and sigmas of `mocap`, `camera` and `rough` are engineering values, not measurements. Of the named robots
each value has its source beside it, or "assumed".
"""

from collections.abc import Mapping
from typing import Any

_NOISE = {"slip": 0.2, "gyro": 0.2}
_MOCAP = {"rate": 100.0, "age": 0.02, "position": 0.001, "heading": 0.01}
"""Motion capture: often, soon, exact. Assumed, and so is that the named robots are localised by it."""

PRESETS: Mapping[str, Mapping[str, Any]] = {
    # The prediction model itself: exact unicycles, seen at once and exactly.
    "ideal": {},
    # Motion capture: often, soon, exact; small differential drives.
    "mocap": {
        **_NOISE,
        "lag": 0.1,
        "acceleration": 1.0,
        "turn_acceleration": 5.0,
        "delay": 0.05,
        "scale": 0.02,
        "turn_scale": 0.02,
        "turn_offset": 0.01,
        "localisation": _MOCAP,
    },
    # A camera above the arena, and relative sensing.
    "camera": {
        **_NOISE,
        "lag": 0.1,
        "acceleration": 1.0,
        "turn_acceleration": 5.0,
        "delay": 0.1,
        "scale": 0.03,
        "turn_scale": 0.03,
        "turn_offset": 0.01,
        "localisation": {
            "rate": 20.0,
            "age": 0.08,
            "position": 0.003,
            "heading": 0.01,
            "outliers": 0.02,
            "outlier_size": 0.05,
        },
        "relative": {"sigma": 0.002},
    },
    # Slow wheels, a slow radio, a poor camera.
    "rough": {
        **_NOISE,
        "lag": 0.2,
        "acceleration": 1.0,
        "turn_acceleration": 5.0,
        "delay": 0.2,
        "scale": 0.05,
        "turn_scale": 0.05,
        "turn_offset": 0.02,
        "localisation": {
            "rate": 10.0,
            "age": 0.1,
            "position": 0.01,
            "heading": 0.02,
            "outliers": 0.05,
            "outlier_size": 0.2,
        },
        "relative": {"sigma": 0.005},
    },
    # TurtleBot3 Burger.
    "turtlebot3": {
        "radius": 0.105,  # turtlebot3_navigation2, burger.yaml: robot_radius
        "limits": {"v": 0.211, "omega": 2.64},  # OpenCR, turtlebot3_burger.h: 61 rpm, wheel 33 mm, track 160 mm
        "lag": 0.1,  # assumed
        "delay": 0.05,  # assumed
        "acceleration": 2.5,  # turtlebot3_navigation2, burger.yaml: acc_lim_x
        "turn_acceleration": 3.2,  # the same: acc_lim_theta
        "slip": 0.2,  # the same: AMCL's alpha1 to alpha4 are 0.2
        "gyro": 0.2,  # assumed
        "turn_scale": 0.11,  # OpenCR against turtlebot3_gazebo: the wheels' separation is off by up to 1.11
        "localisation": _MOCAP,
    },
    # GCtronic e-puck.
    "epuck": {
        "radius": 0.037,  # webots, docs/guide/epuck.md: diameter 71 mm, 74 mm with its ring
        "limits": {"v": 0.129, "omega": 4.95},  # the same: 1000 steps/s of 0.129 mm, wheels 52 mm apart
        "lag": 0.0,  # stepper motors
        "delay": 0.0,  # the same
        "slip": 0.1,  # assumed; a step is 0.129 mm
        "gyro": 0.1,  # assumed
        "turn_scale": 0.095,  # webots_ros2_epuck: odometry is corrected by a factor of 1.095
        "localisation": _MOCAP,
    },
    # GRITSBot X in the Robotarium.
    "robotarium": {
        "radius": 0.0675,  # robotarium_python_simulator 2.0: bodies of 110 mm collide at a distance of 135 mm
        "limits": {"v": 0.2, "omega": 3.64},  # the same: 2 x 0.2 / 0.11
        "lag": 0.0,  # the same: it has none
        "delay": 0.03,  # the same: one step of 33 ms
        "slip": 0.07,  # the same: 1.5 mm per sqrt(m) and wheel, at 0.05 m/s and 100 Hz
        "gyro": 0.04,  # the same: 1.1 degrees per sqrt(m), likewise
        "localisation": _MOCAP,
    },
    # Duckiebot DB18.
    "duckiebot": {
        "radius": 0.1,  # about 200 mm long
        "limits": {"v": 0.6, "omega": 7.5},  # about, from duckietown_world, pwm_dynamics.py
        "lag": 0.2,  # the same: 0.2 s along, 0.25 s in turning
        "delay": 0.15,  # gym-duckietown: delay of actions
        "slip": 0.2,  # assumed
        "gyro": 0.2,  # assumed
        "scale": 0.05,  # assumed: as delivered the trim is not calibrated
        "turn_scale": 0.05,  # assumed, likewise
        "turn_offset": 0.02,  # assumed, likewise
        "localisation": _MOCAP,
    },
}
"""By name; what a preset does not name has the default (formation/bodies/spec.py)."""
