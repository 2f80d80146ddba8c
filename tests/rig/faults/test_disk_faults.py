"""The disk fails: real executor, drivers and bytes, emulated devices and clock."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from benchmarks.rig.fault_case import PHASES
from benchmarks.rig.faults import DISK_FAULTS

Check = Callable[[str, str], None]


@pytest.mark.parametrize("name", DISK_FAULTS)
def test_while_loading(name: str, check: Check) -> None:
    check(name, "load")


@pytest.mark.slow
@pytest.mark.parametrize("phase", [phase for phase in PHASES if phase != "load"])
@pytest.mark.parametrize("name", DISK_FAULTS)
def test_in_every_other_phase(name: str, phase: str, check: Check) -> None:
    check(name, phase)
