"""Facts that a referee asks for, each with its sentence; what nothing tells is left to the authors by its name."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence

import numpy as np

from emg2vsa.extraction import Trials
from emg2vsa.registration.deviations import Registered
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import most
from emg2vsa.report.wording import count, listed
from emg2vsa.run_scores import RunScores
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study

OF_PEOPLE = {
    "presses of each specimen": "The study file asks each participant for {asked} on each specimen; {found}.",
    "order of the specimens, practice and rests": "The study file asks for specimens {order}, before them for "
    "{practice}, and for rests of at least {rest_s} s between presses and {pause_s} s between specimens.",
    "sampling rates": "EMG was sampled at {emg_hz} and force at {force_hz}.",
    "type of the electrodes": "The recordings state the electrodes: {electrodes}.",
    "distance of the electrodes of a pair": "The electrodes of a pair were {InterelectrodeDistance} mm apart.",
    "placement of the electrodes": "The recordings state the placement: {EMGPlacementSchemeDescription}.",
    "reference and ground": "The recordings state the reference and the ground: {reference}.",
    "preparation of the skin": "The recordings state the preparation of the skin: {SkinPreparation}.",
    "maker and model of the amplifier": "The recordings state the amplifier: {amplifier}.",
    "ethics approval": "The ethics approval is {ethics}.",
}
"""Name of a fact to the sentence that states it; the names in braces are values of ``told_of_people``."""

OF_SPECIMENS = {
    "stiffness of the specimens": "The study file gives the specimens a stiffness κ of {stiffness} N/mm.",
    "standard errors of that stiffness": "The standard errors of κ are {errors} N/mm.",
}
OF_PLAN = {
    "registration of the plan": "The study plan was registered on {date} (SHA-256 {sha256}). {then} The study {kept}."
}
OF_RIG = {
    "ramp": "The probe moved at {ramp_mm_per_s} mm/s along a ramp of {travel_mm} mm.",
    "forces of contact and turning back": "Contact was a force of {f_contact_n} N; a press turned back at {f_max_n} N.",
    "pause between presses": "The pause between presses was {pause_s} s.",
    "largest force of a press": "The largest force of a press was {peak_n} N.",
    "presses and mountings": "Each specimen had {mountings} at each angle under each condition, and each mounting "
    "had {presses}.",
    "order of the runs": "The order of the runs was {run_order}.",
    "rate of the control loop": "The control loop ran at {rate_hz} Hz.",
    "rate of the camera": "The camera took {frame_rate_hz} frames a second.",
    "size of the frames": "A frame had {frame_px} px.",
    "pins of the sensor": "The sensor had {pins} pins.",
    "size of the sensor": "The pins were {pin_length_mm} mm long, under a dome with a radius of {dome_radius_mm} mm.",
}
"""The same of ``told_of_specimens``, ``told_of_plan`` and ``told_of_runs``."""

_ORDERS = {
    "blocked": "in random order, all presses of one in a row (seed {})",
    "interleaved": "in random order, press by press (seed {})",
    "listed": "in the order of the study file",
    "latin-square": "in the order of a row of a Latin square, which participants took in turn (letters: seed {})",
    "williams": "in the order of a row of a Williams design, which participants took in turn (letters: seed {})",
}
_JOINED = {
    "electrodes": tuple(f"Electrode{of}" for of in ("Manufacturer", "ManufacturersModelName", "Type", "Material")),
    "reference": ("EMGReference", "EMGGround"),
    "amplifier": ("Manufacturer", "ManufacturersModelName"),
}

Told = dict[str, str]
"""Value by name; "" where nothing tells it."""
_STATED_BY_NONE = ("gain, input impedance and common-mode rejection of the amplifier", "resolution of the converter")


def facts_of(results: StudyResults) -> tuple[dict[str, str], list[str]]:
    """What is stated of people, specimens, plan and rig, and the names of what is left to the authors.

    Nothing is left to the authors of what was simulated.
    """
    study, people, runs = results.study, results.people, results.runs
    said, left = {"people": "", "rig": ""}, []
    if study.recordings:
        said["people"], missing = stated(OF_PEOPLE, told_of_people(study, people.trials if people else ()))
        personal = [key for key in ("age", "sex", "handedness") if not any(getattr(p, key) for p in study.people)]
        if people is None or people.truth is None:
            left += [*missing, *_STATED_BY_NONE, *([f"participants' {listed(personal)}"] if personal else [])]
    if runs:
        said["rig"], missing = stated(OF_RIG, told_of_runs(runs.scores, results.run_order))
        left += missing if not runs.simulated else []
    for part, facts, told in (
        ("specimens", OF_SPECIMENS, told_of_specimens(study)), ("plan", OF_PLAN, told_of_plan(results.registered)),
    ):  # fmt: skip
        said[part], missing = stated(facts, told)
        left += missing if left else []
    return said, left


def stated(facts: Mapping[str, str], told: Told) -> tuple[str, list[str]]:
    """The sentences of the facts that are told, and the names of the others. What users wrote cites no work."""
    told = {key: text.replace("[@", "[") for key, text in told.items() if text}
    sentences, missing = [], []
    for name, sentence in facts.items():
        try:
            sentences.append(sentence.format_map(told))
        except KeyError:
            missing.append(name)
    return " ".join(sentences), missing


def told_of_people(study: Study, trials: Sequence[Trials]) -> Told:
    """What the study file and the recordings tell; the samples of ``trials`` are not needed."""
    asked = {entry.window.expected_trials for entry in study.recordings} - {None}
    rated = [t.rates_hz for t in trials if t.rates_hz]
    read, planned = len(trials), len(study.recordings)
    where = f" in the {read} of {planned} recordings that could be read" if read < planned else ""
    visits = f" at each of {len(study.visits)} visits" if study.visits else ""
    planned_presses = sum((e.window.expected_trials or 0) * max(len(study.visits), 1) for e in study.recordings)
    of = f" of {planned_presses}" if visits and planned_presses else ""
    told = {
        "asked": _several(asked, " press") + visits if asked and trials else "",
        "found": f"{sum(t.repetition.size for t in trials)} presses{of} were found{where}",
        "emg_hz": _rates(rates[:-1] for rates in rated),
        "force_hz": _rates(rates[-1:] for rates in rated),
    }
    stated_by: dict[str, list[str]] = {}
    for key, _, text in (each.partition(": ") for t in trials for each in t.equipment):
        stated_by.setdefault(key, []).append(text.rstrip("."))
    found = {key: "; ".join(dict.fromkeys(texts)) for key, texts in stated_by.items()}
    joined = {name: ", ".join(found[key] for key in keys if key in found) for name, keys in _JOINED.items()}
    return told | found | joined | (_told_of_session(study.session, visits) if study.session else {})


def _told_of_session(session: SessionSettings, visits: str) -> Told:
    next_row = (
        ", the next row at the next visit" if session.order in ("latin-square", "williams") else ", at each visit"
    )
    practice = f"{_several([session.training_repetitions], ' press')} on each of {listed(session.training_specimens)}"
    return {
        "order": _ORDERS[session.order].format(session.seed) + (next_row if visits else ""),
        "practice": f"practice of {practice}" if session.training_specimens else "no practice",
        "rest_s": f"{session.rest_s:g}",
        "pause_s": f"{session.pause_s:g}",
        "ethics": session.ethics.rstrip("."),
    }


def by_hand(study: Study) -> str:
    """Which presses a person excluded or accepted, and why."""
    said = []
    for excludes, did in ((True, "excluded"), (False, "accepted")):
        each = [
            f"{of.participant}/{of.specimen}{f', press {of.repetition}' if of.repetition else ''} ({of.reason})"
            for of in study.judgements
            if of.excludes is excludes
        ]
        said += [f"By hand, whatever these rules say, were {did}: {'; '.join(each)}."] if each else []
    return " ".join(said).replace("[@", "[")


def _over(range_n: tuple[float, float] | None) -> str:
    return f", from {range_n[0]:g} to {range_n[1]:g} N" if range_n else ""


def told_of_specimens(study: Study) -> Told:
    """Stiffness and standard errors as far as the study file states them."""
    known = [s for s in study.specimens if s.stiffness_n_per_mm is not None]
    return {
        "stiffness": listed([f"{s.stiffness_n_per_mm:g} ({s.name}{_over(s.stiffness_range_n)})" for s in known]),
        "errors": listed([f"{s.stiffness_se_n_per_mm:g} ({s.name})" for s in known if s.stiffness_se_n_per_mm]),
    }


def told_of_plan(registered: Registered | None) -> Told:
    """Facts of the registered plan, None where there is none."""
    if registered is None:
        return {}
    points = [f"{each.what} ({each.registered} when registered, {each.now} now)" for each in registered.of_plan]
    kept = f"deviates in {count(len(points), 'point')} from it: {'; '.join(points)}" if points else "follows it"
    then = f"At that time {registered.collected[:1].lower()}{registered.collected[1:]}"
    if registered.amends:
        m = len(registered.from_amended)
        then += f" The plan amends an earlier one (SHA-256 {registered.amends})"
        then += f", from which the study deviates in {count(m, 'point')}." if m else "."
    return {"then": then, "date": registered.registered_at[:10], "sha256": registered.sha256, "kept": kept}


def told_of_runs(runs: Sequence[RunScores], run_order: str) -> Told:
    """What the folders of the runs and their presses tell."""
    setup: dict[str, set[float]] = {}
    for key, values in (item for run in runs for item in run.setup.items()):
        setup.setdefault(key, set()).update(values)
    presses = {n for run in runs for n in np.unique(run.mounting, return_counts=True)[1].tolist()}
    peak_n = most(np.concatenate([run.peak_n for run in runs]))
    frames = dict.fromkeys("{1} × {0}".format(*run.picture.image.shape) for run in runs if run.picture)
    pins = [len(run.first_contact.rest_px) for run in runs if run.first_contact]
    return {key: _several(values) for key, values in setup.items()} | {
        "mountings": _several({int(run.mounting.max()) for run in runs}, " mounting"),
        "presses": _several(presses, " press"),
        "peak_n": f"{peak_n:.3g}" if np.isfinite(peak_n) else "",
        "frame_px": listed(list(frames)),
        "pins": str(max(pins, default="")),
        "run_order": run_order,
    }


def _several(values: Iterable[float | int | None], noun: str = "") -> str:
    """``7``, ``5 or 7``, ``5 to 10``; with a noun ``1 press``, ``5 or 7 presses``."""
    shown = [f"{value:g}" for value in sorted(value for value in values if value is not None)]
    many = "" if shown == ["1"] or not noun else "es" if noun.endswith("s") else "s"
    return (" or ".join(shown) if len(shown) < 3 else f"{shown[0]} to {shown[-1]}") + noun + many


def _rates(of: Iterable[tuple[float, ...]]) -> str:
    """``1000 Hz``; several with the number of recordings of each."""
    counts = Counter(f"{rate:.6g} Hz" for rates in of for rate in dict.fromkeys(rates))
    if len(counts) == 1:
        return next(iter(counts))
    return listed([f"{rate} ({count(n, 'recording')})" for rate, n in counts.items()])
