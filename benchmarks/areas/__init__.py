"""The areas of ``emg2vsa tools bench``: a file each, which gives ``AREA``. To add one, write it and add its name."""

from __future__ import annotations

from importlib import import_module

from benchmarks.bench.case import Area

NAMES = (
    "readers",
    "conditioning",
    "segmentation",
    "records",
    "fits",
    "tests",
    "calibration",
    "pins",
    "flow",
    "growth",
    "area",
    "scoring",
    "rig",
    "runs",
)


def area(name: str) -> Area:
    """The area of a name of ``NAMES``; only its own file is loaded."""
    found = import_module(f"benchmarks.areas.{name}").AREA
    assert isinstance(found, Area)
    assert found.name == name
    return found
