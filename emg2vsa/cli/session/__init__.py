"""``emg2vsa session``: a participant's session; one file per sub-command."""

from __future__ import annotations

from casr.command_line import Commands, add_subcommands

SUBCOMMANDS = ("emulate",)


def add_to(commands: Commands) -> None:
    summary = "A participant's session: acquired, judged and saved while it runs."
    parser = commands.add_parser("session", help=summary, description=summary)
    add_subcommands(parser, "emg2vsa.cli.session", SUBCOMMANDS)
