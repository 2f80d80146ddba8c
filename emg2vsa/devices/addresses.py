"""What to say of a device whose address a file does not give: none is ever guessed."""

from __future__ import annotations

from emg2vsa.errors import SettingError


def no_address(key: str, wanted: str, do: str) -> SettingError:
    """The error, for the ``key`` of the rig file that is absent."""
    do = f"Write it into the rig file, or use the emulated rig (--virtual). {do}"
    return SettingError(key, wanted=wanted, found="none", do=do)
