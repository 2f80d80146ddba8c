"""A newcomer's guess: each equation, figure, table and algorithm of the paper is where its name says."""

from __future__ import annotations

import importlib

import numpy as np
import pytest

from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.springs import SpringJoint
from emg2vsa.schedules.build import stiffness_percent

PLACES = {
    "equation (1), area from divergence": ("casr.spread.area_law", "", r"eq. 1"),
    "equation (2), the spread rate": ("casr.spread.rate", "spread_rate", r"eq. (2)"),
    "equation (3), the hexagon of a pin": ("casr.contact_area.rules", "lattice_cell", r"eq. (3)"),
    "equation (4), the camera matrix": ("casr.camera", "Camera.matrix", r"eq. (4)"),
    "equation (5), pixels to mm": ("casr.camera", "Camera.mm_per_px", r"eq. (5)"),
    "equation (6), the logarithmic law": ("emg2vsa.curves.logarithmic", "", r"equation 6"),
    "equation (6), as a stage": ("emg2vsa.fits", "", r"equation (6)"),
    "equation (7), co-contraction to stiffness": ("emg2vsa.schedules.build", "stiffness_percent", r"Equation (7)"),
    "equation (8), motors to position and preset": (
        "emg2vsa.devices.qbmove.springs",
        "SpringJoint.position_deg",
        r"Equation (8)",
    ),
    "Algorithm 1, the initial area": ("casr.contact_area.rules", "paper_rule", r"Algorithm 1"),
    "figure 2, steps of Algorithm 1": ("emg2vsa.figures.algorithm_1", "", r"Figure 2"),
    "figure 4, co-contraction": ("emg2vsa.figures.cocontraction", "", r"Figure 4"),
    "figure 5, schedules": ("emg2vsa.figures.cocontraction", "", r"Figure 5"),
    "figure 8, initial areas": ("emg2vsa.figures.casr", "", r"Figure 8"),
    "figure 9, contacts": ("emg2vsa.figures.casr", "", r"Figure 9"),
    "figures 10, 12 and 13, rates": ("emg2vsa.figures.casr", "", r"Figures 10, 12 and 13"),
    "figure 11, the interpolated profile": ("emg2vsa.figures.cocontraction", "", r"Figure 11"),
    "figure 14, conditions": ("emg2vsa.figures.casr", "", r"Figure 14"),
    "Table I, stiffness of the new specimen": ("emg2vsa.report.sections.table_one", "", r"Table I"),
    "weight kappa/10 of the softer neighbour": ("emg2vsa.profiles", "", r"kappa / 10"),
    "spikes of EMG": ("emg2vsa.signals.spikes", "", r"spikes"),
}
"""Thing to the module that a newcomer looks in, the object there, and what its docstring cites."""


@pytest.mark.parametrize("thing", PLACES)
def test_the_first_guess_is_right(thing: str) -> None:
    module, name, cited = PLACES[thing]
    found = importlib.import_module(module)
    for part in filter(None, name.split(".")):
        found = getattr(found, part)
    assert cited in (found.__doc__ or "")


def test_equation_7_maps_the_ends_and_the_middle() -> None:
    percent = stiffness_percent([1e-6, 2e-6, 3e-6, 4e-6], (1e-6, 3e-6), (10.0, 60.0))
    np.testing.assert_allclose(percent, [10, 35, 60, 60], rtol=1e-12)


def test_equation_8_goes_there_and_back() -> None:
    joint = SpringJoint("qbmove-maker-pro", 32.0)
    assert joint.targets_deg(10.0, 3 / 32) == (13.0, 7.0)
    for position_deg, preset, motors_deg in ((10.0, 3 / 32, (13.0, 7.0)), (-0.5, 0.75, (23.5, -24.5))):
        at = Measurements(motors_deg, 0.0)
        assert joint.targets_deg(position_deg, preset) == motors_deg
        assert (joint.position_deg(at), joint.preset_at(at)) == (position_deg, preset)
