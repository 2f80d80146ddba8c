"""Which channel of a source of EMG is which muscle's, and what is wrong with that."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from typing import Annotated

from emg2vsa.devices.registry import Wrong
from emg2vsa.session_settings import Text
from emg2vsa.settings import MinLen

Channels = Annotated[dict[str, Text], MinLen(1)]
"""Muscle role of the study (EDC, FDS) to the source's name of its channel."""


def alike(channels: Mapping[str, str], spelt: Callable[[str], str] = str) -> Iterator[Wrong]:
    """Muscles with the channel of another one. ``spelt`` : one way of writing a channel that has several."""
    first: dict[str, str] = {}
    for role, name in channels.items():
        if (same := first.setdefault(spelt(name), role)) != role:
            yield Wrong(("channels", role), "a channel of its own for each muscle", f"{name!r}, as for {same}")


def not_like(channels: Mapping[str, str], pattern: str, wanted: str) -> Iterator[Wrong]:
    """Channels that are not written as the source writes them."""
    for role, name in channels.items():
        if not re.fullmatch(pattern, name):
            yield Wrong(("channels", role), wanted, repr(name))
