"""The solver is compiled once per machine, before anything waits for it."""

import subprocess
import sys
from collections.abc import Callable

from agents.kernels.jit_cache import (
    KERNEL_MODULES,
    cache_folder,
    compiled,
    fetch_prebuilt,
    note_compiled,
    wanted_place,
    writable,
)
from formation.errors import EchelonError
from runtime.own_code import own_code


def ensure_compiled(tell: Callable[[str], None]) -> None:
    """Compile what is not compiled yet, in a process of its own.

    Args:
        tell: called with a line for the user if this takes a while, or if the kernels are kept in a temporary folder.

    Raises:
        EchelonError: it cannot be compiled.
    """
    fetch_prebuilt()
    if compiled():
        return
    wanted = wanted_place()
    if not (wanted and writable(wanted)):
        tell(
            f"the solver cannot be kept in {wanted or 'a home folder'}, which cannot be written: it is kept in "
            f"{cache_folder()}; set ECHELON_CACHE to a folder that can be written"
        )
    tell("compiling the solver (once on this machine, about half a minute) ...")
    command = [sys.executable, "-c", f"import {', '.join(KERNEL_MODULES)}"]
    with own_code():
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise EchelonError(
            f"the solver cannot be compiled: {(done.stderr.strip().splitlines() or ['no reason given'])[-1]}"
        )
    note_compiled()
