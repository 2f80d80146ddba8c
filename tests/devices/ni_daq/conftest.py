"""A calibration whose gauges are the axes."""

from __future__ import annotations

from pathlib import Path

import pytest

CAL = """<?xml version="1.0" encoding="utf-8"?>
<FTSensor Serial="FT1" BodyStyle="Mini45" Family="DAQ" NumGages="6" CalFileVersion="1.1">
<Calibration PartNumber="SI-290-10" CalDate="1/1/2020" ForceUnits="N" TorqueUnits="N-m" DistUnits="m"
 OutputMode="Ground Referenced Differential" OutputRange="20" HWTempComp="True" GainMultiplier="1"
 CableLossDetection="False" OutputBipolar="True">
%s</Calibration></FTSensor>
"""


@pytest.fixture
def cal_file(tmp_path: Path) -> str:
    rows = "".join(
        f'<{tag} Name="{name}" values="{" ".join("1" if i == j else "0" for j in range(6))}" max="100" scale="1"/>'
        for tag in ("Axis", "UserAxis")
        for i, name in enumerate(("Fx", "Fy", "Fz", "Tx", "Ty", "Tz"))
    )
    rows += '<BasicTransform Dx="0" Dy="0" Dz="0" Rx="0" Ry="0" Rz="0"/>'
    path = tmp_path / "FT1.cal"
    path.write_text(CAL % rows)
    return str(path)
