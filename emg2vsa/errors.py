"""Every error a user can cause. One tree, one form: where, what was wanted, what was found, what to do."""

from __future__ import annotations

import casr.errors
from casr.errors import install_extra as install_extra

EXTRAS = {
    **dict.fromkeys(("scipy", "pandas", "matplotlib", "edfio", "ezc3d", "jinja2", "serial"), "study"),
    **dict.fromkeys(("pynwb", "hdmf"), "nwb"),
}
"""Library to the extra that installs it."""


class Emg2vsaError(casr.errors.UserError):
    """Base of the errors of emg2vsa."""


class InputError(casr.errors.InputError, Emg2vsaError):
    """Something given is not usable: where, what was wanted, what was found, what to do."""


class RecordingError(InputError):
    """A recording, or one of its channels, cannot be read as asked."""


class PassingError(RecordingError, casr.errors.PassingError):
    """Reading a recording failed for a reason that may pass: its reader took too long, crashed or was killed."""


class UnsupportedError(RecordingError):
    """A recording that may be sound, and that its reader does not know how to read; another may."""


class SignalError(InputError):
    """A signal cannot be processed as asked: too short, not finite, wrong rate."""


class SettingError(InputError):
    """One setting does not make sense, alone or with the others."""


class DataError(InputError):
    """A table or an array given to a fit, a test or a profile is not usable."""


class ScheduleError(InputError):
    """A stiffness schedule breaks a limit or does not read back as written."""


class DeviceError(InputError):
    """A device of the rig does not answer, refuses, or says what cannot be."""


class StudyError(Emg2vsaError):
    """A study file with one or more problems, all of them listed."""

    def __init__(self, problems: tuple[str, ...]) -> None:
        self.problems = tuple(problems)
        super().__init__(self.problems)

    def __str__(self) -> str:
        return "\n".join(self.problems)

    def told_by(self, program: str) -> str:
        count = len(self.problems)
        return f"{self}\n{count} problem{'s' if count != 1 else ''}; nothing was run."
