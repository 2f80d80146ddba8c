"""One word, two meanings: the status of the Net F/T box and of the Ethernet Axia."""

from __future__ import annotations

import pytest

from emg2vsa.rig.force.rdt import axia_status, netbox_status

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
