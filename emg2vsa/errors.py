"""Every error a user can cause. One tree, one form: where, what was wanted, what was found, what to do."""

from __future__ import annotations


class Emg2vsaError(Exception):
    """Base of all errors that are the input's fault; the command line prints it without a traceback."""


class InputError(Emg2vsaError):
    """Something given is not usable.

    Parameters
    ----------
    where : file and key, line or channel, e.g. ``"rec.csv, channel 'Fz'"``.
    wanted, found, do : what was expected, what was there, what the user can do; short clauses.
    """

    def __init__(self, where: object, *, wanted: str, found: str, do: str) -> None:
        self.where, self.wanted, self.found, self.do = str(where), wanted, found, do
        super().__init__(self.where, wanted, found, do)

    def __str__(self) -> str:
        return f"{self.where}: wanted {self.wanted}; found {self.found}. {self.do}"

    def __reduce__(self) -> tuple[object, ...]:
        # exceptions cross process borders; keyword-only arguments need their own way back
        return _rebuild, (type(self), self.where, self.wanted, self.found, self.do)


def _rebuild(kind: type[InputError], where: str, wanted: str, found: str, do: str) -> InputError:
    return kind(where, wanted=wanted, found=found, do=do)


class RecordingError(InputError):
    """A recording, or one of its channels, cannot be read as asked."""


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
