"""A table of results: columns with names and types, handed to any library of data frames without a copy of its own."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from api.arguments import check_folder, unwritable


class Table:
    """Columns of equal length. `polars.DataFrame(table)`, `pyarrow.table(table)` and pandas 3 take it as it is."""

    def __init__(self, columns: Mapping[str, NDArray[Any]]) -> None:
        """A table of these columns, by name."""
        self._columns = dict(columns)

    @property
    def columns(self) -> list[str]:
        """Names of the columns."""
        return list(self._columns)

    def __getitem__(self, column: str) -> NDArray[Any]:
        """The values of a column."""
        return self._columns[column]

    def __len__(self) -> int:
        return len(next(iter(self._columns.values()), ()))

    def rows(self) -> list[dict[str, Any]]:
        """The table row by row."""
        lists = [values.tolist() for values in self._columns.values()]
        return [dict(zip(self._columns, row, strict=True)) for row in zip(*lists, strict=True)]

    def __arrow_c_stream__(self, requested_schema: object = None) -> object:
        """The Arrow stream of the table (the PyCapsule interface)."""
        del requested_schema  # the types are those of the columns
        return self._query("SELECT * FROM given").__arrow_c_stream__()

    def to_csv(self, file: str | Path) -> Path:
        """Write the table as CSV. Raises EchelonError: the file cannot be written."""
        return self._write(file, "FORMAT csv, HEADER")

    def to_parquet(self, file: str | Path, about: Mapping[str, str] | None = None) -> Path:
        """Write the table as Parquet.

        Args:
            file: where.
            about: text by key, kept with the table.

        Raises:
            EchelonError: the file cannot be written.
        """
        pairs = ", ".join(f"{key}: '{_quoted(text)}'" for key, text in (about or {}).items())
        return self._write(file, f"FORMAT parquet, COMPRESSION zstd{f', KV_METADATA {{{pairs}}}' if pairs else ''}")

    def _write(self, file: str | Path, options: str) -> Path:
        import duckdb  # noqa: PLC0415  a quarter of a second

        path = check_folder(file)
        try:
            self._query(f"COPY given TO '{_quoted(str(file))}' ({options})")
        except duckdb.Error as error:
            raise unwritable(file, error) from None
        return path

    def _query(self, text: str) -> Any:
        import duckdb  # noqa: PLC0415  a quarter of a second

        database = duckdb.connect(config={"threads": 1})  # so that the bytes do not vary
        database.register("given", self._columns)
        return database.sql(text)

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in self._columns)
        shown = [f"<tr>{''.join(f'<td>{cell}</td>' for cell in row.values())}</tr>" for row in self.rows()[:20]]
        more = f"<p>{len(self)} rows</p>" if len(self) > 20 else ""
        return f"<table><tr>{head}</tr>{''.join(shown)}</table>{more}"


def column(values: Sequence[Any]) -> NDArray[Any]:
    """A column of whole numbers, of numbers (nothing is NaN), or of text."""
    if all(isinstance(value, int) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=np.int64)
    if all(value is None or (isinstance(value, int | float) and not isinstance(value, bool)) for value in values):
        return np.array([np.nan if value is None else value for value in values], dtype=float)
    return np.array([str(value) for value in values], dtype=object)


def _quoted(text: str) -> str:
    return text.replace("'", "''")
