"""``emg2vsa tools sample``, ``simulate`` and ``convert``: recordings that are simulated, or written as BIDS."""

from __future__ import annotations

import argparse
import dataclasses
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import JSON, Commands, add_command, add_json, answer
from emg2vsa.cli.arguments import STUDY, add_channels, add_reading, reading_of, recording_of

if TYPE_CHECKING:
    from emg2vsa.study import Person, RecordingEntry

NAMES = ("recordings", "plate", "slopes", "presses", "study")
SAMPLE_SUMMARY = "Write small simulated data, on which the commands and snippets of the documentation run."
SAMPLE = """
recordings: EMG and force of two people on two specimens; plate: plate indentation logs; slopes: a table for
emg2vsa stats; presses: two tactile presses for casr score; study: a study file with its recordings.
The same name gives the same bytes. Example: emg2vsa tools sample study
"""
SAMPLE_OPTIONS = f"""
name NAME  {", ".join(NAMES)}
--out DIR  folder to write to (default: NAME)
--overwrite  replace files of the same names
{JSON}
"""
SIMULATE_SUMMARY = "Write synthetic recordings, and their true values, into the data folder of the study."
SIMULATE = "The same seed gives the same bytes. Existing recordings are never overwritten without --overwrite."
SIMULATE_OPTIONS = f"""
{STUDY}
--out DIR  folder to write to (default: the data folder of the study)
--format {{bids,csv,emgworks,c3d}}  file format (default: the format of the recordings of the study)
--seed N  seed to use instead of the seed of the study
--overwrite  replace existing recordings
{JSON}
"""
CONVERT_SUMMARY = "Write recordings as a BIDS-EMG data set, or recordings and runs of the rig as NWB files."
CONVERT = """
Give a study file to convert all its recordings, or one recording and the names of its channels as for emg2vsa fit. BIDS
has BDF+ files with tables of channels, presses and recording details: EMG in uV, force in N, each at its own rate. NWB
has a file for each recording and for each run of the study, or for the one run whose folder you give. The originals are
not changed. Exit status 1: a recording could not be converted.
Example: emg2vsa tools convert study.toml --out shared --mains 50 --electrode-distance 10
"""
CONVERT_OPTIONS = """
source SOURCE  study file (.toml), one recording, or with nwb the folder of a run
--out DIR  folder of the data set; it must be empty or absent
--format {bids,nwb} = bids  format to write (default bids)
--task LABEL = palpation  BIDS task label (default palpation)
--mains {50,60}  mains frequency of the place of recording, Hz
--electrode-distance MM  distance between the two electrodes of a pair, mm
--about JSON  JSON file with more keys for every _emg.json, such as Manufacturer
--participant ID  for one recording: code of the participant
--specimen NAME  for one recording: name of the specimen
"""


def add_to(commands: Commands) -> None:
    add_command(commands, "sample", sample, SAMPLE_SUMMARY, SAMPLE, SAMPLE_OPTIONS, name={"choices": NAMES})
    add_command(commands, "simulate", simulate, SIMULATE_SUMMARY, SIMULATE, SIMULATE_OPTIONS, {"N": int})
    more: dict[str, Any] = {"out": {"required": True}, "mains": {"type": int, "choices": (50, 60)}}
    types = {"SOURCE": Path, "JSON": Path, "MM": float}
    parser = add_command(commands, "convert", convert, CONVERT_SUMMARY, CONVERT, CONVERT_OPTIONS, types, **more)
    add_channels(parser)
    add_reading(parser)
    add_json(parser)


def sample(arguments: argparse.Namespace) -> int:
    from emg2vsa.sample_data import SAMPLES, write_sample

    folder = arguments.out or Path(arguments.name)
    made = [str(path) for path in write_sample(arguments.name, folder, overwrite=arguments.overwrite)]
    told = {"sample": arguments.name, "folder": str(folder), "files": made}
    answer(arguments.json, told, [f"{folder}: {SAMPLES[arguments.name][0]}", *(f"  {path}" for path in made)])
    return 0


def simulate(arguments: argparse.Namespace) -> int:
    """Simulate all recordings of a study. SettingError : no [simulation] table, or files in the folder."""
    from emg2vsa.cli.progress import counter
    from emg2vsa.errors import SettingError
    from emg2vsa.study_file import load_study, missing_files
    from emg2vsa.worlds.people.plan import format_of
    from emg2vsa.worlds.people.study import simulate_study

    study = load_study(arguments.study)
    if study.simulation is None:
        do = "Add one with the true a_v and b_v of every specimen."
        raise SettingError(arguments.study, wanted="a [simulation] table", found="none", do=do)
    if arguments.seed is not None:
        study = dataclasses.replace(study, simulation=dataclasses.replace(study.simulation, seed=arguments.seed))
    folder = arguments.out or study.data
    if folder.exists() and any(folder.iterdir()) and not arguments.overwrite:
        do = "Choose another with --out, or replace them with --overwrite."
        raise SettingError(folder, wanted="an empty or absent folder", found="files in it", do=do)
    made = simulate_study(study, folder, format=arguments.format or format_of(study), progress=counter("simulate"))
    absent = [] if arguments.out else missing_files(study)
    size_mb = sum(path.stat().st_size for path in made.recordings) / 1e6
    lines = [f"{len(made.recordings)} recordings ({size_mb:.1f} MB, {made.format}) in {folder}", f"truth: {made.truth}"]
    if absent:
        file = absent[0].emg_file
        lines.append(f"note: the study looks for {file}, which is not among them; see its [recordings] table")
    told = {"folder": str(folder), "recordings": [str(path) for path in made.recordings], "truth": str(made.truth)}
    answer(arguments.json, told, lines)
    return 0


def convert(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import counter, progress
    from emg2vsa.pipeline.bids_export import about, export, run_folders
    from emg2vsa.pipeline.judged_sessions import fits_of
    from emg2vsa.settings import CocontractionSettings
    from emg2vsa.study_file import load_study

    said = about(arguments.task, arguments.mains, arguments.electrode_distance, arguments.about)
    told: dict[str, Any] = {"progress": None if arguments.json else counter("convert")}
    own, name = CocontractionSettings(), arguments.source.stem
    entries: Sequence[RecordingEntry] = ()
    people: Sequence[Person] = ()
    nwb = arguments.format == "nwb"
    if arguments.source.suffix.lower() == ".toml":
        study = load_study(arguments.source)
        name, entries, people, own = study.title, study.recordings, study.people, study.cocontraction
        told |= {"base": study.path.parent, "reading": study.reading, "runs": run_folders(study) if nwb else ()}
        told["fits"] = fits_of(study, progress(quiet=arguments.json)) if entries else {}
    else:
        told |= {"base": Path(), "reading": reading_of(arguments, "convert")}
        is_run = nwb and arguments.source.is_dir()
        told["runs"], entries = ([arguments.source], ()) if is_run else ([], (recording_of(arguments, "convert"),))
    if nwb:
        from emg2vsa.pipeline.nwb_export import nwb_writer

        told["writer"] = nwb_writer(people)
    done = export(arguments.out, name, entries, said, cocontraction=own, **told)
    for key, message in () if arguments.json else done.failures:
        print(f"not converted: {key}: {message}", file=sys.stderr)
    files = [str(path) for path in done.files]
    failures = [{"recording": key, "message": message} for key, message in done.failures]
    found = {"folder": str(arguments.out), "recordings": files, "failures": failures, "notes": done.notes}
    what = f"{'file' if nwb else 'recording'}{'s' if len(files) != 1 else ''}"
    answer(
        arguments.json, found, [*(f"note: {note}" for note in done.notes), f"{len(files)} {what} in {arguments.out}"]
    )
    return int(bool(failures))
