"""What ATI's Net F/T box and Ethernet Axia say: records by raw data transfer (RDT), and of themselves over HTTP.

ATI manuals 9620-05 (Net F/T) and 9610-05 (Ethernet Axia). All numbers are big-endian. The counts of a record mean
nothing without the scales and units of the web page.
"""

from __future__ import annotations

import http.client
import math
from dataclasses import dataclass
from enum import IntEnum
from functools import lru_cache
from struct import Struct
from typing import NamedTuple
from xml.etree import ElementTree

from emg2vsa.ati import FORCE_N, TORQUE_NM, unit_in_si
from emg2vsa.devices.protocols import Rating, SensorStatus
from emg2vsa.errors import DeviceError

PATH = "/netftapi2.xml"
_NO_BOX = "Check that the address is that of a Net F/T box."
LARGEST_BUFFER = 40
"Records that one datagram carries at most in buffered mode."

_HEADER = 0x1234
_REQUEST = Struct(">HHI")
_RECORD = Struct(">III6i")


class Command(IntEnum):
    """What a client may ask for."""

    STOP = 0x0000
    STREAM = 0x0002
    "One record a datagram."
    BUFFERED = 0x0003
    "Command for as many records a datagram as the box's RDT buffer size says."
    BIAS = 0x0042
    "Present load becomes zero; not answered."


class Record(NamedTuple):
    """One measurement as the box sends it.

    rdt_sequence : 1, 2, ... within one request.
    ft_sequence : internal samples since power-up.
    status : status word; which bit means what depends on the product.
    counts : Fx, Fy, Fz, Tx, Ty, Tz in counts; their size is told over HTTP.
    """

    rdt_sequence: int
    ft_sequence: int
    status: int
    counts: tuple[int, ...]


def request_bytes(command: Command, sample_count: int = 0) -> bytes:
    """A request for ``sample_count`` records, 0 for no end."""
    return _REQUEST.pack(_HEADER, command, sample_count)


def parse_request(data: bytes) -> tuple[int, int] | None:
    """Command and sample count; None for anything that is no request."""
    if len(data) != _REQUEST.size:
        return None
    header, command, count = _REQUEST.unpack(data)
    return (command, count) if header == _HEADER else None


def record_bytes(record: Record) -> bytes:
    """A record as it goes over the wire, 36 bytes."""
    return _RECORD.pack(record.rdt_sequence, record.ft_sequence, record.status, *record.counts)


def parse_records(data: bytes) -> list[Record]:
    """The records of a datagram; none when its length is no multiple of a record's."""
    if len(data) % _RECORD.size:
        return []
    return [Record(rdt, ft, status, tuple(counts)) for rdt, ft, status, *counts in _RECORD.iter_unpack(data)]


_WRAP = 2**32


def steps(before: int, after: int) -> int:
    """Steps from one 32-bit number to another, forwards or backwards, whichever is shorter."""
    return (after - before + _WRAP // 2) % _WRAP - _WRAP // 2


# the two products give the same bits of the status word different meanings
ANY_ERROR = 1 << 31

NETBOX = {
    30: "CPU or RAM error",
    29: "digital board error",
    28: "analog board error",
    27: "serial link error",
    26: "program verify error",
    25: "halted by configuration error",
    24: "settings validation error",
    23: "configuration and calibration do not match",
    22: "network error",
    21: "CAN error",
    20: "RDT error",
    19: "EtherNet/IP error",
    18: "DeviceNet error",
    17: "transducer saturation or A/D error",
    14: "watchdog reset",
    13: "stack error",
    12: "EEPROM I2C error",
    11: "flash SPI error",
    10: "analog watchdog reset",
    9: "excitation current too high",
    8: "excitation current too low",
    7: "analog ground out of range",
    6: "supply too high",
    5: "supply too low",
    4: "serial data not available",
    3: "reference voltage or power monitor error",
    2: "temperature out of range",
    1: "HTTP error",
}
"Net F/T box, manual 9620-05; bits 31 and 16 are not here: the summary, and a monitor condition, which is no fault."

MONITOR_CONDITION = 1 << 16

AXIA = {
    0: "temperature out of range",
    1: "supply voltage out of range",
    2: "broken gauge",
    3: "busy",
    5: "another error",
    27: "gauge out of range",
    28: "force is simulated",
    29: "calibration checksum error",
    30: "force or torque out of range",
}
"Ethernet Axia, manual 9610-05."


@lru_cache(maxsize=256)
def netbox_status(word: int) -> SensorStatus:
    """Status of a Net F/T box. A latched monitor condition (0x80010000) is a warning: somebody set a threshold."""
    warnings = ("monitor condition latched",) if word & MONITOR_CONDITION else ()
    return _status(word, NETBOX, word & ~MONITOR_CONDITION, warnings)


@lru_cache(maxsize=256)
def axia_status(word: int) -> SensorStatus:
    """Status of an Ethernet Axia."""
    return _status(word, AXIA, word, ())


def _status(word: int, names: dict[int, str], fault_bits: int, warnings: tuple[str, ...]) -> SensorStatus:
    causes = fault_bits & ~ANY_ERROR
    faults = [names.get(bit, f"status bit {bit}") for bit in range(30, -1, -1) if causes >> bit & 1]
    if word & ANY_ERROR and not faults and not warnings:
        faults = ["an error without a cause"]
    return SensorStatus(word, tuple(faults), warnings)


@dataclass(frozen=True)
class NetFtConfig:
    """Settings of a box that are needed to read its records.

    n_per_count, nm_per_count : size of a count, N and N·m.
    rate_hz : records a second.
    axia : an Ethernet Axia, else a Net F/T box; their status words differ.
    product, calibration_serial : as told; empty when not.
    rating : of the transducer (``cfgmr``); None when it is not told as six numbers above 0.
    """

    n_per_count: float
    nm_per_count: float
    rate_hz: float
    axia: bool = False
    product: str = ""
    calibration_serial: str = ""
    rating: Rating | None = None


def fetch_config(host: str, port: int = 80, timeout_s: float = 2.0) -> NetFtConfig:
    """The active configuration of the box at ``host``. Raises DeviceError when it does not answer within ``timeout_s``
    (s) or makes no sense."""
    where = f"http://{host}:{port}{PATH}"
    # straight to the box: a proxy set for the web does not know it
    connection = http.client.HTTPConnection(host, port, timeout=timeout_s)
    try:
        connection.request("GET", PATH)
        answer = connection.getresponse()
        page = answer.read()
    except (OSError, http.client.HTTPException) as error:
        do = "Check address, cable and power."
        raise DeviceError(where, wanted="the box's configuration", found=str(error), do=do) from error
    finally:
        connection.close()
    if answer.status != http.client.OK:
        found = f"HTTP status {answer.status}"
        raise DeviceError(where, wanted="the box's configuration", found=found, do=_NO_BOX)
    return parse_config(page, where)


def parse_config(page: bytes, where: object = PATH) -> NetFtConfig:
    """Configuration from the page the box serves. Raises DeviceError when a scale, unit or rate is missing or odd."""
    try:
        tags = {element.tag: (element.text or "").strip() for element in ElementTree.fromstring(page).iter()}
    except ElementTree.ParseError as error:
        raise DeviceError(where, wanted="the box's configuration as XML", found=str(error), do=_NO_BOX) from error
    if tags.get("comrdte", "Enabled") in ("Disabled", "0"):
        do = "Enable RDT on the Communications page."
        raise DeviceError(where, wanted="raw data transfer enabled", found="disabled", do=do)
    product = tags.get("prodname", "")
    newton = unit_in_si(FORCE_N, tags.get("scfgfu", ""), f"{where}, scfgfu")
    newton_metre = unit_in_si(TORQUE_NM, tags.get("scfgtu", ""), f"{where}, scfgtu")
    return NetFtConfig(
        n_per_count=newton / _number(tags, "cfgcpf", where),
        nm_per_count=newton_metre / _number(tags, "cfgcpt", where),
        rate_hz=_number(tags, "comrdtrate", where),
        axia="axia" in product.lower(),
        product=product,
        calibration_serial=tags.get("cfgcalsn", ""),
        rating=_rating(tags.get("cfgmr", ""), newton, newton_metre),
    )


def _rating(text: str, newton: float, newton_metre: float) -> Rating | None:
    try:
        fx, fy, fz, tx, ty, tz = map(float, text.rstrip("; ").split(";"))
    except ValueError:
        return None
    if not all(0 < value < math.inf for value in (fx, fy, fz, tx, ty, tz)):
        return None
    return Rating((fx * newton, fy * newton, fz * newton), (tx * newton_metre, ty * newton_metre, tz * newton_metre))


def _number(tags: dict[str, str], tag: str, where: object) -> float:
    try:
        value = float(tags.get(tag, "nothing"))
    except ValueError:
        value = math.nan
    if not 0 < value < math.inf:
        found, do = repr(tags[tag]) if tag in tags else "nothing", "Check the box's configuration and firmware."
        raise DeviceError(f"{where}, {tag}", wanted="a number above 0", found=found, do=do)
    return value
