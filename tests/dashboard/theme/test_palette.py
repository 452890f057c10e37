"""Laws of the palettes."""

from dashboard.theme.palette import DARK, LIGHT


def test_both_themes_have_a_colour_for_everything() -> None:
    assert set(DARK.named()) == set(LIGHT.named())
    assert len(set(DARK.identity)) == len(set(LIGHT.identity)) == len(DARK.identity) == len(LIGHT.identity)
