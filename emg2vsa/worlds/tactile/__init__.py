"""Rendered presses with known contact area and force."""

from emg2vsa.worlds.tactile.appearance import Appearance
from emg2vsa.worlds.tactile.contact import ContactWorld
from emg2vsa.worlds.tactile.plan import PressPlan, write_presses
from emg2vsa.worlds.tactile.press import SimulatedFrames, SimulatedPress, simulate_press
from emg2vsa.worlds.tactile.region import ContactEllipse
from emg2vsa.worlds.tactile.scatter import REALISTIC, Drawn, Scatter
from emg2vsa.worlds.tactile.scene import Scene
from emg2vsa.worlds.tactile.settings import PressSettings, TimelineSettings
from emg2vsa.worlds.tactile.skin import TACTIP_127, Skin
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld
from emg2vsa.worlds.tactile.truth import PressTruth, casr_truth
from emg2vsa.worlds.tactile.world import ContactState, World
from emg2vsa.worlds.tactile.write import write_press

__all__ = [
    "REALISTIC",
    "TACTIP_127",
    "Appearance",
    "ContactEllipse",
    "ContactState",
    "ContactWorld",
    "Drawn",
    "PressPlan",
    "PressSettings",
    "PressTruth",
    "Scatter",
    "Scene",
    "SimulatedFrames",
    "SimulatedPress",
    "Skin",
    "TabulatedWorld",
    "TimelineSettings",
    "World",
    "casr_truth",
    "simulate_press",
    "write_press",
    "write_presses",
]
