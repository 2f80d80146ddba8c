"""One word, two meanings: the status of the Net F/T box and of the Ethernet Axia."""

from __future__ import annotations

import pytest

from emg2vsa.devices.netft.box import axia_status, netbox_status

NETBOX = [
    (0x00000000, (), ()),
    (0x80010000, (), ("monitor condition latched",)),
    (0x80020000, ("transducer saturation or A/D error",), ()),
    (0x80030000, ("transducer saturation or A/D error",), ("monitor condition latched",)),
    (0x80000004, ("temperature out of range",), ()),
    (0xC0000000, ("CPU or RAM error",), ()),
    (0x80000300, ("excitation current too high", "excitation current too low"), ()),
    (0x80000000, ("an error without a cause",), ()),
    (0x80000001, ("status bit 0",), ()),
    (0x00100000, ("RDT error",), ()),
]
AXIA = [
    (0x00000000, ()),
    (0x80000001, ("temperature out of range",)),
    (0x80000004, ("broken gauge",)),
    (0x88000000, ("gauge out of range",)),
    (0x90000000, ("force is simulated",)),
    (0xC0000000, ("force or torque out of range",)),
    (0x80010000, ("status bit 16",)),
]


@pytest.mark.parametrize(("word", "faults", "warnings"), NETBOX)
def test_net_ft_box(word, faults, warnings):
    status = netbox_status(word)
    assert (status.code, status.faults, status.warnings) == (word, faults, warnings)


@pytest.mark.parametrize(("word", "faults"), AXIA)
def test_ethernet_axia(word, faults):
    status = axia_status(word)
    assert (status.code, status.faults, status.warnings) == (word, faults, ())


NETBOX_BITS = {
    30: "CPU or RAM", 29: "digital board", 28: "analog board", 27: "serial link", 26: "program verify",
    25: "halted by configuration", 24: "settings validation", 23: "configuration and calibration", 22: "network",
    21: "CAN", 20: "RDT", 19: "EtherNet/IP", 18: "DeviceNet", 17: "transducer saturation or A/D", 14: "watchdog",
    13: "stack", 12: "EEPROM", 11: "flash", 10: "analog watchdog", 9: "excitation current too high",
    8: "excitation current too low", 7: "analog ground", 6: "supply too high", 5: "supply too low",
    4: "serial data not available", 3: "reference voltage", 2: "temperature", 1: "HTTP",
}  # fmt: skip
"""As netft-cpp decodes them."""


@pytest.mark.parametrize(("bit", "name"), NETBOX_BITS.items())
def test_each_bit_of_the_net_ft_box_has_its_name(bit: int, name: str) -> None:
    assert netbox_status(1 << 31 | 1 << bit).faults[0].startswith(name)
