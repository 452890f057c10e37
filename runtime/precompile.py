"""The solver is compiled once per machine, before anything waits for it."""

import subprocess
import sys
from collections.abc import Callable

from agents.kernels.jit_cache import KERNEL_MODULES, compiled, fetch_prebuilt, note_compiled
from formation.errors import EchelonError


def ensure_compiled(tell: Callable[[str], None]) -> None:
    """Compile what is not compiled yet, in a process of its own.

    Args:
        tell: called with a line for the user if this takes a while.

    Raises:
        EchelonError: it cannot be compiled.
    """
    fetch_prebuilt()
    if compiled():
        return
    tell("compiling the solver (once on this machine, about half a minute) ...")
    command = [sys.executable, "-c", f"import {', '.join(KERNEL_MODULES)}"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise EchelonError(
            f"the solver cannot be compiled: {(done.stderr.strip().splitlines() or ['no reason given'])[-1]}"
        )
    note_compiled()
