"""The part of a study report that speaks of the rig's runs: section VI of the paper."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from casr import html
from emg2vsa.calibration.results import CalibrationResults
from emg2vsa.discrimination import Discrimination
from emg2vsa.report import runs_conclusions as conclusions
from emg2vsa.report.drawing import Drawing, shown
from emg2vsa.report.kappa_conclusion import kappa_conclusion
from emg2vsa.report.kappa_tables import kappa_tables
from emg2vsa.report.numbers import Quantity
from emg2vsa.report.paper_comparison import runs_comparison
from emg2vsa.report.runs_figures import runs_figures
from emg2vsa.report.runs_quantities import kappa_quantities, runs_quantities
from emg2vsa.report.runs_tables import runs_tables
from emg2vsa.report.runs_verdicts import runs_verdicts
from emg2vsa.report.table import Table
from emg2vsa.report.wording import area_unit, count
from emg2vsa.runs import RunScores

_NUMBER = re.compile(r"-?\b\d+(\.\d+)?(e[-+]?\d+)?\b")
_SHOWN_RUNS = 3


@dataclass(frozen=True)
class RunsReport:
    """contents : address and name of each section, ``body`` their HTML; the rest by name. Empty without runs."""

    contents: tuple[tuple[str, str], ...] = ()
    body: str = ""
    quantities: dict[str, Quantity] = field(default_factory=dict)
    tables: dict[str, Table] = field(default_factory=dict)
    drawings: dict[str, Drawing] = field(default_factory=dict)


def runs_sections(
    runs: Sequence[RunScores],
    found: Discrimination | None,
    calibration: CalibrationResults | None,
    specimens: Sequence[str],
    why_absent: str = "",
) -> RunsReport:
    """specimens : of the study, so that each keeps its look. why_absent : what is said where ``found`` is None."""
    if not runs:
        return RunsReport()
    numbers, tables = runs_quantities(runs, found), runs_tables(runs, found)
    simulated = bool(numbers["runs.simulated"])
    head = _presses(runs, tables)
    if found is None:
        body = html.section("runs", "Runs", head, html.paragraph(why_absent))
        return RunsReport((("#runs", "Runs"),), body, numbers, tables)
    tables |= runs_verdicts(found)
    tables["paper_comparison_runs"] = runs_comparison(found, numbers, simulated)
    drawings = runs_figures(runs, found, calibration, specimens)
    sections = [
        ("runs", "Runs", head + tables["paper_comparison_runs"].html()),
        ("area", "Initial contact area", _area(runs, found, tables, drawings)),
        ("casr", "Contact area spread rate", _rates(found, tables, drawings)),
        ("vision", "Old and new vision algorithm", _vision(found, tables)),
        ("actuators", "Rigid and human-like actuation", _actuators(found, tables, drawings, simulated)),
    ]
    if calibration is not None and calibration.conditions:
        algorithms = found.table.algorithm, found.settings.old_algorithm
        numbers |= kappa_quantities(calibration)
        tables |= kappa_tables(calibration, *algorithms)
        sections.append(("kappa", "Stiffness of the new specimen", _kappa(calibration, algorithms, tables, drawings)))
    return RunsReport(
        contents=tuple((f"#{name}", title) for name, title, _ in sections),
        body="".join(html.section(name, title, body) for name, title, body in sections),
        quantities=numbers,
        tables=tables,
        drawings=drawings,
    )


def _presses(runs: Sequence[RunScores], tables: Mapping[str, Table]) -> str:
    n = sum(run.simulated for run in runs)
    origin = html.statement("", "These runs were measured,", "as far as their folders say.")
    if n:
        which = "These runs" if n == len(runs) else f"{n} of {len(runs)} runs"
        origin = html.statement(
            "usable",
            f"{which} come from a simulated rig.",
            "Emulated actuator, force sensor and camera share one world. Its numbers show what the method makes "
            "of that world; they are no measurement, and agreement with the paper is not a replication.",
        )
    notes = _notes(runs)
    return (
        origin
        + tables["runs"].html()
        + (html.details(f"{count(len(notes), 'kind')} of notes of the runs", html.bullets(notes)) if notes else "")
    )


def _notes(runs: Sequence[RunScores]) -> list[str]:
    """Notes that differ by their numbers alone are one kind: its first, and the runs it concerns."""
    kinds: dict[str, list[tuple[str, str]]] = {}
    for run in runs:
        for note in run.notes:
            kinds.setdefault(_NUMBER.sub("#", note), []).append((note, run.name))
    return [_note([note for note, _ in of], list(dict.fromkeys(name for _, name in of))) for of in kinds.values()]


def _note(notes: Sequence[str], names: list[str]) -> str:
    like = f"{len(notes)} such notes with other numbers, " if len(set(notes)) > 1 else ""
    where = ", ".join([*names[:_SHOWN_RUNS], *(["…"] if len(names) > _SHOWN_RUNS else [])])
    return f"{notes[0]} ({like}{count(len(names), 'run')}: {where})"


def _area(
    runs: Sequence[RunScores], found: Discrimination, tables: Mapping[str, Table], drawings: Mapping[str, Drawing]
) -> str:
    return (
        html.paragraph(conclusions.first_frames(runs, found))
        + html.heading("Does A_c0 depend on the specimen?")
        + html.paragraph("Claim: at one angle, the initial area is the same on all specimens.")
        + html.paragraph(conclusions.area_and_specimens(found))
        + tables["verdict_area"].html()
        + html.details("Every design", tables["area_by_specimen"].html())
        + html.heading("Does A_c0 depend on the angle?")
        + html.paragraph("Claim: the initial area falls as the angle grows.")
        + html.paragraph(conclusions.area_and_angle(found))
        + tables["verdict_angle"].html()
        + html.details("Every specimen", tables["area_by_angle"].html())
        + _shown(drawings, "fig08_initial_area", "fig09_first_contact")
        + html.heading("Is each sample Gaussian?")
        + html.paragraph(
            "The paper chose rank tests because its samples were not Gaussian. The raw test finds every sample of "
            f"areas in {area_unit(found.table.area_unit)} non-Gaussian whatever its shape, since none is near "
            "zero; rank tests are right either way."
        )
        + tables["verdict_runs_normality"].html()
    )


def _rates(found: Discrimination, tables: Mapping[str, Table], drawings: Mapping[str, Drawing]) -> str:
    new = ""
    if found.new is not None:
        bound = conclusions.mean_rank_bound(found)
        new = (
            html.heading(f"Is {found.new.name} told from its neighbours?")
            + html.paragraph(f"Claim: CASR of {found.new.name} lies between its neighbours' and differs from both.")
            + html.paragraph(conclusions.new_specimen(found))
            + tables["new_specimen"].html()
            + (html.paragraph(bound) if bound else "")
        )
    return (
        html.heading("Does CASR tell specimens apart?")
        + html.paragraph("Claim: CASR differs between specimens, and is the larger the softer the specimen.")
        + html.paragraph(conclusions.specimens(found))
        + tables["verdict_casr"].html()
        + tables["casr_by_specimen"].html()
        + html.paragraph(
            "Presses on one block of silicone are repetitions of one specimen: these tests speak of that block and "
            "that rig, not of all specimens of its stiffness."
        )
        + new
        + _shown(drawings, "fig10_rigid", "fig12_human_like", "fig13_constant")
        + (html.heading("Notes of the tests") + html.bullets(found.notes) if found.notes else "")
    )


_TO_THE_LETTER = (
    "The algorithm “paper” is Algorithm 1, whole-pixel centroids of pins that are paired one to one as it must be "
    "meant, with equations (1) and (2) as printed. As printed, Algorithm 1 compares every pin with every other, which "
    "nearly every pair passes: that area would tell how many pins the sensor has. “Hexagon” takes centroids to parts "
    "of a pixel, counts the pins that those in contact enclose, and has the consistent area law."
)


def _vision(found: Discrimination, tables: Mapping[str, Table]) -> str:
    return (
        html.paragraph(
            "Claim: the new estimate of the initial area improves on the old one, above all on tilted surfaces."
        )
        + html.paragraph(conclusions.vision(found))
        + tables["algorithms"].html()
        + (html.paragraph(_TO_THE_LETTER) if "paper" in found.algorithms.names else "")
    )


def _actuators(
    found: Discrimination, tables: Mapping[str, Table], drawings: Mapping[str, Drawing], simulated: bool
) -> str:
    sentences = (
        conclusions.actuators(found),
        conclusions.why(found, simulated),
        conclusions.constants(found),
        conclusions.constant_levels(found),
    )
    return (
        html.paragraph("Claim: pressed with the whole human profile, specimens are told apart best.")
        + "".join(html.paragraph(sentence) for sentence in sentences if sentence)
        + tables["conditions_compared"].html()
        + tables["conditions"].html()
        + html.paragraph(
            "A gap is Hedges' g: the difference of mean CASR of two specimens over the SD of their presses. The pair "
            "is chosen once, over all conditions. Rank tests cannot compare conditions: once no specimens overlap, "
            "their p is at its bound."
        )
        + _shown(drawings, "fig14_conditions")
    )


def _kappa(
    calibration: CalibrationResults,
    algorithms: tuple[str, str],
    tables: Mapping[str, Table],
    drawings: Mapping[str, Drawing],
) -> str:
    notes: dict[str, list[str]] = {}
    for each in calibration.conditions:
        for note in each.algorithms[algorithms[0]].chosen.notes:
            notes.setdefault(note, []).append(f"{each.condition}, {each.angle_deg:g}°")
    everywhere = len(calibration.conditions)
    told = [
        f"{note} ({'every design' if len(designs) == everywhere else '; '.join(designs)})"
        for note, designs in notes.items()
    ]
    return (
        html.paragraph("Claim: both the new vision algorithm and human-like stiffness reduce the error (Table I).")
        + tables["table_one"].html()
        + tables["table_one_laws"].html()
        + html.paragraph(kappa_conclusion(calibration, *algorithms))
        + tables["kappa_new"].html()
        + html.details("The fitted laws", tables["calibration_laws"].html())
        + _shown(drawings, "figcal_calibration")
        + html.bullets([*told, *calibration.notes])
    )


def _shown(drawings: Mapping[str, Drawing], *names: str) -> str:
    return "".join(shown(drawings[name]) for name in names if name in drawings)
