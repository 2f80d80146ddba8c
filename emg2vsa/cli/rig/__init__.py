"""``emg2vsa rig``: the rig, real or emulated; one file per sub-command."""

from __future__ import annotations

from casr.command_line import Commands, add_subcommands

SUBCOMMANDS = (
    "scan", "info", "commission", "prove-watchdog", "dry-run", "run", "next", "watch", "off", "home", "jog", "tare",
    "zero", "parameters", "camera-delay", "emulate",
)  # fmt: skip


def add_to(commands: Commands) -> None:
    summary = "The rig that presses specimens with an actuator: look for it, ask it, let it run; or emulate it."
    parser = commands.add_parser(
        "rig",
        help=summary,
        description=summary,
        epilog="Try: emg2vsa rig dry-run studies/palpation/rig.toml, then emg2vsa rig run studies/palpation/rig.toml "
        "--virtual. The rig file describes the rig (docs/reference/rig-file.md).",
    )
    add_subcommands(parser, "emg2vsa.cli.rig", SUBCOMMANDS)
