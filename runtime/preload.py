"""What every process of a run needs, imported once in the fork server: they then share its memory and start at once.

No Zenoh session may be opened here, and no thread may run: neither survives a fork.
"""

import gc
import importlib

MODULES = ("agents.process", "agents.controllers.nash", "network.zenoh_bus", "runtime.ghost.process", "world.process")

gc.disable()  # all that is imported stays: to look for garbage in it takes a tenth of the time
for module in MODULES:
    importlib.import_module(module)
gc.freeze()  # or each process would copy the pages that it shares; runtime/supervisor.py enables the collector again
