"""What each file of the package is, in words and as a media type."""

from __future__ import annotations

from pathlib import PurePosixPath

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
