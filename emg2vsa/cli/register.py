"""``emg2vsa register``: the plan of a study, frozen before its data."""

from __future__ import annotations

import argparse
import datetime
import os
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import JSON, Commands, add_command, answer
from emg2vsa.cli.arguments import STUDY

if TYPE_CHECKING:
    from emg2vsa.study import Study

SUMMARY = "Freeze plan, claims, margins, order, exclusions and code of a study into a file that its hash signs."
EPILOG = """
Register before the first recording, and deposit the file (OSF, AsPredicted, an archive): its hash shows that it was not
changed, the deposit shows when it was made. A text with the questions of AsPredicted and OSF is written beside it. From
then on emg2vsa run, session and verify name every deviation. Nothing is overwritten: a changed plan is a registration
of its own (--out), which names the hash of the earlier one. Exit status 2: the file is there already.
"""
OPTIONS = f"""
{STUDY}
--out FILE  file of the registration, ending in .json (default: registration.json beside study.toml)
--rig FILE  rig file whose experiment is registered too, for runs that are to be measured
{JSON}
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "register", run, SUMMARY, EPILOG, OPTIONS)


def run(arguments: argparse.Namespace) -> int:
    """Freeze the plan of a study in a file. SettingError : another ending than .json, or a second rig file."""
    from emg2vsa.errors import SettingError
    from emg2vsa.pipeline.registered import as_it_is
    from emg2vsa.registration import document, read_registration, write_registration
    from emg2vsa.rig_file import load_rig
    from emg2vsa.study import registration_of
    from emg2vsa.study_file import load_study

    study, out = load_study(arguments.study), arguments.out
    if out is not None and out.suffix != ".json":
        do = "Give the file a name such as registration-2.json."
        raise SettingError(f"--out {out}", wanted="a name that ends in .json", found=out.suffix or "no ending", do=do)
    file = _rig_file(study, arguments.rig)
    path = Path(os.path.abspath(out)) if out else study.registration or registration_of(study.path)
    known = (each for each in (study.registration, registration_of(study.path)) if each and each != path)
    before = next((each for each in known if each.is_file()), None)
    amends = read_registration(before, None)["sha256"] if before else ""  # the study may have another name since
    rig = load_rig(file) if file else None
    beside = Path(os.path.relpath(file, study.path.parent)).as_posix() if file else ""
    content = document(
        study.name, study.title, now=as_it_is(study, rig), rig_file=beside, amends=amends,
        registered_at=datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
    )  # fmt: skip
    files = [str(each) for each in write_registration(path, content)]
    told = {name: content[name] for name in ("sha256", "registered_at", "amends", "collected")}
    lines = [
        f"{study.name}: {len(content['claims'])} claims registered. {content['collected']}",
        *(f"  {each}" for each in files),
        f"SHA-256 {content['sha256']}",
        "Deposit the file or its hash where its date is public.",
    ]
    if study.registration != path and path != registration_of(study.path):
        named = Path(os.path.relpath(path, study.path.parent)).as_posix()
        lines.append(f'Name it in the study file, under [study]: registration = "{named}"')
    answer(arguments.json, told | {"files": files, "claims": sorted(content["claims"])}, lines)
    return 0


def _rig_file(study: Study, given: Path | None) -> Path | None:
    """The rig file of the study, or else the one that is given. SettingError : there are both."""
    from emg2vsa.errors import SettingError

    own = study.runs_source.rig if study.runs_source else None
    if own and given:
        found = f"rig = {own.name} in [runs]"
        raise SettingError("--rig", wanted="the rig file of the study alone", found=found, do="Leave --rig out.")
    return own or given
