"""The recorder's process: take what has arrived, write it, close a chunk every so often."""

import logging
from collections.abc import Iterable
from pathlib import Path
from time import monotonic, sleep, time_ns

from formation.errors import EchelonError, WireError
from network import topics
from network.bus import Bus, Incoming, Sample
from network.codec import decode
from network.lifetime import Lifetime
from network.messages import Status
from network.stretch import Stretch
from network.throttled_log import ThrottledLog
from records.file import RecordFile
from records.recorder import Detail, Recorder

FLUSH_SECONDS = 0.9
"""Between two flushes: so much is lost at most, and what is on its way [s]."""
LOOK_SECONDS = 0.05
"""Between two looks at what has arrived [s]: to wake up for each message costs more than to write it."""
MAX_NAMES = 1000


def new_file(path: Path) -> RecordFile:
    """A file of this name; if there is one, which a recorder before this one wrote, of the next free name.

    Raises:
        EchelonError: it cannot be made.
    """
    for number in range(1, MAX_NAMES):
        name = path if number == 1 else path.with_stem(f"{path.stem}-{number}")
        if not name.exists():
            return RecordFile(name)
    raise EchelonError(f"expected a free name like {path.name}")


def run(bus: Bus, path: Path, lifetime: Lifetime, *, detail: Detail) -> bool:
    """Record the run until the lifetime is over. A disk that is full ends the record, not the run.

    Returns:
        Whether the file could be written to its end.
    """
    wanted = [topics.stretch(bus.run), topics.status(bus.run, "*")]
    if detail == "full":
        wanted += [topics.tick(bus.run), topics.plan(bus.run, "*"), topics.command(bus.run, "*")]
    try:
        file = new_file(path)
        for key in wanted:
            bus.subscribe(key)
        _record(bus, file, lifetime, detail)
        return True
    except (EchelonError, OSError) as error:
        logging.getLogger(__name__).error("nothing is recorded any more: %s", error)
        bus.close()  # its token goes: the world logs that the run is no longer recorded
        while not lifetime.over:  # an end would be taken for a crash
            bus.arrivals(FLUSH_SECONDS)
        return False


def _record(bus: Bus, file: RecordFile, lifetime: Lifetime, detail: Detail) -> None:
    """Write to the file until the lifetime is over. Raises OSError if it cannot be written any more."""
    try:
        recorder, log = Recorder(file, bus.run, time_ns(), detail=detail), ThrottledLog()
        bus.announce(topics.recording(bus.run))
        bus.appear("recorder")
        began = flushed = monotonic()
        count = 0
        while not lifetime.over:
            take(recorder, bus.arrivals(FLUSH_SECONDS), log)
            sleep(LOOK_SECONDS)
            if monotonic() - flushed >= FLUSH_SECONDS - LOOK_SECONDS:  # at the next look it would be too late
                file.flush()
                flushed = monotonic()
                count += 1
                bus.publish(topics.recording(bus.run), recorder.stands(count, flushed - began))
        take(recorder, bus.arrivals(), log)
        file.close()
    except OSError:
        file.abandon()
        raise


def take(recorder: Recorder, arrivals: Iterable[Incoming], log: ThrottledLog) -> None:
    """Record what has arrived."""
    for item in arrivals:
        if isinstance(item, Sample):
            try:
                _take_sample(recorder, item)
            except (WireError, ValueError) as error:
                log.add(item.key, str(error))


def _take_sample(recorder: Recorder, sample: Sample) -> None:
    key = sample.key.split("/", 2)[2]
    kind = key.rsplit("/", 1)[-1]
    if kind == "stretch":
        recorder.take(decode(Stretch, sample.payload))
    elif kind != "status":
        recorder.take_wire(key, sample.payload)
    elif recorder.wants_status(topics.robot_of(sample.key) or 0):
        recorder.take_status(decode(Status, sample.payload))
