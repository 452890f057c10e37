"""The scene's layers as arrays: pure functions of the telemetry.

The length of every array depends on the scenario alone, so that points and colours always fit.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from dashboard.scene import geometry
from dashboard.scene.detail import WHOLE, Detail, detail
from dashboard.telemetry.beliefs import BeliefView
from dashboard.telemetry.links import LinkView, untold
from dashboard.telemetry.snapshot import Snapshot
from dashboard.theme import colours
from dashboard.theme.limits import DISTANCE_LIMIT
from dashboard.theme.palette import Palette
from formation.arrays import FloatArray
from formation.pattern import upstream
from formation.scenario.scenario import Scenario
from formation.unicycle import roll_out
from network.messages import Status
from network.values import Motion

TICK = 5
"""Steps of a preview between two ticks of its ribbon: half a second."""
AWAY = -1e4
"""Where what is not shown is drawn [m]."""


@dataclass(frozen=True, slots=True)
class Sizes:
    """Sizes in the scene [m]: those for a spacing of 0.1 m, times `unit`; and how finely it is drawn."""

    unit: float
    detail: Detail = WHOLE

    @classmethod
    def of(cls, scenario: Scenario) -> "Sizes":
        """Sizes for the robots of a scenario; `unit` is 0.4 to 3."""
        spacing = float(scenario.pattern.distance.min())
        return cls(float(np.clip(spacing / 0.1, 0.4, 3.0)), detail(scenario.size))

    @property
    def body(self) -> tuple[float, float]:
        """Length and width."""
        return 0.055 * self.unit, 0.036 * self.unit

    @property
    def ribbon(self) -> float:
        """Width of a preview that is driven."""
        return 0.028 * self.unit

    def z(self, layer: int) -> float:
        """Height of a layer above the ground."""
        return 0.0006 * layer * self.unit


@lru_cache(maxsize=64)
def upstream_rows(robots: int, away: tuple[int, ...] = ()) -> tuple[int, ...]:
    """The row of each robot's upstream neighbour in the ring of those who are not away; theirs is their own."""
    return tuple(i - 1 if i in away else upstream(i, robots, away) - 1 for i in range(1, robots + 1))


def edges(poses: FloatArray, z: float, away: Sequence[int] = ()) -> FloatArray:
    """(n, 2, 3): from every robot to its upstream neighbour; nothing to be seen of one that is away."""
    points, before = poses[:, :2], list(upstream_rows(len(poses), tuple(away)))
    return geometry.lifted(np.stack([points, points[before]], axis=1), z)


def desired(slots: FloatArray, dashes: int, z: float, away: Sequence[int] = ()) -> FloatArray:
    """(dashes n, 2, 3): dashes between the slots of neighbours."""
    before = list(upstream_rows(len(slots), tuple(away)))
    a, b = slots[:, None, :2], slots[before, None, :2]
    at = (np.arange(dashes)[None, :, None] + np.array([0.2, 0.7])[:, None, None]) / dashes  # (2, dashes, 1)
    found = np.stack([a + (b - a) * at[0], a + (b - a) * at[1]], axis=2)
    return geometry.lifted(found.reshape(-1, 2, 2), z)


def edge_colours(distance_errors: FloatArray, palette: Palette) -> colours.Bytes:
    """(n, 2, 3), encoded."""
    colour = colours.encoded_health(np.abs(distance_errors) / DISTANCE_LIMIT, palette)
    return np.repeat(colour[:, None], 2, axis=1)


@dataclass(frozen=True, slots=True)
class Arrows:
    """Shafts and heads of all links, in the order of their senders."""

    shafts: FloatArray
    """(n dashes, 2, 3) [m]."""
    tips: FloatArray
    """(n, 3) [m]."""
    directions: FloatArray
    """(n,) [rad]."""


def arrows(poses: FloatArray, links: list[LinkView], sizes: Sizes, layer: int) -> Arrows:
    """One arrow per link, beside the edge, to the right of the direction from sender to receiver; dashed if lost.

    Robots that are away send to nobody: their arrows are not to be seen.
    """
    start = poses[:, 0] + 1j * poses[:, 1]  # complex numbers take half the time of pairs
    senders = [link.sender - 1 for link in links]
    gap, full = np.zeros_like(start), np.ones(len(poses))
    gap[senders] = start[[link.receiver - 1 for link in links]] - start[senders]
    full[senders] = [0.5 if link.lost else 1.0 for link in links]
    length = np.maximum(np.abs(gap), 1e-6)
    along = gap / length
    clear, aside = along * np.minimum(0.027 * sizes.unit, 0.4 * length), along * (-0.011j * sizes.unit)
    tip = start + gap - clear + aside
    start = start + clear + aside
    shaft = tip - along * np.minimum(0.011 * sizes.unit, 0.3 * length) - start
    count = sizes.detail.dashes
    dashes = np.empty((len(poses), count, 2))
    dashes[..., 0] = np.arange(count)
    dashes[..., 1] = dashes[..., 0] + full[:, None]
    shafts = start[:, None, None] + shaft[:, None, None] * (dashes / count)
    z = sizes.z(layer)
    tip[gap == 0.0] = complex(AWAY, AWAY)
    return Arrows(
        shafts=geometry.lifted(shafts.view(float).reshape(-1, 2, 2), z),
        tips=geometry.lifted(tip.view(float).reshape(-1, 2), z + 0.2 * sizes.z(1)),
        directions=np.angle(along),
    )


def arrow_colours(
    links: list[LinkView], robots: int, dashes: int, palette: Palette
) -> tuple[colours.Bytes, colours.Bytes]:
    """Of the shafts (n dashes, 2, 3) and of the heads (n, 3), encoded."""
    levels = np.zeros(robots)
    levels[[link.sender - 1 for link in links]] = [link.level for link in links]
    colour = colours.encoded_health(levels, palette)
    return np.repeat(np.repeat(colour[:, None], dashes, axis=0), 2, axis=1), colour


def horizons(plans: list[Motion | None], poses: FloatArray, steps: int, now: float) -> FloatArray:
    """(n, steps + 1, 2): where what is left of each plan leads to; a robot without one stays where it is drawn [m].

    Args:
        plans: of each robot.
        poses: (n, 3) where the robots are drawn [m, m, rad].
        steps: inputs of a plan.
        now: [s].
    """
    inputs, interval = np.zeros((len(poses), steps, 2)), 0.1
    for row, plan in enumerate(plans):
        if plan is not None and len(plan.inputs) == steps:
            interval = plan.interval
            gone = min(steps, max(0, int((now - plan.begins) / interval)))
            inputs[row, : steps - gone] = plan.inputs[gone:]
    return roll_out(poses, inputs, interval)[..., :2]


def own_plans(statuses: Mapping[int, Status], robots: int, episode: int) -> list[Motion | None]:
    """The newest plan of every robot in this episode."""
    found = map(statuses.get, range(1, robots + 1))
    return [status.plan if status is not None and status.episode == episode else None for status in found]


def believed(beliefs: list[BeliefView], poses: FloatArray, steps: int) -> tuple[FloatArray, FloatArray]:
    """Where the robot downstream of each believes it to be (n, 3), and to drive (n, steps + 1, 2), ordered by sender.

    One of whom nobody believes anything is where it is.
    """
    places, lines = poses.copy(), np.repeat(poses[:, None, :2], steps + 1, axis=1)
    for belief in beliefs:
        if len(belief.line) == steps + 1:
            place = poses[belief.sender - 1, :2] + belief.offset
            places[belief.sender - 1] = *place, belief.pose[2]
            lines[belief.sender - 1] = belief.line - belief.pose[:2] + place
    return places, lines


def off(beliefs: list[BeliefView], poses: FloatArray, dashes: int) -> FloatArray:
    """(n dashes, 2, 2): dashes from each robot to where it is believed to be, if that is off by DISTANCE_LIMIT [m]."""
    start, end = poses[:, :2], poses[:, :2].copy()
    for belief in beliefs:
        if belief.error > DISTANCE_LIMIT:
            end[belief.sender - 1] += belief.offset
    at = (np.arange(dashes)[:, None] + [0.0, 0.6]) / dashes
    return np.asarray(start[:, None, None] + (end - start)[:, None, None] * at[None, :, :, None]).reshape(-1, 2, 2)


def told_ends(snapshot: Snapshot, robots: int) -> FloatArray:
    """(n, 2): where the way ended that each robot was told, if it is lost; else far away [m]."""
    ends = np.full((robots, 2), AWAY)
    for robot, status in snapshot.statuses.items():
        if untold(status) and len(status.way) and robot <= robots:
            ends[robot - 1] = status.way[-1, 2:4]
    return ends


def preview(way: FloatArray, steps: int, z: float) -> FloatArray:
    """(steps, 2, 3): where robot 1 says that the formation's centre will be; nothing to be seen if it says nothing."""
    line = np.zeros((steps + 1, 2))
    if len(way):
        line[:] = way[-1, 2:4]
        line[: len(way)] = way[: steps + 1, 2:4]
    return geometry.lifted(np.stack([line[:-1], line[1:]], axis=1), z)


def ribbon(line: FloatArray, width: float, z: float) -> FloatArray:
    """(2 steps + ticks, 2, 3): both borders of a ribbon along segments (steps, 2, 3), and a tick each TICK [m]."""
    start, end = line[:, 0, :2], line[:, 1, :2]
    along = end - start
    aside = np.stack([-along[:, 1], along[:, 0]], axis=1)
    aside *= 0.5 * width / np.maximum(np.hypot(*along.T), 1e-9)[:, None]
    borders = [np.stack([start + side * aside, end + side * aside], axis=1) for side in (-1.0, 1.0)]
    ticks = np.stack([end - aside, end + aside], axis=1)[TICK - 1 :: TICK]
    return geometry.lifted(np.concatenate([*borders, ticks]), z)


def goal(place: tuple[float, float] | None, size: float, z: float) -> FloatArray:
    """(2, 2, 3): a cross where the centre is driving to; nothing to be seen if nowhere [m]."""
    arms = np.array([[[-1.0, -1.0], [1.0, 1.0]], [[-1.0, 1.0], [1.0, -1.0]]]) * (0.0 if place is None else size)
    return geometry.lifted(arms + np.array(place or (0.0, 0.0)), z)


def fading(colour: FloatArray, points: int, strength: float, palette: Palette, *, towards_end: bool) -> FloatArray:
    """(n (points - 1), 2, 3) sRGB for polylines that fade into the background."""
    share = strength * (np.linspace(1.0, 0.3, points) if towards_end else np.linspace(0.05, 1.0, points))
    per_point = colours.mix(colour[:, None], share[None, :, None], palette)
    return np.stack([per_point[:, :-1], per_point[:, 1:]], axis=2).reshape(-1, 2, 3)


def body_colours(robots: int, lost: set[int], palette: Palette) -> FloatArray:
    """(n, 3) sRGB: the hue of each robot, pale for one without an agent."""
    colour = colours.identities(robots, palette)
    for robot in lost:
        colour[robot - 1] = colours.mix(colour[robot - 1], 0.35, palette)
    return colour


def outline_colours(robots: int, lost: set[int], stopped: set[int], focus: int | None, palette: Palette) -> FloatArray:
    """(n, 3) sRGB: red for a robot without an agent, amber for one that is held, bright for the chosen one."""
    colour = np.tile(colours.rgb(palette.outline), (robots, 1))
    if focus is not None and 1 <= focus <= robots:
        colour[focus - 1] = colours.rgb(palette.chosen)
    for robot in stopped:
        colour[robot - 1] = colours.rgb(palette.warn)
    for robot in lost:
        colour[robot - 1] = colours.rgb(palette.bad)
    return colour
