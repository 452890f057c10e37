"""Figures as tables print them: one that there is none of, because nothing was measured, is a dash."""

import math


def figure(value: object, factor: float = 1.0, form: str = ".4g") -> str:
    """A number times a factor, in this format; "-" for None and for what is not finite."""
    return format(value * factor, form) if isinstance(value, int | float) and math.isfinite(value) else "-"
