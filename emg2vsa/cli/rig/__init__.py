"""``emg2vsa rig``: the rig, real or emulated."""

from __future__ import annotations

from casr.command_line import Commands, add_group

SUBCOMMANDS = {
    "scan": "devices", "info": "devices", "commission": "measured", "prove-watchdog": "by_hand", "dry-run": "planned",
    "run": "run", "next": "planned", "watch": "watch", "off": "by_hand", "home": "by_hand", "jog": "by_hand",
    "tare": "by_hand", "zero": "by_hand", "parameters": "by_hand", "camera-delay": "measured", "emulate": "devices",
}  # fmt: skip
"""Each in the order of the help, to the file that it is in."""


def add_to(commands: Commands) -> None:
    summary = "The rig that presses specimens with an actuator: look for it, ask it, let it run; or emulate it."
    epilog = (
        "Try: emg2vsa rig dry-run studies/palpation/rig.toml, then emg2vsa rig run studies/palpation/rig.toml "
        "--virtual. The rig file describes the rig (docs/reference/rig-file.md)."
    )
    add_group(commands, "rig", summary, "emg2vsa.cli.rig", SUBCOMMANDS, epilog)
