"""Which robot is a real one, and where: what `echelon up --robot` takes."""

import math
import re
from dataclasses import dataclass

from formation.errors import EchelonError
from ros.decoding import Place

PORT = 7447
"""Of a router, unless it is given."""
KEYS = ("namespace", "pose", "origin", "domain")
FORM = "N=ENDPOINT[,namespace=/robot2,pose=/odom,origin=X:Y:DEGREES,domain=0]"
_NAME = re.compile(r"(/[A-Za-z_][A-Za-z0-9_]*)+")
MAX_DOMAIN = 232
ORIGIN = Place(0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class RobotSpec:
    """A real robot of a run."""

    number: int
    """Of the robot in the formation, from 1."""
    endpoint: str
    """Of its own router."""
    namespace: str = ""
    """Of its topics, such as "/robot2"; empty for none."""
    pose: str = ""
    """Topic that says where it is; empty: found by its type."""
    origin: Place = ORIGIN
    """Where the frame of its poses is in the map of the formation."""
    domain: int = 0
    """ROS_DOMAIN_ID."""

    def __str__(self) -> str:
        x, y, theta = self.origin
        options = [f"origin={x!r}:{y!r}:{math.degrees(theta)!r}", f"domain={self.domain}"]
        options += [f"namespace={self.namespace}"] if self.namespace else []
        options += [f"pose={self.pose}"] if self.pose else []
        return ",".join([f"{self.number}={self.endpoint}", *options])


def endpoint_of(text: str) -> str:
    """A router's endpoint in Zenoh's words: "10.0.0.11" is tcp/10.0.0.11:7447."""
    if "/" in text:
        return text
    host = text if text.rpartition(":")[2].isdecimal() and not text.endswith("]") else f"{text}:{PORT}"
    return f"tcp/{host}"


def parse(text: str) -> RobotSpec:
    """What a word of the command line says. Raises EchelonError."""
    number, _, rest = text.partition("=")
    endpoint, *options = rest.split(",")
    if not (number.isascii() and number.isdecimal() and int(number)) or not endpoint or "=" in endpoint:
        raise EchelonError(f"--robot: expected {FORM}; got {text!r}")
    found: dict[str, str] = {}
    for option in options:
        key, _, value = option.partition("=")
        if key not in KEYS or not value:
            raise EchelonError(f"--robot {number}: expected {', '.join(f'{key}=..' for key in KEYS)}; got {option!r}")
        found[key] = value
    return RobotSpec(
        int(number),
        endpoint_of(endpoint),
        _topic(number, "namespace", found),
        _topic(number, "pose", found),
        _origin(number, found.get("origin", "0:0:0")),
        _domain(f"--robot {number}", found.get("domain", "0")),
    )


def parse_router(text: str) -> tuple[str, int]:
    """Endpoint and domain of what `--ros` says. Raises EchelonError."""
    endpoint, comma, option = text.partition(",")
    key, _, value = option.partition("=")
    if not endpoint or (comma and key != "domain"):
        raise EchelonError(f"--ros: expected ENDPOINT[,domain=0]; got {text!r}")
    return endpoint_of(endpoint), _domain("--ros", value if comma else "0")


def _domain(option: str, text: str) -> int:
    if not (text.isascii() and text.isdecimal() and int(text) <= MAX_DOMAIN):
        raise EchelonError(f"{option}: expected domain=0 to {MAX_DOMAIN}; got {text!r}")
    return int(text)


def _topic(number: str, key: str, found: dict[str, str]) -> str:
    value = found.get(key, "")
    name = f"/{value.strip('/')}" if value.strip("/") else ""
    if name and not _NAME.fullmatch(name):
        raise EchelonError(f"--robot {number}: expected {key}=/name/of/letters; got {value!r}")
    return name


def _origin(number: str, text: str) -> Place:
    try:
        x, y, degrees = map(float, text.split(":"))
    except ValueError:
        x = math.nan
    if not all(map(math.isfinite, (x, y, degrees) if not math.isnan(x) else (x,))):
        raise EchelonError(f"--robot {number}: expected origin=X:Y:DEGREES; got {text!r}")
    return Place(x, y, math.radians(degrees))


def parse_all(texts: list[str], size: int) -> dict[int, RobotSpec]:
    """Every real robot by its number. Raises EchelonError: one is given twice, or the scenario has no such robot."""
    found: dict[int, RobotSpec] = {}
    for text in texts:
        spec = parse(text)
        if spec.number > size:
            raise EchelonError(f"--robot: expected a robot of the scenario, 1 to {size}; got {spec.number}")
        if spec.number in found:
            raise EchelonError(f"--robot: expected robot {spec.number} once; got it twice")
        found[spec.number] = spec
    return found
