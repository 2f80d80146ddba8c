"""The sources of EMG and of force that [session] names."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from emg2vsa.ati.cal_file import read_calibration
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.lsl.driver import LslSource, load_pylsl
from emg2vsa.devices.netft.driver import open_net_ft
from emg2vsa.devices.ni_daq.emg import NiEmg, NiInputs, emg_inputs
from emg2vsa.devices.ni_daq.gauges import DaqFt
from emg2vsa.devices.ni_daq.volts import load_nidaqmx
from emg2vsa.devices.rig_force import RigForce, unit_axis
from emg2vsa.devices.streams import Source
from emg2vsa.devices.trigno.driver import TrignoSource, places_of
from emg2vsa.errors import SettingError
from emg2vsa.session_settings import EmgSourceSettings, ForceSourceSettings, SessionSettings

STALE_S = 1.0
"A force sensor of which nothing comes for so long is lost; nobody is hurt by a bar that stands still for less."
GAUGES_HZ = 1000.0
"Rate of gauges that have a card of their own."


Maker = Callable[[], Source]
"""Opens a device anew, not started: when the session begins, and whenever the device was lost."""


def source_makers(
    settings: SessionSettings,
    muscles: Sequence[str],
    clock: Clock,
    *,
    rig_force: ForceSettings | None = None,
    simulated: tuple[Maker, Maker] | None = None,
) -> tuple[Maker, Maker]:
    """Of EMG and force.

    Parameters
    ----------
    muscles : roles of the study; the EMG has them in this order.
    rig_force : table [force] of the rig file that session.force.rig names.
    simulated : EMG and force of an emulated participant, for kind = "simulated".

    Raises
    ------
    SettingError : a muscle without channel; two on one; no rig file; nobody to simulate.
    DeviceError : the package for a device is not installed. A maker: the force sensor's box does not answer.
    """
    emg, force = _of_muscles(settings.emg, muscles), settings.force
    inputs = NiInputs(emg.fs_hz, clock)
    # every channel of a task is named before it starts, whichever source starts first
    make_emg = _emg(emg, inputs, clock, simulated)
    if force.kind == "rig":
        if emg.kind != "ni-daq" or rig_force is None or not _on_one_card(emg, rig_force):
            inputs = NiInputs(GAUGES_HZ, clock)
        return make_emg, _rig_force(force, rig_force, inputs, clock)
    if force.kind == "lsl":
        load_pylsl("session.force")
        channel, stream, delay_s = {"force": force.channel}, force.stream, force.delay_s
        return make_emg, lambda: LslSource(
            "force", channel, clock, table="session.force", stream=stream, delay_s=delay_s
        )
    if simulated is None:
        raise _nobody("force")
    return make_emg, simulated[1]


def _of_muscles(settings: EmgSourceSettings, muscles: Sequence[str]) -> EmgSourceSettings:
    """The settings with the channels in the order of the muscles."""
    if settings.kind == "simulated":
        return settings
    channels = settings.channels
    for role in {**dict.fromkeys(muscles), **channels}:
        if role not in channels or role not in muscles:
            wanted, found = (
                ("a channel for each muscle of [channels.emg]", "none for this one")
                if role in muscles
                else (f"a muscle of [channels.emg]: {', '.join(muscles)}", f"the muscle {role!r}")
            )
            do = "Give each muscle the device's name of its channel, and no other."
            raise SettingError(f"session.emg.channels.{role}", wanted=wanted, found=found, do=do)
        if (other := next(each for each in channels if channels[each] == channels[role])) != role:
            do = f"Correct one of {other} and {role}."
            found = f"{channels[role]!r}, as for {other}"
            raise SettingError(
                f"session.emg.channels.{role}", wanted="a channel of its own for each muscle", found=found, do=do
            )
    return replace(settings, channels={role: channels[role] for role in muscles})


def _emg(settings: EmgSourceSettings, inputs: NiInputs, clock: Clock, simulated: tuple[Maker, Maker] | None) -> Maker:
    if settings.kind == "simulated" and simulated:
        return simulated[0]
    if settings.kind == "ni-daq":
        load_nidaqmx('session.emg.kind = "ni-daq"')
        group = emg_inputs(settings, inputs)
        return lambda: NiEmg(settings, group, clock)
    if settings.kind == "trigno":
        places_of(settings.channels)
        return lambda: TrignoSource(settings, clock)
    if settings.kind == "lsl":
        load_pylsl("session.emg")
        channels, stream, delay_s = settings.channels, settings.stream, settings.delay_s
        return lambda: LslSource("emg", channels, clock, table="session.emg", stream=stream, delay_s=delay_s)
    raise _nobody("emg")


def _on_one_card(settings: EmgSourceSettings, force: ForceSettings) -> bool:
    """Are EMG and gauges on one card, which has one sample clock?"""
    cards = {name.partition("/")[0] for name in settings.channels.values()}
    return force.kind == "ni-daq" and (force.channels or "").partition("/")[0] in cards


def _rig_force(settings: ForceSourceSettings, force: ForceSettings | None, inputs: NiInputs, clock: Clock) -> Maker:
    unit_axis(settings.axis)
    if force is None:
        do = "Name the rig file whose [force] table describes the sensor."
        raise SettingError("session.force.rig", wanted="a rig file", found="none", do=do)
    bias = force.bias
    if force.kind == "net-ft":
        if (host := force.host) is None:
            do = "Write it into the rig file; it leaves the factory with 192.168.1.1."
            raise SettingError("force.host", wanted="the address of the box", found="none", do=do)
        ports = {"rdt_port": force.rdt_port, "http_port": force.http_port}

        def box() -> Source:
            sensor = open_net_ft(host, clock, buffered=force.buffered, stale_s=STALE_S, **ports)
            return RigForce(sensor, settings, clock, rate_hz=sensor.config.rate_hz, bias=bias)

        return box
    load_nidaqmx('force.kind = "ni-daq"')
    calibration = read_calibration(force.cal_file or "")
    gauges = inputs.add((force.channels or "",), 6, calibration.range_v, differential=True)

    def card() -> Source:
        sensor = DaqFt(gauges, calibration, clock, stale_s=STALE_S)
        return RigForce(sensor, settings, clock, rate_hz=gauges.rate_hz, bias=bias)

    return card


def _nobody(table: str) -> SettingError:
    do = "Run the session with --virtual, or choose the kind of the device."
    return SettingError(f"session.{table}.kind", wanted="a device", found='"simulated"', do=do)
