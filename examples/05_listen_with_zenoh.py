"""Listen to a run with nothing of Echelon but its words: a plain Zenoh session, a checksum, MessagePack."""

import json
import struct
import threading
import zlib

import msgpack
import numpy as np
import zenoh

import echelon

if __name__ == "__main__":
    heard = threading.Event()

    def listen(sample):
        """A State: four bytes of CRC-32, then a map; arrays are raw little-endian float64."""
        payload = sample.payload.to_bytes()
        (checksum,), body = struct.unpack_from("<I", payload), payload[4:]
        if zlib.crc32(body) == checksum and not heard.is_set():
            state = msgpack.unpackb(body)
            poses = np.frombuffer(state["poses"], "<f8").reshape(-1, 3)
            print(f"t = {state['stamp']:.2f} s, robot 1 is at {poses[0, 0]:.2f}, {poses[0, 1]:.2f} m")
            heard.set()

    with echelon.launch("triangle-circle", {"duration": 5}, page=False, speed=1.0) as run:
        settings = {
            "mode": "client",
            "connect": {"endpoints": [run.endpoint]},
            "scouting": {"multicast": {"enabled": False}},
        }
        with zenoh.open(zenoh.Config.from_json5(json.dumps(settings))) as session:
            session.declare_subscriber(f"echelon/{run.name}/state", listen)
            heard.wait(10.0)
