"""What the box says of itself over HTTP: scales, units, product and rates. Counts mean nothing without it."""

from __future__ import annotations

import http.client
import math
from dataclasses import dataclass
from xml.etree import ElementTree

from emg2vsa.ati.units import FORCE_N, TORQUE_NM, unit_in_si
from emg2vsa.devices.protocols import Rating
from emg2vsa.errors import DeviceError

PATH = "/netftapi2.xml"


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
    """The active configuration of the box at ``host``. Raises DeviceError when it does not answer or makes no sense."""
    where = f"http://{host}:{port}{PATH}"
    # straight to the box: a proxy set for the web does not know it
    connection = http.client.HTTPConnection(host, port, timeout=timeout_s)
    try:
        connection.request("GET", PATH)
        answer = connection.getresponse()
        page = answer.read()
    except (OSError, http.client.HTTPException) as error:
        raise DeviceError(
            where, wanted="the box's configuration", found=str(error), do="Check address, cable and power."
        ) from error
    finally:
        connection.close()
    if answer.status != http.client.OK:
        raise DeviceError(
            where,
            wanted="the box's configuration",
            found=f"HTTP status {answer.status}",
            do="Check that the address is that of a Net F/T box.",
        )
    return parse_config(page, where)


def parse_config(page: bytes, where: object = PATH) -> NetFtConfig:
    """Configuration from the page the box serves. Raises DeviceError when a scale, unit or rate is missing or odd."""
    try:
        tags = {element.tag: (element.text or "").strip() for element in ElementTree.fromstring(page).iter()}
    except ElementTree.ParseError as error:
        raise DeviceError(
            where,
            wanted="the box's configuration as XML",
            found=str(error),
            do="Check that the address is that of a Net F/T box.",
        ) from (error)
    if tags.get("comrdte", "Enabled") in ("Disabled", "0"):
        raise DeviceError(
            where, wanted="raw data transfer enabled", found="disabled", do="Enable RDT on the Communications page."
        )
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
        raise DeviceError(
            f"{where}, {tag}",
            wanted="a number above 0",
            found=repr(tags[tag]) if tag in tags else "nothing",
            do="Check the box's configuration and firmware.",
        )
    return value
