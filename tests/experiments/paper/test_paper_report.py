"""Laws of `echelon paper`: what the report holds, and that it is a function of the seed alone."""

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cli.main import main
from experiments.paper import noisy, paper
from experiments.paper.chapters import Extent
from experiments.report.report import Report
from experiments.trials.trial import WorkerPool, simulate_all
from formation.errors import EchelonError

EXTENT = Extent(seeds=1, limit=1.5)
FIGURES = range(3, 12)
"""Of the paper's section 4."""


def written(folder: Path) -> Report:
    return paper.write(paper.folder(str(folder)), EXTENT, lambda *_: None, workers=1)


def contents(folder: Path) -> dict[str, bytes]:
    return {str(f.relative_to(folder)): f.read_bytes() for f in sorted(folder.rglob("*")) if f.is_file()}


@pytest.fixture(scope="module")
def made(tmp_path_factory: Any) -> tuple[Path, Report]:
    folder = tmp_path_factory.mktemp("paper") / "report"
    return folder, written(folder)


def test_the_same_seed_gives_the_same_bytes_in_every_file(made: Any, tmp_path: Any) -> None:
    folder, _ = made
    written(tmp_path / "again")
    first, second = contents(folder), contents(tmp_path / "again")
    assert first.keys() == second.keys()
    assert not [name for name in first if first[name] != second[name]]


def test_the_number_of_workers_changes_nothing() -> None:
    orders = [order for chapter in paper.CHAPTERS for order in chapter.orders(EXTENT)][:3]
    with WorkerPool(1) as alone, WorkerPool(2) as several:
        first, second = simulate_all(orders, alone), simulate_all(orders, several)
    assert list(first) == list(second) == [order.key for order in orders]
    assert all(np.array_equal(first[key].poses, second[key].poses) for key in first)


def test_another_seed_gives_other_noise() -> None:
    with WorkerPool(1) as crew:
        flights = [
            simulate_all(noisy.CHAPTER.orders(Extent(seed=seed, seeds=1, limit=0.5))[:1], crew) for seed in (0, 5)
        ]
    (first,), (second,) = (list(flown.values()) for flown in flights)
    assert not np.array_equal(first.poses, second.poses)


def test_every_figure_of_section_4_is_there_as_png_and_svg(made: Any) -> None:
    folder, report = made
    stems = [picture.stem for picture in report.pictures()]
    for number in FIGURES:
        (stem,) = [stem for stem in stems if stem.startswith(f"fig{number:02d}-")]
        assert (folder / "figures" / f"{stem}.png").read_bytes().startswith(b"\x89PNG")
        assert b"<svg" in (folder / "figures" / f"{stem}.svg").read_bytes()


def test_every_picture_and_table_is_in_both_forms_of_the_report(made: Any) -> None:
    folder, report = made
    page, text = (folder / "report.html").read_text("utf-8"), (folder / "report.md").read_text("utf-8")
    assert page.count("<img ") == len(report.pictures()) == text.count("![")
    for table in report.tables():
        assert table.html() in page
        assert table.markdown() in text
        assert (folder / "tables" / f"{table.name}.csv").read_text("utf-8") == table.csv()
    for section, verdict in report.verdicts():
        assert f'id="{section.anchor}"' in page
        assert verdict.found in text


def test_the_page_needs_nothing_beside_itself(made: Any) -> None:
    folder, _ = made
    page = (folder / "report.html").read_text("utf-8")
    places = re.findall(r'(?:src|href)="([^"]*)"', page)
    assert places
    assert all(place.startswith(("#", "data:image/svg+xml;base64,")) for place in places)
    assert "<script" not in page
    assert not re.search(r"url\(|@import|https?:", re.sub(r"base64,[^\"]*", "", page))


def test_every_link_leads_to_a_place_on_the_page(made: Any) -> None:
    folder, _ = made
    page = (folder / "report.html").read_text("utf-8")
    anchors = re.findall(r'<section id="([^"]+)"', page)
    assert len(set(anchors)) == len(anchors)
    assert set(re.findall(r'href="#([^"]+)"', page)) <= set(anchors)


def test_flights_that_are_cut_judge_no_claim(made: Any) -> None:
    _, report = made
    verdicts = report.verdicts()
    assert len(verdicts) > 10
    assert {verdict.outcome for _, verdict in verdicts} == {"not judged"}


def test_figures_say_seed_and_version_and_no_date(made: Any) -> None:
    folder, _ = made
    assert EXTENT.note.startswith("seed 0")
    for file in (folder / "figures").glob("*.svg"):
        assert b"<dc:date>" not in file.read_bytes(), file


def test_no_table_holds_a_time_that_was_measured_by_a_clock(made: Any) -> None:
    _, report = made
    heads = {head for table in report.tables() for head in table.heads}
    assert not [head for head in heads if "solve" in head or "wall" in head]


def test_each_order_has_a_key_of_its_own_and_can_be_flown() -> None:
    orders = [order for chapter in paper.CHAPTERS for order in chapter.orders(Extent())]
    assert len({order.key for order in orders}) == len(orders)
    assert all(order.load().seed == 0 for order in orders if not order.key.startswith(("noisy/", "switching/")))


def test_json_is_one_object_with_every_table(made: Any, tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    _, report = made
    asked: list[Extent] = []

    def write(_out: Path, extent: Extent, *_: Any) -> Report:
        asked.append(extent)
        return report  # type: ignore[no-any-return]

    monkeypatch.setattr(paper, "write", write)
    words = ["paper", "--out", str(tmp_path / "x"), "--duration", "1500ms", "--seed", "7", "--seeds", "2", "--json"]
    assert main(words) == 0
    found = json.loads(capsys.readouterr().out)
    assert asked == [Extent(seed=7, seeds=2, limit=1.5)]
    assert set(found["tables"]) == {table.name for table in report.tables()}
    assert [v["found"] for v in found["verdicts"]] == [v.found for _, v in report.verdicts()]


def test_a_report_needs_a_folder_that_can_be_made(tmp_path: Any, capsys: Any) -> None:
    assert main(["paper", "--out", str(tmp_path / "no" / "where")]) == 2
    assert "--out: expected a folder, or a new one in a folder that exists" in capsys.readouterr().err
    file = tmp_path / "file"
    file.write_text("x", encoding="utf-8")
    with pytest.raises(EchelonError, match="--out: expected a folder that can be written to"):
        paper.folder(str(file))


def test_a_folder_that_must_not_be_written_to_is_refused(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setattr("os.access", lambda *_: False)  # the user of these tests may be allowed everything
    with pytest.raises(EchelonError, match="permission denied"):
        paper.folder(str(tmp_path / "locked"))


@pytest.mark.parametrize("words", [["--seed", "-1"], ["--seeds", "0"], ["--duration", "soon"], ["--workers", "x"]])
def test_a_wrong_option_is_one_line_and_exit_code_2(words: Any, capsys: Any) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["paper", *words])
    assert ended.value.code == 2
    assert len(capsys.readouterr().err.strip().splitlines()) == 1
