"""The rig: actuator, force sensor, camera and motor, driven for real and emulated to the byte.

From a program or a notebook::

    from emg2vsa import rig

    file = rig.load("rig.toml")
    run = rig.press(file, "S3", 0, "modular", virtual=True)     # or on the devices of the file
    run.log.plot("depth_mm", "force_n")

These functions print nothing: they return what was found, and tell a `Person` what goes on.
"""

from __future__ import annotations

from casr.lazy_names import lazy_names

_NAMES = {
    "AdaptiveRuns": ".lab.adaptive_runs",
    "Judging": ".lab.judging",
    "Person": ".lab.person",
    "Pressed": ".lab.pressed",
    "RunsDone": ".lab.sequence",
    "adaptive": ".lab.adaptive_runs",
    "camera_delay": ".lab.commissioning",
    "check_settings": ".lab.commissioning",
    "dry_run": ".lab.pressing",
    "emulation": ".lab.emulation",
    "home": ".lab.by_hand",
    "info": ".lab.device_states",
    "jog": ".lab.by_hand",
    "load": ".lab.pressing",
    "mend_settings": ".lab.commissioning",
    "next_presses": ".lab.adaptive_runs",
    "off": ".lab.by_hand",
    "parameters": ".lab.by_hand",
    "plates": ".lab.sequence",
    "press": ".lab.pressing",
    "proven_watchdog": ".lab.by_hand",
    "scan": ".lab.device_states",
    "sequence": ".lab.sequence",
    "tare": ".lab.by_hand",
    "watch": ".live.watch_routes",
    "zero": ".lab.by_hand",
}
"""Public name to its module, as `lazy_names` has it; loaded when it is first asked for."""
__all__ = [*_NAMES]

__getattr__, __dir__ = lazy_names(__name__, _NAMES)
