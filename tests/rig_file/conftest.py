"""A small rig file, and a way to change it and see what is said of it."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.rig_file import RigFile, load_rig

SMALL = """\
[actuator]
port = "/dev/ttyUSB0"

[motor]
port = "/dev/ttyUSB1"

[force]
kind = "net-ft"
host = "192.168.1.1"

[experiment]
specimens = ["S1", "S3"]

[emulated]
"""


@pytest.fixture
def small() -> str:
    return SMALL


@pytest.fixture
def load(tmp_path: Path) -> Callable[[str], RigFile]:
    """The rig of a text, loaded from ``<tmp>/studies/small/rig.toml``."""

    def load_text(text: str) -> RigFile:
        path = tmp_path / "studies" / "small" / "rig.toml"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return load_rig(path)

    return load_text


@pytest.fixture
def problems(load: Callable[[str], RigFile]) -> Callable[[str], list[str]]:
    """What is said of a text, each line without the path before its line number."""

    def problems_of(text: str) -> list[str]:
        with pytest.raises(StudyError) as caught:
            load(text)
        return [line.partition("rig.toml:")[2] for line in caught.value.problems]

    return problems_of
