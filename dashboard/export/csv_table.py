"""The last minutes of an episode as CSV."""

import csv
import io
from bisect import bisect_left

import numpy as np

from dashboard.telemetry.export_buffer import DEAD, HELD, ExportData
from formation.link_ids import plan_links


def as_csv(data: ExportData) -> bytes:
    """A row per moment: places in the scenario's coordinates, errors, ages over all links, agents alive, and events."""
    n = data.robots
    numbers = range(1, n + 1)
    robots = [f"R{i}" for i in numbers]
    columns = (
        ("x_m", "x", robots),
        ("y_m", "y", robots),
        ("distance_error_m", "distance_error", robots),
        ("angle_error_rad", "angle_error", robots),
        ("plan_age_s", "age", [str(link) for link in plan_links(n)]),
        ("solve_s", "solve", robots),
    )
    heads = [f"{quantity} {name}" for quantity, _, names in columns for name in names]
    flag_heads = [f"{flag} {name}" for flag in ("agent_alive", "held") for name in robots]
    events: list[list[str]] = [[] for _ in data.t]
    for event in data.events:
        events[min(bisect_left(data.t, event.stamp), len(events) - 1)].append(event.text)
    values = np.concatenate([data.values[key] for _, key, _ in columns], axis=1)
    places = np.repeat(data.origin, n) + values[:, : 2 * n].astype(float)
    ages = slice(4 * n, 5 * n)
    text = io.StringIO()
    writer = csv.writer(text)
    writer.writerow(["t_s", "tracking_error_m", *heads, *flag_heads, "events"])
    for row, t in enumerate(data.t):
        cells = [*(f"{place:.4f}" for place in places[row]), *(f"{value:.6g}" for value in values[row, 2 * n :])]
        cells[ages] = ["" if value < 0.0 else cell for value, cell in zip(values[row, ages], cells[ages], strict=True)]
        flags = data.flags[row]
        alive, held = (flags & DEAD) == 0, (flags & HELD) != 0
        happened = _no_formula("; ".join(events[row]))
        writer.writerow(
            [f"{t:.3f}", f"{data.tracking_error[row]:.6g}", *cells, *map(int, alive), *map(int, held), happened]
        )
    return text.getvalue().encode()


def _no_formula(text: str) -> str:
    """A text that no spreadsheet takes for a formula."""
    return f"'{text}" if text[:1] in ("=", "+", "-", "@", "\t") else text
