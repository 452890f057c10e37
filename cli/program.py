"""What makes this process the program: what it imports, its streams, its signals, and nothing said by libraries.

A test or a notebook that calls a command keeps its own.
"""

import signal
import sys

from cli.own_path import use_own_path


def begin() -> None:
    """Call before anything else is imported."""
    die_of_interrupts()  # while it imports there is nothing to tidy up, and nothing to say
    use_own_path()
    import logging  # noqa: PLC0415  from the right path
    import warnings  # noqa: PLC0415

    from runtime.streams import open_streams  # noqa: PLC0415

    open_streams(results=True)
    logging.disable(logging.WARNING)  # of libraries: what concerns the user is printed
    if not sys.warnoptions:
        warnings.simplefilter("ignore")


def die_of_interrupts() -> None:
    """From now on Ctrl-C ends the program without a word."""
    _on_interrupt(signal.SIG_DFL)
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGINT})  # blocked by ./echelon while Python starts


def raise_interrupts() -> None:
    """From now on Ctrl-C is a KeyboardInterrupt."""
    _on_interrupt(signal.default_int_handler)


def _on_interrupt(handler: object) -> None:
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:  # of a shell that started it in the background
        signal.signal(signal.SIGINT, handler)  # type: ignore[arg-type]
