"""Columns of activities: volts for programs, a readable unit for people."""

from __future__ import annotations

from emg2vsa.figures.activity_scale import ActivityScale
from emg2vsa.report.table import Column


def activity_column(key: str, name: str, scale: ActivityScale) -> Column:
    """Column of activities: volts in CSV, ``scale``'s unit for people; without ``_v`` where it is not in volts."""
    return Column(key, scale.label(name), scale.factor, name="" if scale.unit else key.removesuffix("_v"))
