"""The authors' package: what the report found, laid out for a paper and for an archive, and where numbers come from."""

from __future__ import annotations

import csv
import io
import json
import os
import tempfile
import zipfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from casr.atomic import write_bytes_atomic
from emg2vsa.deposit.crate import METADATA, SOURCES, SUPPLEMENT, UNPUBLISHED, Publication, metadata, parts_of, sha256_of
from emg2vsa.deposit.documents import proof, readme
from emg2vsa.errors import DataError
from emg2vsa.pipeline.plan import DONE, Step, StepPlan
from emg2vsa.pipeline.stage_order import ORDER, stage
from emg2vsa.pipeline.stages.report import results_of
from emg2vsa.report.numbers import macro_names, unit_of
from emg2vsa.report.study_report import write_figure_pdfs
from emg2vsa.study import Study

_FOR_SCREENS = {".html", ".svg", ".png"}
_SIMULATED = "The recordings were simulated: these numbers are no evidence about people."
_RECORDED = "The recordings are taken as made with people."
_EMULATED = "The rig was emulated: its runs are no measurements."
_MEASURED = "The runs are taken as measured on a rig."


def write_package(plan: StepPlan, folder: Path, publication: Publication) -> list[Path]:
    """Write the package of a study whose report is up to date into ``folder``; its files.

    The bytes depend on the results and ``publication`` alone. Whatever the report offers enters: each of its numbers,
    tables, figures and schedules. DataError : the folder holds something that is no such package.
    """
    old = _files_of_earlier(folder)
    files = _files(plan, publication)
    files[SUPPLEMENT] = zip_bytes(files)
    for name in old - set(files):
        (folder / name).unlink(missing_ok=True)
    for name, data in files.items():
        write_bytes_atomic(folder / name, data)
    return [folder / name for name in sorted(files)]


def _files(plan: StepPlan, publication: Publication) -> dict[str, bytes]:
    study, files = plan.study, _from_report(plan)
    found = json.loads(files["results.json"])
    traced = lineage(plan, found)
    files |= _sources(study)
    files["results.csv"] = _results_csv(found, traced).encode()
    files["provenance.json"] = traced.json().encode()
    files["proof.tex"] = proof(study.title, files).encode()
    about = _about(found)
    files["README.txt"] = readme(study.name, study.title, about, files).encode()
    described = f"Numbers, tables, figures and schedules of the study {study.name}, for a paper. {about}"
    if publication.date == UNPUBLISHED:
        described += f" Not published yet: {UNPUBLISHED} stands for the date."
    taken = {path: study.path.parent / path for path in traced.inputs}
    inputs = {path: sha256_of(file) for path, file in taken.items() if file.is_file()}
    crate = metadata(study.title, described, files, inputs, traced.libraries, publication)
    return files | {METADATA: crate.encode()}


def _about(found: Mapping[str, object]) -> str:
    """Who or what made the data, for the parts that this study has."""
    said = []
    if "study.participants" in found:
        said.append(_SIMULATED if found["study.truth_found"] else _RECORDED)
    if found.get("runs.count"):
        said.append(_EMULATED if found["runs.simulated"] else _MEASURED)
    return " ".join(said)


def _from_report(plan: StepPlan) -> dict[str, bytes]:
    """Files of the report that are not for screens, and its figures as PDF."""
    paths = [path for path in plan.files("report") if path.suffix not in _FOR_SCREENS]
    files = {Path(os.path.relpath(path, plan.study.reports)).as_posix(): path.read_bytes() for path in paths}
    with tempfile.TemporaryDirectory() as folder:
        drawn = write_figure_pdfs(results_of(plan.given(plan.steps["report/study"])), Path(folder))
        return files | {path.relative_to(folder).as_posix(): path.read_bytes() for path in drawn}


def _sources(study: Study) -> dict[str, bytes]:
    """The files that a person wrote, under the names that ``SOURCES`` has for them."""
    rig = study.runs_source.rig if study.runs_source else None
    paths = zip(SOURCES, (study.path, rig, study.registration), strict=True)
    return {name: path.read_bytes() for name, path in paths if path is not None}


def _results_csv(found: Mapping[str, object], traced: Lineage) -> str:
    text, names = io.StringIO(), macro_names(list(found))
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["key", "value", "unit", "macro", "steps"])
    for key, value in found.items():
        shown = "" if value is None else json.dumps(value) if not isinstance(value, str) else value
        writer.writerow([key, shown, unit_of(key), f"\\{names[key]}", " ".join(traced.numbers[key])])
    return text.getvalue()


def _files_of_earlier(folder: Path) -> set[str]:
    """What an earlier package in this folder holds; a folder with anything but a package is left alone."""
    if not folder.exists() or not any(folder.iterdir()):
        return set()
    try:
        names = parts_of((folder / METADATA).read_text(encoding="utf-8"))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(
            folder, wanted="an empty folder, or one that holds an earlier authors' package", found="other files",
            do="Choose another folder with --out.",
        ) from error  # fmt: skip
    inside = folder.resolve()
    return {name for name in names if (folder / name).resolve().is_relative_to(inside)}


_EPOCH = (1980, 1, 1, 0, 0, 0)
"""The first time that a zip archive can say."""


def zip_bytes(files: Mapping[str, bytes]) -> bytes:
    """Archive of ``files`` (name to content), sorted by name, without times, owners or compression.

    Compressed bytes change with the version of the compressor; stored ones never do.
    """
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_STORED) as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, _EPOCH)
            entry.create_system = 3
            entry.external_attr = 0o100644 << 16
            archive.writestr(entry, files[name])
    return buffer.getvalue()


_MADE_BY = {
    "study": ("report",), "trials": ("trials",), "fit": ("fits",), "power": ("hypotheses", "report"),
    "recovery": ("fits", "report"), "runs": ("runs", "discrimination"),
}  # fmt: skip
"""First word of a key to the stages behind it, where that word is not a stage's own name."""


@dataclass(frozen=True)
class Lineage:
    """numbers : key to step ids. steps : id to the step as the ledger has it. inputs : path beside the study file to
    the digest the steps took it with.
    """

    numbers: dict[str, tuple[str, ...]]
    steps: dict[str, dict[str, object]]
    inputs: dict[str, str]
    libraries: dict[str, str]

    def json(self) -> str:
        """What provenance.json holds."""
        about = (
            "numbers: key in results.json to the steps that made it. steps: key of the step's result in the ledger, "
            "and all it depends on: settings, files and inputs with their digests, code, libraries. kernel of BLAS: of "
            "its linear algebra; another one may round the last digits otherwise."
        )
        whole = {"about": about, "numbers": self.numbers, "steps": self.steps}
        return json.dumps(whole, indent=1, sort_keys=True, ensure_ascii=False) + "\n"


def lineage(plan: StepPlan, keys: Iterable[str]) -> Lineage:
    """Lineage of the numbers ``keys`` of a study that has just been run."""
    done = [step for step in plan.steps.values() if step.status in DONE]
    base = plan.study.path.parent
    files: dict[str, str] = {}
    libraries: dict[str, str] = {}
    for step in done:
        files |= {_beside(path, base): value for path, value in step.parts.files.items()}
        libraries |= step.parts.libraries.value
    return Lineage(
        numbers={key: _steps_of(key, done, plan.study) for key in keys},
        steps={step.id: _plain(step, base) | {"kernel of BLAS": plan.kernel_of(step)} for step in done},
        inputs=dict(sorted(files.items())),
        libraries=dict(sorted(libraries.items())),
    )


def _steps_of(key: str, steps: Iterable[Step], study: Study) -> tuple[str, ...]:
    """Steps of the key's stages; of one specimen where the key names it. The report made what no stage claims."""
    first, second = [*key.split("."), ""][:2]
    stages = _MADE_BY.get(first, (first,) if first in ORDER else ("report",))
    of = [step for step in steps if step.stage in stages]
    if second in {specimen.name for specimen in study.specimens}:
        of = [step for step in of if stage(step.stage).per != "recording" or step.item.endswith(f"/{second}")]
    return tuple(step.id for step in of)


def _plain(step: Step, base: Path) -> dict[str, object]:
    parts = step.parts
    return {
        "key": step.key,
        "result": step.result,
        "settings": parts.settings.value,
        "files": {_beside(path, base): value for path, value in parts.files.items()},
        "inputs": dict(parts.inputs),
        "code": parts.code.digest,
        "libraries": parts.libraries.value,
    }


def _beside(path: str, base: Path) -> str:
    """A path as seen from the study file, wherever the project lies."""
    return Path(os.path.relpath(base / path, base)).as_posix()
