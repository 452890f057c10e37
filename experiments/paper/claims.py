"""What the paper claims of its plots, and whether it holds: pure functions of trials.

The paper prints no numbers, so its words are given one meaning here, the same for all tests.
"""

from collections.abc import Mapping
from typing import Literal

import numpy as np

from experiments.metrics import recovery, spread
from experiments.report.report import Verdict, grade
from experiments.report.table import shown
from experiments.trials.result import Signals
from formation.arrays import FloatArray
from formation.metrics import rms

MUCH = 5.0
"""Errors are "very small compared with" others, or "much smaller", if they are at most a fifth of them."""
OPTIMAL = 1.5
"""An objective is "optimally achieved" within 1.5 times the error of the best controller that was simulated."""
SMALL = 0.1
"""A deviation is "small" up to a tenth of the spacing."""
ZERO = 0.01
"""Errors have "converged to zero" below a hundredth of the spacing; 0.1 m apart, 1 mm."""
GROWTH = 1.1
"""Errors are bounded if the last quarter of the trial is at most a tenth worse than the second."""
TURNING = 0.05
"""The formation turns where the robots' mean omega is above this [rad/s]."""
SETTLING = 20.0
"""What the first seconds of a trial from printed start poses show is the start [s]."""


def mm(value: float) -> str:
    """A length [m] as text in millimetres."""
    return f"{shown(value * 1e3)} mm"


def outer_is_faster(trial: Signals) -> float:
    """Share of the turning ticks on which the outer of two robots side by side drives faster."""
    rows = trial.after(SETTLING)
    inputs = trial.inputs[min(rows.start, len(trial.inputs) - 1) :]
    turn = inputs[..., 1].mean(axis=1)
    turning = np.abs(turn) > TURNING
    if not turning.any():
        return 0.0
    faster: FloatArray = (inputs[:, 0, 0] - inputs[:, -1, 0]) * turn > 0.0  # robot 1 is the right one
    return float(faster[turning].mean())


def turns(trials: Mapping[str, Signals]) -> Verdict:
    """Figs. 3-4: on turns the outside robot is quick and the inside robot slow."""
    share = {name: outer_is_faster(trials[name]) for name in ("paper", "nash")}
    return Verdict(
        "On turns the outside robot drives quickly and the inside robot slowly, and so the line is kept (figs. 3, 4).",
        f"The outer robot is the faster one during {share['paper']:.1%} of the turning time with `paper` "
        f"and {share['nash']:.1%} with `nash`.",
        grade([share["paper"] >= 0.9]),
    )


def both_objectives(trials: Mapping[str, Signals]) -> Verdict:
    """Fig. 3: trajectory tracking and formation keeping are optimally achieved."""
    keeping = {name: rms(f.distance[f.after(SETTLING)]) for name, f in trials.items()}
    tracking = {name: rms(f.tracking[f.after(SETTLING)]) for name, f in trials.items()}
    best_keeping, best_tracking = min(keeping, key=keeping.__getitem__), min(tracking, key=tracking.__getitem__)
    return Verdict(
        "Trajectory tracking and formation keeping are both optimally achieved (fig. 3).",
        f"From {SETTLING:g} s on, `paper` keeps l to {mm(keeping['paper'])} RMS and its centre trails the path by "
        f"{mm(tracking['paper'])}; `{best_keeping}` keeps l to {mm(keeping[best_keeping])}, and the "
        f"path is followed best by `{best_tracking}`, to {mm(tracking[best_tracking])}.",
        grade(
            [
                keeping["paper"] <= OPTIMAL * keeping[best_keeping],
                tracking["paper"] <= OPTIMAL * tracking[best_tracking],
            ]
        ),
    )


def follower_errs(trials: Mapping[str, Signals]) -> Verdict:
    """Fig. 5: the leader-follower's bearing error is large, those of the proposed algorithm small beside it."""
    rows = {name: trial.after(SETTLING) for name, trial in trials.items()}
    distance = {name: rms(trial.distance[rows[name]]) for name, trial in trials.items()}
    angle = {name: rms(trial.angle[rows[name]]) for name, trial in trials.items()}
    return Verdict(
        "The follower makes a large bearing error when its leader turns; beside it the proposed algorithm's pattern "
        "errors are small (fig. 5).",
        f"RMS from {SETTLING:g} s on, leader-follower against `paper`: ψₑ {shown(angle['leader_follower'])} against "
        f"{shown(angle['paper'])} rad, lₑ {mm(distance['leader_follower'])} against {mm(distance['paper'])}; `nash`: "
        f"{shown(angle['nash'])} rad and {mm(distance['nash'])}.",
        grade([MUCH * e["paper"] <= e["leader_follower"] for e in (angle, distance)]),
    )


def boxes_smaller(paths: Mapping[str, Mapping[str, Signals]], what: Literal["distance", "angle"]) -> Verdict:
    """Figs. 6-7: errors very small compared with leader-follower, deviations much smaller in all the cases."""
    words: list[str] = []
    parts: list[bool] = []
    for path, trials in paths.items():
        found = {name: getattr(trials[name], what) for name in ("paper", "leader_follower")}
        size = {name: spread(np.abs(errors)).median for name, errors in found.items()}
        width = {name: spread(errors).width for name, errors in found.items()}
        parts += [MUCH * e["paper"] <= e["leader_follower"] for e in (size, width)]
        ratios = (e["leader_follower"] / max(e["paper"], 1e-12) for e in (size, width))
        words.append(f"{path} " + " and ".join(shown(ratio) for ratio in ratios))
    figure, symbol = ("fig. 6", "lₑ") if what == "distance" else ("fig. 7", "ψₑ")
    return Verdict(
        f"{symbol}: the proposed algorithm's errors are very small compared with leader-follower's, and their "
        f"deviations much smaller, on all four paths ({figure}).",
        f"Leader-follower's median of |{symbol}|, and then its interquartile range, are larger than `paper`'s by the "
        f"factors: {', '.join(words)}; {sum(parts)} of the {len(parts)} are at least {MUCH:g}.",
        grade(parts),
    )


def corner_recovers(trial: Signals, spacing: float, corner: float) -> Verdict:
    """Fig. 9: errors converge to zero, with a small deviation where the path changes direction."""
    deviation, final = corner_errors(trial, corner)
    return Verdict(
        "Three robots keep the triangle; the distance errors converge to zero, with a small deviation where the path "
        "changes direction (figs. 8 and 9).",
        f"With `paper` |lₑ| rises to {mm(deviation)} after the corner and is at most {mm(final)} in the last 5 s "
        f"(a tenth of the spacing is {mm(SMALL * spacing)}, a hundredth {mm(ZERO * spacing)}).",
        grade([deviation <= SMALL * spacing, final <= ZERO * spacing]),
    )


def corner_errors(trial: Signals, corner: float) -> tuple[float, float]:
    """Largest |l_e| after the corner, and in the last 5 s [m]."""
    size = np.abs(trial.distance)
    last = float(trial.times[-1])
    return float(size[trial.after(corner)].max()), float(size[trial.after(max(corner, last - 5.0))].max())


def corner_beaten(trial: Signals, corner: float) -> Verdict:
    """What this project claims of `nash` on the sharp corner."""
    deviation, _ = corner_errors(trial, corner)
    back = recovery(trial.times, np.abs(trial.distance).max(axis=1), below=1e-4, since=corner)
    when = "does not come back under 0.1 mm" if back is None else f"is back under 0.1 mm after {back:.1f} s"
    return Verdict(
        "This project: after the sharp corner `nash` stays within 10 mm, and is back under 0.1 mm within 10 s.",
        f"|lₑ| rises to {mm(deviation)} and {when}.",
        grade([deviation <= 0.010, back is not None and back <= 10.0]),
    )


def circle_bounded(trial: Signals, spacing: float) -> Verdict:
    """Figs. 10-11: the formation is kept on the circle; errors remain, and stay bounded."""
    sizes = quarters(trial)
    return Verdict(
        "Three robots keep the triangle on the circle; distance errors remain, but stay bounded (figs. 10 and 11).",
        f"With `paper` the RMS of lₑ is {', '.join(mm(size) for size in sizes)} in the four quarters of the lap.",
        grade([sizes[3] <= GROWTH * sizes[1], sizes[3] <= SMALL * spacing]),
    )


def quarters(trial: Signals) -> list[float]:
    """RMS of l_e in each quarter of the trial [m]."""
    return [rms(part) for part in np.array_split(trial.distance, 4)]
