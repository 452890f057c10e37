"""Named values for [bodies]. Lags, delays and sigmas of the first four are engineering values, not measurements."""

from collections.abc import Mapping
from typing import Any

_NOISE = {"slip": 0.2, "gyro": 0.2}

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
        "localisation": {"rate": 100.0, "age": 0.02, "position": 0.001, "heading": 0.01},
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
}
"""By name; what a preset does not name has the default (formation/bodies/spec.py)."""
