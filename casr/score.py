"""From the frames of a press to its contact area spread rate: frames -> initial area -> flow -> area -> rate."""

from __future__ import annotations

import platform
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from casr import __version__
from casr.contact_area import InitialArea
from casr.errors import FramesError
from casr.flow.estimate import FlowSettings
from casr.flow.region import Region
from casr.frames import FrameSequence, LoadingPhase, loading_phase
from casr.pins import Pins
from casr.press_scorer import PressScorer
from casr.spread import SpreadRate
from casr.touch import loading_by_pins
