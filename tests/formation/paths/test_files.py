"""Points from files that people have: found columns, exact values, and mistakes that name file and line."""

import os
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from formation.errors import ScenarioError
from formation.paths.files import DELIMITERS, columns_of
from formation.paths.waypoints import Waypoints
from formation.scenario.files import load, parse
from formation.scenario.scenario import Scenario

POINTS = [[0.0, 0.0], [1.0, 0.25], [2.0, -0.5], [3.0, 1e-3]]


def scenario(folder: Path, content: str | bytes, keys: str = "", *, name: str = "way.csv") -> Scenario:
    """A scenario whose path is a file with this content, beside it."""
    data = content if isinstance(content, bytes) else content.encode()
    (folder / name).write_bytes(data)
    file = folder / "own.toml"
    file.write_text(
        f'name = "own"\n[path]\nkind = "waypoints"\nfile = "{name}"\n{keys}\n[formation]\nshape = "triangle"\n',
        encoding="utf-8",
    )
    return load(str(file))


def points(found: Scenario) -> Any:
    assert isinstance(found.path, Waypoints)
    return found.path.points


def rows(separator: str = ",", head: str = "") -> str:
    return head + "".join(f"{separator.join(map(repr, row))}\n" for row in POINTS)


@pytest.mark.parametrize(
    "content",
    [
        rows(),
        rows(";"),
        rows("\t"),
        rows(" "),
        rows("   "),
        rows(" , "),
        rows(head="x,y\n"),
        rows(head='"X","Y"\n'),
        rows(head="# recorded today\n\n"),
        rows(head="# x_m,y_m\n"),
        rows(";", head="# where from: a map; by hand\n# x_m;y_m\n"),
        rows().replace("\n", "\r\n"),
        rows().replace("\n", "  # here\n"),
        "﻿" + rows(head="x,y\n"),
        rows(";").replace(".", ","),
        "t,x,y,note\n" + "".join(f"{i},{x},{y},a\n" for i, (x, y) in enumerate(POINTS)),
        "y;name;x\n" + "".join(f"{y};p{i};{x}\n" for i, (x, y) in enumerate(POINTS)),
        "".join(f"{x},{y},7,nan,left\n" for x, y in POINTS),
    ],
)
def test_whatever_separates_them_and_whatever_stands_beside_them_the_points_are_those(
    tmp_path: Any, content: Any
) -> None:
    np.testing.assert_array_equal(points(scenario(tmp_path, content)), POINTS)


numbers = st.floats(-1e7, 1e7, allow_nan=False)


@given(
    st.lists(st.tuples(numbers, numbers), min_size=2, max_size=20),
    st.sampled_from([*DELIMITERS, " ", "  "]),
    st.permutations(["x", "y", "speed", "name"]),
    st.booleans(),
)
def test_a_table_gives_back_what_was_written(table: Any, mark: Any, names: Any, comment: Any) -> None:
    by_name = [{"x": x, "y": y, "speed": 0.5, "name": f"p{i}"} for i, (x, y) in enumerate(table)]
    text = ("# " if comment else "") + mark.join(names) + "\n"
    text += "".join(mark.join(str(row[name]) for name in names) + "\n" for row in by_name)
    assert columns_of(text, "way", None) == [[x, y] for x, y in table]
    numbered = columns_of(text, "way", (names.index("x"), names.index("y")), ["speed"])
    assert numbered == [[x, y, 0.5] for x, y in table]


@pytest.mark.parametrize("columns", ['["east", "north"]', "[2, 1]", '["east", 1]'])
def test_columns_are_chosen_by_name_or_by_number(tmp_path: Any, columns: Any) -> None:
    content = "t,north,east\n" + "".join(f"{i},{y},{x}\n" for i, (x, y) in enumerate(POINTS))
    np.testing.assert_array_equal(points(scenario(tmp_path, content, f"columns = {columns}")), POINTS)


@pytest.mark.parametrize(("unit", "metres"), [("mm", 1e-3), ("cm", 1e-2), ("km", 1e3), ("ft", 0.3048)])
def test_other_units_become_metres(tmp_path: Any, unit: Any, metres: Any) -> None:
    found = points(scenario(tmp_path, rows(), f'unit = "{unit}"'))
    np.testing.assert_allclose(found, metres * np.array(POINTS), rtol=1e-15)


def test_speeds_come_from_a_column_and_are_driven(tmp_path: Any) -> None:
    content = "x,y,v\n0,0,0.0\n1,0,0.4\n2,0,0.4\n3,0,0.1\n"
    path = scenario(tmp_path, content, 'speed_column = "v"').path
    assert isinstance(path, Waypoints)
    assert path.speeds == [0.0, 0.4, 0.4, 0.1]
    t = np.linspace(0.0, 25.0, 2501)
    x = path.position(t)[:, 0]
    speed = np.gradient(x, t)
    for place, expected in ((0.25, 0.2), (1.0, 0.4), (1.5, 0.4), (2.5, (0.5 * (0.4**2 + 0.1**2)) ** 0.5), (4.0, 0.1)):
        assert np.interp(place, x, speed) == pytest.approx(expected, abs=2e-3)


def test_a_closed_path_with_speeds_repeats() -> None:
    path = Waypoints(
        kind="waypoints", points=[(0, 0), (1, 0), (1, 1), (0, 1)], closed=True, speeds=[0.1, 0.3, 0.2, 0.0]
    )
    assert path.period is not None
    t = np.linspace(-5.0, 40.0, 100)
    np.testing.assert_allclose(path.position(t + path.period), path.position(t), atol=1e-9)
    speed = np.hypot(*np.gradient(path.position(np.linspace(0, path.period, 20_001)), axis=0).T) / path.period * 20_000
    assert 0.28 < speed.max() < 0.31


def test_once_loaded_the_file_is_not_needed(tmp_path: Any) -> None:
    found = scenario(tmp_path, rows())
    (tmp_path / "way.csv").unlink()
    again = Scenario.model_validate_json(found.model_dump_json(exclude_unset=True))
    assert again == found
    np.testing.assert_array_equal(points(again), POINTS)


def test_a_file_is_sought_beside_the_scenarios(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.chdir("/")
    assert len(points(scenario(tmp_path, rows()))) == len(POINTS)


def test_what_comes_over_the_wire_reads_no_file(tmp_path: Any) -> None:
    (tmp_path / "way.csv").write_text(rows())
    table = {"kind": "waypoints", "file": str(tmp_path / "way.csv")}
    with pytest.raises(ScenarioError, match="loaded by its name") as caught:
        parse({"name": "x", "path": table, "formation": {"shape": "triangle"}})
    assert "\n" not in str(caught.value)


def test_offsets_come_from_a_file_too(tmp_path: Any) -> None:
    (tmp_path / "places.csv").write_text("robot,x,y\n1,10,0\n2,0,10\n3,-10,-10\n")
    (tmp_path / "later.csv").write_text("20 0\n0 20\n-20 -20\n")
    file = tmp_path / "own.toml"
    file.write_text(
        'name = "own"\n[path]\nkind = "line"\n[formation]\nfile = "places.csv"\nunit = "cm"\n'
        'changes = [{ at = 5, file = "later.csv", unit = "cm" }]\n'
    )
    found = load(str(file)).formation
    np.testing.assert_allclose(found.array, [[0.1, 0.0], [0.0, 0.1], [-0.1, -0.1]], atol=1e-15)
    np.testing.assert_allclose(found.changes[0].array_for(3), 2 * found.array, atol=1e-15)


@pytest.mark.parametrize(
    ("content", "keys", "words"),
    [
        ("0,0\n1,nan\n2,0\n", "", ["way.csv, line 2", "finite number", "'nan'"]),
        ("0,0\n1,0\n2,inf\n", "", ["way.csv, line 3", "'inf'"]),
        ("0,0\n1,zero\n2,null\n3,none\n", "", ["way.csv, line 2", "'zero'", "and 2 more like it"]),
        ("x,y\n\n# a\n0,0\n1\n", "", ["way.csv, line 5", "at least 2 columns; got 1"]),
        ("time,lon,lat\n0,11,48\n1,11,48\n", "", ["columns x and y", "time, lon, lat"]),
        ("a,b\n0,0\n1,1\n", 'columns = ["a", "c"]', ["way.csv", "expected one of a, b; got 'c'"]),
        ("0,0\n1,1\n", 'columns = ["x", "y"]', ["way.csv", "no header", "'x'"]),
        ("0,0\n1,1\n", "columns = [0, 2]", ["way.csv", "from 0 to 1; got 2"]),
        ("0,0\n1,1\n", "columns = [0, -1]", ["path.columns"]),
        ("0,0\n1,1\n", 'unit = "inch"', ["path.unit", "'inch'", "did you mean in"]),
        ("0,0\n1,1\n", "points = [[0, 0], [1, 1]]", ["either points or a file"]),
        ("", "", ["rows of numbers; got none"]),
        ("x,y\n", "", ["rows of numbers; got none"]),
        ("0,0\n1,1\n".encode("utf-16"), "", ["path.file", "UTF-8", "UTF-16"]),
        (b"0,0\n1,\xff\n", "", ["path.file", "UTF-8"]),
        ("0,0\n0,0\n", "", ["path", "2 points that differ; got 1"]),
        ("0,0,0.1\n1,1,-0.1\n", "speed_column = 2", ["path.speeds[1]", "at least 0; got -0.1"]),
        ("0,0,0\n1,1,0\n2,2,1\n", "speed_column = 2", ["path", "speeds[0]", "more than 0"]),
    ],
)
def test_a_mistake_names_the_file_and_the_line(tmp_path: Any, content: Any, keys: Any, words: Any) -> None:
    with pytest.raises(ScenarioError) as caught:
        scenario(tmp_path, content, keys)
    assert "\n" not in str(caught.value)
    for word in words:
        assert word in str(caught.value)


def test_a_file_that_is_not_there_or_never_ends_is_told(tmp_path: Any) -> None:
    for name, words in (("none.csv", "there is no"), ("/dev/zero", "at most 64 MiB"), (".", "cannot be read")):
        file = tmp_path / "own.toml"
        file.write_text(f'name="a"\npath={{kind="waypoints", file="{name}"}}\nformation={{shape="triangle"}}\n')
        with pytest.raises(ScenarioError, match=words):
            load(str(file))


def test_points_that_cannot_travel_are_refused_with_the_limit(tmp_path: Any) -> None:
    content = "".join(f"{1e-7 / (i + 7)!r},{-1e-7 / (i + 3)!r}\n" for i in range(99_999))
    assert len(points(scenario(tmp_path, "".join(f"{i / 7:.4f},{i / 3:.4f}\n" for i in range(99_999))))) == 99_999
    with pytest.raises(ScenarioError, match=r"own\.toml: expected at most 4 MiB"):
        scenario(tmp_path, content)
    with pytest.raises(ScenarioError, match=r"path\.points: expected at most 100000 values; got 100001"):
        scenario(tmp_path, "".join(f"{i},0\n" for i in range(100_001)))


def test_a_scenario_comes_through_a_pipe_with_or_without_a_byte_order_mark(tmp_path: Any) -> None:
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for mark in ("", "﻿"):
        text = f'{mark}name = "piped"\npath = {{kind="line"}}\nformation = {{shape="triangle"}}\n'
        writer = threading.Thread(target=pipe.write_text, args=(text,), kwargs={"encoding": "utf-8"})
        writer.start()
        assert load(str(pipe)).name == "piped"
        writer.join()


@pytest.mark.parametrize("name", ["own.TOML", "own.Toml"])
def test_a_suffix_may_be_written_in_capitals(tmp_path: Any, name: Any, monkeypatch: Any) -> None:
    (tmp_path / name).write_text('name="own"\npath={kind="line"}\nformation={shape="triangle"}\n')
    monkeypatch.chdir(tmp_path)
    assert load(name).name == "own"


ENCODINGS = ["utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "utf-32", "utf-32-le"]


@given(
    st.lists(st.tuples(st.integers(-99, 99), st.integers(-99, 99)), min_size=2, max_size=9, unique=True),
    st.sampled_from(ENCODINGS),
)
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_utf8_is_read_with_or_without_a_mark_and_other_encodings_are_named(
    tmp_path: Any, table: Any, encoding: Any
) -> None:
    content = "x,y\n" + "".join(f"{x},{y}\n" for x, y in table)
    own = f'name = "own"\npath = {{ kind = "waypoints", points = {[list(row) for row in table]} }}\n'
    (tmp_path / "names.toml").write_text(
        'name = "own"\npath = { kind = "waypoints", file = "way.csv" }\nformation = { shape = "triangle" }\n'
    )
    (tmp_path / "whole.toml").write_bytes(f'{own}formation = {{ shape = "triangle" }}\n'.encode(encoding))
    (tmp_path / "way.csv").write_bytes(content.encode(encoding))
    for name in ("whole.toml", "names.toml"):
        if encoding.startswith("utf-8"):
            np.testing.assert_array_equal(points(load(str(tmp_path / name))), table)
        else:
            with pytest.raises(ScenarioError, match=r"expected text in UTF-8; got .*UTF-(16|32)$"):
                load(str(tmp_path / name))


@given(content=st.binary(max_size=60) | st.text(max_size=60).map(str.encode))
@settings(max_examples=80, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_any_file_gives_points_or_one_line(tmp_path: Any, content: Any) -> None:
    try:
        found = scenario(tmp_path, content)
    except ScenarioError as error:
        told = str(error)
    else:
        told = ""
        assert np.isfinite(points(found)).all()
    assert len(told) < 1000
    assert "\n" not in told
