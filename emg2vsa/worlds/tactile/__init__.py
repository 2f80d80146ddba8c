"""Rendered presses with known contact area and force."""

from emg2vsa.worlds.tactile.appearance import (
    TACTIP_127,
    Appearance,
    Skin,
    Surface,
    draw_surface,
    drawn,
    exposed,
    read_noise,
)
from emg2vsa.worlds.tactile.contact import ContactWorld, lever, spread
from emg2vsa.worlds.tactile.files import SCATTERS, PressPlan, write_press, write_presses
from emg2vsa.worlds.tactile.press import (
    PressTruth,
    Scene,
    SimulatedFrames,
    SimulatedPress,
    casr_truth,
    make_timeline,
    simulate_press,
)
from emg2vsa.worlds.tactile.settings import REALISTIC, Drawn, PressSettings, Scatter, TimelineSettings
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld, tabulated
from emg2vsa.worlds.tactile.world import ContactEllipse, ContactState, Points, Rim, World

__all__ = [
    "REALISTIC",
    "SCATTERS",
    "TACTIP_127",
    "Appearance",
    "ContactEllipse",
    "ContactState",
    "ContactWorld",
    "Drawn",

    "Points",
    "PressPlan",
    "PressSettings",
    "PressTruth",
    "Rim",
    "Scatter",
    "Scene",
    "SimulatedFrames",
    "SimulatedPress",
    "Skin",
    "Surface",
    "TabulatedWorld",
    "TimelineSettings",
    "World",
    "casr_truth",
    "draw_surface",
    "drawn",
    "exposed",
    "lever",
    "make_timeline",
    "read_noise",
    "simulate_press",
    "spread",
    "tabulated",
    "write_press",
    "write_presses",
]  # fmt: skip
