"""Laws of controls that mirror the world: the world's value is shown, and a user's is not overwritten at once."""

from types import SimpleNamespace
from typing import Any

import pytest

from dashboard.panels import mirrored_controls
from dashboard.panels.mirrored_controls import HOLD_SECONDS, MirroredControl, set_options


class Control:
    """Stamps every value as viser does; its event loop waits for nothing."""

    def __init__(self) -> None:
        self.now = 100.0
        self.update_timestamp = self.now
        self._value = 0.0
        self._impl = at_once()

    @property
    def value(self) -> float:
        return self._value

    @value.setter
    def value(self, value: float) -> None:
        self._value, self.update_timestamp = value, self.now


def at_once() -> Any:
    """What leads to an event loop that calls at once."""
    loop = SimpleNamespace(call_soon_threadsafe=lambda write, *args: write(*args))
    return SimpleNamespace(gui_api=SimpleNamespace(_event_loop=loop))


@pytest.fixture
def control(monkeypatch: pytest.MonkeyPatch) -> Control:
    made = Control()
    monkeypatch.setattr(mirrored_controls, "time", lambda: made.now)
    return made


def test_the_worlds_value_is_shown(control: Control) -> None:
    mirrored = MirroredControl(control)
    for value in (1.0, 2.0):
        mirrored.show(value)
        assert control.value == value


def test_a_users_value_is_kept_until_the_world_has_had_time_to_take_it_over(control: Control) -> None:
    mirrored = MirroredControl(control)
    control.now += 1.0
    control.value = 5.0  # by a user
    control.now += 0.9 * HOLD_SECONDS
    mirrored.show(0.0)
    assert control.value == 5.0
    control.now += 0.2 * HOLD_SECONDS
    mirrored.show(0.0)
    assert control.value == 0.0


def test_a_released_control_shows_the_worlds_value_at_once(control: Control) -> None:
    mirrored = MirroredControl(control)
    control.now += 1.0
    control.value = 5.0
    mirrored.release()
    mirrored.show(0.0)
    assert control.value == 0.0


def test_a_value_that_is_not_offered_becomes_the_first_option() -> None:
    dropdown = SimpleNamespace(options=("a", "b"), value="anything", _impl=at_once())
    set_options(dropdown, ("a", "b"))
    assert dropdown.value == "a"
    dropdown.value = "b"
    set_options(dropdown, ("a", "b", "c"))
    assert (dropdown.options, dropdown.value) == (("a", "b", "c"), "b")
