"""Scenario files: the shipped ones run, and every mistake gets one line that names the key and what there is."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from formation.errors import ScenarioError
from formation.scenario.files import load, parse, read, shipped
from formation.scenario.scenario import Scenario

NAMES = [
    "circle",
    "drive-me",
    "figure8",
    "follow-the-leader",
    "hexagon-sinusoid",
    "ring-16",
    "sinusoid",
    "spiral",
    "square-figure8",
    "triangle-circle",
    "triangle-corner",
]
SMALL: dict[str, Any] = {"name": "small", "path": {"kind": "circle"}, "formation": {"shape": "triangle"}}


def lines(raw: dict[str, Any], *settings_: str) -> list[str]:
    """What a wrong scenario is told."""
    with pytest.raises(ScenarioError) as caught:
        parse(raw, settings_, where="small")
    return str(caught.value).split("\n")


def test_the_shipped_scenarios_are_those_of_issue_2() -> None:
    assert shipped() == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_a_shipped_scenario_loads_and_has_its_files_name(name: Any) -> None:
    scenario = load(name)
    assert scenario.name == name
    assert scenario.source
    assert scenario.ticks == round(scenario.duration / 0.01) > 0
    assert (scenario.controller.horizon, scenario.stride) == (20, 10)
    assert scenario.controller.name == "nash"
    assert scenario.start_poses().shape == (scenario.size, 3)


def test_the_shipped_scenarios_hold_what_their_names_say() -> None:
    expected = {
        "circle": ("circle", 2),
        "figure8": ("figure8", 2),
        "hexagon-sinusoid": ("sinusoid", 6),
        "ring-16": ("circle", 16),
        "sinusoid": ("sinusoid", 2),
        "spiral": ("spiral", 2),
        "square-figure8": ("figure8", 4),
        "triangle-circle": ("circle", 3),
        "triangle-corner": ("corner", 3),
    }
    for name, (kind, size) in expected.items():
        assert (load(name).path.kind, load(name).size) == (kind, size)
    noise = load("ring-16").robots.start_noise
    assert (noise.position, noise.heading) == (0.02, 0.1)


@pytest.mark.parametrize(
    ("name", "poses"),
    [
        ("figure8", [[-0.05, -0.055, math.pi / 10], [-0.05, 0.055, math.pi / 10]]),
        ("triangle-corner", [[0, 0.05, math.pi / 2], [-0.05, -0.05, math.pi / 2], [0.05, -0.05, math.pi / 2]]),
        ("triangle-circle", [[0.8, 0.065, 1.5], [0.75, -0.05, 1.5], [0.85, -0.05, 1.5]]),
    ],
)
def test_the_start_poses_are_those_that_the_paper_gives(name: Any, poses: Any) -> None:
    np.testing.assert_allclose(load(name).start_poses(), poses, atol=1e-15)


@pytest.mark.parametrize("name", ["circle", "sinusoid", "spiral", "square-figure8", "hexagon-sinusoid"])
def test_where_the_paper_gives_no_poses_the_robots_start_in_formation(name: Any) -> None:
    scenario = load(name)
    np.testing.assert_array_equal(scenario.start_poses(), scenario.reference().block(0).slots[0])


def test_the_numbering_of_the_papers_triangles_is_that_of_the_formation() -> None:
    # Robot 1 in front, 2 left, 3 right, as the paper's start poses have it.
    offsets = load("triangle-corner").formation.array
    assert offsets[0, 0] > 0
    assert offsets[1, 1] > 0 > offsets[2, 1]


# ---------------------------------------------------------------- start noise


def test_start_noise_depends_on_the_seed_and_on_nothing_else() -> None:
    noisy = ["robots.start_noise.position=0.02", "robots.start_noise.heading=0.1"]

    def noise(name: str, *settings_: str) -> np.ndarray:
        return load(name, [*noisy, *settings_]).start_poses() - load(name).start_poses()

    once = noise("triangle-circle")
    assert np.abs(once).min() > 0
    np.testing.assert_array_equal(noise("triangle-circle"), once)
    np.testing.assert_allclose(noise("triangle-corner"), once, atol=1e-15)
    np.testing.assert_array_equal(noise("triangle-circle", "controller.name=paper", "noise.slip=0.2"), once)
    assert np.abs(noise("triangle-circle", "seed=1") - once).min() > 0


def test_start_noise_has_the_standard_deviations_asked_for() -> None:
    raw = {
        **SMALL,
        "formation": {"shape": "line", "robots": 64},
        "robots": {"poses": [[0, 0, 0]] * 64, "start_noise": {"position": 0.02, "heading": 0.1}},
    }
    draws = np.concatenate([parse(raw, [f"seed={seed}"]).start_poses() for seed in range(100)])
    np.testing.assert_allclose(draws.std(axis=0), [0.02, 0.02, 0.1], rtol=0.04)  # 6400 draws: 0.9 % spread
    np.testing.assert_allclose(draws.mean(axis=0) / [0.02, 0.02, 0.1], 0.0, atol=0.1)


# ---------------------------------------------------------------- --set


@pytest.mark.parametrize(
    ("setting", "value"),
    [
        ("link.latency=0.5", lambda s: s.link.latency == 0.5),
        ("link.latency=500ms", lambda s: s.link.latency == 0.5),
        ('link.latency="500ms"', lambda s: s.link.latency == 0.5),
        ("link.loss=30%", lambda s: s.link.loss == pytest.approx(0.3)),
        ("noise.slip=0.2", lambda s: s.noise.slip == 0.2),
        ("robots.start_noise.position=0.02", lambda s: s.robots.start_noise.position == 0.02),
        ("robots.limits.v=1", lambda s: s.robots.limits.v == 1.0),
        ("duration=2min", lambda s: s.duration == 120.0),
        ("seed=7", lambda s: s.seed == 7),
        (" seed = 7", lambda s: s.seed == 7),
        ("path.radius=1.5", lambda s: s.path.radius == 1.5),
        ("controller.name=paper", lambda s: s.controller.name == "paper"),
        ("controller={name='paper', errata=[1, 2]}", lambda s: getattr(s.controller, "errata", ()) == (1, 2)),
        (
            "controller={game='pair', q=[1, 2, 3, 4, 5, 6]}",
            lambda s: getattr(s.controller, "q", ()) == [1, 2, 3, 4, 5, 6],
        ),
        ("controller.age_plans=false", lambda s: s.controller.age_plans is False),
        ("link.keep_order=true", lambda s: s.link.keep_order is True),
        ("name=other", lambda s: s.name == "other"),
        ("formation={shape='line', robots=3}", lambda s: s.formation.shape == "line"),
        ('faults=[{at=1, link="2->3", loss=0.5}]', lambda s: [f.changes() for f in s.faults] == [{"loss": 0.5}]),
        ("source=a=b", lambda s: s.source == "a=b"),
    ],
)
def test_a_setting_reaches_any_key_by_its_path(setting: Any, value: Any) -> None:
    assert not value(load("triangle-circle"))
    assert value(load("triangle-circle", [setting]))


def test_later_settings_win_and_the_raw_table_is_left_alone() -> None:
    raw = read("triangle-circle")
    before = repr(raw)
    assert parse(raw, ["seed=1", "seed=2", "path.radius=2"]).seed == 2
    assert repr(raw) == before


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ("seed", ["expected key=value", "'seed'"]),
        ("=3", ["expected key=value"]),
        ("seed.value=3", ["seed: expected a whole number"]),
        ("duration.value=3", ["duration", "expected a number"]),
        ("name.first.second=3", ["name", "expected text"]),
        ("sed=3", ["sed: unknown key", "did you mean seed?"]),
        ("link.latensy=1", ["link.latensy: unknown key", "did you mean latency?"]),
        ("path.radius=big", ["path.radius", "'big'"]),
    ],
)
def test_a_wrong_setting_is_told_in_a_line(setting: Any, words: Any) -> None:
    text = "\n".join(lines(read("triangle-circle"), setting))
    assert "\n" not in text
    for word in words:
        assert word in text


# ---------------------------------------------------------------- mistakes

MISTAKES: dict[str, tuple[dict[str, Any], list[str]]] = {
    "unknown key at the top": ({"pth": {}}, ["pth: unknown key", "path"]),
    "no name": ({"name": None}, ["name"]),
    "a name that is no file name": ({"name": "../x"}, ["name"]),
    "unknown kind of path": ({"path": {"kind": "circel"}}, ["path.kind", "figure8, circle", "did you mean circle?"]),
    "no kind of path": ({"path": {"radius": 1.0}}, ["path", "kind"]),
    "unknown key in a path": ({"path": {"kind": "circle", "radus": 1}}, ["path.radus", "did you mean radius?"]),
    "a radius of zero": ({"path": {"kind": "circle", "radius": 0}}, ["path.radius: expected more than 0; got 0"]),
    "a radius that is text": ({"path": {"kind": "circle", "radius": "wide"}}, ["path.radius", "number", "'wide'"]),
    "an endless radius": ({"path": {"kind": "circle", "radius": math.inf}}, ["path.radius", "finite"]),
    "a path that is text": ({"path": "circle"}, ["path"]),
    "too few waypoints": ({"path": {"kind": "waypoints", "points": [[0, 0]]}}, ["path.points"]),
    "a waypoint of three": ({"path": {"kind": "waypoints", "points": [[0, 0, 0], [1, 1]]}}, ["path.points[0]"]),
    "unknown shape": ({"formation": {"shape": "ring"}}, ["formation.shape", "polygon", "'ring'"]),
    "shape and offsets": ({"formation": {"shape": "line", "offsets": [[0, 0], [0, 1]]}}, ["formation", "either"]),
    "neither shape nor offsets": ({"formation": {}}, ["formation", "shape or offsets"]),
    "a line of nobody knows": ({"formation": {"shape": "line"}}, ["formation", "robots = n", "line"]),
    "a triangle of four": ({"formation": {"shape": "triangle", "robots": 4}}, ["formation", "3 robots", "got 4"]),
    "a lonely robot": ({"formation": {"shape": "line", "robots": 1}}, ["formation.robots: expected at least 2; got 1"]),
    "too many robots": ({"formation": {"shape": "line", "robots": 1025}}, ["formation.robots: expected at most 1024"]),
    "half a robot": ({"formation": {"shape": "line", "robots": 2.5}}, ["formation.robots", "2.5"]),
    "robots in one place": ({"formation": {"offsets": [[0, 0], [0, 0], [1, 1]]}}, ["formation", "differ"]),
    "offsets and another number": ({"formation": {"offsets": [[0, 0], [0, 1]], "robots": 3}}, ["formation", "2 and 3"]),
    "no spacing": ({"formation": {"shape": "triangle", "spacing": 0}}, ["formation.spacing: expected more than 0"]),
    "too few poses": ({"robots": {"poses": [[0, 0, 0]]}}, ["robots.poses: expected 3 poses", "got 1"]),
    "a pose of two": ({"robots": {"poses": [[0, 0], [0, 0, 0], [1, 1, 1]]}}, ["robots.poses[0]"]),
    "no speed": ({"robots": {"limits": {"v": 0}}}, ["robots.limits.v: expected more than 0"]),
    "negative noise": ({"noise": {"slip": -0.1}}, ["noise.slip: expected at least 0; got -0.1"]),
    "noise that is no number": ({"noise": {"slip": math.nan}}, ["noise.slip", "finite"]),
    "unknown controller": ({"controller": {"name": "nsh"}}, ["controller.name", "leader_follower", "mean nash?"]),
    "weights of another controller": ({"controller": {"q": [1, 2, 3, 4, 5]}}, ["controller", "6 values in q", "got 5"]),
    "weights for paper": ({"controller": {"name": "paper", "q": [1] * 6}}, ["controller", "5 values in q", "got 6"]),
    "a key of another controller": (
        {"controller": {"gains": [1, 1]}},
        ["controller.gains: unknown key", "horizon", "formation", "it is a key of leader_follower"],
    ),
    "a key of another path": ({"path": {"kind": "line", "radius": 1}}, ["path.radius", "it is a key of circle"]),
    "a key of no controller": ({"controller": {"formatoin": 1}}, ["controller.formatoin", "mean formation?"]),
    "a weight of zero in r": ({"controller": {"r": [0.1, 0]}}, ["controller.r[1]: expected more than 0"]),
    "an erratum that does not exist": (
        {"controller": {"name": "paper", "errata": [12]}},
        ["controller.errata[0]", "12", "5"],
    ),
    "no horizon": ({"controller": {"horizon": 1}}, ["controller.horizon: expected at least 2; got 1"]),
    "an odd interval": ({"controller": {"prediction_interval": 0.015}}, ["prediction_interval", "whole number"]),
    "an interval below a tick": ({"controller": {"prediction_interval": 0.001}}, ["prediction_interval", "whole"]),
    "no time": ({"duration": 0}, ["duration: expected more than 0"]),
    "a duration in words": ({"duration": "long"}, ["duration", "300ms", "'long'"]),
    "a negative seed": ({"seed": -1}, ["seed: expected at least 0; got -1"]),
    "a seed too large": ({"seed": 2**63}, ["seed: expected less than"]),
    "loss of more than all": ({"link": {"loss": 1.5}}, ["link.loss: expected at most 1; got 1.5"]),
    "loss in words": ({"link": {"loss": "much"}}, ["link.loss", "30%", "'much'"]),
    "unknown jitter": ({"link": {"distribution": "gauss"}}, ["link.distribution", "uniform, normal, pareto", "gauss"]),
    "a fault that ends before it begins": ({"faults": [{"at": 5, "until": 5}]}, ["faults[0]", "until > at"]),
    "a fault on no link": ({"faults": [{}, {"link": "1->3"}]}, ["faults[1].link", "1->2, 2->3, 3->1", "'1->3'"]),
    "unknown preset": ({"faults": [{"preset": "wify"}]}, ["faults[0]", "wifi", "did you mean wifi?"]),
    "unknown key in a fault": ({"faults": [{"los": 0.1}]}, ["faults[0].los: unknown key", "did you mean loss?"]),
    "a fault that is no table": ({"faults": {"loss": 0.1}}, ["faults"]),
}


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_told_in_one_line_with_its_key_and_the_choices(mistake: Any) -> None:
    change, words = MISTAKES[mistake]
    raw = {key: value for key, value in {**SMALL, **change}.items() if value is not None}
    told = lines(raw)
    assert len(told) == 1
    assert told[0].startswith("small: ")
    for word in words:
        assert word in told[0], told[0]


def test_every_mistake_gets_a_line_of_its_own() -> None:
    told = lines({**SMALL, "seed": -1, "nam": 1, "noise": {"slip": -1, "giro": 2}, "link": {"loss": 2}})
    assert len(told) == 5
    for key in ("seed", "nam", "noise.slip", "noise.giro", "link.loss"):
        assert sum(f"small: {key}:" in line for line in told) == 1


def test_an_empty_file_is_told_what_it_lacks() -> None:
    told = lines({})
    assert [line.split(":")[1].strip() for line in told] == ["name", "path", "formation"]


ANYTHING = (
    st.none()
    | st.integers()
    | st.text(max_size=5)
    | st.lists(st.floats(), max_size=2)
    | st.dictionaries(st.text(max_size=5), st.booleans(), max_size=2)
)


@given(st.dictionaries(st.sampled_from(list(Scenario.model_fields)), ANYTHING, max_size=4))
@settings(max_examples=60)
def test_any_table_is_a_scenario_or_a_scenario_error(raw: Any) -> None:
    try:
        scenario = parse({**SMALL, **raw})
    except ScenarioError as error:
        told = str(error).split("\n")
        assert all(line.startswith("scenario: ") for line in told)
    else:
        assert isinstance(scenario, Scenario)


# ---------------------------------------------------------------- files


def test_an_unknown_name_lists_the_scenarios_and_the_nearest() -> None:
    with pytest.raises(ScenarioError, match=r"figure8.*spiral.*did you mean circle\?") as caught:
        load("cirle")
    assert "\n" not in str(caught.value)


def test_a_file_is_found_by_its_path(tmp_path: Any) -> None:
    file = tmp_path / "own.toml"
    file.write_text('name = "own"\n[path]\nkind = "line"\n[formation]\nshape = "wedge"\nrobots = 5\n', encoding="utf-8")
    assert load(str(file)).size == 5


@pytest.mark.parametrize("content", [b"name = ", b"\xff\xfe", b"[path\n"])
def test_a_file_that_is_not_toml_is_told_in_a_line(tmp_path: Any, content: Any) -> None:
    file = tmp_path / "own.toml"
    file.write_bytes(content)
    with pytest.raises(ScenarioError, match=r"own\.toml") as caught:
        load(str(file))
    assert "\n" not in str(caught.value)


def test_a_folder_or_a_missing_file_is_told_in_a_line(tmp_path: Any) -> None:
    for name in (str(tmp_path) + "/", str(tmp_path / "none.toml")):
        with pytest.raises(ScenarioError) as caught:
            load(name)
        assert "\n" not in str(caught.value)


def test_a_scenario_comes_back_from_the_json_that_the_world_sends() -> None:
    for name in NAMES:
        scenario = load(name, ["link.loss=0.1", 'faults=[{at=1, link="all", preset="wifi", loss=0.2}]'])
        again = Scenario.model_validate_json(scenario.model_dump_json(exclude_unset=True))
        assert again.model_dump() == scenario.model_dump()
        # which keys a fault names is part of it: unset keys must not come back as set ones
        assert again.faults[0].changes() == scenario.faults[0].changes()


def test_a_scenario_is_frozen() -> None:
    with pytest.raises(ValueError, match="frozen"):
        load("circle").seed = 3  # type: ignore[misc]
    assert not load("circle").formation.array.flags.writeable


@pytest.mark.parametrize(
    "changes", [{}, {"bodies": "camera"}, {"noise": {"slip": 0.2, "position": 0.001}}, {"controller": {"game": "pair"}}]
)
def test_a_scenario_with_every_key_written_out_is_the_same_scenario(changes: Any) -> None:
    short = load("triangle-circle", changes)
    whole = Scenario.model_validate_json(short.model_dump_json())
    assert whole.body == short.body
    assert whole.nominal == short.nominal
    assert whole.controller == short.controller
