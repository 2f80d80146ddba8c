"""The rig file's schema for editors and its reference for people, from the classes of its tables."""

from __future__ import annotations

from typing import Any

from emg2vsa.rig import device_settings, experiment, guards, rig_settings
from emg2vsa.rig.emulated import settings as emulated
from emg2vsa.rig_file import tables
from emg2vsa.study_file.reference import markdown
from emg2vsa.study_file.schema import schema_of

_MODULES = (tables, rig_settings, guards, device_settings, experiment, emulated)


def json_schema() -> dict[str, Any]:
    """The schema of a rig file, in Draft 4."""
    return schema_of(tables.RigTables, _MODULES)


def reference() -> str:
    """The reference of the rig file, as Markdown."""
    return markdown(json_schema(), _HEAD, {})


_HEAD = """\
# The rig file

Written by `python -m emg2vsa.rig_file`; do not edit.

A rig file is TOML and lies beside the study file. Every problem in it is reported at once, as
`file:line: key: wanted ...; found ...`. Unknown keys are errors. Units are part of the names. Relative paths start at
the folder of the rig file; `~` and environment variables are not expanded. Ticks are those of the qbmove, 32768 to a
turn of its shaft. What each guard means: [how-to/engineer.md](../how-to/engineer.md). An editor that knows TOML schemas
checks the file as you type, if its first line is `#:schema ../rig.schema.json`."""
