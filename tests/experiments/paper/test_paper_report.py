"""Laws of `echelon paper`: what the report holds, and that it is a function of the seed alone."""

import json
import re
import signal
from pathlib import Path
from typing import Any

import pytest

from cli.main import main
from experiments.paper import noisy, paper
from experiments.paper.chapters import Extent
from experiments.report.html import inline
from experiments.report.report import Report
from experiments.trials.batch import Place, run_batch
from experiments.trials.journal import NAME
from experiments.trials.trial import Trial
from formation.errors import EchelonError
from tests.experiments.killing import dask_cluster, kill_after, start

EXTENT = Extent(seeds=1, limit=1.5)
FIGURES = range(3, 12)
"""Of the paper's section 4."""


def nothing(*_: Any) -> None:
    """No progress."""


def written(folder: Path) -> Report:
    return paper.write(EXTENT, Place(paper.folder(str(folder)), 1), tell=nothing, trials=nothing, figures=nothing)


def contents(folder: Path) -> dict[str, bytes]:
    """Everything of the report; the journal's lines stand in the order in which trials ended."""
    files = (f for f in sorted(folder.rglob("*")) if f.is_file() and f.name != NAME)
    return {str(f.relative_to(folder)): f.read_bytes() for f in files}


def assert_same(one: Path, other: Path) -> None:
    first, second = contents(one), contents(other)
    assert first.keys() == second.keys()
    assert not [name for name in first if first[name] != second[name]]


def trials_of(extent: Extent) -> list[Trial]:
    return [trial for chapter in paper.CHAPTERS for trial in chapter.trials(extent)]


@pytest.fixture(scope="module")
def made(tmp_path_factory: Any) -> tuple[Path, Report]:
    folder = tmp_path_factory.mktemp("paper") / "report"
    return folder, written(folder)


def test_a_finished_report_is_written_again_without_a_simulation(made: Any, tmp_path: Any) -> None:
    folder, _ = made
    paper.folder(str(tmp_path / "again"))
    (tmp_path / "again" / NAME).write_bytes((folder / NAME).read_bytes())
    fresh: list[bool] = []
    place = Place(tmp_path / "again", 1)
    paper.write(EXTENT, place, tell=nothing, trials=lambda *told: fresh.append(told[-1]), figures=nothing)
    assert fresh
    assert not any(fresh)
    assert_same(folder, tmp_path / "again")


ARGUMENTS = ["paper", "--seeds", "1", "--duration", "1500ms", "--json"]


@pytest.mark.processes
def test_two_workers_killed_and_started_again_give_the_bytes_of_one_in_every_file(made: Any, tmp_path: Any) -> None:
    arguments = [*ARGUMENTS, "--out", str(tmp_path), "--workers", "2"]
    kill_after(arguments, tmp_path, 2, signal.SIGKILL)
    assert (tmp_path / NAME).read_bytes().count(b"\n") < len(trials_of(EXTENT))
    second = start(arguments)
    out, err = second.communicate(timeout=200)
    assert second.returncode == 0, err
    assert f" of {len(trials_of(EXTENT))} trials are in " in err
    assert json.loads(out)["verdicts"]
    assert_same(tmp_path, made[0])


@pytest.mark.processes
def test_a_dask_cluster_of_real_processes_gives_the_same_results(tmp_path: Any) -> None:
    trials = [trial for chapter in paper.CHAPTERS for trial in chapter.trials(Extent(seeds=1, limit=0.5))[:1]]
    with dask_cluster(tmp_path) as address:
        far = run_batch(trials, Place(tmp_path, None, address), tell=nothing, progress=nothing)
    (tmp_path / "here").mkdir()
    assert run_batch(trials, Place(tmp_path / "here", 1), tell=nothing, progress=nothing) == far


def test_another_seed_gives_other_noise(tmp_path: Any) -> None:
    trials = [noisy.CHAPTER.trials(Extent(seed=seed, seeds=1, limit=0.5))[0] for seed in (0, 5)]
    first, second = run_batch(trials, Place(tmp_path, 1), tell=nothing, progress=nothing)
    assert first["trajectory_sha256"] != second["trajectory_sha256"]


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
        assert f"<caption>{inline(table.caption)}</caption>" in page
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


def test_trials_that_are_cut_judge_no_claim(made: Any) -> None:
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


def test_each_trial_has_a_name_of_its_own_and_the_first_seed() -> None:
    trials = trials_of(Extent())
    assert len({trial.name for trial in trials}) == len(trials)
    one_each = ("noisy/", "switching/", "talking/")
    assert all(trial.load().seed == 0 for trial in trials if not trial.name.startswith(one_each))


def test_json_is_one_object_with_every_table(made: Any, tmp_path: Any, monkeypatch: Any, capsys: Any) -> None:
    _, report = made
    asked: list[Extent] = []

    def write(extent: Extent, *_: Any, **__: Any) -> Report:
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
