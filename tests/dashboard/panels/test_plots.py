"""Laws of the plots."""

import numpy as np
import pytest

from dashboard.panels import plots
from dashboard.telemetry.ghost_track import FAR_BEHIND


def test_the_ghosts_curve_is_held_while_its_message_may_be_on_its_way_and_no_longer() -> None:
    stamps = np.arange(0.0, 6.0, 0.1)
    values = np.where((stamps > 2.0) & (stamps < 4.0), 7.0, np.nan)
    drawn = plots._held(stamps, values)
    known = stamps[np.isfinite(drawn)]
    assert set(drawn[np.isfinite(drawn)]) == {7.0}
    assert known[0] == pytest.approx(2.1 - FAR_BEHIND, abs=0.11)
    assert known[-1] == pytest.approx(3.9 + FAR_BEHIND, abs=0.11)
    assert np.isnan(plots._held(stamps, np.full_like(stamps, np.nan))).all()


def test_a_span_is_shaded_from_its_first_to_its_last_moment_and_one_outside_the_window_is_not() -> None:
    stamps = np.arange(10.0, 20.0, 0.5)
    shade = plots._during(stamps, [(12.0, 13.0), (0.0, 5.0), (19.0, 40.0)], 1.0, 0.0)
    assert stamps[shade > 0.0].tolist() == [12.0, 12.5, 13.0, 19.0, 19.5]
