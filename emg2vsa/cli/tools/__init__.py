"""``emg2vsa tools``: what is needed now and then."""

from __future__ import annotations

from casr.command_line import Commands, add_group

SUBCOMMANDS = {
    "convert": "data", "sample": "data", "simulate": "data", "clean": "upkeep", "power": "sizes", "design": "sizes",
    "stiffness": "softness", "cast": "softness", "bench": "upkeep", "completion": "upkeep",
}  # fmt: skip


def add_to(commands: Commands) -> None:
    summary = (
        "Sample and synthetic data, BIDS, softness of specimens, sample sizes, clearing up, benchmarks, completion."
    )
    epilog = "Try: emg2vsa tools simulate studies/palpation/study.toml"
    add_group(commands, "tools", summary, "emg2vsa.cli.tools", SUBCOMMANDS, epilog)
