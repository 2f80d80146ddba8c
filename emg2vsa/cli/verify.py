"""``emg2vsa verify``: recompute every number of an authors' package and say which differ."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_jobs, jobs_of

if TYPE_CHECKING:
    from emg2vsa.deposit.agreement import Agreement, Difference
    from emg2vsa.deposit.verification import Verification

_SHOWN = 20


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "verify",
        run,
        "Recompute every number of an authors' package from its data and say which differ.",
        "The package's files are held against its manifest, its macros against its numbers, and its numbers, tables "
        "and schedules against those that its study file gives on the data. Nothing is written beside them. Exit "
        "status 0: everything agrees; 1: a number differs, or a file was changed; 2: the package cannot be verified, "
        "or not all of it, as data are missing.",
    )
    parser.add_argument(
        "package", type=Path, metavar="PACKAGE", help="folder that emg2vsa report STUDY --paper wrote, or its archive"
    )
    parser.add_argument(
        "--data",
        type=Path,
        metavar="FOLDER",
        help="folder of the study file, from which it names its data (default: found in or beside the package)",
    )
    parser.add_argument(
        "--keys", default="*", metavar="GLOB", help="compare only numbers with such keys, for example 'fit.*'"
    )
    parser.add_argument("--work", type=Path, metavar="DIR", help="recompute in DIR and keep it (default: temporary)")
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.deposit.verification import verify_package

    found = verify_package(
        arguments.package,
        data=arguments.data,
        work=arguments.work,
        keys=arguments.keys,
        jobs=jobs_of(arguments),
        progress=progress(quiet=arguments.json),
    )
    if arguments.json:
        print_json(_as_json(found))
    else:
        for line in _lines(found):
            print(line)
    return found.status


def _lines(found: Verification) -> Iterator[str]:
    import emg2vsa

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


def _as_json(found: Verification) -> dict[str, object]:
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
