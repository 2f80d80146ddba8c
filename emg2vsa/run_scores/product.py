"""What is known of a run once it is scored: one specimen, angle and condition, pressed a number of times."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import Floats, Ints

ALGORITHMS = ("front", "edge", "hexagon", "circle", "paper")
"""Vision algorithms: the contact's front followed in every frame (default); the growth of the skin that is in contact
first, with its initial area by the edge of contact, by hexagons or by a circle (previous work), measured as the run's
algorithm measures it; and the paper's, whole: ``emg2vsa.settings.RECIPES``."""

PICTURED_N = 1.0
"""Force at which the contacts of different runs are shown side by side, N."""

_NUMBER = re.compile(r"\d+(\.\d+)?")


@dataclass(frozen=True, eq=False)
class PressCurve:
    """The loading phase of one press.

    force_n, area_mm2 : (T,) per frame whose area is determined, by the run's algorithm, its area law and force rule;
    area in px2 without a camera file. Empty where an area is above that of the pin array. first_n : force of the first
    frame of the loading phase, determined or not. Equation (2) puts 0 in place of the first force. travel_force_n,
    travel_mm : (K,) force, and travel of the shaft, of the rows of the rig's log from the approach on; empty without
    one.
    stretch_force_n, stretch_log_ratio, stretch_log_sd : how the skin of first contact grew against the contact, as
    ``casr.doubts.Stretch``; empty where the front is not determined.
    """

    force_n: Floats
    area_mm2: Floats
    first_n: float = np.nan
    travel_force_n: Floats = field(default_factory=lambda: np.empty(0))
    travel_mm: Floats = field(default_factory=lambda: np.empty(0))
    stretch_force_n: Floats = field(default_factory=lambda: np.empty(0))
    stretch_log_ratio: Floats = field(default_factory=lambda: np.empty(0))
    stretch_log_sd: float = np.nan


@dataclass(frozen=True, eq=False)
class ContactPicture:
    """The frame of a run that was taken nearest to ``PICTURED_N``, for people to look at.

    image : (H, W) uint8. force_n : of this frame. outline_px : (K, 2) of the area that the algorithm finds in it.
    area_mm2 : within the outline, in px2 without a camera file.
    """

    image: NDArray[np.uint8]
    force_n: float
    outline_px: Floats
    area_mm2: float


@dataclass(frozen=True, eq=False)
class FirstContact:
    """What Algorithm 1 sees of one press, for people to look at.

    repetition : of the press. frames : (3, H, W) uint8, at rest, the first in contact and the next. force_n : (2,) of
    the last two. rest_px, contact_px : (N, 2) pins of the first two, NaN where lost. selected : (n,) rows of those that
    it counts.
    """

    repetition: int
    frames: NDArray[np.uint8]
    force_n: Floats
    rest_px: Floats
    contact_px: Floats
    selected: Ints


@dataclass(frozen=True, eq=False)
class PressPins:
    """The pins of one press in its loaded frames: what ``casr.kappa`` tells stiffness from.

    rest_px : (N, 2). pins_px : (T, N, 2), NaN where lost. force_n : (T,). force_zero_sd_n : N, of the force's zero.
    """

    rest_px: Floats
    pins_px: Floats
    force_n: Floats
    force_zero_sd_n: float


@dataclass(frozen=True)
class WeighedPress:
    """Press number ``press`` in the folder of a run, and the stiffness of its specimen by force over depth of it alone.

    specimen, stated_n_per_mm : the plan's; NaN where it states none. kappa_n_per_mm : with its 95 % interval; NaN where
    the press tells none, high inf where the specimen may be rigid. verdict : ok, doubtful, rejected, or ended.
    """

    folder: str
    press: int
    specimen: str
    stated_n_per_mm: float
    kappa_n_per_mm: float
    low_n_per_mm: float
    high_n_per_mm: float
    verdict: str
    why: str

    @property
    def said(self) -> str:
        """In plain words."""
        if self.why:
            return self.why
        if math.isnan(self.kappa_n_per_mm):
            return "too short to tell the specimen"
        return "nothing stated to compare with" if math.isnan(self.stated_n_per_mm) else f"presses like {self.specimen}"


@dataclass(frozen=True, eq=False)
class RunScores:
    """R presses of one run; a press that could not be scored has NaN numbers and its reason.

    algorithm : the vision algorithm whose scores count; the others are companions. repetitions : (R,). mounting : (R,)
    number, from 1, of the mounting that a press belongs to: each folder is one, unless the rig says that it goes on.
    pressed_at : (R,) when its folder was begun: s since 1970 on the rig, place in the experiment of an emulated rig or
    by a table of runs, NaN where nothing tells.
    verdicts : "ok" or "rejected". reasons : empty where ok. pins_selected : (R,) n of Algorithm 1 with centroids paired
    one to one in the first frame of the loading phase by the recipe "paper", of rejected presses too; -1 where it is
    not determined. first_n : (R,) force of that frame, N, NaN where it is not determined.
    a_c0, start_area, casr : algorithm to (R,), in ``area_unit``, ``area_unit`` and ``area_unit``/N; by rate "paper"
    casr is a sum over frames. a_c0 is the area of the first frame of the loading phase, whose force differs from press
    to press (front: on the power law of the frames in which it is determined); start_area is the area at the force
    where the phase begins, on the power law of the press (where the rate is by none: a_c0). casr is NaN where an area
    is above that of the pin array; over_array is then the largest area over that of the array, else NaN. true_a_c0 :
    (R,) mm2, NaN unless simulated.
    indent_n_per_mm : (R,) slope of force over shaft travel, the kinesthetic cue; NaN without a log. peak_n : (R,)
    largest force along the push axis, N, beyond the force of turning back too; NaN without presses.csv. curves : R.
    simulated : the run was emulated. over_bytes : False where drivers of an emulated rig skipped the wire. setup : how
    its folders say that it was made, such as ``f_max_n``, ``rate_hz`` of the control loop, ``frame_rate_hz``: each
    value once. first_contact : of the first press in which Algorithm 1 finds pins. notes : once each. weighed :
    presses of the rig by their own files, those without a score among them. pins : R, of the presses that kappa can be
    told from by their pins. camera : that they were seen by, as the arguments of ``casr.camera.Camera``; empty without.
    """

    specimen: str
    angle_deg: float
    condition: str
    simulated: bool
    algorithm: str
    repetitions: Ints
    mounting: Ints
    pressed_at: Floats
    verdicts: tuple[str, ...]
    reasons: tuple[str, ...]
    area_unit: str
    pins_selected: Ints
    first_n: Floats
    a_c0: dict[str, Floats]
    start_area: dict[str, Floats]
    casr: dict[str, Floats]
    over_array: dict[str, Floats]
    true_a_c0: Floats
    indent_n_per_mm: Floats
    peak_n: Floats
    curves: tuple[PressCurve, ...]
    picture: ContactPicture | None
    first_contact: FirstContact | None
    notes: tuple[str, ...]
    setup: dict[str, tuple[float, ...]] = field(default_factory=dict)
    over_bytes: bool = True
    weighed: tuple[WeighedPress, ...] = ()
    pins: tuple[PressPins | None, ...] = ()
    camera: dict[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        usable = self.verdicts.count("ok")
        casr = self.casr.get(self.algorithm, np.array([]))
        told = (
            f", median CASR {np.nanmedian(casr):.4g} {self.area_unit}/N by {self.algorithm}"
            if np.isfinite(casr).any()
            else ""
        )
        return f"RunScores({self.name}: {usable} of {len(self.verdicts)} presses scored{told})"

    @property
    def name(self) -> str:
        """Specimen, angle and condition in one word, as the run's folder is called."""
        return f"{self.specimen}_{self.angle_deg:g}_{self.condition}"

    @property
    def most_frequent_reason(self) -> str:
        """The reason for which most presses were rejected, in the words of the first of them; empty where none was.

        Presses and numbers aside, reasons that say the same are one.
        """
        kinds: dict[str, list[str]] = {}
        for reason in filter(None, self.reasons):
            where, colon, why = reason.partition(": expected ")
            kinds.setdefault(_NUMBER.sub("#", why if colon else where), []).append(reason)
        return max(kinds.values(), key=len)[0] if kinds else ""
