"""What lets other hosts into a run: its authority, its codes and the place where they enrol."""

from collections.abc import Callable
from pathlib import Path

from runtime.hosts.authority import Authority
from runtime.hosts.codes import Codes, Guest
from runtime.hosts.enrolment import Enrolment, Offer
from runtime.hosts.listening import Listening

FOLDER = "keys"
"""In a run's folder."""


class Reception:
    """Lets other hosts into a run, until it is closed."""

    def __init__(
        self, wish: Listening, run: str, folder: Path, vacant: Callable[[], set[int]], tell: Callable[[str], None]
    ) -> None:
        """Make the run's authority and the router's keys, and enrol from now on; see Enrolment."""
        self.folder = folder / FOLDER
        self._authority = Authority()
        self._authority.write(self.folder, "router")
        offer = Offer(run, wish.port, wish.agents)
        where = (wish.host, wish.port + 1)
        self._enrolment = Enrolment(where, offer, self.folder, self._authority, vacant, tell)

    def invite(self, guest: Guest) -> str:
        """A new code."""
        return Codes(self.folder).new(guest, self._authority.pem)

    def close(self) -> None:
        """Let nobody in any more."""
        self._enrolment.close()
