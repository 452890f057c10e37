"""Where the command's own process imports from: the folder of this code, Python's modules, installed packages.

The current folder and the user's PYTHONPATH are left out, because the names of our rooms are common words. This module
must not import anything that they could hold: only what Python has imported at its start. Processes that the command
starts are runtime/own_code.py's.
"""

import os
import site
import sys


def use_own_path() -> None:
    """Leave out the current or the script's folder and PYTHONPATH; put this code's folder first."""
    root = os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
    installed = {os.path.dirname(os.__file__), *site.getsitepackages()}
    given = os.environ.get("PYTHONPATH")
    foreign = {os.path.abspath(entry) for entry in given.split(os.pathsep)} - installed if given else set()
    found = [entry for entry in sys.path[0 if sys.flags.safe_path else 1 :] if entry not in foreign]
    if root not in installed:  # a checkout; else it is found where packages are, behind Python's own modules
        found = [root, *(entry for entry in found if entry != root)]
    sys.path[:] = found
