"""Differential drives on a floor, by MuJoCo: masses, wheels that grip, and bodies that push each other.

The wheels' speeds are those of world/bodies/wheeled.py, lag, limits, slip and scales included; here they turn wheels
that grip and creep by half a per cent, and where two robots touch they push each other. Masses and wheels follow from
each robot's radius; an e-puck's are assumed for all (`MASS`, `WHEEL`, `TRACK`).
"""

import importlib
import math
from typing import Any

import numpy as np

from formation.arrays import FloatArray
from formation.errors import ScenarioError
from formation.scenario.scenario import Scenario

STEP = 0.002
"""Largest step of the physics [s]."""
MASS, AT_RADIUS = 0.16, 0.035
"""Of a robot [kg], and for which radius [m]; it grows with the square of the radius."""
WHEEL, TRACK = 0.59, 1.5
"""Radius of a wheel, and distance of both, in radii of the robot."""
GRIP, SMOOTH = 1.0, 0.001
"""Friction of wheels; of floor and casters. Two surfaces that touch have the larger of their two."""


class MujocoGround:
    """Moves all robots of an episode. The same speeds give the same motion to the last bit."""

    def __init__(self, scenario: Scenario) -> None:
        """Robots at their start, at the speeds of their slots.

        Raises:
            ScenarioError: MuJoCo is not installed.
        """
        self._mujoco = _imported()
        self._radii = scenario.bodies.radii(scenario.size)
        self._steps = math.ceil(scenario.control_interval / STEP - 1e-9)
        starts, speeds = scenario.start_poses().tolist(), scenario.reference().block(0).inputs[0].tolist()
        self._model: Any = self._mujoco.MjModel.from_xml_string(
            _world(self._radii, scenario.control_interval / self._steps)
        )
        self._data: Any = self._mujoco.MjData(self._model)
        for i, ((x, y, theta), (v, omega)) in enumerate(zip(starts, speeds, strict=True)):
            self._place(i, x, y, theta)
            wheels = self._wheels(i, v, omega)
            self._data.qvel[8 * i : 8 * i + 8] = v * math.cos(theta), v * math.sin(theta), 0.0, 0.0, 0.0, omega, *wheels
        self._mujoco.mj_forward(self._model, self._data)

    def __getstate__(self) -> dict[str, Any]:
        """Model and data can be pickled, the module cannot."""
        return {**self.__dict__, "_mujoco": None}

    def __setstate__(self, state: dict[str, Any]) -> None:
        """As it was; MuJoCo is imported again."""
        self.__dict__.update(state)
        self._mujoco = _imported()

    def roll(self, speeds: list[tuple[float, float]], carried: FloatArray | None, dt: float) -> FloatArray:
        """Poses (n, 3) a tick later.

        Args:
            speeds: v and omega that the wheels make, per robot [m/s, rad/s].
            carried: (n, 3) velocity with which each is carried on top, in the world's frame; None: none is.
            dt: the tick [s].
        """
        for i, (v, omega) in enumerate(speeds):
            self._data.ctrl[2 * i : 2 * i + 2] = self._wheels(i, v, omega)
        self._mujoco.mj_step(self._model, self._data, nstep=self._steps)
        poses = np.array([self._pose(i) for i in range(len(speeds))])
        if carried is not None:
            poses += dt * carried
            for i, (x, y, theta) in enumerate(poses.tolist()):
                self._place(i, x, y, theta)
        return poses

    def _wheels(self, i: int, v: float, omega: float) -> tuple[float, float]:
        """How fast the left and the right wheel turn [rad/s]."""
        radius, half = WHEEL * self._radii[i], 0.5 * TRACK * self._radii[i]
        return (v - omega * half) / radius, (v + omega * half) / radius

    def _pose(self, i: int) -> tuple[float, float, float]:
        """Of nine positions of a robot the first three are its place, the next four its turn, the rest its wheels'."""
        x, y, _, w, a, b, c = self._data.qpos[9 * i : 9 * i + 7].tolist()
        return x, y, math.atan2(2.0 * (w * c + a * b), 1.0 - 2.0 * (b * b + c * c))

    def _place(self, i: int, x: float, y: float, theta: float) -> None:
        """Put a robot there upright; speeds and height stay."""
        self._data.qpos[9 * i : 9 * i + 2] = x, y
        self._data.qpos[9 * i + 3 : 9 * i + 7] = math.cos(theta / 2.0), 0.0, 0.0, math.sin(theta / 2.0)


def _imported() -> Any:
    """MuJoCo, for no other bodies need it. Raises ScenarioError: it is not installed."""
    try:
        return importlib.import_module("mujoco")
    except ImportError:
        raise ScenarioError(
            "bodies.implementation: expected MuJoCo for 'mujoco' (pip install 'mujoco==4.0.0'; it is in no "
            "container); got none. 'wheeled' needs nothing"
        ) from None


def _world(radii: list[float], step: float) -> str:
    """The model: a floor, and a differential drive for each radius [m]."""
    robots = [_robot(i, radius) for i, radius in enumerate(radii)]
    return (
        f'<mujoco><option timestep="{step:.9g}" integrator="implicitfast" cone="elliptic" impratio="10"/><worldbody>'
        f'<geom type="plane" size="0 0 1" friction="{SMOOTH}" contype="1" conaffinity="2"/>'
        f"{''.join(body for body, _ in robots)}</worldbody>"
        f"<actuator>{''.join(motors for _, motors in robots)}</actuator></mujoco>"
    )


def _robot(i: int, radius: float) -> tuple[str, str]:
    """Body and motors of robot row i. Wheels are ellipsoids: these touch the floor in one point."""
    mass, wheel, half = MASS * (radius / AT_RADIUS) ** 2, WHEEL * radius, 0.5 * TRACK * radius
    spin = mass * wheel * wheel
    wheels, casters, motors = [], [], []
    for name, side in (("left", 1), ("right", -1)):
        wheels.append(
            f'<body pos="0 {side * half:.9g} 0"><joint name="{name}{i}" axis="0 1 0" armature="{spin:.9g}"/>'
            f'<geom type="ellipsoid" size="{wheel:.9g} {0.1 * radius:.9g} {wheel:.9g}" mass="{0.05 * mass:.9g}" '
            f'friction="{GRIP}" contype="2" conaffinity="1"/></body>'
        )
        casters.append(
            f'<geom type="sphere" size="{0.2 * radius:.9g}" '
            f'pos="{side * 0.7 * radius:.9g} 0 {0.2 * radius - wheel:.9g}" '
            f'mass="{0.01 * mass:.9g}" friction="{SMOOTH}" condim="1" contype="2" conaffinity="1"/>'
        )
        motors.append(
            f'<velocity joint="{name}{i}" kv="{250.0 * spin:.9g}" forcerange="{-20.0 * mass * wheel:.9g} '
            f'{20.0 * mass * wheel:.9g}"/>'
        )
    return (
        f'<body pos="0 0 {wheel:.9g}"><freejoint/>'
        f'<geom type="cylinder" size="{radius:.9g} {0.5 * wheel:.9g}" pos="0 0 {0.7 * wheel:.9g}" '
        f'mass="{0.88 * mass:.9g}" friction="0.3" contype="4" conaffinity="4"/>'
        f"{''.join(wheels)}{''.join(casters)}</body>",
        "".join(motors),
    )
