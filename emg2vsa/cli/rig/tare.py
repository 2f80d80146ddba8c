"""``emg2vsa rig tare``: the present load is the zero of the force sensor."""

from __future__ import annotations

import argparse

from casr.command_line import Commands, add_command, add_json, print_json
from emg2vsa.cli.rig.choice import add_rig

_LEFT_N = 0.2
_WAIT_S = 0.2


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "tare",
        run,
        "Set the zero of the force sensor to the present load. The probe must touch nothing.",
        "A Net F/T box keeps this zero until its power is switched off. A National Instruments card keeps no zero: "
        "set [force] bias = true instead. Exit status 0: the force is zero; 1: the force is not zero, and "
        "the command prints it.",
    )
    add_rig(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.open_rig import open_force
    from emg2vsa.rig_file import load_rig

    file, clock = load_rig(arguments.rig), WallClock()
    if file.devices.force.kind != "net-ft":
        do = "Set [force] bias = true: every run then begins with a tare."
        raise SettingError(f"{file.path}, force.kind", wanted="net-ft, which keeps a zero", found="ni-daq", do=do)
    with rig_lock(file.path):
        sensor = open_force(file.devices.force, file.rig.guards, clock)
        try:
            sensor.start()
            before_n = sensor.read().force_n
            sensor.bias()
            clock.sleep_until(clock.now_s() + _WAIT_S)
            force_n = sensor.read().force_n
        finally:
            sensor.close()
    if arguments.json:
        print_json({"before_n": list(map(float, before_n)), "force_n": list(map(float, force_n))})
    else:
        print("before: {:.3f}, {:.3f}, {:.3f} N".format(*before_n))
        print("now: {:.3f}, {:.3f}, {:.3f} N".format(*force_n))
    return int(not float(abs(force_n).max()) <= _LEFT_N)
