"""Who flies: processes of this machine, or the workers of a Dask cluster. Both give results as they come in."""

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
from typing import Any

from experiments.study.flights import Result, simulate
from experiments.study.grid import Job, words
from experiments.study.journal import Journal
from formation.errors import EchelonError, StudyError

Engine = Callable[[Sequence[Job]], Iterator[Result]]
"""Flies jobs in any order; closing the iterator ends what is still flying."""
CONNECT_SECONDS = "10s"
DASK_VERSION = "2026.8.0"


def finish(jobs: Sequence[Job], journal: Journal, engine: Engine, done: Callable[[Job], None]) -> list[Result]:
    """Results of all jobs, in their order; only those that the journal lacks are flown.

    Args:
        jobs: what is wanted.
        journal: results so far; every new one is added at once.
        engine: who flies.
        done: called for each job whose result is there, those of the journal first.

    Raises:
        EchelonError: a flight failed; the others' results are in the journal.
    """
    by_key: dict[str, list[Job]] = {}  # a grid may hold the same flight twice
    for job in jobs:
        by_key.setdefault(job.key, []).append(job)
    missing = []
    for key, same in by_key.items():
        if key in journal.results:
            for job in same:
                done(job)
        else:
            missing.append(same[0])
    if missing:
        # The longest first, so that no worker is left alone with one at the end.
        ordered = sorted(missing, key=lambda job: -job.cost)
        with closing(engine(ordered)) as results:  # type: ignore[type-var]
            for result in results:
                journal.add(result)
                for job in by_key[result.key]:
                    done(job)
    return [journal.results[job.key] for job in jobs]


def local(workers: int) -> Engine:
    """An engine of so many processes on this machine."""

    def run_all(jobs: Sequence[Job]) -> Iterator[Result]:
        before = set(active_children())
        pool = ProcessPoolExecutor(min(workers, len(jobs)), get_context("spawn"), initializer=_settle)
        try:
            with _deaf_to_interrupts():
                futures = {pool.submit(simulate, job): job for job in jobs}
            for future in as_completed(futures):
                try:
                    yield future.result()
                except BrokenProcessPool:
                    raise StudyError("a worker process died; run the study again to go on where it stopped") from None
                except EchelonError:
                    raise
                except Exception as error:
                    raise _failed(futures[future], error) from error
        except BaseException:  # Ctrl-C and closing too: nobody waits for what is still flying
            pool.shutdown(wait=False, cancel_futures=True)
            for child in set(active_children()) - before:
                child.terminate()
            raise
        finally:
            pool.shutdown()

    return run_all


@contextmanager
def _deaf_to_interrupts() -> Iterator[None]:
    """Processes started in here ignore Ctrl-C, which reaches every process of a terminal: the launcher decides."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def _settle() -> None:
    """A worker ends with its launcher, however that ends, and says nothing about it."""
    launcher = parent_process()
    if launcher is not None:
        threading.Thread(target=_outlive, args=(launcher.sentinel,), daemon=True).start()


def _outlive(launcher: int) -> None:
    wait([launcher])
    os._exit(1)


def cluster(address: str) -> Engine:
    """An engine of the workers of a Dask cluster, by the address of its scheduler.

    The workers need this project installed, in the same version.

    Raises:
        EchelonError: Dask is not installed.
    """
    try:
        dask: Any = import_module("distributed")  # optional, and slow to import
    except ImportError:
        raise StudyError(
            f"--cluster: expected Dask to be installed; got none (python -m pip install distributed=={DASK_VERSION})"
        ) from None

    def run_all(jobs: Sequence[Job]) -> Iterator[Result]:
        try:
            client = dask.Client(address, timeout=CONNECT_SECONDS)
        except (OSError, ValueError) as error:
            reason = str(error).splitlines()[0] if str(error) else type(error).__name__
            raise StudyError(f"--cluster: expected a Dask scheduler at {address}; got none ({reason})") from None
        with client:
            if not client.scheduler_info()["workers"]:
                raise StudyError(f"--cluster: expected workers at {address}; got none (start dask worker {address})")
            futures = client.map(simulate, jobs, pure=False)
            of = dict(zip(futures, jobs, strict=True))
            try:
                for future in dask.as_completed(futures):
                    try:
                        yield future.result()
                    except EchelonError:
                        raise
                    except Exception as error:
                        raise _failed(of[future], error) from error
            finally:
                client.cancel(futures)

    return run_all


def _failed(job: Job, error: Exception) -> StudyError:
    text = str(error).splitlines()[0] if str(error) else ""
    return StudyError(f"the flight {words(job.cell)}, seed {job.seed} failed: {type(error).__name__}: {text}")
