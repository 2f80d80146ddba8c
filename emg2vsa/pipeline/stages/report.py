"""Report: everything that was found, in one folder; a stage that failed leaves its section saying why.

``emg2vsa run --human-only`` and ``--casr-only`` write what they found into a folder of their own inside it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from emg2vsa.pipeline.stage import Given, Keyed, Stage
from emg2vsa.report.people import about_people
from emg2vsa.run_folders.find import plate_logs

if TYPE_CHECKING:
    from emg2vsa.curves.plate_tests import PlateTests
    from emg2vsa.multiverse import IndexPresets
    from emg2vsa.pipeline.campaign import Campaign
    from emg2vsa.report.inputs import People, StudyResults
    from emg2vsa.study import Person, Study

NOT_SHOWN = (
    "path", "results", "reports", "data", "task", "runs", "runs_source", "recordings", "session", "registration",
)  # fmt: skip
"""Where things lie changes nothing in a report; which runs there are, it sees in their results.

How a session is run makes recordings, and what they hold counts.
"""
ASKED = (
    "order", "seed", "training_specimens", "training_repetitions", "rest_s", "pause_s", "ethics",
)  # fmt: skip
"""... but for what its methods say of it."""
PEOPLE, RIG = "people", "rig"
"""Folders of the reports of one part, in that of the whole report."""


def settings(campaign: Campaign, item: str, *, rig: bool = True) -> dict[str, Any]:
    """rig : whether the report is on the rig too; a run of the people's part alone does not look its runs up."""
    study = campaign.study
    shown = {each.name: getattr(study, each.name) for each in fields(study) if each.name not in NOT_SHOWN}
    asked = study.session and tuple(getattr(study.session, name) for name in ASKED)
    shown["people"] = _said_of(study.people)
    more = {"file": study.path.name, "recordings": _recordings(campaign), "session": asked}
    source = study.runs_source if rig else None
    logs = plate_logs(source.plates) if source else []
    return {
        "study": Keyed(study, shown | more),
        "registered": campaign.registered,
        "run_order": (campaign.rig.experiment.order, campaign.rig.experiment.seed) if campaign.rig and rig else None,
        "plates": Keyed(logs, [log.name for log in logs]),
    }


def _said_of(people: Sequence[Person]) -> str:
    """Facts that the report tells of all people together: the ledger and the authors' package have no personal data."""
    return about_people(people) if people else ""


def _recordings(campaign: Campaign) -> list[tuple[Any, list[str]]]:
    """Each set of settings once, with the recordings that have it."""
    found: dict[tuple[int, ...], tuple[Any, list[str]]] = {}
    for key, entry in campaign.recordings.items():
        own = (entry.channels, entry.filters, entry.window)
        found.setdefault(tuple(map(id, own)), (own, []))[1].append(key)
    return list(found.values())


def files(campaign: Campaign, item: str, *, rig: bool = True) -> dict[str, Sequence[Path]]:
    """The table of the simulated presses, where the study was simulated; logs of plates; the order of measured runs."""
    data, source = campaign.study.data, campaign.study.runs_source if rig else None
    places = (data / "derivatives" / "truth" / "truth.tsv", data / "truth.tsv") if campaign.study.recordings else ()
    drawn = [source.root / "order.json"] if source and campaign.rig is None else []
    logs = plate_logs(source.plates) if source else []
    return {
        "truth": [path for path in places if path.is_file()][:1],
        "order": [path for path in drawn if path.is_file()],
        "plates": [path for log in logs for path in _files_of(log)],
    }


def _files_of(log: Path) -> list[Path]:
    return [log] if log.is_file() else sorted(path for path in log.glob("[!.]*") if path.is_file())


def folder(campaign: Campaign, item: str) -> Path:
    return campaign.study.reports


def run(given: Given, pages: str = "participants") -> list[Path]:
    """Write the report; ``pages``: folder of the participants' pages, from that of the report; "" links to none."""
    from emg2vsa.calibration_file import file_name, write_calibration
    from emg2vsa.report.study_report import write_study_report
    from emg2vsa.schedule_files import write_schedule

    assert given.folder is not None
    results = results_of(given, pages)
    written = write_study_report(results, given.folder)
    for schedule in results.people.schedules if results.people else ():
        written += write_schedule(given.folder / "schedules", schedule)
    calibration = results.runs.calibration if results.runs else None
    for each in calibration.online if calibration else ():
        written.append(write_calibration(given.folder / "calibrations" / file_name(each), each))
    return written


def results_of(given: Given, pages: str = "") -> StudyResults:
    """All products of the study; of stages that failed none. pages : as for ``run``. DataError : the kept order of the
    runs is damaged."""
    from emg2vsa.errors import Emg2vsaError
    from emg2vsa.report.failures import Failure
    from emg2vsa.report.inputs import Runs, StudyResults

    scores, study, plates = tuple(given.each("runs")), given.settings["study"], None
    failures = [Failure(*failure) for failure in given.failures]
    if given.settings["plates"]:
        try:
            plates = _plates(given)
            study = _with_plates(study, plates.worst_adj_r2())
        except Emg2vsaError as error:
            failures.append(Failure("study", "plates", str(error)))
    return StudyResults(
        study, _people(given), Runs(scores, given.one("discrimination"), given.one("calibration")) if scores else None,
        given.one("stiffness"), tuple(failures), _provenance(given), pages, given.settings["registered"],
        given.one("paths"), _presets(given), plates, _run_order(given),
    )  # fmt: skip


def _people(given: Given) -> People | None:
    """What was found of people; None for a study without."""
    from emg2vsa.fits import concatenate
    from emg2vsa.report.inputs import People, without_samples
    from emg2vsa.screening import screened, screened_trials
    from emg2vsa.truth import read_truth

    if not given.inputs.get("fits"):
        return None
    truth, screening = given.files.get("truth", ()), given.one("screening")
    fits = concatenate((screened(each, screening) for each in given.each("fits")), bins=False)
    return People(
        fits=fits,
        trials=tuple(without_samples(screened_trials(each, screening)) for each in given.each("trials")),
        hypotheses=given.one("hypotheses"), choice=given.one("exemplary"), profiles=given.one("profiles"),
        schedules=given.one("schedules") or (), truth=read_truth(truth[0], fits) if truth else None,
    )  # fmt: skip


def _plates(given: Given) -> PlateTests:
    """What the logs of plate presses tell of the specimens' stiffness."""
    from emg2vsa.curves.rubber import Cylinder
    from emg2vsa.rig_file.plate_logs import Asked, read_plates

    study = given.settings["study"]
    sizes = {
        each.name: Cylinder(each.size_mm[0], each.size_mm[1], each.ends) for each in study.specimens if each.size_mm
    }
    return read_plates(given.settings["plates"], Asked(study.window.force_n, cylinders=sizes))


def _run_order(given: Given) -> str:
    """Order of the runs, as the rig file of an emulated rig says, or as the rig kept it beside its runs. DataError :
    it is damaged.
    """
    import json

    from emg2vsa.errors import DataError

    order, seed = given.settings["run_order"] or ("", None)
    for path in given.files.get("order", ()):
        try:
            kept = json.loads(path.read_text(encoding="utf-8"))
            order, seed = kept["order"], kept["seed"]
        except (ValueError, KeyError, TypeError) as error:
            do = "Put back the file that the rig wrote, or remove it."
            raise DataError(
                path, wanted="the order of the runs", found="a file that tells no order and seed", do=do
            ) from error
    return f"{order}, seed {seed}" if order == "random" else order


def _with_plates(study: Study, worst_adj_r2: Mapping[str, float]) -> Study:
    """R2 of the logs where the study file gives none, and every trial has one."""
    known = {name: worst for name, worst in worst_adj_r2.items() if worst == worst}
    given = [
        each if each.plate_adjusted_r2 is not None else replace(each, plate_adjusted_r2=known.get(each.name))
        for each in study.specimens
    ]
    return replace(study, specimens=tuple(given))


def _presets(given: Given) -> IndexPresets | None:
    """Presets from the profile of one person. The profile of all people takes too long for every report; it is one
    of the paths.
    """
    from emg2vsa.multiverse import index_presets
    from emg2vsa.screening import Screening

    paths, profiles = given.one("paths"), given.one("profiles")
    if paths is not None or profiles is None or not profiles.participant:
        return paths.presets if paths is not None else None
    study, screening = given.settings["study"], given.one("screening") or Screening()
    own = [
        trials
        for trials in given.each("trials")
        if trials.participant == profiles.participant
        and screening.counts(trials.participant, trials.specimen, study.hypotheses.use)
    ]
    return index_presets(study, own, profiles.participant)


def _provenance(given: Given) -> dict[str, str]:
    """Versions and kernel of what made the numbers, and the digests of the results that have one step."""
    import platform
    from importlib.metadata import version

    import emg2vsa
    from casr.blas_kernel import blas_kernel
    from emg2vsa import artifacts

    versions = {name: version(name) for name in ("numpy", "scipy", "matplotlib")} | {"emg2vsa": emg2vsa.__version__}
    python = ".".join(platform.python_version_tuple()[:2])
    single = {stage: paths[0] for stage, paths in given.inputs.items() if len(paths) == 1}
    return (
        {"python": python, "kernel of BLAS": blas_kernel()}
        | versions
        | {f"digest of {stage}": artifacts.digest_of(path) for stage, path in single.items()}
    )


STAGE = Stage(
    per="study", of="report", run=run, settings=settings, files=files, folder=folder, tells_failures=True,
    needs=(
        "trials", "fits", "screening", "pages", "hypotheses", "exemplary", "profiles", "schedules", "stiffness",
        "emulation", "runs", "discrimination", "calibration", "paths",
    ),
)  # fmt: skip
PART_STAGES = {
    "people_report": replace(
        STAGE,
        run=lambda given: run(given, "../participants"),
        settings=partial(settings, rig=False),
        files=partial(files, rig=False),
        folder=lambda campaign, item: campaign.study.reports / PEOPLE,
        needs=("trials", "fits", "screening", "pages", "hypotheses", "exemplary", "profiles", "schedules"),
    ),
    "rig_report": replace(
        STAGE,
        run=lambda given: run(given, ""),
        folder=lambda campaign, item: campaign.study.reports / RIG,
        needs=tuple(need for need in STAGE.needs if need not in ("pages", "hypotheses", "paths")),
    ),
}
"""What people do, without the runs of a rig; and those runs, with the schedules behind them."""
