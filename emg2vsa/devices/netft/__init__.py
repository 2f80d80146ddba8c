"""ATI's Net F/T box and Ethernet Axia as the force sensor of a rig: table [force]."""

from __future__ import annotations

from typing import Literal

from emg2vsa.devices.device_settings import ForceSettings, NetPort, Text
from emg2vsa.devices.registry import Kind
from emg2vsa.settings_class import settings_class

RDT_PORT = 49152
"""UDP port of the raw data of ATI's boxes."""
INTERNAL_RATE_HZ = 7000
"""Rate at which a box samples; it sends every one, or every second, third, ..."""


@settings_class
class NetFtSettings(ForceSettings):
    """A Net F/T box or Ethernet Axia of ATI, on the network."""

    kind: Literal["net-ft"] = "net-ft"
    host: Text | None = None
    "Address of the box; 192.168.1.1 when it leaves the factory. Omitted: only the emulated rig can run."
    rdt_port: NetPort = RDT_PORT
    "UDP port of its raw data."
    http_port: NetPort = 80
    "Port of its web page, which tells scales and units."
    buffered: bool = False
    "Many records in a datagram; less work for both ends, and later by a buffer's time."


NET_FT = Kind(
    "force", NetFtSettings, open="netft.driver:open_net_ft", about="netft.driver:about", facts="netft.driver:facts",
    serial_number=lambda sensor: sensor.config.calibration_serial,
)  # fmt: skip
