"""Simulates what a record holds again, in one process, and compares every pose with it to the last bit."""

import json
import zlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from formation.errors import EchelonError
from formation.faults import Fault
from formation.link_ids import LinkId
from formation.loading.load import differs
from formation.loading.source import LOADED
from formation.scenario.files import parse
from formation.scenario.scenario import Scenario
from formation.scenario.user_code import from_text
from network.messages import VERSION
from network.values import Intervention
from records.record import Record, RecordedEpisode, RecordedOrder
from runtime.ghost.shadow import Shadow


@dataclass(frozen=True, slots=True)
class Verdict:
    """What came of an episode."""

    episode: int
    """Its place in the record, from 1."""
    ticks: int
    """That were compared, all equal up to the difference."""
    until: float
    """Simulated time up to which it was compared [s]."""
    difference: str = ""
    """Where it differs first; empty if nowhere."""
    remark: str = ""
    """What could not be compared, and why."""


def verify(record: Record, progress: Callable[[float], None] = lambda _: None) -> list[Verdict]:
    """Compare every episode.

    Args:
        record: as it was read.
        progress: called now and then with the simulated time [s].

    Raises:
        EchelonError: this record cannot be simulated again here; the text gives the reason.
    """
    check_repeatable(record)
    return [_verdict(number, episode, progress) for number, episode in enumerate(record.episodes, 1)]


def check_version(record: Record) -> None:
    """Refuse a record of another wire. Raises EchelonError."""
    version = record.about.get("version")
    if version != str(VERSION):
        raise EchelonError(f"expected a record of wire version {VERSION}; {record.path} is of version {version}")


def check_repeatable(record: Record) -> None:
    """Refuse a record that cannot be simulated again. Raises EchelonError with the reason."""
    check_version(record)
    if not record.episodes:
        raise EchelonError(f"expected an episode; {record.path} has none")
    for episode in record.episodes:
        if episode.mode != "lockstep":
            raise EchelonError(
                f"expected a lockstep run; {record.path} is of a {episode.mode} run, which depends on the wall clock"
            )


def scenario_of(episode: RecordedEpisode) -> Scenario:
    """What ran.

    Raises:
        EchelonError: the code of a user's own that it ran with is not here.
    """
    for code in from_text(episode.user_code):
        here = LOADED.get((code.kind, code.name))
        if here is None or here.sha256 != code.sha256:
            raise EchelonError(differs(code.kind, code.name, code.origin, code.sha256, here.sha256 if here else None))
    return parse(json.loads(episode.scenario), where="the record's scenario")


def shadow_of(episode: RecordedEpisode) -> Shadow:
    """An episode at its start, with all that was ordered in it; step it on. Raises EchelonError as `scenario_of`."""
    scenario = scenario_of(episode)
    orders = episode.sorted_orders
    shadow = Shadow(scenario, scenario.controller.name, episode.number)
    shadow.learn(
        [(order.tick * episode.interval, table_of(order)) for order in orders if order.kind == "faults"],
        [(order.tick, order.value["v"], order.value["omega"]) for order in orders if order.kind == "drive"],
        [_intervention(order) for order in orders if order.kind in ("push", "release", "shape", "ring")],
    )
    shadow.resume_at(episode.resumed)
    return shadow


def _verdict(number: int, episode: RecordedEpisode, progress: Callable[[float], None]) -> Verdict:
    shadow, orders = shadow_of(episode), episode.sorted_orders
    missing = sorted(set(range(max((order.number for order in orders), default=-1) + 1)) - {o.number for o in orders})
    remarks = [f"order {number} is not in the record" for number in missing]
    end = _everybody_until(orders, episode.ticks, remarks, episode.interval)
    compared = 0
    for tick in episode.ticks:
        if tick > end:
            break
        while shadow.k < tick:
            shadow.step()
            if shadow.k % 100 == 0:
                progress(shadow.now)
        difference = difference_of(episode, tick, shadow)
        if difference:
            return Verdict(number, compared, shadow.now, difference, "; ".join(remarks))
        compared += 1
    return Verdict(number, compared, shadow.now, "", "; ".join(remarks))


def _everybody_until(orders: list[RecordedOrder], ticks: list[int], remarks: list[str], interval: float) -> int:
    """The last tick up to which every agent took part: an agent that joins later begins cold, who knows with what."""
    size = next((order for order in orders if order.kind == "agents"), None)
    if size is None:
        return ticks[-1] if ticks else 0
    answered = ", ".join(map(str, size.value["answered"])) or "none"
    remarks.append(
        f"from t = {size.tick * interval:.2f} s on not every agent took part (only {answered}): not compared"
    )
    return size.tick


def table_of(order: RecordedOrder) -> dict[LinkId, Fault]:
    """Every link that is not perfect from this order on."""
    return {LinkId.parse(link): Fault(**fault) for link, fault in order.value.items()}


def _intervention(order: RecordedOrder) -> Intervention:
    kind: Any = order.kind
    return Intervention(order.tick, kind, order.value)


def difference_of(episode: RecordedEpisode, tick: int, shadow: Shadow) -> str:
    """Which robot is elsewhere than in the record at a tick; empty if none is."""
    poses = np.ascontiguousarray(shadow.poses, dtype="<f8")
    exact = episode.poses.get(tick)
    for i, (pose, check) in enumerate(zip(poses, episode.checks[tick], strict=True)):
        same = zlib.crc32(pose.tobytes()) == check
        if same and (exact is None or pose.tobytes() == exact[i].tobytes()):
            continue
        text = f"tick {tick} (t = {shadow.now:.2f} s), robot {i + 1}: simulated {_words(pose)}"
        return text if exact is None else f"{text}, recorded {_words(exact[i])}"
    return ""


def _words(pose: np.ndarray[tuple[int], np.dtype[np.float64]]) -> str:
    return "(" + ", ".join(repr(float(value)) for value in pose) + ")"
