"""What every process of a run needs, imported once in the fork server: they then share its memory and start at once.

No Zenoh session may be opened here, and no thread may run: neither survives a fork.
"""

import atexit
import contextlib
import gc
import importlib
import multiprocessing.forkserver
import os
import sys
import warnings
from pathlib import Path

from runtime.streams import open_streams


def remove_folder(server: int) -> None:
    """Remove the folder of the fork server's socket, which the launcher leaves behind if it is killed."""
    address = getattr(multiprocessing.forkserver, "_forkserver")._forkserver_address  # noqa: B009  no public way
    if os.getpid() == server and address and Path(address).parent.name.startswith("pymp-"):
        with contextlib.suppress(OSError):
            Path(address).unlink(missing_ok=True)
            Path(address).parent.rmdir()


MODULES = ("agents.process", "agents.controllers.nash", "network.zenoh_bus", "runtime.ghost.process", "world.process")

if not sys.warnoptions:
    warnings.simplefilter("ignore")  # of libraries; they concern no user
open_streams(results=False)
atexit.register(remove_folder, os.getpid())
gc.disable()  # all that is imported stays: to look for garbage in it takes a tenth of the time
for module in MODULES:
    importlib.import_module(module)
gc.freeze()  # or each process would copy the pages that it shares; runtime/supervisor.py enables the collector again
