"""What a hostile client does to the page: thirty kinds of messages, up to 10^5 of each, and the memory it costs.

Run it with `python -m benchmarks.hostile`.
"""

import asyncio
import contextlib
import gc

import psutil
import websockets

from tests.dashboard.serving.hostile import camera, kinds
from tests.dashboard.serving.test_gate import Served, update

FLOOD = 100_000


def memory() -> float:
    """Of this process, which serves the page and attacks it [MB]."""
    gc.collect()
    return float(psutil.Process().memory_info().rss) / 1e6


async def attack(served: Served) -> float:
    """Every kind in full, each until it is disconnected; the most memory meanwhile [MB]."""
    most = 0.0
    async with served.page() as good:
        await good.send(camera())
        for name, make in kinds(served.uuids).items():
            sent = 0
            with contextlib.suppress(websockets.ConnectionClosed):
                async with served.page() as page:
                    await page.send(camera())
                    for sent in range(FLOOD):
                        await page.send(make(sent))
            most = max(most, memory())
            print(f"{name}: disconnected after {sent}, {memory():.0f} MB", flush=True)
        await good.send(update(served.uuids["checkbox"], not served.controls["checkbox"].value))
        await asyncio.sleep(0.5)
    return most


def main() -> None:
    """Attack twice: the first time is what anything costs."""
    served = Served()
    asyncio.run(attack(served))
    before = memory()
    most = asyncio.run(attack(served))
    print(f"{before:.0f} MB before, {most:.0f} MB at most, {memory():.0f} MB after; set {served.set}")


if __name__ == "__main__":
    main()
