"""Runs end where they ended when they were recorded: every scenario kind and controller, with noise and faults.

`trajectories.json` holds the hash and the last poses of every run, and the machine they were recorded on. The last bits
of sin and cos depend on the C library, on numpy and on the processor's vector units, those of a sum on the compiler. So
where all of these are as recorded a trajectory must have its hash; elsewhere the last poses must agree to a micrometre.
Record anew after a change that is meant, with its reason in the commit: `python -m tests.runtime.test_hashes`.
"""

import json
import platform
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from formation.scenario.files import load
from runtime.inprocess import Simulation

DATA = Path(__file__).parent / "trajectories.json"
NOISE = ("noise.slip=0.2", "noise.gyro=0.2", "noise.position=0.001", "noise.heading=0.01")
FAULTS = ("link.latency=0.3", "link.jitter=0.05", "link.loss=0.3", "link.burst=4")
DISTURBANCES = (
    "disturbances=[{robot=2, at=1, until=2, drive=0.0}, {robot=1, at=2.5, until=3.5, drift=[0.008, 0.0, 0.0]}]",
)
WAYPOINTS = (
    'path={kind="waypoints", points=[[0.0,0.0],[1.0,0.0],[1.5,0.8],[0.5,1.2],[-0.5,0.6]], closed=true, speed=0.1}',
)
CONTROLLERS = ("paper", "leader_follower", "virtual_structure", "consensus", "centralised")
RUNS: dict[str, tuple[str, tuple[str, ...]]] = {
    **{
        f"{scenario}, {kind}": (scenario, settings)
        for scenario in ("triangle-circle", "square-figure8", "triangle-corner", "ring-16")
        for kind, settings in (("noise", NOISE), ("faults", FAULTS), ("disturbances", DISTURBANCES))
    },
    **{name: ("triangle-circle", (*NOISE, *FAULTS, f"controller.name={name}")) for name in CONTROLLERS},
    "waypoints": ("triangle-circle", (*NOISE, *FAULTS, *WAYPOINTS)),
}
DURATION = 5.0
NEAR = 1e-6
"""Of poses on another machine [m, rad]: rounding in the last bit grows by the tolerance of the solvers."""


def machine() -> dict[str, Any]:
    """What the last bits depend on."""
    try:
        flags = set(Path("/proc/cpuinfo").read_text(encoding="utf-8").split())
    except OSError:  # not Linux
        flags = set()
    return {
        "machine": platform.machine(),
        "libc": " ".join(platform.libc_ver()),
        "numba": version("numba"),
        "numpy": version("numpy"),
        "vector units": sorted(flags & {"fma", "avx2", "avx512f", "avx512_skx", "asimd"}),
    }


def simulated(name: str) -> dict[str, Any]:
    scenario, settings = RUNS[name]
    run = Simulation(load(scenario, (*settings, f"duration={DURATION}")))
    trace = run.simulate()
    return {"sha256": run.world.summary()["trajectory_sha256"], "last": trace.poses[-1].tolist()}


RECORDED: dict[str, Any] = json.loads(DATA.read_text(encoding="utf-8")) if DATA.exists() else {}


def test_every_run_is_recorded() -> None:
    assert set(RECORDED["runs"]) == set(RUNS)
    assert len({run["sha256"] for run in RECORDED["runs"].values()}) == len(RUNS)


@pytest.mark.parametrize("name", RUNS)
def test_a_run_ends_as_recorded(name: str) -> None:
    found, recorded = simulated(name), RECORDED["runs"][name]
    np.testing.assert_allclose(found["last"], recorded["last"], rtol=0.0, atol=NEAR)
    if machine() == RECORDED["machine"]:
        assert found["sha256"] == recorded["sha256"]


if __name__ == "__main__":
    runs = {name: simulated(name) for name in RUNS}
    DATA.write_text(json.dumps({"machine": machine(), "runs": runs}, indent=1) + "\n", encoding="utf-8")
