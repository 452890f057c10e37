"""Starts and ends the recorder of a run, as its users wish."""

import time
from collections.abc import Callable, Iterable
from pathlib import Path

from network.messages import State
from runtime.process_list import Program
from runtime.supervisor import Supervisor


class RecordKeeper:
    """Follows the wish in the world's newest State."""

    def __init__(
        self, supervisor: Supervisor, recorder: Callable[[str], Program], folder: Path, tell: Callable[[str], None]
    ) -> None:
        """Without a State yet.

        Args:
            supervisor: of this host's processes.
            recorder: that records in a file.
            folder: for the files.
            tell: called with a line for the user.
        """
        self._supervisor, self._recorder, self._folder, self._tell = supervisor, recorder, folder, tell

    def keep(self, state: State) -> None:
        """Do as the world's users wish."""
        records = "recorder" in self._supervisor.roles
        if state.record == "on" and not records:
            file = self._folder / file_name(state.scenario)
            self._supervisor.start([self._recorder(str(file))])
            self._tell(f"recording in {file}")
        elif state.record == "off" and records:
            codes = self._supervisor.end("recorder")
            self._tell(f"the record is closed; {broken(codes)}" if any(codes) else "the record is closed")


def broken(codes: Iterable[int]) -> str:
    """What is wrong with a record, of whose recorder's processes some ended so: exit codes, or signals below 0."""
    if any(code > 0 for code in codes):
        return "it could not be written to its end"
    return "its recorder died: parts are missing, and what came later is in files with a number behind the name"


def file_name(scenario: str) -> str:
    """Of a record that nobody has named: scenario and time."""
    return f"{scenario}-{time.strftime('%Y%m%d-%H%M%S')}.mcap"
