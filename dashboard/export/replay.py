"""The last minutes of an episode as one HTML file that any browser plays, without this project or a network."""

import base64

import numpy as np

from dashboard.scene.layers import Sizes
from dashboard.telemetry.export_buffer import ExportData
from dashboard.telemetry.links import LOST_SECONDS
from dashboard.theme.limits import DISTANCE_LIMIT, TRACKING_LIMIT
from dashboard.theme.palette import DARK, LIGHT, Palette
from dashboard.theme.templates import render
from formation.arrays import FloatArray
from formation.scenario.scenario import Scenario


def as_replay(run: str, data: ExportData, scenario: Scenario, path: FloatArray, palette: Palette) -> bytes:
    """The player export/replay.html with these data.

    Args:
        run: its name.
        data: the last minutes.
        scenario: of the episode.
        path: (M, 2) points of the reference path [m].
        palette: the theme it opens in; it has both.
    """
    fields: dict[str, object] = {
        "run": run,
        "scenario": data.scenario,
        "controller": data.controller,
        "robots": data.robots,
        "dark": palette.dark,
        "themes": {"dark": _theme(DARK, data.robots), "light": _theme(LIGHT, data.robots)},
        "unit": Sizes.of(scenario).unit,
        "limits": {"distance": DISTANCE_LIMIT, "tracking": TRACKING_LIMIT, "age": LOST_SECONDS},
        "start": float(data.t[0]),
        "origin": data.origin.tolist(),
        "t": _packed(data.t - data.t[0]),
        "tracking": _packed(data.tracking_error),
        "path": _packed(path),
        "values": {name: _packed(value) for name, value in data.values.items()},
        "flags": base64.b64encode(data.flags.tobytes()).decode(),
        "excursions": [
            [one.at, one.robot, one.peak, one.until, one.recovery, one.cause, one.cause_at] for one in data.excursions
        ],
        "excursionLimit": data.excursion_limit,
        "events": [[event.stamp, event.kind, event.text] for event in data.events],
    }
    return render("export/replay.html", data=fields).encode()


def _theme(palette: Palette, robots: int) -> dict[str, object]:
    hues = palette.identity[:robots] if robots <= len(palette.identity) else (palette.crowd,) * robots
    names = ("ok", "warn", "bad", "muted", "background", "slot", "path", "outline", "number", "cell", "section")
    return {
        "robots": [f"#{hue}" for hue in hues],
        "plots": [f"#{hue}" for hue in palette.identity[:4]],
        **{name: f"#{getattr(palette, name)}" for name in names},
    }


def _packed(values: FloatArray | np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> str:
    """Little-endian float32, base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()
