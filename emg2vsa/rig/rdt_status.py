"""Status words of RDT records. The Net F/T box and the Ethernet Axia give the same bits different meanings."""

from __future__ import annotations

from functools import lru_cache

from emg2vsa.rig.force_sensor import SensorStatus

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
