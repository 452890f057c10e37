"""Laws of figures: a function of what is drawn, whatever the user's own settings."""

from typing import Any

from experiments.report import style


def test_a_figure_is_a_function_of_what_is_drawn(tmp_path: Any) -> None:
    def drawn(name: str, height: float) -> list[bytes]:
        with style.styled():
            figure = style.figure(2.0)
            axes = figure.subplots()
            axes.plot([0.0, 1.0], [0.0, height], label="line")
            style.outside_legend(axes)
            return [file.read_bytes() for file in style.save(figure, tmp_path / name, "seed 0")]

    assert drawn("a", 1.0) == drawn("b", 1.0)
    assert drawn("a", 1.0) != drawn("b", 2.0)


def test_the_users_own_matplotlib_settings_do_not_matter_and_are_left_alone() -> None:
    import matplotlib as mpl

    with mpl.rc_context({"font.size": 31.0}):
        with style.styled():
            assert mpl.rcParams["font.size"] == 9
        assert mpl.rcParams["font.size"] == 31.0


def test_controllers_have_colours_that_differ() -> None:
    assert len(set(style.controllers().values())) == len(style.controllers())
    assert style.colour("b", ["a", "b"]) == style.PALETTE[1]
    assert style.colour("nobody") == style.GREY
