"""What a registration freezes of a study, as plain values: who presses what, every setting, the order, the claims."""

from __future__ import annotations

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, fields
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.claims import paper
from emg2vsa.claims.arithmetic import Counted, arithmetic_claims
from emg2vsa.claims.claim import OF_A_STUDY, Claim, Judged, judge
from emg2vsa.claims.kappa import kappa_claims
from emg2vsa.claims.people import PressTable, people_claims
from emg2vsa.claims.rig import rig_claims
from emg2vsa.discrimination.run_table import RunTable
from emg2vsa.rig.experiment import ExperimentSettings, Run
from emg2vsa.session_settings import EmgSettings
from emg2vsa.settings import StageSettings
from emg2vsa.study import RecordingEntry, Study
from emg2vsa.study_file.patterns import REPETITION

Plain = dict[str, Any]
LEFT_OUT = ("reading", "simulation")
"""Tables that change no result of given recordings: what a decoder may cost, and how synthetic recordings are made."""
_OF_THE_PLACE = (
    "emg", "force", "bar_n", "bar_filter_hz", "palette", "sound", "ethics", "checklist", "about", "texts", "form",
    "places", "lsl_outlets", "trigger",
)  # fmt: skip
"""Keys of [session] that say where and in which language it is run. Of the devices, kind and delay are registered."""
EMULATED = "emulated rig"
_PRESSES = 2
"""Presses of each cell of a table that stands for data: as many as claims ask for before they look at numbers."""


def plan_of(study: Study, rig: Plain, runs: Mapping[str, Run]) -> Plain:
    """The plan of ``study``. rig : tables of the rig file of its runs, empty where there is none. runs : by name."""
    names = [each.name for each in fields(StageSettings) if each.name not in LEFT_OUT]
    tables = {name: asdict(getattr(study, name)) for name in names}
    tables |= {"runs": asdict(study.scoring) | _source(study)} if study.runs_source else {}
    tables |= {"session": session_plan(asdict(study.session))} if study.session else {}
    return plain(
        {
            "mode": study.mode,
            "participants": dict.fromkeys(study.participants, "planned"),
            "specimens": {one.name: {k: v for k, v in asdict(one).items() if k != "name"} for one in study.specimens},
            "order of specimens": [one.name for one in study.specimens],
            **({"visits": study.visits} if study.visits else {}),
            "tables": tables,
            "rig tables": rig,
            "runs": {name: run._asdict() for name, run in runs.items()},
            "recordings": {entry.key: _own(study, entry) for entry in study.recordings},
            "judgements": {
                f"{own.participant}/{own.specimen}" + (f", press {own.repetition}" if own.repetition else ""):
                f"{'rejected' if own.excludes else 'accepted'} by hand: {own.reason}" for own in study.judgements
            },
        }
    )  # fmt: skip


def _source(study: Study) -> Plain:
    """Where runs come from, and tables of domes. The folder of runs that an emulated rig makes is no part of a plan."""
    source = study.runs_source
    domes = {"domes": _spelled(study, source.domes)} if source and source.domes else {}
    measured = source and not source.rig
    return domes | {"source": f"measured runs in {_spelled(study, source.root)}" if source and measured else EMULATED}


def plain(value: Plain) -> Plain:
    """The value as JSON has it, digits of numbers kept."""
    return dict(json.loads(json.dumps(value)))


def session_plan(said: Plain) -> Plain:
    """What is registered of the keys of [session]."""
    devices = {
        role: {each.name: said[role].get(each.name) for each in fields(EmgSettings)} for role in ("emg", "force")
    }
    return {key: value for key, value in said.items() if key not in _OF_THE_PLACE} | devices


def _own(study: Study, entry: RecordingEntry) -> Plain:
    """Files and channels of a recording, and where it is filtered and cut otherwise than the others."""
    files = dict.fromkeys(
        re.sub(r"ses-[A-Za-z0-9]+", "ses-*", _spelled(study, file)) if part.visit else _spelled(study, file)
        for part in entry.parts
        for file in (part.emg_file, part.force_file)
        if file is not None
    )
    own: Plain = {"files": list(files), "channels": asdict(entry.channels)}
    for name in ("filters", "window"):
        of_study, of_entry = asdict(getattr(study, name)), asdict(getattr(entry, name))
        own |= {name: more} if (more := {k: v for k, v in of_entry.items() if v != of_study[k]}) else {}
    return own


def _spelled(study: Study, file: Path) -> str:
    """Path from the study's folder, or from that of the recordings where it lies elsewhere; ``*`` for what is open."""
    place, root = study.path.parent, study.data
    if file.is_relative_to(place):
        said = file.relative_to(place).as_posix()
    else:
        said = f"*/{(file.relative_to(root) if file.is_relative_to(root) else Path(file.name)).as_posix()}"
    return said.replace(REPETITION, "*")


def planned_claims(study: Study, experiment: ExperimentSettings | None) -> dict[str, Plain]:
    """Every claim that the report of ``study`` will judge, by key, as far as it is known without data.

    experiment : of the rig; None where no rig file tells it.
    """
    alpha = study.claims.false_verdict_percent / 100
    return {each.claim.key: claim_plan(each) for each in judge(_claims(study, experiment), alpha, OF_A_STUDY)}


def claim_plan(judged: Judged) -> Plain:
    """What is known of a claim before its data: all but its estimate and what that rests on."""
    claim = judged.claim
    said = {key: getattr(claim, key) for key in ("question", "says", "estimand", "asserts", "unit", "algorithm")}
    confidence = judged.confidence if judged.confidence == judged.confidence else None
    return plain(said | {"margin": claim.margin * claim.factor, "confidence": confidence})


def _claims(study: Study, experiment: ExperimentSettings | None) -> Iterable[Claim]:
    """On tables of the shape that the data will have; their numbers mean nothing."""
    new, people, runs = study.profile.new_specimen or "", bool(study.participants), study.runs_source is not None
    if people:
        kept = study.hypotheses.kept_specimens or _palpated(study)
        table, force_n = _presses(study), study.window.force_n
        yield from people_claims(table, study.stiffness_n_per_mm, kept, study.claims, new=new, force_n=force_n)
    if runs:
        yield from rig_claims(_runs(study, experiment), study.calibration.mounting_sd_percent / 100, study.claims)
        hexagons = study.scoring.recipe_of("paper").area_rule in ("paper", "hexagon")
        nothing = CalibrationResults(new, np.nan, (), ())
        yield from kappa_claims(nothing, study.scoring.algorithm, study.claims, hexagons=hexagons)
    weight = paper.WEIGHT_ALPHA if new and people else np.nan
    yield from arithmetic_claims(study, weight_alpha=weight, counted=Counted(0, 0, 0) if people else None, runs=runs)


def _palpated(study: Study) -> tuple[str, ...]:
    """All specimens while no recording is listed yet."""
    return study.palpated or tuple(specimen.name for specimen in study.specimens)


def _presses(study: Study) -> PressTable:
    cells = list(product(study.participants, _palpated(study), range(1, _PRESSES + 1)))
    who, specimen, repetition = (np.array(column) for column in zip(*cells, strict=True))
    values = np.linspace(1.0, 2.0, len(cells))
    return PressTable(who, specimen, repetition.astype(np.int64), values, values, np.full(len(cells), np.nan))


def _runs(study: Study, experiment: ExperimentSettings | None) -> RunTable:
    """The runs of the experiment; those of the paper where no rig file says which are planned."""
    stiffness: Mapping[str, float] = study.pressed_n_per_mm
    runs = experiment.all_runs() if experiment else ()
    designs: list[tuple[str, float]] = sorted({(run.condition, run.angle_deg) for run in runs}) or [*paper.CASR_WORST_P]
    planned = {run.specimen for run in runs} & stiffness.keys() if runs else stiffness
    names = sorted(planned, key=lambda name: -stiffness[name])
    new, shape = study.profile.new_specimen, (len(designs), len(names), _PRESSES)
    return RunTable(
        conditions=tuple(condition for condition, _ in designs),
        angles_deg=np.array([angle for _, angle in designs]),
        specimens=tuple(names),
        stiffness_n_per_mm=np.array([stiffness[name] for name in names]),
        new=names.index(new) if new in names else -1,
        algorithm=study.scoring.algorithm,
        area_unit="mm2",
        casr={study.scoring.algorithm: np.linspace(1.0, 2.0, int(np.prod(shape))).reshape(shape)},
        start_area={study.scoring.algorithm: np.linspace(1.0, 2.0, int(np.prod(shape))).reshape(shape)},
        mounting=np.ones(shape, dtype=np.int64),
    )
