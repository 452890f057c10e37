"""Whether a run with real robots can start: each is there, says where it is, and has the room that it needs."""

from collections.abc import Mapping
from queue import Empty
from time import monotonic

import numpy as np

from formation.errors import EchelonError
from formation.scenario.scenario import Scenario
from network.inbox import Inbox
from ros.decoding import Place, PoseReader
from ros.session import RosSession
from ros.spec import RobotSpec
from ros.survey import Chosen, choose, robots_of

POSE_SECONDS = 0.5
"""The newest pose of a robot may be so old [s]."""
LOOK_SECONDS = 1.5
"""Longest wait for the first pose after subscribing [s]: links are found first."""


def check(scenario: Scenario, specs: Mapping[int, RobotSpec]) -> dict[int, Chosen]:
    """Look at every real robot; how each is driven.

    Raises:
        EchelonError: one cannot take part; one line with the reason.
    """
    if scenario.bodies.implementation != "wheeled":
        raise EchelonError(
            f"--robot: expected bodies.implementation = wheeled for the others; got {scenario.bodies.implementation}"
        )
    check_room("the slots at the start", scenario, specs, scenario.start.slots[0])
    places, chosen = {}, {}
    for number, spec in specs.items():
        chosen[number], places[number] = _look(spec)
    poses = np.array(scenario.start_poses())
    for number, place in places.items():
        poses[number - 1] = place
    check_room("the poses", scenario, specs, poses)
    return chosen


def reachable(endpoint: str, domain: int) -> tuple[str, int]:
    """The same, once somebody has answered there. Raises EchelonError."""
    try:
        with RosSession(endpoint, "echelon_check", domain=domain):
            return endpoint, domain
    except EchelonError as error:
        raise EchelonError(f"--ros: {error}") from None


def check_room(what: str, scenario: Scenario, specs: Mapping[int, RobotSpec], poses: np.ndarray) -> None:
    """Refuse real robots that would touch others. Raises EchelonError."""
    radii = scenario.bodies.radii(scenario.size)
    for one in specs:
        for other in range(1, scenario.size + 1):
            if other == one or (other in specs and other < one):
                continue
            apart = float(np.linalg.norm(poses[one - 1, :2] - poses[other - 1, :2]))
            least = radii[one - 1] + radii[other - 1]
            if apart < least:
                raise EchelonError(
                    f"--robot {one}: expected {what} of robots {one} and {other} at least {least:g} m apart, the sum "
                    f"of their radii (bodies.radius); got {apart:.3f} m"
                )


def _look(spec: RobotSpec) -> tuple[Chosen, Place]:
    """The topics of a robot, and where it is. Raises EchelonError."""
    try:
        with RosSession(spec.endpoint, "echelon_check", domain=spec.domain) as session:
            chosen = choose(spec, robots_of(session.tokens()))
            return chosen, _pose(session, spec, chosen)
    except EchelonError as error:
        text = str(error)
        raise EchelonError(text if text.startswith("robot ") else f"robot {spec.number}: {text}") from None


def _pose(session: RosSession, spec: RobotSpec, chosen: Chosen) -> Place:
    inbox: Inbox[tuple[bytes, float]] = Inbox()
    end = session.subscribe(chosen.pose, lambda data, at: inbox.put((data, at)))
    reader = PoseReader(chosen.pose.type, spec.namespace)
    until, wrong = monotonic() + LOOK_SECONDS, ""
    while (left := until - monotonic()) > 0.0:
        try:
            data, came = inbox.get(timeout=left)
            located = reader.read(data)
        except Empty:
            break
        except ValueError as error:
            wrong = f"; what came could not be read: {error}"
            continue
        if located is not None and monotonic() - came <= POSE_SECONDS:
            end()
            return spec.origin.then(located.place)
    raise EchelonError(
        f"robot {spec.number}: expected a pose on {chosen.pose.topic} at least every {POSE_SECONDS:g} s; "
        f"none in {LOOK_SECONDS:g} s{wrong}"
    )
