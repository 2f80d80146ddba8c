"""Score every press of a run; one that cannot be scored stays with its reason and stops no other."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

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
    rows: list[_Row] = []
    first_contact: FirstContact | None = None
    for press in map(_decoded_once, presses):
        found, reason = _tried(press, settings, domes)
        counted = _counted(press, settings, found)
        rows.append(_Row.of(press, found, reason, counted))
        first_contact = first_contact or (counted if counted and counted.selected.size else None)
    scored = [row.found for row in rows]
    known = [found for found in scored if found]
    told = (*notes, *_missing(scored, settings.algorithm), *(note for found in known for note in found.notes))
    # what has no score has no unit of its own
    units = [found.area_unit for found in known] or [row.press.area_unit for row in rows][-1:] or ["mm2"]
    return RunScores(
        specimen=specimen, angle_deg=angle_deg, condition=condition, simulated=simulated, algorithm=settings.algorithm,
        repetitions=np.array([row.press.repetition for row in rows], dtype=np.int64),
        mounting=np.array([row.press.mounting for row in rows], dtype=np.int64),
        pressed_at=np.array([row.press.pressed_at for row in rows], dtype=np.float64),
        verdicts=tuple("ok" if found else "rejected" for found in scored),
        reasons=tuple(row.reason for row in rows),
        area_unit=units[0],
        pins_selected=np.array([row.selected for row in rows], dtype=np.int64),
        first_n=np.array([row.first_n for row in rows], dtype=np.float64),
        a_c0=_by_algorithm([found.a_c0 if found else None for found in scored]),
        start_area=_by_algorithm([found.start_area if found else None for found in scored]),
        casr=_by_algorithm([found.casr if found else None for found in scored]),
        over_array=_by_algorithm([found.over_array if found else None for found in scored]),
        true_a_c0=np.full(len(rows), np.nan),
        indent_n_per_mm=np.array([found.indent_n_per_mm if found else np.nan for found in scored]),
        peak_n=np.array([row.press.peak_n for row in rows], dtype=np.float64),
        curves=tuple(found.curve if found else _NOTHING for found in scored),
        picture=min(
            (found.picture for found in known if found.picture),
            key=lambda picture: abs(picture.force_n - PICTURED_N), default=None,
        ),
        first_contact=first_contact,
        notes=tuple(dict.fromkeys(told)),
        pins=tuple(found.pins if found else None for found in scored),
        camera=_one_camera({row.camera for row in rows if row.found}),
    )  # fmt: skip


class _Row(NamedTuple):
    """What is kept of a press, whose frames are let go. found : its scores, or None for a ``reason``. selected, first_n
    : pins that the paper's Algorithm 1 counts, -1 where it cannot, and the force then."""

    press: Press
    found: ScoredPress | None
    reason: str
    selected: int
    first_n: float
    camera: Camera | None

    @classmethod
    def of(cls, press: Press, found: ScoredPress | None, reason: str, counted: FirstContact | None) -> _Row:
        selected, first_n = (counted.selected.size, float(counted.force_n[0])) if counted else (-1, np.nan)
        camera = press.frames.camera if press.frames else None
        return cls(replace(press, frames=None), found, reason, selected, first_n, camera)


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
    """Presses without a spread rate, by the runs' algorithm and the paper's, and why the first has none."""
    for name in dict.fromkeys((algorithm, "paper")):
        reasons = [found.missing[name] for found in scored if found and name in found.missing]
        if reasons:
            which = "1 press has" if len(reasons) == 1 else f"{len(reasons)} presses have"
            yield f"algorithm {name}: {which} no spread rate: {reasons[0]}"
