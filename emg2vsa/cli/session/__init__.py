"""``emg2vsa session``: a participant's session."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from casr.command_line import Commands, add_group

SUBCOMMANDS = {"run": "live", "form": "recorded", "finish": "recorded", "replay": "recorded", "emulate": "live"}
PARTICIPANT = """--participant CODE  a code of [participants]: P03
--visit LABEL  one of [recordings] visits, where participants come more than once
"""
REQUIRED = {"required": True}


def add_to(commands: Commands) -> None:
    parser = add_group(
        commands,
        "session",
        "A participant's session: acquired, judged and saved while it runs.",
        "emg2vsa.cli.session",
        SUBCOMMANDS,
        "emg2vsa session STUDY is short for emg2vsa session run STUDY. Try: emg2vsa session "
        "studies/palpation/study.toml --participant P03 --virtual. docs/how-to/session.md leads through a session.",
    )
    parse = parser.parse_known_args

    def parse_known_args(words: Any = None, namespace: Any = None) -> Any:
        """A study file in the place of a command is run; a bare word is a command, if a misspelt one."""
        word = words[0] if words else "-"
        known = word in SUBCOMMANDS or word.startswith("-")
        is_study = not known and (Path(word).suffix or Path(word).exists())
        return parse(["run", *words] if is_study else words, namespace)

    parser.parse_known_args = parse_known_args
