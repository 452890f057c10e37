"""From what a user types to a class: FILE.py:CLASS, package.module:CLASS, or the name of an entry point."""

import hashlib
import importlib
import inspect
import traceback
from collections.abc import Callable
from importlib.metadata import entry_points
from pathlib import Path
from types import ModuleType

from formation.errors import ScenarioError
from formation.loading.folder import Folder
from formation.loading.source import Kind, Source, digest, from_json, read

PACKED = ".own.json"
"""How the file ends in which a launcher hands a source to the processes of its run."""


def group(kind: Kind) -> str:
    """The group of entry points."""
    return "echelon.controllers" if kind == "controller" else "echelon.bodies"


def names_code(spec: str, kind: Kind) -> bool:
    """Whether a text names code, rather than something that is built in."""
    return ":" in spec or spec.endswith((".py", PACKED)) or bool(entry_points(group=group(kind), name=spec))


def load(spec: str, kind: Kind) -> tuple[Source, type]:
    """The class that a text names, and its source.

    Raises:
        ScenarioError: it cannot be had; one line says what was expected and what there is.
    """
    if spec.endswith(PACKED):
        return unpack(from_json(read(Path(spec), spec), spec))
    module, colon, attribute = spec.rpartition(":")
    if not colon:
        found = [*entry_points(group=group(kind), name=spec)]
        if found:
            module, _, attribute = found[0].value.partition(":")
        elif spec.endswith(".py"):
            raise ScenarioError(
                f"--{kind}: expected FILE.py:CLASS; got {spec}, which has {_classes_in(Path(spec), spec)}"
            )
        else:
            raise ScenarioError(f"--{kind}: expected FILE.py:CLASS or package.module:CLASS; got {spec!r}")
    if not module or not attribute.isidentifier():
        raise ScenarioError(f"--{kind}: expected FILE.py:CLASS or package.module:CLASS; got {spec!r}")
    if module.endswith(".py") or "/" in module:
        return _of_file(Path(module).absolute(), attribute, kind, spec)
    return _of_module(module, attribute, kind, spec)


def unpack(source: Source) -> tuple[Source, type]:
    """The class of a source that was read elsewhere or earlier: its text counts, not what its file holds now.

    Raises:
        ScenarioError: an installed module is not the same here.
    """
    if source.file is None:
        here, found = _of_module(source.module, source.attribute, source.kind, source.origin)
        if here.sha256 != source.sha256:
            raise ScenarioError(differs(source.kind, source.name, source.origin, source.sha256, here.sha256))
        return source, found
    folder = Folder(source.file.parent, dict(source.texts))
    module = _imported(lambda: folder.module(_stem(source)), source.origin, source.file.parent)
    return source, _class_of(module, source.attribute, source.origin)


def differs(kind: str, name: str, origin: str, expected: str, got: str | None) -> str:
    """Text for code that is not the code of the run."""
    have = f"that of SHA-256 {got[:12]}" if got else "none"
    return f"{kind} {name}: expected {origin} of SHA-256 {expected[:12]} (--{kind} on this command line); got {have}"


def _of_file(file: Path, attribute: str, kind: Kind, spec: str) -> tuple[Source, type]:
    texts = {file.name: read(file, spec)}
    folder = Folder(file.parent, texts)
    module = _imported(lambda: folder.module(file.name.removesuffix(".py")), spec, file.parent)
    found = _class_of(module, attribute, spec)
    return Source(kind, attribute, str(file), attribute, dict(texts), digest(texts)), found


def _of_module(name: str, attribute: str, kind: Kind, spec: str) -> tuple[Source, type]:
    module = _imported(lambda: importlib.import_module(name), spec, None)
    found = _class_of(module, attribute, spec)
    try:
        file = inspect.getsourcefile(found) or ""
        sha256 = hashlib.sha256(Path(file).read_bytes()).hexdigest()
    except (TypeError, OSError):
        raise ScenarioError(f"--{kind} {spec}: expected a class with Python source; got none") from None
    return Source(kind, attribute, name, attribute, {}, sha256), found


def _stem(source: Source) -> str:
    assert source.file is not None
    return source.file.name.removesuffix(".py")


def _imported(run: Callable[[], ModuleType], spec: str, folder: Path | None) -> ModuleType:
    """Import; whatever goes wrong in the user's code is one line, with the place.

    Raises:
        ScenarioError: the import raised something.
    """
    try:
        return run()
    except (Exception, SystemExit) as error:
        if isinstance(error, ScenarioError):
            raise
        raise ScenarioError(f"{spec}: expected code that can be imported; {failure(error, folder)}") from None


def failure(error: BaseException, folder: Path | None) -> str:
    """An exception of a user's code in a line: type, text, file and line."""
    text = " ".join(str(error).split())[:200]
    place = ""
    if isinstance(error, SyntaxError) and error.filename:
        text, place = error.msg, f" ({Path(error.filename).name}:{error.lineno})"
    else:
        frames = [frame for frame in traceback.extract_tb(error.__traceback__) if _inside(frame.filename, folder)]
        if frames:
            place = f" ({Path(frames[-1].filename).name}:{frames[-1].lineno})"
    return f"{type(error).__name__}{': ' if text else ''}{text}{place}"


def folder_of(code: object) -> Path | None:
    """The folder of the file that a class or function is defined in."""
    try:
        return Path(inspect.getfile(code)).parent  # type: ignore[arg-type]
    except (TypeError, OSError):
        return None


def _inside(file: str, folder: Path | None) -> bool:
    return folder is not None and folder in Path(file).parents


def _class_of(module: ModuleType, attribute: str, spec: str) -> type:
    found = getattr(module, attribute, None)
    if not isinstance(found, type):
        raise ScenarioError(f"{spec}: expected a class {attribute}; it has {_classes(module)}")
    return found


def _classes(module: ModuleType) -> str:
    own = [n for n, v in vars(module).items() if isinstance(v, type) and v.__module__ == module.__name__]
    return ", ".join(own) or "no class"


def _classes_in(file: Path, spec: str) -> str:
    folder = Folder(file.absolute().parent, {file.name: read(file, spec)})
    module = _imported(lambda: folder.module(file.name.removesuffix(".py")), spec, folder.path)
    return _classes(module)
