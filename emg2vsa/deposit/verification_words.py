"""What the verification of a package found: in lines for people, and for programs."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import emg2vsa
from emg2vsa.deposit.agreement import Agreement, Difference
from emg2vsa.deposit.verification import Verification

_SHOWN = 20


def lines(found: Verification) -> Iterator[str]:
    """The verdict last."""
    deposit, data = found.deposit, found.data
    other = "" if deposit.version == emg2vsa.__version__ else f"; this is {emg2vsa.__version__}, so methods may differ"
    yield f"Package: {deposit.source}, written by emg2vsa {deposit.version}{other}"
    yield f"Files: {len(deposit.sha256)} in the manifest, {len(found.damage)} not as it says"
    yield from _few([f"{name}: {what}" for name, what in found.damage])
    there = len(deposit.inputs) - len(data.missing)
    yield f"Data: {there} of {len(deposit.inputs)} files in {data.folder}, {len(data.changed)} of them changed"
    yield from _few([f"{name}: changed" for name in data.changed])
    yield from _few([f"{name}: missing" for name in sorted(data.missing)])
    if len(data.missing) == len(deposit.inputs) and data.missing:
        yield "  Name the folder of the study file with --data."
    yield f"Inside the package: {len(found.restated)} numbers are not as in results.json"
    yield from _few(found.restated, "in the file", "in results.json")
    unchecked = [name for name in found.unchecked if "/" not in name and not name.endswith(".tex")]
    yield f"Numbers: {_counted(found.numbers)}, {len(unchecked)} not checked"
    yield from _few(found.numbers.differ)
    files = len(found.unchecked) - len(unchecked)
    yield f"Lines of tables, statements and schedules: {_counted(found.texts)}, {files} files not checked"
    yield from _few(found.texts.differ)
    yield ("Verified.", "Not as published.", "Not verified: see what was not checked.")[found.status]


def _counted(agreement: Agreement) -> str:
    return f"{agreement.exact} equal, {agreement.within} within tolerance, {len(agreement.differ)} differ"


def _few(
    found: Sequence[Difference | str], published: str = "published", recomputed: str = "recomputed"
) -> Iterator[str]:
    for each in found[:_SHOWN]:
        yield f"  {each}".replace(": published ", f": {published} ").replace(", recomputed ", f", {recomputed} ")
    if len(found) > _SHOWN:
        yield f"  and {len(found) - _SHOWN} more; --json lists all"


def as_json(found: Verification) -> dict[str, object]:
    """All of it."""
    deposit, data = found.deposit, found.data
    return {
        "package": str(deposit.source),
        "version": deposit.version,
        "status": found.status,
        "files": [{"file": name, "found": what} for name, what in found.damage],
        "data": {"folder": str(data.folder), "missing": sorted(data.missing), "changed": list(data.changed)},
        "restated": [vars(difference) for difference in found.restated],
        "numbers": _agreement(found.numbers),
        "lines": _agreement(found.texts),
        "not_checked": list(found.unchecked),
    }


def _agreement(agreement: Agreement) -> dict[str, object]:
    differ = [vars(difference) for difference in agreement.differ]
    return {"equal": agreement.exact, "within_tolerance": agreement.within, "differ": differ}
