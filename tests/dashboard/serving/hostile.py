"""A client that sends what no page does: thirty kinds of messages."""

import math
from collections.abc import Callable
from typing import Any

import msgspec

POSE = {"wxyz": [1.0, 0.0, 0.0, 0.0], "position": [0.0, 0.0, 5.0], "look_at": [0.0, 0.0, 0.0]}
CAMERA = {**POSE, "up_direction": [0.0, 0.0, 1.0], "fov": 0.2, "near": 0.1, "far": 100.0, "image_height": 10}


def message(kind: str, **fields: Any) -> bytes:
    """A message of viser's wire."""
    return msgspec.msgpack.encode({"type": kind, **fields})


def camera(**fields: Any) -> bytes:
    """Where a page's camera is."""
    return message("ViewerCameraMessage", **{**CAMERA, "image_width": 10, **fields})


def kinds(uuids: dict[str, str]) -> dict[str, Callable[[int], bytes]]:
    """Thirty kinds of messages by name, each made for a number.

    Args:
        uuids: of a slider, a checkbox, a dropdown and a button of the page.
    """

    def update(control: str, **updates: Any) -> bytes:
        return message("GuiUpdateMessage", uuid=uuids[control], updates=updates)

    huge = "x" * 60_000
    return {
        "update_cb": lambda n: update("slider", update_cb=[n]),
        "removed": lambda n: update("slider", removed=True),
        "props": lambda n: update("slider", props={"label": str(n)}),
        "sync_cb": lambda n: update("checkbox", sync_cb=None),
        "is_button": lambda n: update("checkbox", is_button=True),
        "value and props": lambda n: update("checkbox", value=True, props={}),
        "unknown property": lambda n: update("slider", **{f"p{n}": n}),
        "value out of range": lambda n: update("slider", value=1e6 + n),
        "value that is no number": lambda n: update("slider", value=math.nan),
        "value of another type": lambda n: update("slider", value={"n": n}),
        "text for a checkbox": lambda n: update("checkbox", value=f"text {n}"),
        "option that is not offered": lambda n: update("dropdown", value=f"none {n}"),
        "list for a dropdown": lambda n: update("dropdown", value=[n] * 10),
        "huge text": lambda n: update("dropdown", value=huge),
        "unknown control": lambda n: message("GuiUpdateMessage", uuid=f"u{n}", updates={"value": 1}),
        "control that is no text": lambda n: message("GuiUpdateMessage", uuid=n, updates={"value": 1}),
        "form dirty": lambda n: message("GuiFormDirtyMessage", uuid=f"f{n}", dirty=True),
        "form submit": lambda n: message("GuiFormSubmitMessage", uuid=f"f{n}"),
        "button hold": lambda n: message("GuiButtonHoldMessage", uuid=uuids["button"], frequency=1.0 + n),
        "upload to a dropdown": lambda n: message(
            "FileTransferStartUpload",
            source_component_uuid=uuids["dropdown"],
            transfer_uuid=f"t{n}",
            filename="f",
            mime_type="text/plain",
            part_count=n % 2,
            size_bytes=0,
        ),
        "part of an upload": lambda n: message(
            "FileTransferPart",
            source_component_uuid=uuids["dropdown"],
            transfer_uuid=f"t{n}",
            part_index=0,
            content=b"x" * 1000,
        ),
        "share": lambda n: message("ShareUrlRequest"),
        "run javascript": lambda n: message("RunJavascriptMessage", source=f"alert({n})"),
        "reset the page": lambda n: message("ResetGuiMessage"),
        "remove a node": lambda n: message("RemoveSceneNodeMessage", name="/bodies"),
        "camera of texts": lambda n: camera(position=["a", "b", str(n)]),
        "camera without numbers": lambda n: camera(fov=math.inf),
        "unknown type": lambda n: message(f"Kind{n}"),
        "no message": lambda n: msgspec.msgpack.encode([n]),
        "no bytes of a message": lambda n: b"\xc1" * (1 + n % 50),
    }
