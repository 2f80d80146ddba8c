"""Rendered presses with known flow, contact area and force."""

from casr.synthetic.appearance import Appearance
from casr.synthetic.contact import ContactWorld
from casr.synthetic.flow_pairs import FlowPair, contact_pair, linear_pair
from casr.synthetic.press import SimulatedFrames, SimulatedPress, simulate_press
from casr.synthetic.region import ContactEllipse
from casr.synthetic.scene import Scene
from casr.synthetic.settings import PressSettings, TimelineSettings
from casr.synthetic.skin import TACTIP_127, TACTIP_331, Skin
from casr.synthetic.truth import PressTruth, casr_truth
from casr.synthetic.write import write_press

__all__ = [
    "TACTIP_127",
    "TACTIP_331",
    "Appearance",
    "ContactEllipse",
    "ContactWorld",
    "FlowPair",
    "PressSettings",
    "PressTruth",
    "Scene",
    "SimulatedFrames",
    "SimulatedPress",
    "Skin",
    "TimelineSettings",
    "casr_truth",
    "contact_pair",
    "linear_pair",
    "simulate_press",
    "write_press",
]
