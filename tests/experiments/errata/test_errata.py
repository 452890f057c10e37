"""The page of errata: every figure is wrong as printed and right as mended; the errata from 13 on are shown here."""

import ast
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from experiments.errata import errata, evidence, evidence_text, readings
from experiments.errata.errata_list import ENTRIES
from experiments.errata.evidence import Case
from experiments.errata.ring_map import Ring, Wording
from formation.metrics import error_state
from formation.scenario.files import load
from runtime.inprocess import simulate


def test_every_erratum_has_a_number_and_a_test_that_exists() -> None:
    names = {
        node.name
        for file in Path(__file__).parents[2].rglob("test_*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.FunctionDef)
    }
    assert [entry.number for entry in ENTRIES] == list(range(1, len(ENTRIES) + 1))
    assert {f"test_{entry.test}" for entry in ENTRIES} <= names


@pytest.mark.parametrize(
    ("figures", "at_least", "at_most"),
    [
        (lambda: evidence.rate_errors(1), 0.01, 1e-6),
        (lambda: evidence.rate_errors(2), 0.01, 1e-6),
        (evidence.missing_drift, 0.005, 1e-12),
        (evidence.distance_to_equilibrium, 1e-3, 1e-9),
        (evidence.distance_to_best_response, 1e-3, 1e-9),
        (evidence_text.centres_apart, 0.04, 1e-12),
        (evidence_text.angle_in_formation, 2.0, 1e-12),
        (evidence_text.leaving_the_place, 0.004, 1e-12),
        (evidence_text.mean_heading, 3.0, 1e-12),
        (evidence_text.corner_jump, 0.09, 1e-4),
        (evidence_text.growing_triangle, 0.01, 1e-9),
    ],
)
def test_figures_of_the_page_are_large_as_printed_and_vanish_as_mended(
    figures: Any, at_least: Any, at_most: Any
) -> None:
    printed, mended = figures()
    assert printed > at_least
    assert mended <= at_most


def test_erratum_13_the_followers_place_turns_with_its_leader() -> None:
    def rms(errata_: list[int]) -> float:
        settings = ["controller.name=leader_follower", f"controller.errata={errata_}", "duration=30"]
        return float(simulate(load("circle", settings))["robots"]["2"]["distance_error_m"]["rms"])

    assert rms([]) > 0.01
    assert rms([13]) < 1e-5


def test_erratum_14_eq_11_is_no_best_response_to_the_received_plan_either() -> None:
    printed, mended = evidence.distance_to_best_response()
    assert printed > 1e-3
    assert mended < 1e-9


def test_erratum_15_the_error_state_is_not_a_state() -> None:
    assert evidence.rates_of_one_state()[0] > 0.02
    one, other = Case(7), Case(7)
    other.half = -one.half
    for case in (one, other):  # one and the same error state
        own, upstream = case.poses(case.z)
        z = error_state(own, upstream, case.reference[:3], case.distance, case.psi_r, case.pv)
        np.testing.assert_allclose(z, one.z, atol=1e-12)


def test_erratum_16_abreast_the_model_cannot_steer_every_error() -> None:
    assert evidence.controllable_directions() == (4.0, 6.0)


def test_erratum_17_the_angle_of_a_pattern_turns_with_the_frame() -> None:
    length, angle = evidence_text.turned_frame()
    assert length < 1e-12
    assert angle == pytest.approx(0.5)


def test_erratum_18_a_triangle_that_turns_has_slots_with_headings_of_their_own() -> None:
    turn, apart = evidence_text.headings_on_the_circle()
    slots = load("triangle-circle").reference().block(0)
    off = np.abs(slots.slots[0, :, 2] - slots.centre[0, 2]).max()
    assert turn == pytest.approx(off, abs=5e-3)  # the reference's theta_r is that of the last 0.1 s
    assert apart == pytest.approx(0.05 * 0.1 * np.sqrt(3.0) / 2.0)


def test_erratum_19_with_its_orientation_kept_the_triangle_stays_together() -> None:
    turned, kept = evidence_text.orientation_turned_and_kept()
    assert turned > 100.0
    assert kept < 10.0


def test_erratum_20_r_must_be_positive_definite() -> None:
    least, rank = evidence_text.singular_r()
    assert least == 0.0
    assert rank == 1.0
    with pytest.raises(np.linalg.LinAlgError):
        np.linalg.inv(np.diag([0.1, 0.0]))


def test_erratum_21_the_second_theorem_stands_without_the_inverse_of_its_proof() -> None:
    rank, asymmetry = evidence_text.singular_k()
    assert rank == 4.0
    assert asymmetry < 1e-9


def test_erratum_22_not_every_symmetric_matrix_is_a_square() -> None:
    assert evidence_text.square_of_a_real()[0] == pytest.approx(-1.0)


def test_erratum_23_the_input_that_is_applied_is_the_one_left_out() -> None:
    assert evidence_text.inputs_applied() == (20.0, 1.0)


def test_erratum_24_one_index_stands_for_two_intervals() -> None:
    assert evidence_text.horizons() == pytest.approx((0.2, 2.0))


def test_erratum_25_the_second_tests_path_is_not_differentiable() -> None:
    corner, smooth = evidence_text.corner_jump()
    assert corner == pytest.approx(0.1, abs=1e-4)
    assert smooth < 1e-4


def test_erratum_26_a_growing_triangle_moves_its_virtual_centres() -> None:
    growing, constant = evidence_text.growing_triangle()
    assert growing > 0.01
    assert constant < 1e-9


def test_erratum_27_the_mean_of_two_wrapped_headings_can_point_back() -> None:
    printed, mended = evidence_text.mean_heading()
    assert printed == pytest.approx(np.pi)
    assert mended < 1e-12


def test_the_ring_of_the_readings_is_the_product() -> None:
    """Its default wording is the scenario triangle-circle with controller `paper`, pose by pose."""
    settings = ["controller.name=paper", "duration=3"]
    ring, scenario = Ring(Wording()), load("triangle-circle", settings)
    state = ring.start()
    for k in range(scenario.ticks):
        state = ring.advance(k, state)
    product = simulate(scenario)["robots"]
    finals = [product[str(robot)]["distance_error_m"]["final"] for robot in (1, 2, 3)]
    np.testing.assert_allclose(ring.errors(state), finals, atol=2e-4)


def test_the_map_of_the_ring_does_not_depend_on_the_time() -> None:
    ring = Ring(Wording())
    state = ring.start()
    for k in (100, 5000):
        angle = 0.05 * 0.01 * k
        later = ring.turned(ring.advance(k, ring.turned(state, angle)), -angle)
        np.testing.assert_allclose(later, ring.advance(0, state), atol=1e-9)


def test_only_what_affects_a_controller_is_simulated() -> None:
    trials = errata.trials()
    names = [trial.name for trial in trials]
    assert len(set(names)) == len(names)
    rms_mm = {name: float(place) for place, name in enumerate(names)}
    table = errata.errata_table(rms_mm)
    assert [row.number for row in table] == [entry.number for entry in ENTRIES]
    for row, entry in zip(table, ENTRIES, strict=True):
        assert set(row.effect_mm or {}) == set(entry.cases)
        assert row.effect_mm is not None or row.note, "what affects no controller says why"
        assert "{" not in row.evidence
    assert {value for row in table for pair in (row.effect_mm or {}).values() for value in pair} == set(rms_mm.values())


def test_an_erratum_is_what_its_two_trials_differ_in() -> None:
    mended = {trial.name: trial.load().controller.model_dump()["errata"] for trial in errata.trials()}
    assert mended["errata/circle/as printed"] == ()
    assert mended["errata/circle/{'controller': {'errata': [4]}}"] == (4,)


@pytest.mark.parametrize("name", ["orientation kept, mended", "errata 1 to 5"])
def test_of_the_third_tests_readings_only_those_that_keep_the_orientation_stay_together(name: Any) -> None:
    trial = next(trial for trial in readings.quick() if trial.title == name)
    reading = readings.reading_of(trial, trial.run())
    assert reading.bounded == name.startswith("orientation kept")
    assert len(reading.rms_mm) == 12
    assert reading.spectral_radius == pytest.approx(1.02, abs=0.03)  # nearly neutral: neither pulled together nor apart
