"""The [metrics] table of a scenario."""

from formation.schema import Model, Positive

SIGMAS, SHARE = 3.0, 0.02
"""An excursion is more than so many standard deviations of localisation, and more than this share of the spacing."""


class Metrics(Model):
    """What measures of an episode compare with."""

    excursion: Positive | None = None
    """A robot's error above this is an excursion [m]; if absent the larger of three standard deviations of its
    localisation and 2 % of the spacing."""

    def limit(self, sigma: float, spacing: float) -> float:
        """The limit [m] where localisation has the standard deviation sigma [m]."""
        return max(SIGMAS * sigma, SHARE * spacing) if self.excursion is None else self.excursion
