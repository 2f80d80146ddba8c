"""A rig file of two specimens under the rigid motor, which needs no schedules; its devices are nowhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from emg2vsa import rig
from emg2vsa.rig_file import RigFile

RIG = """\
[actuator]
port = "/dev/no-such-port"

[motor]
port = "/dev/no-such-motor"

[force]
kind = "net-ft"
host = "127.0.0.1"

[experiment]
specimens = ["S1", "S3"]
angles_deg = { high-stiffness = [0] }
repetitions = 1
f_max_n = 4
ramp_mm_per_s = 8
pause_s = 0.1

[plate]
trials = 1
ramp_mm_per_s = 8
pause_s = 0.1

[emulated]
world = "elastic"
"""


@pytest.fixture
def file(tmp_path: Path) -> RigFile:
    path = tmp_path / "rig.toml"
    path.write_text(RIG)
    return rig.load(path)
