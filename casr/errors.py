"""Every error a user can cause. One tree, one form: where, what was wanted, what was found, what to do."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TypeVar

Kind = TypeVar("Kind", bound="InputError")


class UserError(Exception):
    """Base of what a user can mend; the command line prints it without a traceback."""

    def told_by(self, program: str) -> str:
        """What the program prints."""
        return f"{program}: {self}"


class InputError(UserError):
    """Something given is not usable.

    where : file, frame, row or setting, e.g. ``"press.tif, frame 12"``.
    wanted, found, do : what was expected, what was there, what the user can do; short clauses.
    """

    def __init__(self, where: object, *, wanted: str, found: str, do: str) -> None:
        self.where, self.wanted, self.found, self.do = str(where), wanted, found, do
        super().__init__(self.where, wanted, found, do)

    def __str__(self) -> str:
        return f"{self.where}: expected {self.wanted}, but found {self.found}. {self.do}"

    def __reduce__(self) -> tuple[object, ...]:
        # exceptions cross process borders; keyword-only arguments need their own way back
        return _rebuild, (type(self), self.where, self.wanted, self.found, self.do)


class CasrError(InputError):
    """Base of the errors of casr."""


class PassingError(InputError):
    """A file could not be read for a reason that may pass, such as too little memory; no word on the file itself.

    It is no ``CasrError``: what stores why a press cannot be scored must not store this.
    """


EXTRAS = {"skfem": "solver", "scipy": "solver"}
"""Library to the extra that installs it."""


def install_extra(extra: str) -> str:
    """The command that installs an extra, for the ``do`` of an error.

    No package index has emg2vsa, so it installs from the sources. Pages say the same: tests/test_install.py.
    """
    return f'pip install ".[{extra}]" in the folder of the sources'


@contextmanager
def said_of(place: object) -> Iterator[None]:
    """Errors raised inside name the place, such as a press or a file, before their own ``where``."""
    try:
        yield
    except (CasrError, PassingError) as error:
        raise _rebuild(type(error), f"{place}, {error.where}", error.wanted, error.found, error.do) from error


def _rebuild(kind: type[Kind], where: str, wanted: str, found: str, do: str) -> Kind:
    return kind(where, wanted=wanted, found=found, do=do)


class ImageError(CasrError):
    """An image cannot be used as asked: empty, not finite, wrong shape or type."""


class FramesError(CasrError):
    """A frame sequence or its force log cannot be read or does not fit together."""


class CameraError(CasrError):
    """A camera file or a camera parameter makes no sense."""


class PinsError(CasrError):
    """Pins cannot be found, or too few of them for what was asked."""


class NoContactError(CasrError):
    """The frames show no contact, so there is no initial area to start from."""


class AreaError(CasrError):
    """A contact area that cannot be: larger than the pin array it is seen by."""


class PluginError(CasrError):
    """What another installed package adds cannot be imported, or does not keep to its contract."""


class SettingError(CasrError):
    """One setting does not make sense, alone or with the others."""


_LONGEST_SAID = 160


def said_by(error: BaseException) -> str:
    """What foreign code says of what it could not do, as one short line: it may quote a file, whatever is in it."""
    name = type(error).__name__
    try:
        said = f"{name}: {error}"
    except Exception:  # its __str__ may be foreign too
        said = name
    said = "".join(each if each.isprintable() else " " for each in said)
    said = " ".join(said.split())
    return said if len(said) <= _LONGEST_SAID else said[: _LONGEST_SAID - 3] + "..."
