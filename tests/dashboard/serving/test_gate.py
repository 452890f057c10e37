"""Laws of the gate: a hostile client changes nothing, costs no memory, and pages that fight end up alike."""

import asyncio
import contextlib
import gc
import random
from typing import Any

import msgspec
import psutil
import pytest
import websockets
import zstandard
from websockets.asyncio.client import ClientConnection

from dashboard.serving import gate
from tests.dashboard.serving.hostile import camera, kinds
from tests.dashboard.serving.served import Served, send, update

FLOODS, FLOOD = 5, gate.BURST + gate.MOST_DROPPED + 200
"""Kinds, drawn by a seed, and messages of each, that are sent in a test; benchmarks/hostile.py sends all of all."""


def test_a_hostile_client_changes_nothing_and_a_page_beside_it_works(served: Served) -> None:
    hostile = kinds(served.uuids)
    assert len(hostile) == 30
    before, properties = served.values(), {name: vars(c._impl).copy() for name, c in served.controls.items()}

    async def attack() -> None:
        async with served.page() as good:
            await send(good, camera())
            for make in hostile.values():
                async with served.page() as page:
                    await send(page, camera(), *(make(n) for n in range(3)))
            await asyncio.sleep(0.3)
            assert served.values() == before
            assert not served.set
            for name, control in served.controls.items():
                now = {key: value for key, value in vars(control._impl).items() if key != "update_timestamp"}
                assert now == {key: properties[name][key] for key in now}, name
            await send(good, update(served.uuids["slider"], 3), update(served.uuids["dropdown"], "b"))
            await asyncio.sleep(0.3)
            assert (served.controls["slider"].value, served.controls["dropdown"].value) == (3.0, "b")

    asyncio.run(attack())


def test_a_flood_is_cut_off_and_costs_no_memory(served: Served) -> None:
    def memory() -> float:
        gc.collect()
        return float(psutil.Process().memory_info().rss) / 1e6

    async def attack() -> float:
        most = 0.0
        async with served.page() as good:
            await send(good, camera())
            hostile = kinds(served.uuids)
            for name in random.Random(7).sample(sorted(hostile), FLOODS):
                flood = [hostile[name](n) for n in range(int(FLOOD))]
                with contextlib.suppress(websockets.ConnectionClosed):
                    async with served.page() as page:
                        await send(page, camera(), *flood)
                most = max(most, memory())
            await send(good, update(served.uuids["checkbox"], True))
            await asyncio.sleep(0.3)
            assert served.controls["checkbox"].value is True
        return most

    asyncio.run(attack())
    before = memory()
    most = asyncio.run(attack() if not served.controls["checkbox"].value else _again(served, attack))
    assert most < before + 20.0
    assert memory() < before + 10.0


async def _again(served: Served, attack: Any) -> float:
    served.controls["checkbox"].value = False
    return float(await attack())


def test_pages_that_set_one_control_at_once_are_told_the_same_value(served: Served) -> None:
    uuid = served.uuids["slider"]

    async def fight() -> list[list[float]]:
        told: list[list[float]] = [[], []]

        async def listen(page: ClientConnection, into: list[float]) -> None:
            async for raw in page:
                assert isinstance(raw, bytes)
                into += _values(raw, uuid)

        async with served.page() as one, served.page() as other:
            tasks = [asyncio.create_task(listen(page, into)) for page, into in zip((one, other), told, strict=True)]
            await send(one, camera())
            await send(other, camera())
            for n in range(10):
                await asyncio.gather(one.send(update(uuid, 2.0 + 0.1 * n)), other.send(update(uuid, 5.0 + 0.1 * n)))
            await asyncio.sleep(gate.SETTLED_SECONDS + 0.5)
            for task in tasks:
                task.cancel()
        return told

    one, other = asyncio.run(fight())
    assert one[-1] == other[-1] == served.controls["slider"].value


def _values(raw: bytes, uuid: str) -> list[float]:
    """Values of a control in a window of messages."""
    size = int.from_bytes(raw[8:16], "little")
    window = msgspec.msgpack.decode(zstandard.ZstdDecompressor().decompress(raw[16 : 16 + size]))
    messages = window["messages"] if isinstance(window, dict) else window[0]
    found = [one for one in messages if one.get("type") == "GuiUpdateMessage" and one.get("uuid") == uuid]
    return [float(one["updates"]["value"]) for one in found if "value" in one["updates"]]


def test_connections_are_bounded_and_one_that_shows_nothing_is_closed(
    served: Served, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(gate, "SILENT_SECONDS", 3.0)

    async def idle() -> None:
        async with served.page() as good:
            await send(good, camera())
            pages, refused = [], 0
            for _ in range(200):
                try:
                    pages.append(await served.page().__aenter__())
                except websockets.InvalidStatus as answer:
                    refused += answer.response.status_code == 503
                assert len(served.server._websock_server._live_connections) <= gate.PAGES
            assert refused > 0
            await asyncio.sleep(4.0)
            assert len(served.server.get_clients()) == 1
            async with served.page() as late:  # there is room again
                await send(late, camera())
                await asyncio.sleep(0.3)
                assert len(served.server.get_clients()) == 2
            for page in pages:
                await page.close()

    asyncio.run(idle())


def test_what_a_picture_may_be() -> None:
    png = b"\x89PNG\r\n\x1a\n" + b"\0\0\0\rIHDR"
    assert gate._is_picture(png + (1920).to_bytes(4, "big") + (1080).to_bytes(4, "big"))
    assert not gate._is_picture(png + (60_000).to_bytes(4, "big") + (60_000).to_bytes(4, "big"))
    assert not gate._is_picture(b"GIF89a" + bytes(30))
