"""How late the frames of a camera are, from presses: pins move when force rises, whatever the clock of the frames says.

A frame taken at t shows the pins under the force of then. So the force is shifted against the frames until the motion
of the pins is one smooth function of it, from rest through first contact. Contact is what tells: on a steady ramp
alone, a shift in time and another force law look alike.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.stats import t as student

from casr.errors import CasrError, PassingError
from casr.frame_files import open_frames, read_force_log
from casr.frame_files.folder import FORCE_FILE
from casr.frames import FrameSequence
from casr.pins.detect import detect_pins
from casr.pins.lattice import match_pins, pin_pitch_px
from emg2vsa.arrays import Floats
from emg2vsa.errors import RecordingError
from emg2vsa.rig.record.new_folder import PLAN_FILE

TO_N = 2.0
"""Frames up to this force are used: contact, and enough after it to know how pins follow force."""
FEWEST_PRESSES, FEWEST_AT_REST, FEWEST_TOUCHED = 3, 3, 5
SEARCH_S = 0.3
"""How far from the delay that is set already."""
SYSTEMATIC_S = 0.004
"""Error that more presses do not lessen: 2 ms on the emulated camera, up to 3.3 ms for other laws of pins and force."""
_STEP_S = 5e-4
_TOUCH_N = 0.1
_CONFIDENCE = 0.95
_ROUNDS = 3
_SMOOTH = 5
"""Readings of the force to average, half of them before the moment and half after: noise would be taken for contact."""
_EXPONENTS = np.arange(0.5, 1.65, 0.1)
"""Exponents of the motion of pins over force. More freedom than a power was tried, and let the shift drift by 10 to
20 ms.
"""


@dataclass(frozen=True)
class CameraDelay:
    """Time from exposure to arrival. delay_s : mean of the presses. half_width_s : of its 95 % confidence interval,
    to which ``SYSTEMATIC_S`` is to be added.
    """

    delay_s: float
    half_width_s: float
    by_press_s: tuple[float, ...]
    "Delays in the order of the presses that could be used."
    left_out: tuple[str, ...]
    "Why others could not."
    set_s: float
    "delay_s of the camera when the runs were recorded; it is part of the result."


def measure_delay(folders: Sequence[Path]) -> CameraDelay:
    """The delay from all presses of runs that were recorded with the same camera.

    RecordingError : not runs of a rig with a camera; recorded with different delays; too few presses that can be used.
    """
    set_s = {_delay_of(folder) for folder in folders}
    if len(set_s) != 1:
        found, do = ", ".join(f"{value:g} s" for value in sorted(set_s)), "Choose runs of one camera and one delay_s."
        raise RecordingError(folders[0], wanted="one delay_s of all runs", found=found, do=do)
    found_s: list[float] = []
    left_out: list[str] = []
    for press in (path for folder in folders for path in sorted(folder.glob("press-*"))):
        try:
            found_s.append(_shift_of_press(press))
        except (CasrError, PassingError, RecordingError) as error:
            left_out.append(f"{press.parent.name}/{press.name}: {error}")
    if len(found_s) < FEWEST_PRESSES:
        raise RecordingError(
            folders[0],
            wanted=f"{FEWEST_PRESSES} presses or more, each from before contact to {TO_N:g} N",
            found=f"{len(found_s)}" + (f" ({left_out[0]})" if left_out else ""),
            do="Press a soft specimen slowly, several times.",
        )
    (delay_s,) = set_s
    spread_s = float(np.std(found_s, ddof=1)) / len(found_s) ** 0.5
    half_width_s = float(student.ppf(0.5 + _CONFIDENCE / 2, len(found_s) - 1)) * spread_s
    total_s = [delay_s + each for each in found_s]
    return CameraDelay(float(np.mean(total_s)), half_width_s, tuple(total_s), tuple(left_out), delay_s)


def _shift_of_press(press: Path) -> float:
    # which frames show less than TO_N depends on the shift as well
    shift_s = 0.0
    for _ in range(_ROUNDS):
        shift_s = shift_of(*motion_and_force(press, shift_s))
    return shift_s


def motion_and_force(press: Path, shift_s: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Times of the frames as recorded (T,), s, and motion of the pins in them (T,), px; times (n,), s, and values of
    the force (n,), N.

    Of the frames up to ``TO_N``, were they taken ``shift_s`` (s) before they say. Motion is along the way that each pin
    has gone at ``TO_N``, so that noise has no sign.
    RecordingError, CasrError: the press lacks frames, times, forces, or what is needed of them.
    """
    frames, log = open_frames(press), read_force_log(press / FORCE_FILE)
    if log.time_s is None or log.frame_time_s is None:
        do = "Only presses recorded by emg2vsa rig run have them."
        raise RecordingError(press / FORCE_FILE, wanted="times of forces and frames", found="none", do=do)
    first = np.unique(log.frame_index, return_index=True)
    at = {int(index): float(log.frame_time_s[row]) for index, row in zip(*first, strict=True) if index >= 0}
    known = np.isfinite(log.force_n) & np.isfinite(log.time_s)
    force_s, force_n = log.time_s[known], log.force_n[known]
    used = [index for index in sorted(at) if np.isfinite(at[index]) and index < len(frames)]
    frame_s = np.array([at[index] for index in used])
    felt_n = np.interp(frame_s - shift_s, force_s, force_n)
    last = int(np.argmax(felt_n > TO_N)) if np.any(felt_n > TO_N) else 0
    touched = int(np.sum(felt_n[: last + 1] > _TOUCH_N))
    if last + 1 - touched < FEWEST_AT_REST or touched < FEWEST_TOUCHED:
        raise RecordingError(
            press,
            wanted=f"{FEWEST_AT_REST} frames before contact and {FEWEST_TOUCHED} from there to {TO_N:g} N",
            found=f"{last + 1 - touched} and {touched}" if last else f"{felt_n.max(initial=0.0):.2g} N at most",
            do="Begin above the specimen, and press more slowly.",
        )
    return frame_s[: last + 1], _motion_px(frames, used[: last + 1]), force_s, force_n


def _motion_px(frames: FrameSequence, used: Sequence[int]) -> Floats:
    pins_px = [detect_pins(frames[index]).centroids_px for index in used]
    rest_px = pins_px[0]
    way_px = np.full((len(used), *rest_px.shape), np.nan)
    for each, found_px in enumerate(pins_px):
        before, after = match_pins(rest_px, found_px, max_distance_px=pin_pitch_px(rest_px) / 2)
        way_px[each, before] = found_px[after] - rest_px[before]
    seen = np.isfinite(way_px).all(axis=(0, 2))
    way_px = way_px[:, seen]
    final_px = way_px[-1] - way_px[-1].mean(axis=0)
    return np.asarray((way_px * final_px).sum(axis=(1, 2)) / np.sqrt((final_px**2).sum()), dtype=np.float64)


def shift_of(frame_s: Floats, motion_px: Floats, force_s: Floats, force_n: Floats) -> float:
    """How much later the frames say they were taken than they were, s: where motion is a function of force best.

    frame_s, motion_px : (T,) s and px. force_s, force_n : (n,) s and N.
    RecordingError : no delay within the search fits best.
    """
    rest_n = float(np.median(force_n[force_s <= frame_s[FEWEST_AT_REST - 1]]))
    kernel = np.ones(_SMOOTH) / _SMOOTH
    force_n = np.convolve(np.pad(force_n, _SMOOTH // 2, mode="edge"), kernel, "valid")
    shifts_s = np.arange(-SEARCH_S, SEARCH_S + _STEP_S / 2, _STEP_S)
    misfit = np.array([_misfit(motion_px, np.interp(frame_s - shift, force_s, force_n) - rest_n) for shift in shifts_s])
    best = int(np.argmin(misfit))
    if best in (0, len(misfit) - 1):
        do = f"Is the camera more than {SEARCH_S:g} s late?"
        raise RecordingError("camera delay", wanted="pins that move with the force", found="none that do", do=do)
    before, at, after = misfit[best - 1 : best + 2]
    return float(shifts_s[best] + _STEP_S / 2 * (before - after) / (before - 2 * at + after))


def _misfit(motion_px: Floats, force_n: Floats) -> float:
    """Sum of squares about a constant at rest and the best power of the force beyond it."""
    pushed = np.maximum(force_n, 0.0)
    moved = motion_px - motion_px.mean()
    misfits = []
    for exponent in _EXPONENTS:
        power = pushed**exponent
        power -= power.mean()
        explained = float(power @ moved) ** 2 / max(float(power @ power), np.finfo(float).tiny)
        misfits.append(float(moved @ moved) - explained)
    return min(misfits)


def _delay_of(folder: Path) -> float:
    path = folder / PLAN_FILE
    try:
        camera = json.loads(path.read_text(encoding="utf-8")).get("devices", {}).get("camera", {})
        return float(camera.get("delay_s", 0.0))
    except (OSError, ValueError, TypeError, AttributeError) as error:
        found, do = f"{type(error).__name__}: {error}", "Choose the folders of runs, for example runs/S1_0_modular."
        raise RecordingError(path, wanted="the plan of a run", found=found, do=do) from error
