"""`echelon completion`: a script by which the shell completes commands, options and names."""

import argparse
from collections.abc import Iterable

from cli.main import whole_parser
from experiments.study import study
from formation.bodies.presets import PRESETS as BODIES
from formation.faults import PRESETS
from formation.scenario.files import shipped
from formation.scenario.registry import names

HOW = {
    "bash": "echelon completion bash > ~/.local/share/bash-completion/completions/echelon",
    "zsh": "echelon completion zsh > ~/.zfunc/_echelon   (with ~/.zfunc in fpath, before compinit)",
    "fish": "echelon completion fish > ~/.config/fish/completions/echelon.fish",
}
"""Where each shell looks for the script."""


VALUES = {
    "scenario": tuple(shipped()),
    "study": tuple(study.shipped()),
    "controller": names(),
    "faults": tuple(PRESETS),
    "bodies": tuple(BODIES),
}
"""What an option or argument may be, besides a file."""


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "\n".join(HOW.values())
    parser.add_argument("shell", choices=tuple(HOW))


def run(options: argparse.Namespace) -> None:
    """Print the script."""
    import shtab  # noqa: PLC0415  no other command needs it

    parser = whole_parser()
    for action in _actions(parser):
        if action.dest in VALUES:
            action.complete = _names_or_files(action.dest, VALUES[action.dest])  # type: ignore[attr-defined]
    print(shtab.complete(parser, options.shell))


def _actions(parser: argparse.ArgumentParser) -> Iterable[argparse.Action]:
    """Every option and argument, those of commands as well."""
    for action in parser._actions:  # argparse shows them nowhere else; shtab does the same
        yield action
        if isinstance(action, argparse._SubParsersAction):
            for command in action.choices.values():
                yield from _actions(command)


def _names_or_files(what: str, names: Iterable[str]) -> dict[str, str | dict[str, str]]:
    """As shtab has it: for each shell a call, and the function that it calls."""
    function, words = f"_echelon_{what}", " ".join(names)
    return {
        "bash": function,
        "zsh": f'_alternative "names:name:({words})" "files:file:_files -g \\"*.(#i)toml\\""',
        "fish": f"(echo {words} | string split ' '; __fish_complete_suffix .toml)",
        "preamble": {
            "bash": f'{function}() {{\n  compgen -W "{words}" -- "$1"\n  compgen -f -X "!*.[tT][oO][mM][lL]" -- "$1"\n'
            '  compgen -d -- "$1"\n}'
        },
    }
