"""`echelon schema`: the JSON schema of scenario files, for editors."""

import argparse
import json

from formation.scenario.json_schema import json_schema


def arguments(parser: argparse.ArgumentParser) -> None:
    """What the command accepts."""
    parser.epilog = (
        "echelon schema > scenario.schema.json; a TOML file whose first line is #:schema ./scenario.schema.json "
        "is then completed and checked by editors that know JSON schemas (Even Better TOML, taplo)."
    )


def run(options: argparse.Namespace) -> None:
    """Print it."""
    print(json.dumps(json_schema(), indent=2))
