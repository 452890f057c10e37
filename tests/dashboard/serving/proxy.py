"""A small reverse proxy: it forwards a prefix of its own port to another port, as nginx does with such a location."""

import asyncio
import contextlib
import threading
from collections.abc import Iterator
from functools import partial


@contextlib.contextmanager
def proxied(port: int, prefix: str) -> Iterator[int]:
    """The port of a proxy that forwards what is below `prefix` to `port`, without the prefix."""
    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever, daemon=True)
    thread.start()
    serve = asyncio.start_server(partial(_forward, port, prefix.encode()), "127.0.0.1", 0)
    server = asyncio.run_coroutine_threadsafe(serve, loop).result(10.0)
    try:
        yield server.sockets[0].getsockname()[1]
    finally:
        loop.call_soon_threadsafe(server.close)
        asyncio.run_coroutine_threadsafe(_end(), loop).result(10.0)
        loop.call_soon_threadsafe(loop.stop)
        thread.join(10.0)
        loop.close()


async def _end() -> None:
    others = asyncio.all_tasks() - {asyncio.current_task()}
    for task in others:
        task.cancel()
    await asyncio.gather(*others, return_exceptions=True)
    await asyncio.sleep(0.05)  # what they closed is gone before the loop is


async def _forward(port: int, prefix: bytes, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError, asyncio.IncompleteReadError, asyncio.CancelledError):
        line, _, rest = (await reader.readuntil(b"\r\n\r\n")).partition(b"\r\n")
        method, path, version = line.split(b" ")
        if not path.startswith(prefix + b"/"):
            writer.write(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n")
        else:
            behind_reader, behind = await asyncio.open_connection("127.0.0.1", port)
            behind.write(b" ".join((method, path.removeprefix(prefix), version)) + b"\r\n" + rest)
            try:
                await asyncio.gather(_pump(reader, behind), _pump(behind_reader, writer))
            finally:
                behind.close()
    writer.close()


async def _pump(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
    with contextlib.suppress(OSError):
        while data := await reader.read(1 << 16):
            writer.write(data)
            await writer.drain()
    writer.close()
