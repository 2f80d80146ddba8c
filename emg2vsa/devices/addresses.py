"""What to say of a device whose address a file does not give: none is ever guessed."""

from __future__ import annotations

from collections.abc import Sequence

from emg2vsa.errors import SettingError


def no_address(key: str, wanted: str, do: str) -> SettingError:
    """The error, for the ``key`` of the rig file that is absent."""
    do = f"Write it into the rig file, or use the emulated rig (--virtual). {do}"
    return SettingError(key, wanted=wanted, found="none", do=do)


def ids_asked(ids: Sequence[int], every: range) -> Sequence[int]:
    """``ids``, or ``every`` one that a device of a kind can have where none are given. SettingError for one that none
    can have, such as that of all devices at once, which would answer together."""
    if wrong := [each for each in ids if each not in every]:
        wanted = f"ids of {every[0]} to {every[-1]}"
        raise SettingError("--id", wanted=wanted, found=", ".join(map(str, wrong)), do="Leave it out to ask all.")
    return ids or every
