"""``emg2vsa rig``: the rig, real or emulated; one file per sub-command."""

from __future__ import annotations

import importlib

from emg2vsa.cli.arguments import Commands

SUBCOMMANDS = ("scan", "info", "dry-run", "run", "emulate", "watch")


def add_to(commands: Commands) -> None:
    summary = "The rig that presses specimens with a qbmove: look for it, ask it, let it run; or emulate it."
    parser = commands.add_parser(
        "rig",
        help=summary,
        description=summary,
        epilog="Try: emg2vsa rig dry-run studies/palpation/rig.toml, then emg2vsa rig run studies/palpation/rig.toml "
        "--virtual. What a rig is made of stands in its rig file (docs/reference/rig-file.md).",
    )
    subcommands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name in SUBCOMMANDS:
        importlib.import_module(f"emg2vsa.cli.rig.{name.replace('-', '_')}").add_to(subcommands)
