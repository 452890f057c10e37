"""A run as bytes: everything of its Parts, so that a simulation that goes on from them does the same to the last bit.

The bytes are a line of JSON (the scenario, and whether the bodies are in it) and a pickle. What follows from the
scenario is not in it. A pickle may name the classes of this program, of numpy and of bodies of users' own that are
loaded here, and no other: bytes that were tampered with are refused, they run nothing.
"""

import copyreg
import io
import json
import pickle
from enum import Enum, EnumMeta
from typing import Any, Final, NamedTuple

from formation.errors import EchelonError
from formation.faults import PERFECT
from formation.loading.folder import PREFIX
from formation.loading.source import LOADED
from formation.scenario.reshaping import with_changes
from formation.scenario.scenario import Scenario
from network.messages import VERSION
from world.bodies.own import OwnBodies
from world.bodies.registry import bodies_for
from world.measures.trace import Trace
from world.parts import Parts

ROOMS = ("formation.", "network.", "world.")
"""Prefixes of the modules that a world is made of."""
OTHERS = {
    "builtins": {"set", "frozenset", "range", "complex", "bytearray"},
    "collections": {"deque", "OrderedDict", "Counter", "defaultdict"},
    "numpy": {"ndarray", "dtype"},
    "numpy._core.multiarray": {"_reconstruct", "scalar"},
    "numpy._core.numeric": {"_frombuffer"},
    "mujoco._structs": {"MjModel", "MjData"},
    "pathlib": {"Path", "PosixPath", "PurePosixPath"},
    "pathlib._local": {"Path", "PosixPath", "PurePosixPath"},
}
"""Names of other modules that a pickle may hold."""
SCENARIO: Final = "scenario"
RESHAPED: Final = "reshaped"
REFERENCE: Final = "reference"
LINK: Final = "perfect"
BODIES: Final = "bodies"


class SnapshotError(EchelonError):
    """The bytes are no run that can go on here."""


class _Pickler(pickle.Pickler):
    """Leaves out what follows from the scenario, and what is compared by identity."""

    def __init__(self, file: io.BytesIO, parts: Parts, *, bodies: bool) -> None:
        super().__init__(file, protocol=5)
        world = parts.world
        self._known = {id(world.scenario): RESHAPED, id(world.given): SCENARIO, id(PERFECT): LINK}
        if world.driver is None:
            self._known[id(world.reference)] = REFERENCE
        if not bodies:
            self._known[id(world.plant)] = BODIES

    def persistent_id(self, value: Any) -> str | None:
        return self._known.get(id(value))

    def reducer_override(self, value: Any) -> Any:
        """Of a trace its rows are left out: they are kept apart (world/resume/saver.py), as far as they are new."""
        return (copyreg.__newobj__, (Trace,), value.without_rows()) if type(value) is Trace else NotImplemented  # type: ignore[attr-defined]


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, scenario: Scenario, now: Scenario) -> None:
        super().__init__(file)
        self._scenario, self._now = scenario, now
        self._made: dict[str, Any] = {SCENARIO: scenario, RESHAPED: now, LINK: PERFECT}

    def persistent_load(self, name: str) -> Any:
        if name not in self._made:
            self._made[name] = bodies_for(self._scenario) if name == BODIES else self._now.reference()
        return self._made[name]

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == ("builtins", "getattr"):  # how Python up to 3.11.3 writes a member of an enumeration
            return _member
        if name in OTHERS.get(module, ()):
            return super().find_class(module, name)
        if module.startswith((*ROOMS, PREFIX)) or module in _installed():
            found = super().find_class(module, name)
            if isinstance(found, type) and found.__module__ == module:  # no function, and nothing that it imports
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is not part of a run")


def _member(kind: object, name: str) -> Enum:
    """The member of an enumeration, and no other attribute of anything."""
    if isinstance(kind, EnumMeta):
        return kind[name]
    raise pickle.UnpicklingError(f"an attribute {name} is not part of a run")


def _installed() -> set[str]:
    """Modules of bodies of users' own that are installed packages."""
    return {source.module for source in LOADED.values() if source.kind == "bodies" and source.file is None}


def dump(parts: Parts) -> bytes:
    """The run as bytes.

    The state of bodies of a user's own is left out if it cannot be pickled; everything else is kept all the same.
    """
    world = parts.world
    scenario = world.given.model_dump_json(exclude_unset=True)
    changes = [change.model_dump(mode="json", exclude_unset=True) for change in world.interventions.changes]
    bodies = True
    try:
        pickled = _pickled(parts, bodies=True)
    except Exception:  # of a user's class: any that it likes
        if not isinstance(parts.world.plant, OwnBodies):
            raise
        bodies, pickled = False, _pickled(parts, bodies=False)
    head = json.dumps({"version": VERSION, "bodies": bodies, "scenario": scenario, "changes": changes})
    return head.encode() + b"\n" + pickled


def _pickled(parts: Parts, *, bodies: bool) -> bytes:
    file = io.BytesIO()
    _Pickler(file, parts, bodies=bodies).dump(tuple(parts))
    return file.getvalue()


class Loaded(NamedTuple):
    """A run, as it was when it was saved."""

    parts: Parts
    bodies: bool
    """Whether the state of its bodies is that of then; else they stand at their start."""


def load(data: bytes) -> Loaded:
    """The run that `dump` made bytes of.

    Raises:
        SnapshotError: it is no such run, or needs code of a user's own that is not loaded here.
    """
    head, _, pickled = data.partition(b"\n")
    try:
        about = json.loads(head)
        if about["version"] != VERSION:
            raise SnapshotError(f"expected a run of wire version {VERSION}; got {about['version']}")
        scenario = Scenario.model_validate_json(about["scenario"])
        now = with_changes(scenario, about["changes"])
        parts = Parts(*_Unpickler(io.BytesIO(pickled), scenario, now).load())
    except SnapshotError:
        raise
    except Exception as error:  # bytes may be anything
        raise SnapshotError(f"expected a saved run; got {type(error).__name__}: {error}") from None
    return Loaded(parts, bool(about["bodies"]))
