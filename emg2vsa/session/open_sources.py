"""The sources of EMG and of force that [session] names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.registry import Around, known
from emg2vsa.devices.streams import Source
from emg2vsa.session_settings import SessionSettings

LOST_S = 1.0
"A force sensor of which nothing comes for so long is lost; nobody is hurt by a bar that stands still for less."

Maker = Callable[[], Source]
"""Opens a device anew, not started: when the session begins, and whenever the device was lost."""


def source_makers(
    settings: SessionSettings, muscles: Sequence[str], clock: Clock, *, rig_force: ForceSettings | None = None
) -> tuple[Maker, Maker]:
    """Of EMG and force. They raise SettingError and DeviceError as the kinds of the devices do.

    Parameters
    ----------
    muscles : roles of the study; the EMG has them in this order.
    rig_force : table [force] of the rig file that session.force.rig names.
    """
    emg = settings.emg
    if channels := getattr(emg, "channels", None):  # of whatever kind
        emg = replace(emg, channels={role: channels[role] for role in muscles if role in channels})  # type: ignore[call-arg]
    others = {"emg": emg, "session-force": settings.force} | ({"force": rig_force} if rig_force else {})
    around = Around(clock, LOST_S, others=others)
    force = settings.force
    return partial(known("emg", emg).opened, emg, around), partial(known("session-force", force).opened, force, around)
