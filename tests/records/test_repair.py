"""Laws of broken records: what was flushed is read, whatever was cut off or damaged behind or between."""

import struct
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC

from formation.errors import EchelonError
from records.export import ERRORS, POSES, export
from records.file import RecordFile
from records.record import load
from records.repair import repair
from records.scanning import Damage, End, Message, Note, scan
from tests.records.recorded import record, scenario


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("records") / "whole.mcap"
    record(path, scenario(), flush_every=20)
    return path


def counted(path: Path) -> int:
    """Messages that an ordinary reader finds; it goes by the index."""
    with path.open("rb") as stream:
        return sum(1 for _ in make_reader(stream, validate_crcs=True).iter_messages())


def items(path: Path) -> list[Message]:
    return [item for item in scan(path) if isinstance(item, Message)]


def test_a_whole_record_has_no_damage(whole: Path) -> None:
    found = list(scan(whole))
    assert isinstance(found[-1], End)
    assert not [item for item in found if isinstance(item, Damage)]
    assert [item.name for item in found if isinstance(item, Note)] == ["echelon", "episode"]
    assert len(items(whole)) == counted(whole)


@settings(max_examples=40, deadline=None)
@given(share=st.floats(0.05, 0.999))
def test_a_record_cut_anywhere_is_read_to_the_last_flush(whole: Path, share: float) -> None:
    data = whole.read_bytes()
    cut, new = whole.with_name("cut.mcap"), whole.with_name("new.mcap")
    cut.write_bytes(data[: int(share * len(data))])
    new.unlink(missing_ok=True)
    done = repair(cut, new)
    assert items(new) == items(whole)[: done.messages]
    assert counted(new) == done.messages
    assert load(new).sound
    with cut.open("rb") as stream, pytest.raises((McapError, struct.error)):  # an ordinary reader
        make_reader(stream, validate_crcs=True).get_summary()


@settings(max_examples=60, deadline=None)
@given(share=st.floats(0.02, 0.9), length=st.integers(1, 200), bit=st.integers(1, 255))
def test_damage_in_the_middle_costs_its_chunks_and_no_more(whole: Path, share: float, length: int, bit: int) -> None:
    data = bytearray(whole.read_bytes())
    at = int(share * len(data))
    data[at : at + length] = bytes(byte ^ bit for byte in data[at : at + length])
    broken, new = whole.with_name("broken.mcap"), whole.with_name("mended.mcap")
    broken.write_bytes(data)
    new.unlink(missing_ok=True)
    done = repair(broken, new)
    kept, all_of_them = items(new), items(whole)
    assert len(all_of_them) - len(kept) <= 0.35 * len(all_of_them)  # of 13 chunks at most three, and their indexes
    left = iter(all_of_them)
    assert all(message in left for message in kept), "what is kept is in the order of the record, and unchanged"
    assert counted(new) == done.messages == len(kept)


@pytest.mark.parametrize("opcode", [Opcode.SCHEMA, Opcode.CHANNEL, Opcode.MESSAGE])
def test_an_index_that_is_taken_for_what_chunks_hold_is_damage(whole: Path, opcode: int) -> None:
    """Nothing guards the first byte of a record outside chunks; a flipped bit makes a message of an index."""
    data, at = bytearray(whole.read_bytes()), len(MCAP0_MAGIC)
    while data[at] != Opcode.MESSAGE_INDEX:
        at += 9 + int.from_bytes(data[at + 1 : at + 9], "little")
    data[at] = opcode
    broken = whole.with_name("broken.mcap")
    broken.write_bytes(data)
    assert items(broken) == items(whole)
    assert sum(isinstance(item, Damage) for item in scan(broken)) == 1


@pytest.mark.parametrize(
    ("data", "words"), [(b"", "an empty file"), (b"not a record at all", "begins with b'not a re'")]
)
def test_a_file_that_is_no_record_is_refused_in_a_line(tmp_path: Path, data: bytes, words: str) -> None:
    path = tmp_path / "x.mcap"
    path.write_bytes(data)
    for read in (load, lambda path: repair(path, path.with_name("y.mcap"))):
        with pytest.raises(EchelonError, match=words) as caught:
            read(path)
        assert "\n" not in str(caught.value)
    assert not path.with_name("y.mcap").exists()


def test_a_missing_file_and_a_foreign_record_are_refused_in_a_line(tmp_path: Path) -> None:
    with pytest.raises(EchelonError, match="cannot read"):
        load(tmp_path / "missing.mcap")
    with RecordFile(tmp_path / "foreign.mcap"):
        pass
    with pytest.raises(EchelonError, match="expected a record of a run"):
        load(tmp_path / "foreign.mcap")


def test_a_record_is_never_overwritten(whole: Path) -> None:
    before = whole.read_bytes()
    with pytest.raises(EchelonError, match="new file"):
        RecordFile(whole)
    assert whole.read_bytes() == before


def test_csv_and_parquet_hold_the_same_table(whole: Path) -> None:
    import duckdb

    read = load(whole)
    tables = zip(export(read, "csv"), export(read, "parquet"), (POSES, ERRORS), strict=True)
    for text, parquet, columns in tables:
        lines = text.read_text().splitlines()
        assert lines[0].split(",") == list(columns)
        with duckdb.connect() as database:
            rows = database.read_parquet(str(parquet)).fetchall()
        assert [",".join(map(str, row)) for row in rows] == lines[1:]
        assert len(rows) > 70
