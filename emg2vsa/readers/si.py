"""Stored channels to SI: voltages in V, forces in N, with the conversion written down."""

from __future__ import annotations

from emg2vsa.readers.opened import StoredChannel
from emg2vsa.readers.units import si_factor
from emg2vsa.recordings import Channel


def to_si(stored: StoredChannel) -> Channel:
    """V and N by the file's own unit; any other unit is kept as the file spells it ("" where it states none)."""
    known = si_factor(stored.unit)
    if known is None:
        return scaled(stored, 1.0, stored.unit or "", f"{stored.unit} as stored" if stored.unit else "no unit stated")
    unit, factor = known
    return scaled(stored, factor, unit, unit_step(str(stored.unit), factor, unit))


def unit_step(written: str, factor: float, unit: str) -> str:
    """ "mV x 0.001 = V", or "V as stored"."""
    return f"{unit} as stored" if factor == 1.0 else f"{written} x {factor:.10g} = {unit}"


def scaled(stored: StoredChannel, factor: float, unit: str, conversion: str) -> Channel:
    """The channel times ``factor``; works on the samples in place, which nobody else holds."""
    samples = stored.samples
    if factor != 1.0:
        samples *= factor
    return Channel(stored.name, samples, unit, stored.fs_hz, stored.start_s, conversion)
