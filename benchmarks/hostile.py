"""What a hostile client does to the page of a real run: thirty kinds of messages, up to 10^5 of each.

python -m benchmarks.hostile [--flood 100000]

Prints JSON: how many messages of each kind were taken until the page was disconnected; the memory of the dashboard's
process before, at most, and after; what another page saw meanwhile; whether the world is as it was. The first attack
is not measured: it costs what anything costs when it is done first. A run fills its time line meanwhile; so what it
takes by itself in the same time, afterwards, is measured too, and told apart from what the attack has left.
"""

import argparse
import asyncio
import contextlib
import json
import sys
from collections import Counter
from time import monotonic
from typing import Any

import msgspec
import psutil
import viser  # noqa: TID251  only for the version that its web socket wants to hear
import websockets
import zstandard
from websockets.asyncio.client import connect
from websockets.typing import Origin, Subprotocol

from network.messages import State
from tests.browser.browser_run import BrowserRun
from tests.dashboard.serving.hostile import camera, kinds

FIRST = 700
"""Messages of each kind in the first attack: more than a page may send at once."""
MOST_MB = 20.0
LEFT_MB = 3.0
"""That an attack may leave behind."""
QUIET_SECONDS = 10.0
"""Before memory is read a last time, and while a page's updates are counted for comparison."""
CREATED = {
    "GuiSliderMessage": "slider",
    "GuiCheckboxMessage": "checkbox",
    "GuiDropdownMessage": "dropdown",
    "GuiButtonMessage": "button",
}
NEVER_TOLD = (
    "RunJavascriptMessage",
    "ResetGuiMessage",
    "ResetSceneMessage",
    "RemoveSceneNodeMessage",
    "GuiRemoveMessage",
)
"""A page in which nobody does anything is told none of these."""


def page(address: str) -> Any:
    """A connection as a page makes it."""
    protocol = [Subprotocol(f"viser-v{viser.__version__}")]
    return connect(
        address.replace("http", "ws"), origin=Origin(address), subprotocols=protocol, max_size=None, close_timeout=0.5
    )


class Bystander:
    """Another page, which does nothing: what it is told."""

    def __init__(self) -> None:
        self.uuids: dict[str, str] = {}
        """Of the first control of each kind."""
        self._values: dict[str, Any] = {}
        self.windows = 0
        self.told = Counter[str]()
        """Messages that would change its controls or take something from it; a value that a control has does not."""
        self.attacked = False

    async def listen(self, address: str) -> None:
        """Until it is cancelled."""
        async with page(address) as socket:
            await socket.send(camera())
            async for raw in socket:
                assert isinstance(raw, bytes)
                self.windows += 1
                self._read(raw)

    def _read(self, raw: bytes) -> None:
        size = int.from_bytes(raw[8:16], "little")
        window = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size]))
        for message in window["messages"] if isinstance(window, dict) else window[0]:
            kind = message.get("type", "")
            if kind in CREATED:
                if self.uuids.setdefault(CREATED[kind], message["uuid"]) == message["uuid"]:
                    self._values[message["uuid"]] = message["value"]
            elif kind in NEVER_TOLD:
                self.told[kind] += 1
            elif kind == "GuiUpdateMessage" and message["uuid"] in self._values:
                for name, value in message["updates"].items():
                    if name != "value" or (self.attacked and value != self._values[message["uuid"]]):
                        self.told[f"{name} of a control: {value!r:.40}"] += 1
                    elif name == "value":
                        self._values[message["uuid"]] = value


async def attack(address: str, uuids: dict[str, str], flood: int, dashboard: psutil.Process) -> tuple[Any, float]:
    """Every kind, each until it is disconnected: how many were taken, and the most memory meanwhile [MB]."""
    taken, most = {}, 0.0
    for name, make in kinds(uuids).items():
        sent = 0
        with contextlib.suppress(websockets.ConnectionClosed):
            async with page(address) as socket:
                await socket.send(camera())
                for sent in range(1, flood + 1):
                    await socket.send(make(sent))
        taken[name] = sent
        most = max(most, memory(dashboard))
    return taken, most


def memory(process: psutil.Process) -> float:
    """Of a process [MB]."""
    return float(process.memory_info().rss) / 1e6


def world(state: State) -> dict[str, Any]:
    """What a page could change of it."""
    return {
        "scenario": state.scenario,
        "controller": state.controller,
        "status": state.status,
        "faults": sorted(map(str, state.faults)),
        "pushes": len(state.pushes),
        "dismissed": list(state.dismissed),
    }


async def measure(run: BrowserRun, flood: int) -> dict[str, Any]:
    """Attack twice, and tell of the second time."""
    other, dashboard = Bystander(), psutil.Process(run.pid("dashboard"))
    listening = asyncio.create_task(other.listen(run.url))
    while len(other.uuids) < len(CREATED):
        await asyncio.sleep(0.1)
    await attack(run.url, other.uuids, min(flood, FIRST), dashboard)
    other.told.clear()
    began, windows = monotonic(), other.windows
    await asyncio.sleep(QUIET_SECONDS)
    quiet = (other.windows - windows) / (monotonic() - began)
    before, was = memory(dashboard), world(run.state())
    other.told.clear()
    other.attacked = True
    began, windows = monotonic(), other.windows
    taken, most = await attack(run.url, other.uuids, flood, dashboard)
    seconds = monotonic() - began
    during = (other.windows - windows) / seconds
    await asyncio.sleep(QUIET_SECONDS)
    after, told = memory(dashboard), dict(other.told)
    await asyncio.sleep(seconds + QUIET_SECONDS)
    by_itself = memory(dashboard) - after
    left = after - before - by_itself
    alive = not listening.done()
    listening.cancel()
    return {
        "taken": taken,
        "seconds": round(seconds, 1),
        "memory_mb": {"before": round(before, 1), "most": round(most, 1), "after": round(after, 1)},
        "growth_mb": round(most - before, 1),
        "kept_mb": round(after - before, 1),
        "by_itself_mb": round(by_itself, 1),
        "left_mb": round(left, 1),
        "other_page": {
            "connected": alive,
            "windows_per_s": {"quiet": round(quiet, 1), "attacked": round(during, 1)},
            "changed": told,
        },
        "world": was,
        "world_is_as_it_was": world(run.state()) == was,
        "holds": max(most, after) - before <= MOST_MB and left <= LEFT_MB and alive and not told,
    }


def main() -> None:
    """Attack the page of a run of three robots."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--flood", type=int, default=100_000, help="messages of each kind")
    options = parser.parse_args()
    with BrowserRun("triangle-circle", robots=3, alone=()) as run:
        found = asyncio.run(measure(run, options.flood))
    json.dump(found, sys.stdout, indent=2)
    print()
    sys.exit(not (found["holds"] and found["world_is_as_it_was"]))


if __name__ == "__main__":
    main()
