"""The central law: in lockstep, processes over the network give exactly the trajectory of one process."""

import contextlib
import json
import os
import random
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import psutil
import pytest

from formation.errors import WireError
from formation.scenario.files import load
from formation.scenario.overrides import from_settings
from network import topics
from network.bus import Sample
from network.codec import decode
from network.control import GetSummary, Start
from network.messages import State
from network.zenoh_bus import ZenohBus
from runtime import inprocess
from runtime.process_list import Program, RunPlan, programs
from runtime.run_registry import Claim
from runtime.supervisor import Supervisor
from tests.processes.live import echelon, title, wait_for

pytestmark = [pytest.mark.processes, pytest.mark.usefixtures("runs")]

BURSTY = ("triangle-circle", ["faults=[{preset='bursty'}]", "duration=6"])
JITTERY = ("figure8", ["link.latency=0.05", "link.jitter=0.04", "link.loss=0.2", "duration=6"])
SPARING = (
    "triangle-circle",
    [
        "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}",
        "bodies.gusts={sigma=0.008, correlation=0.5}",
        "controller.send_when=0.001",
        "link.loss=0.2",
        "duration=6",
    ],
)
NOISY = (
    "triangle-circle",
    [
        "noise={slip=0.2, gyro=0.2, position=0.001, heading=0.01}",
        "faults=[{link='world->2', latency=0.1}, {link='3->world', loss=0.2}, {at=2, until=3, link='1->2', cut=true}]",
        "link.corrupt=0.2",
        "duration=5",
    ],
)


GARBAGE = int(os.environ.get("ECHELON_GARBAGE", "300"))
"""Payloads on each topic; tried with 10000 too, which takes some minutes."""


def simulate(
    name: str,
    settings: list[str],
    *,
    order: int = 0,
    disturb: Any = None,
    settle: Any = None,
    several: bool = False,
    crew: int = 1,
) -> dict[str, Any]:
    """One episode as processes, started in an order drawn from `order`."""
    scenario = load(name, settings)
    with Claim("lockstep") as claim:
        plan = RunPlan(
            "lockstep",
            name,
            claim.endpoint,
            (claim.endpoint,),
            from_settings(settings),
            speed=0.0,
            paused=True,
            together=crew,
        )
        found = programs(plan, scenario)
        if several:
            words = ("--run", plan.run, "--connect", plan.connect, "--ids", f"1-{scenario.size}")
            found = [program for program in found if program.role != "agent"]
            found.append(Program("agent", 1, "agents", words))
        random.Random(order).shuffle(found)
        supervisor = Supervisor("lockstep", print)
        try:
            supervisor.start(found)
            with ZenohBus(claim.endpoint, "lockstep") as session:
                session.subscribe(topics.state("lockstep"))
                wait_for(lambda: (r := session.ask(Start())) and r.ok)
                if disturb is not None:
                    disturb(session)

                def finished() -> bool:
                    supervisor.watch(0.0)
                    over = False
                    for item in session.arrivals():
                        with contextlib.suppress(WireError):
                            over |= isinstance(item, Sample) and decode(State, item.payload).status == "finished"
                    return over

                wait_for(finished, 60.0)
                if settle is not None:
                    wait_for(lambda: (r := session.ask(GetSummary())) and settle(r.value))
                reply = session.ask(GetSummary())
                assert reply is not None
                return reply.value
        finally:
            supervisor.stop()


@pytest.mark.parametrize("case", [BURSTY, JITTERY, NOISY, SPARING], ids=["bursty", "jittery", "noisy", "sparing"])
def test_processes_give_the_trajectory_of_one_process_in_any_start_order(case: tuple[str, list[str]]) -> None:
    alone = inprocess.simulate(load(*case))
    for order in (1, 2):
        together = simulate(*case, order=order)
        assert together["trajectory_sha256"] == alone["trajectory_sha256"]
        assert {link: f["lost"] for link, f in together["links"].items()} == {
            link: f["lost"] for link, f in alone["links"].items()
        }


def test_agents_of_one_command_are_those_of_three() -> None:
    name, settings = "triangle-circle", ["faults=[{preset='bursty'}]", "duration=5"]
    alone = inprocess.simulate(load(name, settings))
    assert simulate(name, settings, several=True)["trajectory_sha256"] == alone["trajectory_sha256"]


def test_crews_give_the_trajectory_of_one_process_in_any_start_order_on_a_loaded_machine() -> None:
    name, settings = "ring-16", ["link.loss=0.2", "duration=1"]
    alone = inprocess.simulate(load(name, settings))
    burners = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(3)]
    try:
        for order, crew in ((1, 8), (2, 5)):
            together = simulate(name, settings, order=order, crew=crew)
            assert together["trajectory_sha256"] == alone["trajectory_sha256"]
            lost = ({link: f["lost"] for link, f in one["links"].items()} for one in (together, alone))
            assert next(lost) == next(lost)
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()


def test_a_loaded_machine_changes_nothing() -> None:
    alone = inprocess.simulate(load(*BURSTY))
    burners = [subprocess.Popen([sys.executable, "-c", "while True: pass"]) for _ in range(3)]
    try:
        assert simulate(*BURSTY)["trajectory_sha256"] == alone["trajectory_sha256"]
    finally:
        for burner in burners:
            burner.kill()
            burner.wait()


def test_a_run_of_which_every_process_is_suspended_for_seven_seconds_is_the_same() -> None:
    """As Ctrl-Z and fg do, or a container that is paused: longer than the leases, and than people wait for an agent."""
    name, settings = "triangle-circle", ["faults=[{preset='bursty'}]", "duration=20"]

    def suspend(session: ZenohBus) -> None:
        session.subscribe(topics.state("lockstep"))
        wait_for(lambda: [item for item in session.arrivals() if isinstance(item, Sample)])
        stopped: list[psutil.Process] = []

        def all_are_named() -> bool:
            children = psutil.Process().children(recursive=True)
            stopped[:] = [child for child in children if title(child).startswith("echelon lockstep: ")]
            return len(stopped) == 5

        wait_for(all_are_named)  # router, world, three agents
        for process in stopped:
            process.suspend()
        time.sleep(7.0)
        for process in stopped:
            process.resume()

    alone = inprocess.simulate(load(name, from_settings(settings)))
    together = simulate(name, settings, disturb=suspend)
    assert together["trajectory_sha256"] == alone["trajectory_sha256"]
    assert any("stood still" in event["text"] for event in together["events"])


def test_garbage_on_every_topic_is_counted_and_changes_nothing() -> None:
    name, settings = "triangle-circle", ["duration=10"]
    draws = random.Random(7)
    words = [topics.tick, topics.state]
    robots = [topics.plan, topics.command, topics.status]
    targets = [key("lockstep") for key in words] + [key("lockstep", i) for key in robots for i in (1, 2, 3)]

    def litter(session: ZenohBus) -> None:
        import zenoh

        stranger = session._session  # our processes themselves have no way to say such things
        for _ in range(GARBAGE):
            for target in targets:
                payload = draws.randbytes(draws.randrange(0, 700))
                stranger.put(target, payload, congestion_control=zenoh.CongestionControl.BLOCK)
            list(stranger.get(topics.control("lockstep"), payload=draws.randbytes(20), timeout=5.0))

    expected = GARBAGE * 7  # commands and statuses of three robots, and control
    together = simulate(name, settings, disturb=litter, settle=lambda figures: figures["rejected"] == expected)
    assert together["trajectory_sha256"] == inprocess.simulate(load(name, settings))["trajectory_sha256"]


def test_the_command_prints_the_same_figures_with_either_engine(runs: Path) -> None:
    words = ["run", "circle", "--duration", "5", "--warmup", "1", "--json", "--faults", "wifi", "--seed", "3"]
    one, many = (json.loads(echelon(*words, "--engine", engine).stdout) for engine in ("inprocess", "processes"))
    varying = {"engine", "wall_s", "solve_s", "events", "overruns", "rejected"}
    assert {k: v for k, v in one.items() if k not in varying} == {k: v for k, v in many.items() if k not in varying}
    assert one["engine"] == "inprocess"
    assert many["engine"] == "processes"
    assert not list(runs.iterdir())
