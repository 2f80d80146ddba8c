"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import whole_number

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import StepPlan
    from emg2vsa.settings import ReadingSettings
    from emg2vsa.study import Study


def add_study(parser: argparse.ArgumentParser) -> None:
    """The study file."""
    parser.add_argument(
        "study", type=Path, metavar="STUDY", help="study file, for example studies/palpation/study.toml"
    )


def add_jobs(parser: argparse.ArgumentParser) -> None:
    """Number of processes."""
    parser.add_argument("--jobs", type=whole_number, metavar="N", help="processes to use (default: all cores)")


def add_work(parser: argparse.ArgumentParser) -> None:
    """Another place for what is written."""
    parser.add_argument(
        "--work",
        type=Path,
        metavar="DIR",
        help="write results, report and emulated runs into DIR and nothing anywhere else",
    )


def add_wait(parser: argparse.ArgumentParser) -> None:
    """What to do while another run holds the study."""
    parser.add_argument(
        "--no-wait",
        action="store_true",
        help="end with a message, instead of waiting, when another run is using the study",
    )


def add_channels(parser: argparse.ArgumentParser) -> None:
    """Which channels of a single recording play which role."""
    channels = parser.add_argument_group("channels")
    channels.add_argument(
        "--emg",
        action="append",
        default=[],
        metavar="CH",
        help="name of an EMG channel; give the option once for each muscle",
    )
    channels.add_argument("--force", metavar="CH", help="name of the force channel")
    channels.add_argument(
        "--force-file", type=Path, metavar="FILE", help="second file that holds the force, recorded on the same clock"
    )
    channels.add_argument(
        "--emg-unit", choices=("V", "mV", "uV"), help="unit of the EMG, if the file does not state it"
    )
    channels.add_argument(
        "--gain", type=float, default=1.0, metavar="X", help="amplifier gain to divide the EMG by (default 1)"
    )
    channels.add_argument("--force-unit", metavar="UNIT", help="unit of the force, if the file does not state it")
    channels.add_argument("--newtons-per-unit", type=float, metavar="X", help="newtons per stored unit (counts, %%MVC)")
    channels.add_argument(
        "--sign", type=int, choices=(1, -1), default=1, help="-1 if the sensor reports a press as a negative force"
    )
    channels.add_argument(
        "--no-tare",
        action="store_true",
        help="do not subtract the force at rest: it is already zero, or the recording has no rest",
    )
    channels.add_argument("--fs", type=float, metavar="HZ", help="sampling rate in Hz, if the file does not state it")


def channels_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """These options as the keys of [channels]."""
    emg = {
        name: {"name": name, "unit": arguments.emg_unit, "gain": arguments.gain, "fs_hz": arguments.fs}
        for name in arguments.emg
    }
    force = {
        "name": arguments.force,
        "unit": arguments.force_unit,
        "newtons_per_unit": arguments.newtons_per_unit,
        "sign": arguments.sign,
        "tare": "none" if arguments.no_tare else "rest",
        "fs_hz": arguments.fs,
    }
    return {"emg": emg, "force": force}


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Limits of the decoders of binary files."""
    reading = parser.add_argument_group("limits of a binary file's decoder")
    reading.add_argument(
        "--max-seconds",
        type=float,
        metavar="S",
        help="longest time in seconds, plus 1 s per 10 MB of the file (default 10)",
    )
    reading.add_argument(
        "--max-memory",
        type=float,
        metavar="MB",
        help="most memory in MB, plus ten times the size of the file (default 600)",
    )


def reading_of(arguments: argparse.Namespace, command: str) -> ReadingSettings:
    """These limits, checked as a study file's are."""
    from emg2vsa.settings import ReadingSettings

    limits = given({"max_seconds": arguments.max_seconds, "max_memory_mb": arguments.max_memory})
    reading: ReadingSettings = checked_settings(command, {"reading": (ReadingSettings, limits)})["reading"]
    return reading


def checked_settings(command: str, asked: dict[str, tuple[type, dict[str, Any]]]) -> dict[str, Any]:
    """The settings of each name, or every problem in them."""
    from emg2vsa.errors import StudyError
    from emg2vsa.study_file.problems import checked

    made: dict[str, Any] = {}
    problems: list[str] = []
    for name, (kind, values) in asked.items():
        made[name], found = checked(kind, values, (name,))
        problems += [f"emg2vsa {command}: {problem}" for problem in found]
    if problems:
        raise StudyError(tuple(problems))
    return made


def given(values: dict[str, Any]) -> dict[str, Any]:
    """The options that were given."""
    return {name: value for name, value in values.items() if value is not None}


def study_of(arguments: argparse.Namespace) -> tuple[Study, Path | None]:
    """The study, placed in --work where that is given, and the results beside its study file that are then read."""
    from emg2vsa.study_file import load_study

    study = load_study(arguments.study)
    if arguments.work is None:
        return study, None
    from emg2vsa.pipeline.places import placed_in

    return placed_in(study, arguments.work), study.results


def jobs_of(arguments: argparse.Namespace) -> int:
    """The number of processes asked for, or all cores."""
    from emg2vsa.process_pool import available_cores

    return int(arguments.jobs or available_cores())


def say_not_used(plan: StepPlan) -> None:
    """One line on the error stream for every step that was refused or failed, in this run or before it."""
    for item, stage, message in plan.failures():
        print(f"not used: {item} ({stage}): {message}", file=sys.stderr)


def add_port(group: argparse._ActionsContainer, default: int) -> None:
    """Port of a page."""
    group.add_argument(
        "--port", type=_port, default=default, metavar="N", help=f"port (default: {default}; 0: any free port)"
    )


def _port(text: str) -> int:
    if not text.isdecimal() or int(text) > 65535:
        raise argparse.ArgumentTypeError(f"expected a port from 0 to 65535, but found {text!r}")
    return int(text)


@contextmanager
def web_pages(command: str) -> Iterator[None]:
    """For the imports of a command that serves pages: SettingError where the extra for web pages is not installed."""
    try:
        yield
    except ModuleNotFoundError as error:
        from emg2vsa.errors import SettingError

        library = str(error.name).partition(".")[0]
        if library not in ("starlette", "uvicorn"):
            raise
        do = 'Install it: pip install "emg2vsa[web]".'
        raise SettingError(command, wanted="the extra for web pages", found=f"no {library}", do=do) from error
