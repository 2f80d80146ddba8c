"""Units that ATI's boxes and calibration files speak of, by number and by name, in N, N·m and m."""

from __future__ import annotations

from emg2vsa.errors import DeviceError

LBF_N = 4.4482216152605
KGF_N = 9.80665
INCH_M = 0.0254

FORCE_N = {"lbf": LBF_N, "N": 1.0, "klbf": 1e3 * LBF_N, "kN": 1e3, "kgf": KGF_N, "gf": 1e-3 * KGF_N}
TORQUE_NM = {
    "lbf-in": LBF_N * INCH_M,
    "lbf-ft": LBF_N * 12 * INCH_M,
    "N-m": 1.0,
    "N-mm": 1e-3,
    "kgf-cm": 1e-2 * KGF_N,
    "kN-m": 1e3,
}
LENGTH_M = {"in": INCH_M, "ft": 12 * INCH_M, "mm": 1e-3, "cm": 1e-2, "m": 1.0}

_SPELLINGS = {"Nm": "N-m", "Nmm": "N-mm", "kNm": "kN-m", "kg-cm": "kgf-cm", "in-lbf": "lbf-in", "ft-lbf": "lbf-ft"}


def unit_in_si(units: dict[str, float], name: str, where: object) -> float:
    """Size of the unit ``name`` of one of the tables above in N, N·m or m. Raises DeviceError when it is not there."""
    name = name.strip()
    size = units.get(_SPELLINGS.get(name, name))
    if size is None:
        raise DeviceError(
            where,
            wanted=f"one of the units {', '.join(units)}",
            found=repr(name),
            do="Choose one of these on the sensor's configuration page, or give the right file.",
        )
    return size
