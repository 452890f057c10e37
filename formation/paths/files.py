"""Points from the files that people have: columns of numbers, with or without a header.

What is read becomes part of the scenario when it is loaded: afterwards nobody needs the file.
"""

import codecs
import math
from collections.abc import Iterator, Sequence
from pathlib import Path as File
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, ValidationError, model_validator

from formation.errors import ScenarioError, unknown
from formation.schema import Model
from formation.validation import problems

MAX_FILE = 64 << 20
"""Bytes of a file of points."""
DELIMITERS = (";", "\t", ",")
"""The first of these that a row holds separates its columns; else any white space does."""
X_NAMES, Y_NAMES = ("x", "x_m", "pos_x", "position_x"), ("y", "y_m", "pos_y", "position_y")
"""Columns that are meant unless the scenario names others."""
OTHER_TEXT = (
    ("UTF-32", codecs.BOM_UTF32_LE),
    ("UTF-32", codecs.BOM_UTF32_BE),
    ("UTF-16", codecs.BOM_UTF16_LE),
    ("UTF-16", codecs.BOM_UTF16_BE),
)
"""Encodings by the byte order mark that a file begins with."""
UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001, "km": 1000.0, "ft": 0.3048, "in": 0.0254}


def _column(value: object) -> object:
    named, numbered = isinstance(value, str) and value, type(value) is int and value >= 0
    if not named and not numbered:
        raise ValueError(f"expected the name of a column or its number from 0; got {value!r:.60}")
    return value


Column = Annotated[int | str, BeforeValidator(_column)]
"""A column by its name in the header, or by its number from 0."""


class PointFile(Model):
    """Where points come from if they are not written out."""

    file: str | None = None
    """CSV file, beside the scenario's: its rows are the points (offsets); what follows a # is a comment."""
    columns: tuple[Column, Column] | None = None
    """Which columns of the `file` hold x and y: their names, or their numbers from 0 (default: x and y, else the first
    two)."""
    unit: Literal["m", "cm", "mm", "km", "ft", "in"] = "m"
    """Of the columns of the `file`."""

    @model_validator(mode="before")
    @classmethod
    def _read(cls, raw: Any) -> Any:
        if cls is not PointFile and isinstance(raw, dict) and raw.get("file") is not None:
            raise ValueError(f"file: only a scenario that is loaded by its name may name files; got {raw['file']!r}")
        return raw


def with_files(raw: dict[str, Any], folder: File, where: str) -> dict[str, Any]:
    """A scenario's table in which points and offsets stand in place of the files that hold them.

    Args:
        raw: the table.
        folder: to which names of files are relative.
        where: what errors begin with.

    Raises:
        ScenarioError: a file cannot be read or does not hold what was asked for.
    """
    found = dict(raw)
    if "path" in found:
        found["path"] = _read(found["path"], "points", "path", folder, where)
    formation = _read(found.get("formation"), "offsets", "formation", folder, where)
    if isinstance(formation, dict):
        found["formation"] = formation = dict(formation)
        changes = formation.get("changes")
        if isinstance(changes, list | tuple):
            keys = [f"formation.changes[{index}]" for index in range(len(changes))]
            formation["changes"] = [
                _read(change, "offsets", key, folder, where) for key, change in zip(keys, changes, strict=True)
            ]
    return found


def _read(table: Any, what: str, key: str, folder: File, where: str) -> Any:
    """The table with `what` in place of its file; as it is if it names none."""
    if not isinstance(table, dict) or table.get("file") is None:
        return table
    keys = {name: table[name] for name in PointFile.model_fields if name in table}
    try:
        source = PointFile.model_validate(keys)
    except ValidationError as error:
        raise ScenarioError("\n".join(f"{where}: {key}.{line}" for line in problems(error, PointFile))) from None
    if table.get(what) is not None:
        raise ScenarioError(f"{where}: {key}: expected either {what} or a file; got both")
    assert source.file is not None
    text = text_of(folder / source.file, f"{where}: {key}.file", MAX_FILE)
    speed = table.get("speed_column") if what == "points" else None
    name = f"{where}: {File(source.file).name}"
    rows = columns_of(text, name, source.columns, [] if speed is None else [speed])
    scale = UNITS[source.unit]
    kept = {name: value for name, value in table.items() if name not in PointFile.model_fields}
    kept.pop("speed_column", None)
    kept[what] = [[scale * row[0], scale * row[1]] for row in rows]
    if speed is not None:
        kept["speeds"] = [scale * row[2] for row in rows]
    return kept


def text_of(file: File, where: str, limit: int) -> str:
    """The text of a file, a pipe as well.

    Raises:
        ScenarioError: it is not there, not text, or longer than `limit` [bytes].
    """
    try:
        with file.open("rb") as stream:
            data = stream.read(limit + 1)
    except FileNotFoundError:
        raise ScenarioError(f"{where}: expected a file; there is no {file}") from None
    except (OSError, ValueError) as error:
        raise ScenarioError(f"{where}: cannot be read: {error}") from None
    if len(data) > limit:
        raise ScenarioError(f"{where}: expected at most {limit >> 20} MiB; got more")
    other = next((name for name, mark in OTHER_TEXT if data.startswith(mark)), None)
    if other or b"\0" in data:  # without a mark: every second byte of plain text is 0
        raise ScenarioError(f"{where}: expected text in UTF-8; got {other or 'bytes that are 0, as in UTF-16'}")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ScenarioError(f"{where}: expected text in UTF-8; {error.reason} at byte {error.start}") from None


def columns_of(
    text: str, where: str, wanted: tuple[int | str, int | str] | None, more: Sequence[object] = ()
) -> list[list[float]]:
    """Rows of the wanted columns of a table of numbers.

    Args:
        text: of the file.
        where: its name.
        wanted: columns of x and y; None for those named so, or the first two.
        more: further columns.

    Raises:
        ScenarioError: a column is not there or a value is no number; the text names the file and the line.
    """
    rows = list(_rows(text))
    if not any(header is None for _, _, header in rows):
        raise ScenarioError(f"{where}: expected rows of numbers; got none")
    delimiter = _delimiter(next(line for _, line, header in rows if header is None))
    header = next((found for _, _, found in reversed(rows[: _first(rows)]) if found is not None), None)
    names = [] if header is None else _split(header, delimiter)
    first = _split(rows[_first(rows)][1], delimiter)
    if names and len(names) != len(first):
        names = []  # a comment, not the names of the columns
    chosen = [_index(column, names, len(first), where) for column in [*(wanted or _usual(names, where)), *more]]
    found, wrong = [], []
    for number, line, head in rows:
        if head is None:
            values = _split(line, delimiter)
            try:
                row = [_number(values[index], delimiter) for index in chosen]
            except IndexError:
                wrong.append(f"line {number}: expected at least {max(chosen) + 1} columns; got {len(values)}")
            except ValueError:
                bad = next(values[i] for i in chosen if not _is_number(values[i], delimiter))
                wrong.append(f"line {number}: expected a finite number; got {bad[:40]!r}")
            else:
                found.append(row)
    if wrong:
        others = f" (and {len(wrong) - 1} more like it)" if len(wrong) > 1 else ""
        raise ScenarioError(f"{where}, {wrong[0]}{others}")
    return found


def _rows(text: str) -> Iterator[tuple[int, str, str | None]]:
    """Every line that is not empty: its number from 1, its text, and if it is no row of numbers, its header's text."""
    begun = False
    for number, line in enumerate(text.splitlines(), start=1):
        bare, comment, remark = line.partition("#")
        if bare.strip():
            head = not begun and not any(_is_number(v, ";") or v.lower() in ("nan", "inf") for v in _split_any(bare))
            begun = begun or not head
            yield number, bare.strip(), bare.strip() if head else None
        elif comment and not begun and remark.strip():
            yield number, "", remark.strip()


def _first(rows: list[tuple[int, str, str | None]]) -> int:
    return next(index for index, (_, _, header) in enumerate(rows) if header is None)


def _delimiter(line: str) -> str | None:
    return next((mark for mark in DELIMITERS if mark in line), None)


def _split(line: str, delimiter: str | None) -> list[str]:
    return [value.strip().strip("\"'") for value in line.split(delimiter)]


def _split_any(line: str) -> list[str]:
    return _split(line, _delimiter(line))


def _number(value: str, delimiter: str | None) -> float:
    """A finite number; with a decimal comma where commas separate nothing."""
    number = float(value.replace(",", ".") if delimiter != "," else value)
    if not math.isfinite(number):
        raise ValueError(value)
    return number


def _is_number(value: str, delimiter: str | None) -> bool:
    try:
        _number(value, delimiter)
    except ValueError:
        return False
    return True


def _usual(names: list[str], where: str) -> tuple[int | str, int | str]:
    if not names:
        return 0, 1
    lower = [name.lower() for name in names]
    for x, y in zip(X_NAMES, Y_NAMES, strict=True):
        if x in lower and y in lower:
            return lower.index(x), lower.index(y)
    raise ScenarioError(f"{where}: expected columns x and y, or `columns` that names two of {', '.join(names)}"[:400])


def _index(column: object, names: list[str], count: int, where: str) -> int:
    if isinstance(column, int):
        if not 0 <= column < count:
            raise ScenarioError(f"{where}: expected a column from 0 to {count - 1}; got {column}")
        return column
    if column in names:
        return names.index(str(column))
    if not names:
        raise ScenarioError(f"{where}: expected a number from 0 as column, the file has no header; got {column!r}")
    raise ScenarioError(unknown(f"{where}: column", str(column), names))
