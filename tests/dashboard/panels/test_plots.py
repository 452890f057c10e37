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
