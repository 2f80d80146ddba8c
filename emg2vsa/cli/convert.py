"""``emg2vsa convert``: own recordings as a BIDS-EMG data set."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.arguments import add_channels, add_reading, channels_of, checked_settings, reading_of

if TYPE_CHECKING:
    from emg2vsa.fits import Fits
    from emg2vsa.study import RecordingEntry, Study


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "convert",
        run,
        "Write recordings as a BIDS-EMG data set: BDF+ files with tables of channels, presses and recording details.",
        "Give a study file to convert all its recordings, or one recording and the names of its channels as for "
        "emg2vsa fit. EMG is "
        "stored in uV, force in N, each at its own rate. The originals are not changed. Exit status 1: a recording "
        "could "
        "not be converted. Example: emg2vsa convert study.toml --out shared --mains 50 --electrode-distance 10",
    )
    parser.add_argument("source", type=Path, metavar="SOURCE", help="study file (.toml), or one recording")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder of the data set; it must be empty or absent"
    )
    parser.add_argument("--task", default="palpation", metavar="LABEL", help="BIDS task label (default palpation)")
    parser.add_argument("--mains", type=int, choices=(50, 60), help="mains frequency of the place of recording, Hz")
    parser.add_argument(
        "--electrode-distance", type=float, metavar="MM", help="distance between the two electrodes of a pair, mm"
    )
    parser.add_argument(
        "--about", type=Path, metavar="JSON", help="JSON file with more keys for every _emg.json, such as Manufacturer"
    )
    parser.add_argument("--participant", metavar="ID", help="for one recording: code of the participant")
    parser.add_argument("--specimen", metavar="NAME", help="for one recording: name of the specimen")
    add_channels(parser)
    add_reading(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import counter
    from emg2vsa.pipeline.bids_export import About, export
    from emg2vsa.settings import CocontractionSettings

    about = About(arguments.task, arguments.mains, _distance(arguments), _about(arguments.about))
    if arguments.source.suffix.lower() == ".toml":
        from emg2vsa.study_file import load_study

        study = load_study(arguments.source)
        name, entries, base = study.title, study.recordings, study.path.parent
        cocontraction, reading = study.cocontraction, study.reading
        fits: dict[str, Fits] | None = _fits(study, quiet=arguments.json)
    else:
        name, entries, base = arguments.source.stem, (_entry(arguments),), Path()
        cocontraction, reading = CocontractionSettings(), reading_of(arguments, "convert")
        fits = None
    done = export(
        arguments.out, name, entries, about, base=base, cocontraction=cocontraction, reading=reading, fits=fits,
        progress=None if arguments.json else counter("convert"),
    )  # fmt: skip
    if arguments.json:
        failures = [{"recording": key, "message": message} for key, message in done.failures]
        print_json(
            {"folder": str(arguments.out), "recordings": [str(path) for path in done.files], "failures": failures,
             "notes": list(done.notes)}
        )  # fmt: skip
        return int(bool(done.failures))
    for key, message in done.failures:
        print(f"not converted: {key}: {message}", file=sys.stderr)
    for note in done.notes:
        print(f"note: {note}")
    print(f"{len(done.files)} recording{'s' if len(done.files) != 1 else ''} in {arguments.out}")
    return int(bool(done.failures))


def _fits(study: Study, *, quiet: bool) -> dict[str, Fits]:
    """Key of each recording that could be fitted to its fits, brought up to date, with the judgements of people."""
    from emg2vsa import artifacts
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.places import writable_or_temporary
    from emg2vsa.pipeline.run_study import run_study
    from emg2vsa.process_pool import available_cores

    with writable_or_temporary(study, None, now=True) as (placed, below):
        plan = run_study(
            placed, stages=("trials", "fits"), jobs=available_cores(), progress=progress(quiet=quiet), below=below
        )
        return {key: artifacts.load(path) for key in plan.campaign.recordings for path in plan.done("fits", (key,))}


def _distance(arguments: argparse.Namespace) -> float | None:
    from emg2vsa.errors import SettingError

    distance: float | None = arguments.electrode_distance
    if distance is not None and not 0 < distance < 1000:
        raise SettingError(
            "--electrode-distance", wanted="millimetres above 0", found=f"{distance:g}", do="Measure centre to centre."
        )
    return distance


def _about(path: Path | None) -> dict[str, Any]:
    from emg2vsa.errors import SettingError

    if path is None:
        return {}
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        found = getattr(error, "strerror", None) or str(error)
        raise SettingError(path, wanted="a JSON object", found=found, do="Correct the file.") from error
    if not isinstance(content, dict):
        raise SettingError(path, wanted="a JSON object", found=type(content).__name__, do='Write {"Key": "value"}.')
    return content


def _entry(arguments: argparse.Namespace) -> RecordingEntry:
    """The one recording that the options describe."""
    from emg2vsa.errors import SettingError
    from emg2vsa.settings import ChannelSettings, FilterSettings, WindowSettings
    from emg2vsa.study import RecordingEntry

    absent = [option for option in ("emg", "force", "participant") if not getattr(arguments, option)]
    if absent:
        raise SettingError(
            arguments.source, wanted="a study file, or a recording with its channels and participant",
            found=f"no {', '.join('--' + option for option in absent)}",
            do=f"Add these options; emg2vsa inspect {arguments.source} tells what the channels are.",
        )  # fmt: skip
    channels = checked_settings("convert", {"channels": (ChannelSettings, channels_of(arguments))})["channels"]
    return RecordingEntry(
        arguments.participant, arguments.specimen or "", arguments.source, arguments.force_file, channels,
        FilterSettings(), WindowSettings(),
    )  # fmt: skip
