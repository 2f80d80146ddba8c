"""The qbmove on the emulated bench."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.springs import SPRINGS
from emg2vsa.devices.qbmove.ticks import to_ticks
from emg2vsa.devices.serial_line import ByteLine
from emg2vsa.worlds.bench.far_end import FarEnd, Place
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.wire_faults import WIRE_FAULTS
from emg2vsa.worlds.far_ends.qbmove.direct import DirectQbmove
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.frames import QbmoveFrames
from emg2vsa.worlds.far_ends.qbmove.motor_faults import MOTOR_FAULTS
from emg2vsa.worlds.far_ends.qbmove.switches import ADVANCED, MAKER_PRO

DEVICE_ID = 1
# with the rate limit of the factory, 0, a saturated move never starts; the one at which motors do move is a guess
_ADVANCED = replace(ADVANCED, max_pwm_rate=10)


def _advanced(emulated: EmulatedSettings) -> bool:
    return emulated.springs == "qbmove-advanced"


def _device(place: Place) -> QbmoveFirmware:
    switches, home_ticks = _ADVANCED if _advanced(place.emulated) else MAKER_PRO, to_ticks(place.rig.home_deg)
    memory, loads = switches.factory((home_ticks,) * 3), place.world.loads_nm
    return QbmoveFirmware(switches, place.world, place.clock, memory=memory, loads=loads, latency_s=place.latency_s)


def driver(line: ByteLine, firmware: Any, place: Place, exact: bool, *, rigid: bool = False) -> Qbmove:
    """The driver of a qbmove's board, or of the rigid motor's."""
    named: dict[str, Any] = {
        "model": "advanced" if _advanced(place.emulated) and not rigid else "maker-pro", "rigid": rigid,
        "clock": place.clock, "stiffness_percent": place.rig.stiffness_percent,
    }  # fmt: skip
    if exact:
        return Qbmove(line, DEVICE_ID, **named)
    return DirectQbmove(line, DEVICE_ID, firmware=firmware, **named)


def _table(place: Place) -> dict[str, Any]:
    return {"id": DEVICE_ID, "generation": "v6", "model": "advanced" if _advanced(place.emulated) else "maker-pro"}


FAR_END = FarEnd(
    springs=lambda emulated: SPRINGS[emulated.springs],
    device=_device,
    driver=driver,
    table=_table,
    faults=WIRE_FAULTS | MOTOR_FAULTS,
    frames=QbmoveFrames(),
)
