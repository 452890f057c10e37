"""Tables of results as CSV, Markdown and JSON: the same numbers give the same bytes."""

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

Cell = str | float | int | bool | None
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def shown(value: Cell) -> str:
    """A cell as text: three significant digits, words for yes and no, a dash for nothing."""
    match value:
        case None:
            return "–"
        case bool():
            return "yes" if value else "no"
        case int() | str():
            return str(value)
    if not math.isfinite(value):
        return "∞" if value > 0 else "–"
    if value == 0.0:
        return "0"
    value = float(f"{value:.2e}")  # first, so that 9.999 is 10.0
    exponent = math.floor(math.log10(abs(value)))
    if -4 <= exponent <= 5:
        return f"{value:.{max(0, 2 - exponent)}f}".replace("-", "−")
    mantissa, _, power = f"{value:.1e}".partition("e")
    return f"{mantissa}×10{str(int(power)).translate(_SUPERSCRIPT)}".replace("-", "−")


@dataclass(frozen=True, slots=True)
class Table:
    """A table of results."""

    name: str
    """Of its CSV file, without suffix."""
    caption: str
    heads: tuple[str, ...]
    """Column heads, with units."""
    rows: tuple[tuple[Cell, ...], ...]

    def csv(self) -> str:
        """Comma-separated values, nine significant digits."""
        return "".join(",".join(_csv(cell) for cell in row) + "\n" for row in (self.heads, *self.rows))

    def markdown(self) -> str:
        """A pipe table; numbers stand right."""
        rule = ["---:" if right else "---" for right in self.numeric]
        rows = [_bars(self.heads), rule, *(_bars(map(shown, row)) for row in self.rows)]
        return "\n".join(f"| {' | '.join(row)} |" for row in rows)

    def json(self) -> dict[str, Any]:
        """What `--json` prints of it; numbers that are not finite become null."""
        rows = [[None if isinstance(c, float) and not math.isfinite(c) else c for c in row] for row in self.rows]
        return {"caption": self.caption, "columns": list(self.heads), "rows": rows}

    @property
    def numeric(self) -> list[bool]:
        """Per column, whether it holds a number."""
        columns = zip(*self.rows, strict=True)
        numbers = [any(isinstance(c, int | float) and not isinstance(c, bool) for c in column) for column in columns]
        return numbers or [False] * len(self.heads)


def _bars(cells: Iterable[str]) -> list[str]:
    """A bar in a cell would end it."""
    return [cell.replace("|", r"\|") for cell in cells]


def _csv(cell: Cell) -> str:
    match cell:
        case None:
            return ""
        case bool():
            return "yes" if cell else "no"
        case float():
            return f"{cell:.9g}"
    text = str(cell)
    return '"' + text.replace('"', '""') + '"' if set(text) & set(',"\n') else text
