"""Laws of the scene."""

from dashboard.page import Page


def test_the_first_frame_of_a_scenario_shows_everything(page: Page) -> None:
    nodes = page._scene._nodes
    assert nodes["/bodies"].batched_colors.max(axis=1).min() > 0, "none is black"
    assert nodes["/heads"].batched_colors.max(axis=1).min() > 0
    for name in ("/trails", "/horizons", "/beliefs", "/edges", "/links", "/desired"):
        assert nodes[name].points[..., 2].min() > 0.0, f"{name} has been lifted off the ground"
