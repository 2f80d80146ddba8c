"""What the emulated box serves beside records: its configuration as XML, and commands over TCP."""

from __future__ import annotations

from struct import Struct
from xml.sax.saxutils import escape

from emg2vsa.rig.emulated.rdt_box import INTERNAL_RATE_HZ, RdtBox

SERIAL = "FT00000"
TCP_REQUEST_BYTES = 20

_FORCE_CODES = {"lbf": 1, "N": 2, "klbf": 3, "kN": 4, "kgf": 5, "gf": 6}
_TORQUE_CODES = {"lbf-in": 1, "lbf-ft": 2, "Nm": 3, "N-m": 3, "Nmm": 4, "N-mm": 4, "kgf-cm": 5, "kNm": 6, "kN-m": 6}
_READING = Struct(">HH6h")
_CALIBRATION = Struct(">HBBII6H")
_READ_FORCE, _READ_CALIBRATION = 0, 1
_HEADER = 0x1234


def configuration_page(box: RdtBox) -> bytes:
    """netftapi2.xml: the tags of a live box that clients look at, in its order."""
    s = box.settings
    tags = {
        "runstat": "0x00000000",
        "runrate": INTERNAL_RATE_HZ,
        "cfgnam": "emulated",
        "cfgcalsel": 0,
        "cfgcalsn": SERIAL,
        "scfgfu": s.force_unit,
        "scfgtu": s.torque_unit,
        "cfgcpf": s.counts_per_force,
        "cfgcpt": s.counts_per_torque,
        "cfgmr": ";".join(f"{rating:g}" for rating in s.rating),
        "setcfgsel": 0,
        "setbias": "0;0;0;0;0;0",
        "comrdte": "Enabled",
        "comrdtrate": INTERNAL_RATE_HZ // s.divisor,
        "comrdtbsiz": s.buffer,
    }
    if s.axia:
        tags = {"prodname": "Ethernet Axia"} | tags
    return _page("netft", tags)


def calibration_page() -> bytes:
    """netftcalapi.xml: which transducer."""
    return _page("netftcal", {"calsn": SERIAL})


def tcp_answer(box: RdtBox, request: bytes, time_s: float) -> bytes:
    """Answer to one 20-byte command on TCP port 49151: READFT and READCALINFO; nothing to any other."""
    s = box.settings
    # counts of 32 bits are divided to fit 16
    scale = [min(max(1, int(rating * per_unit) // 2**15 + 1), 2**16 - 1) for rating, per_unit in _ranges(box)]
    if request[0] == _READ_FORCE:
        status, counts = box.reading(time_s)
        short = (min(max(round(count / by), -(2**15)), 2**15 - 1) for count, by in zip(counts, scale, strict=True))
        return _READING.pack(_HEADER, status >> 16, *short)
    if request[0] == _READ_CALIBRATION:
        units = _FORCE_CODES[s.force_unit], _TORQUE_CODES[s.torque_unit]
        return _CALIBRATION.pack(_HEADER, *units, s.counts_per_force, s.counts_per_torque, *scale)
    return b""


def _ranges(box: RdtBox) -> list[tuple[float, int]]:
    s = box.settings
    return list(zip(s.rating, [s.counts_per_force] * 3 + [s.counts_per_torque] * 3, strict=True))


def _page(root: str, tags: dict[str, object]) -> bytes:
    lines = "\n".join(f"<{tag}>{escape(str(text))}</{tag}>" for tag, text in tags.items())
    return f'<?xml version="1.0"?><{root}>\n{lines}\n</{root}>'.encode("ascii")
