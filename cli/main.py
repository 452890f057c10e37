"""The console script: finds the command and runs it; a mistake of the user is one line and exit code 2."""

import argparse
import importlib
import re
import sys
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, NoReturn

from cli import program

COMMANDS = {
    "up": "start a live run: its processes and the dashboard",
    "run": "simulate a scenario without a page and print its measures",
    "study": "simulate a grid of trials, with statistics and figures",
    "join": "run agents of a run on another host",
    "invite": "print a code for somebody on another host",
    "fault": "set and clear faults of a live run's links",
    "paper": "repeat the tests of the paper and write a report",
    "control": "start, pause, step, reset, speed up or stop a live run",
    "status": "print the state of a live run",
    "robots": "list the robots of ROS 2 at a router",
    "recording": "look into a record, repair it, export its tables",
    "replay": "show a record on the page, or two as run and ghost",
    "verify": "simulate a record again and compare every bit",
    "scenarios": "list the scenarios, or the keys of a scenario",
    "schema": "print the JSON schema of scenario files",
    "new": "write a controller of your own to begin with, and its test",
    "compose": "print a compose file for a scenario",
    "doctor": "check what a run needs",
    "completion": "print a script for the shell's completion",
}
"""Every command is a module of this room with `arguments(parser)` and `run(options)`."""
LIVE = {"up", "join", "invite", "fault", "control", "status"}
"""The modules of cli/live/."""


class _Parser(argparse.ArgumentParser):
    """A parser whose error message is one line, and to which a minus and a digit begin a value: no option does so."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        """As argparse's own, which takes -2e-2, -5ms and -5% for options."""
        super().__init__(*args, **kwargs)
        self._negative_number_matcher = re.compile(r"-(\.?\d|inf|nan)")
        for kind, words in ((int, "a whole number"), (float, "a number")):
            self.register("type", kind, partial(_number, kind, words))

    def error(self, message: str) -> NoReturn:
        """Print what is wrong and exit with code 2."""
        print(f"{self.prog}: {message} ({self.prog} --help)", file=sys.stderr)
        sys.exit(2)


def _number(kind: Callable[[str], float], words: str, text: str) -> float:
    try:
        return kind(text)
    except ValueError:
        raise argparse.ArgumentTypeError(f"expected {words}; got {text!r}") from None


def main(arguments: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: of the command; None: this process is the program, and they are its own.

    Returns:
        0; 2 for a mistake of the caller, or if something outside prevents it; 130 after Ctrl-C; or what the command
        returns.
    """
    if arguments is not None:
        return _run(list(arguments), as_program=False)
    program.begin()
    try:
        return _run(sys.argv[1:], as_program=True)
    finally:
        program.die_of_interrupts()


def _run(words: Sequence[str], *, as_program: bool) -> int:
    errors = importlib.import_module("formation.errors")
    streams = importlib.import_module("runtime.streams")
    try:
        if _starts_processes(words):
            importlib.import_module("runtime.fork_server").start_early()
        words = [_whole(word, words) for word in words]
        options = _commands(words[:1]).parse_args(words)  # only this command's module is imported: some are slow to
        module = importlib.import_module(_module(options.command))
        if as_program:
            program.raise_interrupts()
        code = int(module.run(options) or 0)
        sys.stdout.flush()
        return code
    except streams.ReaderGoneError:  # `echelon scenarios --keys | head`
        return 0
    except (errors.EchelonError, OSError) as error:  # a full disk, too few open files: nothing that we could mend
        for line in (str(error) or type(error).__name__).splitlines():
            print(f"echelon {next(iter(words), '')}: {line}", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


def _whole(word: str, words: Sequence[str]) -> str:
    """--record alone has no value: a scenario that follows is not its file."""
    return "--record=" if word == "--record" and words[0] in ("up", "run") else word


def whole_parser() -> argparse.ArgumentParser:
    """The parser with the arguments of all commands."""
    return _commands(list(COMMANDS))


def _commands(wanted: Sequence[str]) -> argparse.ArgumentParser:
    """All commands, and the arguments of some."""
    parser = _Parser(prog="echelon", description="Formations of wheeled robots with a controller process each.")
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    for name, text in COMMANDS.items():
        command = commands.add_parser(name, help=text, description=f"{text[0].upper()}{text[1:]}.")
        if name in wanted:
            importlib.import_module(_module(name)).arguments(command)
    return parser


def _module(command: str) -> str:
    return f"cli.live.{command}" if command in LIVE else f"cli.{command}"


def _starts_processes(words: Sequence[str]) -> bool:
    """Whether the command will start a run's processes, as its bare words tell: a wrong guess costs time only."""
    if not {"-h", "--help"}.isdisjoint(words):
        return False
    return words[:1] in (["up"], ["join"]) or (
        words[:1] == ["run"] and {"inprocess", "--engine=inprocess"}.isdisjoint(words)
    )


if __name__ == "__main__":
    sys.exit(main())
