"""Score every press of a run; one that cannot be scored stays with its reason and stops no other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from casr.camera import KEYS, Camera
from casr.errors import CasrError
from emg2vsa.arrays import Floats
from emg2vsa.run_scores.counted_pins import counted_pins
from emg2vsa.run_scores.domes import NO_DOMES, Domes
from emg2vsa.run_scores.press import Press, ScoredPress, score_press
from emg2vsa.run_scores.product import ALGORITHMS, PICTURED_N, FirstContact, PressCurve, RunScores
from emg2vsa.settings import RunSettings

_NOTHING = PressCurve(np.empty(0), np.empty(0))


def score_run(
    presses: Iterable[Press],
    settings: RunSettings,
    *,
    specimen: str,
    angle_deg: float,
    condition: str,
    simulated: bool,
    notes: tuple[str, ...] = (),
    domes: Domes = NO_DOMES,
) -> RunScores:
    """Scores of all presses, in their order; ``notes`` of the run go before those of its presses.

    angle_deg : of the sensor, degrees. A press that cannot be scored has NaN and its reason.
    """
    repetitions: list[int] = []
    mountings: list[int] = []
    reasons: list[str] = []
    peaks_n: list[float] = []
    pressed_at: list[float] = []
    scored: list[ScoredPress | None] = []
    counts: list[int] = []
    first_n: list[float] = []
    first_contact: FirstContact | None = None
    unit_of_rejected = "mm2"
    cameras: set[Camera | None] = set()
    for press in map(_decoded_once, presses):
        found, reason = _tried(press, settings, domes)
        if found and press.frames:
            cameras.add(press.frames.camera)
        else:
            unit_of_rejected = press.area_unit
        repetitions.append(press.repetition)
        mountings.append(press.mounting)
        peaks_n.append(press.peak_n)
        pressed_at.append(press.pressed_at)
        reasons.append(reason)
        scored.append(found)
        counted = _counted(press, settings, found)
        counts.append(counted.selected.size if counted else -1)
        first_n.append(float(counted.force_n[0]) if counted else np.nan)
        if first_contact is None and counted and counted.selected.size:
            first_contact = counted
    return RunScores(
        specimen=specimen,
        angle_deg=angle_deg,
        condition=condition,
        simulated=simulated,
        algorithm=settings.algorithm,
        repetitions=np.array(repetitions, dtype=np.int64),
        mounting=np.array(mountings, dtype=np.int64),
        pressed_at=np.array(pressed_at, dtype=np.float64),
        verdicts=tuple("ok" if found else "rejected" for found in scored),
        reasons=tuple(reasons),
        area_unit=next((found.area_unit for found in scored if found), unit_of_rejected),
        pins_selected=np.array(counts, dtype=np.int64),
        first_n=np.array(first_n, dtype=np.float64),
        a_c0=_by_algorithm([found.a_c0 if found else None for found in scored]),
        start_area=_by_algorithm([found.start_area if found else None for found in scored]),
        casr=_by_algorithm([found.casr if found else None for found in scored]),
        over_array=_by_algorithm([found.over_array if found else None for found in scored]),
        true_a_c0=np.full(len(scored), np.nan),
        indent_n_per_mm=np.array([found.indent_n_per_mm if found else np.nan for found in scored]),
        peak_n=np.array(peaks_n, dtype=np.float64),
        curves=tuple(found.curve if found else _NOTHING for found in scored),
        picture=min(
            (found.picture for found in scored if found and found.picture),
            key=lambda picture: abs(picture.force_n - PICTURED_N),
            default=None,
        ),
        first_contact=first_contact,
        notes=tuple(
            dict.fromkeys(
                (
                    *notes,
                    *_missing(scored, settings.algorithm),
                    *(note for found in scored if found for note in found.notes),
                )
            )
        ),
        pins=tuple(found.pins if found else None for found in scored),
        camera=_one_camera(cameras),
    )


def _one_camera(cameras: set[Camera | None]) -> dict[str, Any]:
    """The arguments of ``Camera``; empty where there is none, or more than one."""
    camera = cameras.pop() if len(cameras) == 1 else None
    return {} if camera is None else {**{key: getattr(camera, key) for key in KEYS}, "sensor": camera.sensor.known()}


def _by_algorithm(numbers: Sequence[dict[str, float] | None]) -> dict[str, Floats]:
    """(R,) of each algorithm, NaN for a press without."""
    return {name: np.array([own[name] if own else np.nan for own in numbers]) for name in ALGORITHMS}


def _tried(press: Press, settings: RunSettings, domes: Domes) -> tuple[ScoredPress | None, str]:
    if press.frames is None:
        return None, press.problem
    try:
        return score_press(press, settings, domes), ""
    except CasrError as error:
        return None, str(error)


def _decoded_once(press: Press) -> Press:
    """The same press, whose frames are kept for the next algorithm that looks at them."""
    return press if press.frames is None else replace(press, frames=press.frames.kept())


def _counted(press: Press, settings: RunSettings, found: ScoredPress | None) -> FirstContact | None:
    if press.frames is None or press.frames.force_n is None:
        return None
    return counted_pins(press.frames, settings, press.repetition, found.by_paper if found else None)


def _missing(scored: Sequence[ScoredPress | None], algorithm: str) -> Iterator[str]:
    """Of the runs' algorithm and the paper's: how many presses have no spread rate, and why the first of them."""
    for name in dict.fromkeys((algorithm, "paper")):
        reasons = [found.missing[name] for found in scored if found and name in found.missing]
        if reasons:
            which = "1 press has" if len(reasons) == 1 else f"{len(reasons)} presses have"
            yield f"algorithm {name}: {which} no spread rate: {reasons[0]}"
