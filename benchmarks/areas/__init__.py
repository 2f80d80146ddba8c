"""The areas of ``emg2vsa tools bench``: a file each, which gives ``AREA``, and one of the tactile side, which gives
them by name. To add one, write it and add its name."""

from __future__ import annotations

from importlib import import_module

from benchmarks.bench.case import Area

TACTILE = ("pins", "flow", "growth", "area", "scoring")
NAMES = (
    "readers", "conditioning", "segmentation", "records", "fits", "tests", "calibration", *TACTILE, "rig", "runs",
)  # fmt: skip


def area(name: str) -> Area:
    """The area of a name of ``NAMES``; only its own file is loaded."""
    file, variable = ("tactile", name.upper()) if name in TACTILE else (name, "AREA")
    found = getattr(import_module(f"benchmarks.areas.{file}"), variable)
    assert isinstance(found, Area)
    assert found.name == name
    return found
