"""Rendered presses with known contact area and force."""

from casr.synthetic.appearance import Appearance
from casr.synthetic.contact import ContactWorld
from casr.synthetic.press import SimulatedFrames, SimulatedPress, simulate_press
from casr.synthetic.region import ContactEllipse
from casr.synthetic.scatter import REALISTIC, Drawn, Scatter
from casr.synthetic.scene import Scene
from casr.synthetic.settings import PressSettings, TimelineSettings
from casr.synthetic.skin import TACTIP_127, Skin
from casr.synthetic.tabulated import TabulatedWorld
from casr.synthetic.truth import PressTruth, casr_truth
from casr.synthetic.world import ContactState, World
from casr.synthetic.write import write_press

__all__ = [
    "REALISTIC",
    "TACTIP_127",
    "Appearance",
    "ContactEllipse",
    "ContactState",
    "ContactWorld",
    "Drawn",
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
]
