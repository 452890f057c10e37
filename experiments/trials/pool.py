"""Parallel work: on processes of this machine, or on the workers of a Dask cluster; results come as they are ready."""

import os
import signal
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from contextlib import closing, contextmanager
from importlib import import_module
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait
from typing import Any, Protocol

from experiments.trials.journal import Journal
from formation.errors import EchelonError
from runtime.own_code import own_code, without_main

CONNECT_SECONDS = "10s"
DASK_VERSION = "2026.8.0"


class Work(Protocol):
    """A piece of work that other processes can be given: a `Trial`, or another value that can be pickled."""

    @property
    def name(self) -> str:
        """What errors call it."""

    @property
    def key(self) -> str:
        """Names the result."""

    @property
    def cost(self) -> int:
        """How long it takes, compared with other work."""

    def run(self) -> dict[str, Any]:
        """The result, as JSON has it. Raises EchelonError."""


Pool = Callable[[Sequence[Work]], Iterator[tuple[Work, dict[str, Any]]]]
"""Does work in any order and gives it back with its result; closing the iterator ends what is still running."""
Progress = Callable[[float, int, int, bool], None]
"""Called with the share of the work done, pieces done, all pieces, and whether one was just done; else it was found in
the journal."""


def finish(work: Sequence[Work], journal: Journal, pool: Pool, progress: Progress) -> list[dict[str, Any]]:
    """Results of all work, in its order; only what the journal lacks is done.

    Args:
        work: what is wanted.
        journal: results so far; every new one is added at once.
        pool: who works.
        progress: called for each piece whose result is there, those of the journal first.

    Raises:
        EchelonError: a piece failed; the others' results are in the journal.
    """
    keys = [piece.key for piece in work]
    total, shares = sum(piece.cost for piece in work), [0, 0]

    def count(key: str, fresh: bool) -> None:
        for piece in by_key[key]:
            shares[0] += piece.cost
            shares[1] += 1
            progress(shares[0] / total, shares[1], len(work), fresh)

    by_key: dict[str, list[Work]] = {}  # a grid may hold the same trial twice
    for key, piece in zip(keys, work, strict=True):
        by_key.setdefault(key, []).append(piece)
    missing = []
    for key, same in by_key.items():
        if key in journal.results:
            count(key, False)
        else:
            missing.append(same[0])
    if missing:
        # The longest first, so that no worker is left alone with one at the end.
        ordered = sorted(missing, key=lambda piece: -piece.cost)
        with closing(pool(ordered)) as results:  # type: ignore[type-var]
            for piece, result in results:
                journal.add(piece.key, result)
                count(piece.key, True)
    return [journal.results[key] for key in keys]


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def local(workers: int) -> Pool:
    """A pool of so many processes on this machine."""

    def run_all(work: Sequence[Work]) -> Iterator[tuple[Work, dict[str, Any]]]:
        before = set(active_children())
        pool = ProcessPoolExecutor(min(workers, len(work)), get_context("spawn"), initializer=_follow_the_launcher)
        try:
            with _interrupts_ignored(), own_code(), without_main():
                of = {pool.submit(_run, piece): piece for piece in work}
            for future in as_completed(of):
                try:
                    yield of[future], future.result()
                except BrokenProcessPool:
                    raise EchelonError("a worker process died; the same command goes on where it stopped") from None
                except EchelonError:
                    raise
                except Exception as error:
                    raise _failed(of[future], error) from error
        except BaseException:  # Ctrl-C and closing too: nobody waits for what is still running
            pool.shutdown(wait=False, cancel_futures=True)
            for child in set(active_children()) - before:
                child.terminate()
            raise
        finally:
            pool.shutdown()

    return run_all


@contextmanager
def _interrupts_ignored() -> Iterator[None]:
    """Processes started in here ignore Ctrl-C, which reaches every process of a terminal: the launcher decides."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _follow_the_launcher() -> None:
    """A worker ends with its launcher, however that ends, and prints nothing."""
    launcher = parent_process()
    if launcher is not None:
        threading.Thread(target=_outlive, args=(launcher.sentinel,), daemon=True).start()


def _outlive(launcher: int) -> None:
    wait([launcher])
    os._exit(1)


def cluster(address: str) -> Pool:
    """A pool of the workers of a Dask cluster, by the address of its scheduler.

    The workers need this project installed, in the same version.

    Raises:
        EchelonError: Dask is not installed.
    """
    try:
        dask: Any = import_module("distributed")  # optional, and slow to import
    except ImportError:
        raise EchelonError(
            f"--cluster: expected Dask to be installed; got none (python -m pip install distributed=={DASK_VERSION})"
        ) from None

    def run_all(work: Sequence[Work]) -> Iterator[tuple[Work, dict[str, Any]]]:
        try:
            client = dask.Client(address, timeout=CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise EchelonError(f"--cluster: expected a Dask scheduler at {address}; got none ({reason})") from None
        with client:
            if not client.scheduler_info()["workers"]:
                raise EchelonError(f"--cluster: expected workers at {address}; got none (start dask worker {address})")
            futures = client.map(_run, work, pure=False)
            of = dict(zip(futures, work, strict=True))
            try:
                for future in dask.as_completed(futures):
                    try:
                        yield of[future], future.result()
                    except EchelonError:
                        raise
                    except Exception as error:
                        raise _failed(of[future], error) from error
            finally:
                client.cancel(futures)

    return run_all


def _run(work: Work) -> dict[str, Any]:
    return work.run()


def _failed(work: Work, error: Exception) -> EchelonError:
    text = str(error).splitlines()[0] if str(error) else ""
    return EchelonError(f"{work.name} failed: {type(error).__name__}: {text}")
