"""Key expressions of a run; the README's table is made of these."""


def tick(run: str) -> str:
    """The world's Tick."""
    return f"echelon/{run}/tick"


def plan(run: str, robot: int | str) -> str:
    """An agent's Plan."""
    return f"echelon/{run}/robot/{robot}/plan"


def command(run: str, robot: int | str) -> str:
    """An agent's Command."""
    return f"echelon/{run}/robot/{robot}/command"


def status(run: str, robot: int | str) -> str:
    """An agent's Status."""
    return f"echelon/{run}/robot/{robot}/status"


def state(run: str) -> str:
    """The world's State, for displays."""
    return f"echelon/{run}/state"


def ghost(run: str) -> str:
    """The same episode under another controller: Ghost."""
    return f"echelon/{run}/ghost"


def control(run: str) -> str:
    """The queryable on which the world answers Requests."""
    return f"echelon/{run}/control"


def alive(run: str, role: str, number: int | str) -> str:
    """The liveliness token of a process."""
    return f"echelon/{run}/alive/{role}/{number}"


def robot_of(key: str) -> int | None:
    """The robot in a key `.../robot/{id}/...` or `.../alive/agent/{id}`; None if there is none."""
    parts = key.split("/")
    if len(parts) != 5 or not (parts[2] == "robot" or parts[2:4] == ["alive", "agent"]):
        return None
    text = parts[3] if parts[2] == "robot" else parts[4]
    return int(text) if text.isascii() and text.isdigit() and len(text) <= 3 else None
