"""Arguments that several commands share."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from casr.command_line import JSON, Group, add_options, wanted, whole, whole_number

if TYPE_CHECKING:
    from pathlib import Path

    from emg2vsa.pipeline.plan import StepPlan
    from emg2vsa.settings import ReadingSettings
    from emg2vsa.study import RecordingEntry, Study

STUDY = "study STUDY  study file, for example studies/palpation/study.toml\n"
JOBS = "--jobs N  processes to use (default: all cores)\n"
WORK = "--work DIR  write results, report and emulated runs into DIR and nothing anywhere else\n"
WAIT = "--no-wait  end with a message, instead of waiting, when another run is using the study\n"
ON_STUDY = WORK + WAIT + JOBS + JSON
COUNT = {"N": whole_number}

_CHANNELS = """
--emg CH...  name of an EMG channel; give the option once for each muscle
--force CH  name of the force channel
--force-file FILE  second file that holds the force, recorded on the same clock
--emg-unit {V,mV,uV}  unit of the EMG, if the file does not state it
--gain X = 1  amplifier gain to divide the EMG by (default 1)
--force-unit UNIT  unit of the force, if the file does not state it
--newtons-per-unit X  newtons per stored unit (counts, %%MVC)
--sign {1,-1} = 1  -1 if the sensor reports a press as a negative force
--no-tare  do not subtract the force at rest: it is already zero, or the recording has no rest
--fs HZ  sampling rate in Hz, if the file does not state it
"""
_READING = """
--max-seconds S  longest time in seconds, plus 1 s per 10 MB of the file (default 10)
--max-memory MB  most memory in MB, plus ten times the size of the file (default 600)
"""


def add_channels(parser: argparse.ArgumentParser) -> None:
    """Which channels of a single recording play which role."""
    add_options(parser.add_argument_group("channels"), _CHANNELS, sign={"type": int, "choices": (1, -1)})


def channels_of(arguments: argparse.Namespace) -> dict[str, Any]:
    """These options as the keys of [channels]."""
    emg = {
        name: {"name": name, "unit": arguments.emg_unit, "gain": arguments.gain, "fs_hz": arguments.fs}
        for name in arguments.emg
    }
    force = {
        "name": arguments.force, "unit": arguments.force_unit, "newtons_per_unit": arguments.newtons_per_unit,
        "sign": arguments.sign, "tare": "none" if arguments.no_tare else "rest", "fs_hz": arguments.fs,
    }  # fmt: skip
    return {"emg": emg, "force": force}


def recording_of(arguments: argparse.Namespace, command: str) -> RecordingEntry:
    """The one recording that the options describe, its source among them. SettingError : an option is absent."""
    from emg2vsa.errors import SettingError
    from emg2vsa.settings import ChannelSettings, FilterSettings, WindowSettings
    from emg2vsa.study import RecordingEntry

    if absent := [f"--{option}" for option in ("emg", "force", "participant") if not getattr(arguments, option)]:
        wanted = "a study file, or a recording with its channels and participant"
        do = f"Add these options; emg2vsa inspect {arguments.source} tells what the channels are."
        raise SettingError(arguments.source, wanted=wanted, found=f"no {', '.join(absent)}", do=do)
    channels = checked_settings(command, {"channels": (ChannelSettings, channels_of(arguments))})["channels"]
    return RecordingEntry(
        arguments.participant, arguments.specimen or "", arguments.source, arguments.force_file, channels,
        FilterSettings(), WindowSettings(),
    )  # fmt: skip


def add_reading(parser: argparse.ArgumentParser) -> None:
    """Limits of the decoders of binary files."""
    add_options(parser.add_argument_group("limits of a binary file's decoder"), _READING, {"MB": float})


def reading_of(arguments: argparse.Namespace, command: str) -> ReadingSettings:
    """These limits, checked as a study file's are."""
    from emg2vsa.settings import ReadingSettings

    limits = given({"max_seconds": arguments.max_seconds, "max_memory_mb": arguments.max_memory})
    reading: ReadingSettings = checked_settings(command, {"reading": (ReadingSettings, limits)})["reading"]
    return reading


def check_rate(fs_hz: float | None) -> None:
    """SettingError for a rate of --fs, Hz, that cannot be."""
    from emg2vsa.errors import SettingError

    if fs_hz is not None and not 0 < fs_hz < float("inf"):
        raise SettingError("--fs", wanted="a rate above 0 Hz", found=f"{fs_hz:g}", do="Give the rate in hertz.")


def checked_settings(command: str, asked: dict[str, tuple[type, dict[str, Any]]]) -> dict[str, Any]:
    """The settings of each name. Raises StudyError with every problem in them."""
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


def add_port(group: Group, default: int) -> None:
    """Port of a page."""
    port = {"N": wanted("a port from 0 to 65535", whole(0, 65535))}
    add_options(group, f"--port N = {default}  port (default: {default}; 0: any free port)", port)


@contextmanager
def web_pages(command: str) -> Iterator[None]:
    """For the imports of a command that serves pages: SettingError where the extra for web pages is not installed."""
    try:
        yield
    except ModuleNotFoundError as error:
        from emg2vsa.errors import SettingError, install_extra

        library = str(error.name).partition(".")[0]
        if library not in ("starlette", "uvicorn"):
            raise
        do = f"Install it: {install_extra('web')}."
        raise SettingError(command, wanted="the extra for web pages", found=f"no {library}", do=do) from error
