"""The paper's third test, read in every way that its text allows: does the triangle on the circle stay together?

It does if the triangle keeps its orientation in the plane while its centre goes round, and in no other way that was
found. The text prints no psi_r for three robots. If the triangle turns with the path, every slot has a heading of its
own (erratum 18), while the error state wants both headings of a pair to have the mean theta_r and does not know their
difference (errata 15, 16): the pattern comes apart at omega_r times its size, and next to nothing pulls it together.
"""

import hashlib
import math
from dataclasses import dataclass, field, replace
from typing import Any

from agents.kernels.paper_errors import BEST_RESPONSE, ONE_HEADING, ROLLED_OUT, STEP_4_STATES
from experiments.errata.ring_map import ROBOTS, TICK, Ring, Wording
from experiments.trials.code_version import check_code_version, code_version
from runtime.precompile import ensure_compiled

LAP = 126.0
"""One lap of Ref. path 2 [s]."""
BOUND = 25.0
"""A reading is bounded if RMS l_e stays below this in every 10 s of a lap [mm]: the largest error of the start."""
LOOK = 10.0
"""When the trajectory is linearised [s]: the start is over, the pattern not yet apart."""
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
    """Of the closed loop's map over one second, linearised in the path's frame about the state after 10 s."""


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


EXACT = ("as printed", "orientation kept")
"""Readings that plan on every tick, as the paper says, in the quick study too."""


@dataclass(frozen=True, slots=True)
class ReadingTrial:
    """One lap under one wording, as work for a pool (experiments/trials/pool.py)."""

    title: str
    words: str
    wording: Wording
    code: str = field(default_factory=code_version)
    """`code_version()` of who asks."""

    @property
    def name(self) -> str:
        """What errors call it."""
        return f"reading {self.title}"

    @property
    def key(self) -> str:
        """Names the result."""
        return hashlib.sha256(f"{self.title}\n{self.wording!r}\n{self.code}".encode()).hexdigest()

    @property
    def cost(self) -> int:
        """Plans of a lap: each takes about as long as a control interval of a `Trial`."""
        return round(LAP / TICK / self.wording.every * ROBOTS)

    def run(self) -> dict[str, Any]:
        """RMS and spectral radius as plain data. Raises EchelonError."""
        check_code_version(self.code)
        ensure_compiled(lambda _: None)
        ring = Ring(self.wording)
        rms_mm = (1e3 * ring.simulate(LAP)).tolist()
        return {"rms_mm": rms_mm, "spectral_radius": math.exp(ring.rates(LOOK)[0])}


def reading_of(trial: ReadingTrial, plain: dict[str, Any]) -> Reading:
    """What became of a reading, from the plain data of its trial."""
    rms_mm = tuple(plain["rms_mm"])
    return Reading(trial.title, trial.words, rms_mm, max(rms_mm) < BOUND, plain["spectral_radius"])


def quick() -> tuple[ReadingTrial, ...]:
    """READINGS with a plan on every tenth tick only, but for EXACT: ten times cheaper, with the same verdicts."""
    return tuple(
        ReadingTrial(title, words, wording if title in EXACT else replace(wording, every=FAST))
        for title, words, wording in READINGS
    )
