"""The package as a research object: RO-Crate 1.1 metadata (https://w3id.org/ro/crate/1.1)."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from urllib.parse import quote, unquote

import emg2vsa

METADATA = "ro-crate-metadata.json"
SUPPLEMENT = "supplement.zip"
"""The archive in the package, which holds its other files."""
SPECIFICATION = "https://w3id.org/ro/crate/1.1"
CONTEXT = [f"{SPECIFICATION}/context", {"sha256": "https://w3id.org/ro/terms/workflow-run#sha256"}]
"""RO-Crate 1.1 has no word for a checksum; the one of Workflow Run RO-Crate is declared beside its own."""
SOURCES = ("study.toml", "rig.toml", "registration.json")
"""Files of the package itself that the run took."""
UNPUBLISHED = "1980-01-01"
"""Stands for the date of publication, which the specification demands, until the author says it."""
UNLICENSED = "No licence has been chosen yet; all rights remain with the authors."

_RUN = "emg2vsa report --paper"

Entity = dict[str, object]


@dataclass(frozen=True)
class Publication:
    """What only the author knows. date : YYYY-MM-DD. licence : an address, or a sentence."""

    date: str = UNPUBLISHED
    licence: str = UNLICENSED


def metadata(
    name: str,
    about: str,
    files: Mapping[str, bytes],
    inputs: Mapping[str, str],
    libraries: Mapping[str, str],
    publication: Publication,
) -> str:
    """``ro-crate-metadata.json`` of ``files`` (name to content).

    inputs : path of a recording, beside the study file, to its SHA-256. libraries : name to version.
    """
    parts = [_file(path, files[path]) for path in sorted(files)]
    taken = [_input(path, sha256) for path, sha256 in sorted(inputs.items())]
    software = [_software("emg2vsa", emg2vsa.__version__), *(_software(*item) for item in sorted(libraries.items()))]
    run: Entity = {
        "@id": "#run", "@type": "CreateAction", "name": _RUN,
        "description": "From recordings to fits, tests, profiles, schedules, tables, figures and numbers; "
        "provenance.json says step by step which number came from which step and inputs.",
        "instrument": _links(software), "object": _links([*taken, *(p for p in parts if p["@id"] in SOURCES)]),
        "result": _links([part for part in parts if part["@id"] not in SOURCES]),
    }  # fmt: skip
    licence = _licence(publication.licence)
    root: Entity = {
        "@id": "./", "@type": "Dataset", "name": name, "description": about, "datePublished": publication.date,
        "license": {"@id": licence["@id"]}, "hasPart": _links(parts), "mentions": {"@id": "#run"},
    }  # fmt: skip
    graph = [_descriptor(), root, licence, *parts, run, *software, *taken]
    return json.dumps({"@context": CONTEXT, "@graph": graph}, indent=1, ensure_ascii=False) + "\n"


def parts_of(text: str) -> list[str]:
    """Names of the files of a package with this metadata. ValueError, KeyError, TypeError : it is no such metadata."""
    entities = {entity["@id"]: entity for entity in json.loads(text)["@graph"]}
    if entities["#run"]["name"] != _RUN:
        raise ValueError("the metadata of another research object")
    return [METADATA, *(unquote(part["@id"]) for part in entities["./"]["hasPart"])]


def sha256_of(path: Path) -> str:
    """SHA-256 of a file."""
    with path.open("rb") as opened:
        return hashlib.file_digest(opened, "sha256").hexdigest()


def _descriptor() -> Entity:
    return {
        "@id": METADATA, "@type": "CreativeWork", "conformsTo": {"@id": SPECIFICATION}, "about": {"@id": "./"},
    }  # fmt: skip


def _file(path: str, data: bytes) -> Entity:
    return {
        "@id": quote(path), "@type": "File", "name": path, "description": description(path),
        "encodingFormat": encoding_format(path), "contentSize": str(len(data)),
        "sha256": hashlib.sha256(data).hexdigest(),
    }  # fmt: skip


def _input(path: str, sha256: str) -> Entity:
    # a recording is named, not packed: it is no File of the crate
    return {
        "@id": f"#input/{quote(path)}", "@type": "CreativeWork", "name": path,
        "description": "Input of the run, beside the study file; not in this archive", "sha256": sha256,
    }  # fmt: skip


def _software(name: str, version: str) -> Entity:
    return {"@id": f"#software/{name}", "@type": "SoftwareApplication", "name": name, "softwareVersion": version}


def _licence(licence: str) -> Entity:
    address = licence if licence.startswith(("https://", "http://")) else "#licence"
    return {"@id": address, "@type": "CreativeWork", "name": licence, "description": "Licence of this package"}


def _links(entities: list[Entity]) -> list[dict[str, object]]:
    return [{"@id": entity["@id"]} for entity in entities]


_FORMATS = {
    ".json": "application/json", ".csv": "text/csv", ".tex": "application/x-tex", ".pdf": "application/pdf",
    ".txt": "text/plain", ".toml": "application/toml",
}  # fmt: skip
_FILES = {
    "README.txt": "How to use this package in a paper",
    "numbers.tex": "Every number as a LaTeX macro, rounded, with its unit",
    "statements.tex": "Every test as a LaTeX macro, as a manuscript prints it",
    "methods.txt": "Methods paragraph, written from the settings that ran",
    "results.json": "Every number by name, all digits, SI units",
    "results.csv": "Every number by name with unit, macro and the steps that made it",
    "provenance.json": "The steps behind every number: settings, inputs, code and library versions",
    "proof.tex": "All tables, figures, numbers and statements in one document, to look at",
    "study.toml": "The study file: every setting that differs from the defaults",
    "rig.toml": "The rig file: devices, how they are emulated, and the experiment",
    "registration.json": "The registered plan: claims, margins, settings, order and code, signed by its hash",
}
_FOLDERS = {
    ("figures", ".pdf"): "Figure {}, vector graphics with embedded fonts",
    ("figures", ".tex"): "Figure {} as a LaTeX environment with caption and label",
    ("tables", ".csv"): "Table {}, every digit",
    ("tables", ".tex"): "Table {} as LaTeX",
    ("schedules", ".csv"): "Stiffness schedule {}, as a table",
    ("schedules", ".json"): "Stiffness schedule {}, as the actuator reads it",
}


def encoding_format(name: str) -> str:
    """Media type of a file of the package."""
    return _FORMATS.get(PurePosixPath(name).suffix, "application/octet-stream")


def description(name: str) -> str:
    """One line on a file of the package."""
    path = PurePosixPath(name)
    said = _FOLDERS.get((path.parts[0], path.suffix), "Result {}")
    return _FILES.get(name) or said.format(path.stem)
