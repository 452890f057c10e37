"""What every process of a run needs, imported once in the fork server: they then share its memory and start at once.

No Zenoh session may be opened here, and no thread may run: neither survives a fork.
"""

import agents.process
import network.zenoh_bus
import runtime.ghost.process
import world.process

__all__ = ["agents", "network", "runtime", "world"]
