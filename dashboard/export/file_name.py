"""Names of exported files."""

import re

from dashboard.telemetry.export_buffer import ExportData


def file_name(run: str, data: ExportData, ending: str) -> str:
    """Run, scenario, controller and simulated time, in letters that every file system has."""
    parts = ("echelon", run, data.scenario, data.controller, f"t{data.t[-1]:.1f}s")
    return "_".join(re.sub(r"[^A-Za-z0-9.-]+", "-", part) for part in parts) + ending
