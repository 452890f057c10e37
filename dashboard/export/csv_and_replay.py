"""What people take away: the plots as CSV, and a replay that plays in any browser without this project or a network."""

import base64
import csv
import io
import json
import re
from bisect import bisect_left
from pathlib import Path
from typing import Any

import numpy as np

from dashboard.scene.layers import Sizes
from dashboard.telemetry.export_buffer import DEAD, HELD, ExportData
from dashboard.telemetry.links import LOST_SECONDS
from dashboard.theme.limits import DISTANCE_LIMIT, TRACKING_LIMIT
from dashboard.theme.palette import DARK, LIGHT, Palette
from formation.arrays import FloatArray
from formation.pattern import downstream
from formation.scenario.scenario import Scenario

_PLAYER = Path(__file__).with_name("replay.html")
_PLACE = "__DATA__"


def file_name(run: str, record: ExportData, ending: str) -> str:
    """Run, scenario, controller and simulated time, in letters that every file system has."""
    parts = ("echelon", run, record.scenario, record.controller, f"t{record.t[-1]:.1f}s")
    return "_".join(re.sub(r"[^A-Za-z0-9.-]+", "-", part) for part in parts) + ending


def as_csv(record: ExportData) -> bytes:
    """A row per moment: errors of all robots, ages over all links, who is there, and what happened since the last."""
    n = record.robots
    numbers = range(1, n + 1)
    named = (
        ("distance_error_m", "distance_error", [f"R{i}" for i in numbers]),
        ("angle_error_rad", "angle_error", [f"R{i}" for i in numbers]),
        ("plan_age_s", "age", [f"{i}->{downstream(i, n)}" for i in numbers]),
        ("solve_s", "solve", [f"R{i}" for i in numbers]),
    )
    heads = [f"{quantity} {who}" for quantity, _, whose in named for who in whose]
    states = [f"{word} R{i}" for word in ("agent_alive", "held") for i in numbers]
    happened: list[list[str]] = [[] for _ in record.t]
    for event in record.events:
        happened[min(bisect_left(record.t, event.stamp), len(happened) - 1)].append(event.text)
    values = np.concatenate([record.values[key] for _, key, _ in named], axis=1)
    ages = slice(2 * n, 3 * n)
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["t_s", "tracking_error_m", *heads, *states, "events"])
    for row, t in enumerate(record.t):
        cells = [f"{value:.6g}" for value in values[row]]
        cells[ages] = ["" if value < 0.0 else cell for value, cell in zip(values[row, ages], cells[ages], strict=True)]
        flags = record.flags[row]
        alive, held = (flags & DEAD) == 0, (flags & HELD) != 0
        words = _harmless("; ".join(happened[row]))
        writer.writerow(
            [f"{t:.3f}", f"{record.tracking_error[row]:.6g}", *cells, *map(int, alive), *map(int, held), words]
        )
    return text.getvalue().encode()


def _harmless(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t") else text


def as_replay(run: str, record: ExportData, scenario: Scenario, path: FloatArray, palette: Palette) -> bytes:
    """One HTML file that plays the record.

    Args:
        run: its name.
        record: what was kept.
        scenario: what is flown.
        path: (M, 2) points of the reference path [m].
        palette: the look it opens in; it has both.
    """
    data: dict[str, Any] = {
        "run": run,
        "scenario": record.scenario,
        "controller": record.controller,
        "robots": record.robots,
        "dark": palette.dark,
        "looks": {"dark": _look(DARK, record.robots), "light": _look(LIGHT, record.robots)},
        "unit": Sizes.of(float(scenario.pattern.distance.min())).unit,
        "limits": {"distance": DISTANCE_LIMIT, "tracking": TRACKING_LIMIT, "age": LOST_SECONDS},
        "start": float(record.t[0]),
        "t": _packed(record.t - record.t[0]),
        "tracking": _packed(record.tracking_error),
        "path": _packed(path),
        "values": {name: _packed(value) for name, value in record.values.items()},
        "flags": base64.b64encode(record.flags.tobytes()).decode(),
        "events": [[event.stamp, event.kind, event.text] for event in record.events],
    }
    # Within a script element nothing may look like its end; the player shows every text as text.
    plain = json.dumps(data).replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")
    return _PLAYER.read_text(encoding="utf-8").replace(_PLACE, plain).encode()


def _look(palette: Palette, robots: int) -> dict[str, object]:
    hues = palette.identity[:robots] if robots <= len(palette.identity) else (palette.crowd,) * robots
    names = ("ok", "warn", "bad", "muted", "background", "slot", "path", "outline", "number", "cell", "section")
    plots = [f"#{hue}" for hue in palette.identity[:4]]
    return {
        "robots": [f"#{hue}" for hue in hues],
        "plots": plots,
        **{name: f"#{getattr(palette, name)}" for name in names},
    }


def _packed(values: FloatArray | np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> str:
    """Little-endian float32, base64."""
    return base64.b64encode(np.ascontiguousarray(values, dtype="<f4").tobytes()).decode()
