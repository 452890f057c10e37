"""The paper's third test, read in every way that its text allows: does the triangle on the circle stay together?

It does if the triangle keeps its orientation in the plane while its centre goes round, and in no other way that was
found. The text prints no psi_r for three robots. If the triangle turns with the path, every slot has a heading of its
own (erratum 18), while the error state wants both headings of a pair to have the mean theta_r and does not know their
difference (errata 15, 16): the pattern comes apart at omega_r times its size, and next to nothing pulls it together.
"""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from agents.kernels.paper_errors import BEST_RESPONSE, ONE_HEADING, ROLLED_OUT, STEP_4_STATES
from experiments.errata.ring_map import Ring, Wording

LAP = 126.0
"""One lap of Ref. path 2 [s]."""
BOUND = 25.0
"""A reading is bounded if RMS l_e stays below this in every 10 s of a lap [mm]: the largest error of the start."""
LOOK = 10.0
"""When the flight is linearised [s]: the start is over, the pattern not yet apart."""
FAST = 10
"""Ticks from plan to plan in the quick study; the readings marked `exact` plan on every tick even there."""


@dataclass(frozen=True, slots=True)
class Reading:
    """What became of one reading."""

    name: str
    words: str
    rms_mm: tuple[float, ...]
    """RMS l_e of the three robots in every 10 s from the printed start [mm]."""
    bounded: bool
    spectral_radius: float | None
    """Of the closed loop's map over one second, linearised in the path's frame where the flight is after 10 s."""


PRINTED_Q4 = (0.1, 0.1, 0.2, 0.01)
"""As the third test has it."""
READINGS: tuple[tuple[str, str, Wording], ...] = (
    ("as printed, centroid", "nothing mended but p_v (erratum 6); psi_r turns with the path", Wording()),
    ("as printed", "p_v as printed too", Wording(centre="printed")),
    ("errata 1 to 3", "eq. (3) and its Jacobians mended", Wording(switches=(1, 2, 3))),
    ("errata 1 to 4", "and the affine term, inputs relative to the reference's", Wording(switches=(1, 2, 3, 4))),
    ("errata 1 to 5", "and the equilibrium played", Wording(switches=(1, 2, 3, 4, 5))),
    ("best response", "a best response to the received plan (erratum 14)", Wording(switches=(BEST_RESPONSE,))),
    ("own heading only", "the column of theta_e: only the own heading moves", Wording(switches=(ONE_HEADING,))),
    ("states of step 4", "eq. (11) along the states of step 4", Wording(switches=(STEP_4_STATES,))),
    ("rolled out", "eq. (11) along eq. (1) in place of (5)", Wording(switches=(ROLLED_OUT,))),
    ("in sequence", "the neighbour's plan of the same tick is known", Wording(play="sequence")),
    ("every 0.1 s", "a plan and its input are kept for Delta_T", Wording(every=10)),
    ("horizon of delta_t", "the horizon's steps are delta_t (erratum 24)", Wording(interval=0.01)),
    ("ring reversed", "robot i listens to i + 1", Wording(reversed_ring=True)),
    ("clockwise", "the circle is driven clockwise", Wording(clockwise=True)),
    ("Q without x_e", "the four entries are y_e, theta_e, l_e, psi_e", Wording(q=(0.0, *PRINTED_Q4))),
    ("Q without theta_e", "the four entries are x_e, y_e, l_e, psi_e", Wording(q=(0.1, 0.1, 0.0, 0.2, 0.01))),
    ("Q without psi_e", "the four entries are x_e, y_e, theta_e, l_e", Wording(q=(*PRINTED_Q4, 0.0))),
    ("orientation kept", "psi_r is constant, p_v mended; all else as printed", Wording(turning=False)),
    ("orientation kept, p_v", "psi_r is constant, p_v as printed", Wording(turning=False, centre="printed")),
    ("orientation kept, mended", "psi_r is constant, errata 1 to 5", Wording((1, 2, 3, 4, 5), turning=False)),
)
"""Name, words, and what they mean."""


Job = tuple[str, str, Wording]
Mapper = Callable[[Callable[[Job], Reading], Iterable[Job]], Iterable[Reading]]
EXACT = ("as printed", "orientation kept")
"""Readings that plan on every tick, as the paper says, in the quick study too."""


def read(name: str, words: str, wording: Wording) -> Reading:
    """Fly one reading for a lap, and linearise it."""
    ring = Ring(wording)
    rms = tuple(float(value) for value in 1e3 * ring.simulate(LAP))
    return Reading(name, words, rms, max(rms) < BOUND, math.exp(ring.rates(LOOK)[0]))


def quick() -> tuple[Job, ...]:
    """READINGS with a plan on every tenth tick only, but for EXACT: ten times cheaper, with the same verdicts."""
    return tuple(
        (name, words, wording if name in EXACT else replace(wording, every=FAST)) for name, words, wording in READINGS
    )


def third_test(
    progress: Callable[[float], None] | None = None, *, thorough: bool = False, mapper: Mapper = map
) -> tuple[Reading, ...]:
    """Every reading of READINGS, flown for a lap from the printed start.

    Args:
        progress: told the share that is done.
        thorough: as they are; else as in quick().
        mapper: how readings are flown: `map`, or that of a pool of processes.
    """
    jobs = READINGS if thorough else quick()
    results = []
    for reading in mapper(_read, jobs):
        results.append(reading)
        if progress:
            progress(len(results) / len(jobs))
    return tuple(results)


def _read(job: Job) -> Reading:
    return read(*job)
