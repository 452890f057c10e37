"""Code of users' own on its way from the launcher to the processes of a run: as it was read, not as its file is now."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from formation.errors import ScenarioError
from formation.loading.load import PACKED
from formation.loading.source import LOADED, Kind, Source
from formation.scenario import registry
from formation.scenario.user_code import UserCode, to_text

MOUNT = "/own"
"""Folder of the containers in which the folders of users' files are mounted."""


@dataclass(frozen=True, slots=True)
class CodeArguments:
    """What the processes of a run are told of code of users' own."""

    controllers: tuple[str, ...] = ()
    """For --controller of agents and ghost."""
    bodies: tuple[str, ...] = ()
    """For --bodies of world and ghost."""
    known: str = ""
    """For --controllers of the world, which loads none of them."""


NO_CODE = CodeArguments()


def named(spec: str, kind: Kind) -> str:
    """Load code of a user's own; its name. Raises ScenarioError."""
    if kind == "bodies":
        from world.bodies.own import load_bodies  # noqa: PLC0415  the launcher alone needs no bodies

        return load_bodies(spec).name
    from agents.controllers.own import load_controller  # noqa: PLC0415  half a second, for numba

    return load_controller(spec).name


def admit(source: Source) -> None:
    """Load what another process has read, unless it is loaded already. Raises ScenarioError."""
    if LOADED.get((source.kind, source.name)) == source:
        return
    if source.kind == "bodies":
        from world.bodies import own as bodies  # noqa: PLC0415

        bodies.admit(source)
    else:
        from agents.controllers import own as controllers  # noqa: PLC0415

        controllers.admit(source)


def packed(folder: Path) -> CodeArguments:
    """Write what is loaded into a run's folder, for its processes."""

    def write(source: Source) -> str:
        file = folder / f"{source.kind}-{source.name}{PACKED}"
        file.write_text(source.to_json(), encoding="utf-8")
        return str(file)

    return _arguments([*LOADED.values()], write)


def mounted(sources: Iterable[Source]) -> tuple[CodeArguments, dict[str, str]]:
    """For containers: the arguments, and which folder is mounted where.

    Raises:
        ScenarioError: an installed module, which the image does not have.
    """
    mounts: dict[str, str] = {}

    def place(source: Source) -> str:
        if source.file is None:
            raise ScenarioError(
                f"--{source.kind}: expected FILE.py:CLASS, whose folder can be mounted; got {source.origin}, which the "
                "image does not have"
            )
        there = mounts.setdefault(str(source.file.parent), f"{MOUNT}/{len(mounts) + 1}")
        return f"{there}/{source.file.name}:{source.attribute}"

    return _arguments([*sources], place), mounts


def _arguments(sources: list[Source], argument: Callable[[Source], str]) -> CodeArguments:
    controllers = tuple(argument(source) for source in sources if source.kind == "controller")
    bodies = tuple(argument(source) for source in sources if source.kind == "bodies")
    known: list[UserCode] = registry.own_controllers()
    return CodeArguments(controllers, bodies, to_text(known) if controllers else "")
