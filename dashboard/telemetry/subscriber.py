"""The newest message of each kind from the world, the agents and the ghost: what the page is drawn from.

One thread drains the inbox and only stores, so that a slow page never slows the run. Statuses, which are the most
messages, wait outside Python until the page takes them.
"""

import json
import threading
from collections import deque
from itertools import islice
from time import monotonic

import numpy as np

from dashboard.telemetry.export_buffer import ExportBuffer
from dashboard.telemetry.snapshot import Snapshot
from dashboard.telemetry.tape import Tape
from formation.arrays import FloatArray
from formation.errors import EchelonError, WireError
from formation.metrics import wrapped
from formation.scenario.files import parse
from formation.scenario.registry import register_unloaded
from formation.scenario.scenario import Scenario
from formation.schema import MAX_ROBOTS
from network import topics
from network.bus import Bus, Sample
from network.codec import decode
from network.messages import Ghost, State, Status
from network.throttled_log import ThrottledLog

WAITING_GHOSTS = 1000
"""Ghost messages that wait, at most: a ghost that catches up publishes 450 in a row."""
WAITING_STATUSES = 2 * MAX_ROBOTS
"""Statuses that wait, at most: of each robot only the newest counts."""
SETUP_INTERVAL = 0.25
"""Between two requests for the setup [s]."""


class TelemetrySubscriber:
    """Subscribes to the states, statuses and ghosts of a run: some hundred messages a second, but no plans."""

    live = True

    def __init__(self, bus: Bus) -> None:
        """Subscribe; `start` then begins to receive."""
        self._bus = bus
        self._lock = threading.Lock()
        self._states: tuple[tuple[float, State], ...] = ()
        self._statuses: dict[int, Status] = {}
        self._ghosts: deque[Ghost] = deque(maxlen=WAITING_GHOSTS)
        self._scenario: tuple[int, int, Scenario] | None = None
        self._rejects = ThrottledLog()
        self._asked_at = 0.0
        self._over = False
        self._thread = threading.Thread(target=self._listen, name="telemetry", daemon=True)
        run = bus.run
        bus.subscribe(topics.state(run))
        self._waiting = bus.keep(topics.status(run, "*"), WAITING_STATUSES)
        bus.subscribe(topics.ghost(run))
        bus.appear("dashboard")

    def start(self) -> None:
        """Begin to receive."""
        self._thread.start()

    def stop(self) -> None:
        """Receive no more."""
        self._over = True
        self._bus.wake()
        self._thread.join(1.0)

    def fill(self, tape: Tape, export_buffer: ExportBuffer) -> bool:
        """A run comes in by itself."""
        return False

    def snapshot(self) -> Snapshot:
        """What is known now. Called by the thread that draws, and by no other."""
        now = monotonic()
        for sample in islice(self._waiting.take(), WAITING_STATUSES):
            self._take(sample)
        with self._lock:
            states, scenario = self._states, self._scenario
        ghosts = tuple(self._ghosts.popleft() for _ in range(len(self._ghosts)))
        poses, stamp = _between(states, now)
        state = states[-1][1] if states else None
        if state is not None:  # the last status of an agent that is gone is dropped for good
            live = set(state.live)
            self._statuses = {robot: status for robot, status in self._statuses.items() if robot in live}
        fits = state is not None and scenario is not None and scenario[0] == state.episode
        return Snapshot(
            state=state,
            scenario=scenario[2] if fits and scenario is not None else None,
            statuses=dict(self._statuses),
            poses=poses,
            stamp=stamp,
            ghosts=ghosts,
            world_alive=bool(states) and now - states[-1][0] < topics.STATE.stale,
            connected=self._bus.connected,
        )

    # ------------------------------------------------------------------ the scenario

    def update_scenario(self) -> None:
        """Request the setup if the scenario has changed; called by the thread that may wait for replies."""
        now = monotonic()
        with self._lock:
            state, known = self._states[-1][1] if self._states else None, self._scenario
        if state is None or now - self._asked_at < SETUP_INTERVAL:
            return
        if known is not None and known[:2] == (state.episode, state.revision):
            return
        self._asked_at = now
        try:
            setup = self._bus.setup()
            if setup is None:
                return
            register_unloaded(setup.user_code)
            scenario = parse(json.loads(setup.scenario), where="the world's scenario")
        except (EchelonError, ValueError) as error:
            self._rejects.add("setup", error)
            return
        with self._lock:
            self._scenario = (setup.episode, setup.revision, scenario)

    # ------------------------------------------------------------------ incoming messages

    def _listen(self) -> None:
        while not self._over:
            for item in self._bus.arrivals(0.5):
                if isinstance(item, Sample):
                    self._take(item)

    def _take(self, sample: Sample) -> None:
        try:
            self._put(sample)
        except WireError as error:
            self._rejects.add(sample.key, error)

    def _put(self, sample: Sample) -> None:
        if sample.key.endswith("/ghost"):
            ghost = decode(Ghost, sample.payload)
            if not len(ghost.distance_errors) == len(ghost.angle_errors) == len(ghost.poses):
                raise WireError(f"expected errors of {len(ghost.poses)} robots")
            self._ghosts.append(ghost)
        elif sample.key.endswith("/status"):
            status = decode(Status, sample.payload)
            if status.sender != topics.robot_of(sample.key):
                raise WireError(f"expected the sender named in the key; got {status.sender}")
            self._statuses[status.sender] = status
        else:
            state = _checked(decode(State, sample.payload))
            with self._lock:
                self._states = (*self._states[-1:], (monotonic(), state))


def _checked(state: State) -> State:
    """The state, if its parts fit each other.

    Raises:
        WireError: lengths of arrays differ, or a robot does not exist.
    """
    n = len(state.poses)
    if n > MAX_ROBOTS:
        raise WireError(f"poses: expected at most {MAX_ROBOTS}; got {n}")
    if not len(state.slots) == len(state.distance_errors) == len(state.angle_errors) == n:
        raise WireError(f"expected {n} slots and errors")
    for name in ("waiting_for", "dismissed", "live", "stopped"):
        for robot in getattr(state, name):
            if not 1 <= robot <= n:
                raise WireError(f"{name}: expected robots from 1 to {n}; got {robot}")
    return state


def _between(states: tuple[tuple[float, State], ...], now: float) -> tuple[FloatArray, float]:
    """Poses and stamp to draw now, interpolated from the state before the last towards the last.

    The page therefore runs one state (50 ms) behind; it never extrapolates.
    """
    if not states:
        return np.empty((0, 3)), 0.0
    at, last = states[-1]
    if len(states) < 2:
        return last.poses, last.stamp
    before_at, before = states[0]
    if before.episode != last.episode or before.poses.shape != last.poses.shape or at <= before_at:
        return last.poses, last.stamp
    share = min(1.0, (now - at) / (at - before_at))
    moved = last.poses - before.poses
    moved[:, 2] = wrapped(moved[:, 2])
    return before.poses + share * moved, before.stamp + share * (last.stamp - before.stamp)
