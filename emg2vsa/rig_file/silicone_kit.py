"""Specimens whose softness is known: which silicone, and how high a cylinder of it, has a wanted stiffness.

Moduli: Dawood, Zhang, Osman, Suulker, Abdulali, Angelmahr, Althoefer 2026, Tissue Phantom Material Database, CC BY 4.0.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.optimize import brentq

from casr.atomic import write_text_atomic
from emg2vsa.curves.rubber import Cylinder
from emg2vsa.errors import DataError, SettingError
from emg2vsa.settings import WindowSettings

SOURCE = "Moduli: Dawood et al. 2026, Tissue Phantom Material Database, CC BY 4.0"
OFF_SD = 0.067
"""SD by which kappa of a casting differs from what this module says, as a share: root mean square
over the ten mixtures (``benchmarks.silicone``)."""
_SHAPES = (0.4, 1.0)
"""Height over diameter: of a flatter cylinder the ends decide, a higher one bends."""
_MOST_STRAIN = 0.35


@dataclass(frozen=True)
class Silicone:
    """Ecoflex with a share of silicone thinner. modulus_kpa, sd_kpa : published mean and SD over ten tests."""

    name: str
    base: str
    thinner_percent: float
    modulus_kpa: float
    sd_kpa: float

    @property
    def recipe(self) -> str:
        return f"Ecoflex {self.base}" + (f", {self.thinner_percent:g} % thinner" if self.thinner_percent else "")


SILICONES = (
    Silicone("EF10_100T", "00-10", 100, 6.19, 0.77), Silicone("EF10_75T", "00-10", 75, 9.58, 0.12),
    Silicone("EF10_50T", "00-10", 50, 16.29, 0.40), Silicone("EF10_25T", "00-10", 25, 28.16, 0.79),
    Silicone("EF30_50T", "00-30", 50, 31.85, 0.62), Silicone("EF30_25T", "00-30", 25, 50.21, 1.50),
    Silicone("EF10_0T", "00-10", 0, 56.27, 2.12), Silicone("EF50_37_5T", "00-50", 37.5, 72.76, 3.07),
    Silicone("EF30_0T", "00-30", 0, 103.46, 2.32), Silicone("EF50_12_5T", "00-50", 12.5, 111.86, 6.44),
)  # fmt: skip


@dataclass(frozen=True)
class Recipe:
    """A specimen to be cast. kappa_n_per_mm : secant over the range of force, by a Neo-Hookean cylinder of the
    published modulus; low, high : 95 % of castings. change : of kappa over the range, a share. strain : at the larger
    force."""

    specimen: str
    wanted_n_per_mm: float
    silicone: Silicone
    size: Cylinder
    kappa_n_per_mm: float
    change: float
    strain: float

    @property
    def low(self) -> float:
        return self.kappa_n_per_mm * (1 - 2 * OFF_SD)

    @property
    def high(self) -> float:
        return self.kappa_n_per_mm * (1 + 2 * OFF_SD)


def kappa_of(silicone: Silicone, size: Cylinder, range_n: tuple[float, float]) -> tuple[float, float, float]:
    """Secant over the forces, N/mm; change of the tangent over them, a share of it; strain at the larger one."""
    depth = size.height_mm * np.linspace(0, 0.9, 4001)
    force = size.force_n(depth, silicone.modulus_kpa)
    if force[-1] <= range_n[1]:
        return 0.0, np.nan, 1.0  # squeezed flat before that
    first, last = np.interp(range_n, force, depth)
    slope = np.interp((first, last), depth, np.gradient(force, depth))
    secant = (range_n[1] - range_n[0]) / (last - first)
    return float(secant), float((slope[1] - slope[0]) / secant), float(last / size.height_mm)


def recipe_for(
    specimen: str, wanted_n_per_mm: float, diameter_mm: float = 50.0, height_mm: float | None = None,
    range_n: tuple[float, float] = WindowSettings().force_n,
) -> Recipe:  # fmt: skip
    """The silicone whose cylinder has this stiffness, N/mm, at the height that strains it least; with a stated height,
    mm, the one that comes nearest.

    range_n : between which the stiffness is meant, N. SettingError : none does.
    """
    found = []
    for silicone in SILICONES:
        height = height_mm or _height(silicone, wanted_n_per_mm, diameter_mm, range_n)
        if height is not None:
            size = Cylinder(diameter_mm, height)
            found.append(Recipe(specimen, wanted_n_per_mm, silicone, size, *kappa_of(silicone, size, range_n)))
    within = [each for each in found if each.strain <= _MOST_STRAIN]
    if not within:
        softest, stiffest = (
            kappa_of(silicone, Cylinder(diameter_mm, height_mm or share * diameter_mm), range_n)[0]
            for silicone, share in zip((SILICONES[0], SILICONES[-1]), reversed(_SHAPES), strict=True)
        )
        wanted = f"{softest:.2g} to {stiffest:.2g} N/mm, as cylinders of {diameter_mm:g} mm have, at strains up to "
        do = "Choose another diameter, height, stiffness or range of force."
        raise SettingError(
            f"stiffness of {specimen}",
            wanted=f"{wanted}{100 * _MOST_STRAIN:g} %",
            found=f"{wanted_n_per_mm:g} N/mm",
            do=do,
        )
    if height_mm:
        return min(within, key=lambda each: abs(np.log(each.kappa_n_per_mm / wanted_n_per_mm)))
    return min(within, key=lambda each: each.strain)


def _height(silicone: Silicone, wanted: float, diameter_mm: float, range_n: tuple[float, float]) -> float | None:
    """Height of a cylinder of this stiffness, within the shapes that are cast; to a tenth of a millimetre."""

    def above(height: float) -> float:
        return kappa_of(silicone, Cylinder(diameter_mm, height), range_n)[0] - wanted

    least, most = (share * diameter_mm for share in _SHAPES)
    return round(float(brentq(above, least, most)), 1) if above(least) >= 0 >= above(most) else None


def lines(recipes: Sequence[Recipe], range_n: tuple[float, float]) -> Iterator[str]:
    """The recipes as a table to read: mm, and N/mm over ``range_n``, N."""
    yield (
        f"{'specimen':<10}{'wanted':>8}  {'silicone':<30}{'diameter':>9}{'height':>8}{'kappa (95 % of castings)':>28}"
        f"{'change':>8}{'strain':>8}"
    )
    for each in recipes:
        kappa = f"{each.kappa_n_per_mm:.3g} ({each.low:.3g} to {each.high:.3g})"
        yield (
            f"{each.specimen:<10}{each.wanted_n_per_mm:>8.3g}  {each.silicone.recipe:<30}{each.size.diameter_mm:>9g}"
            f"{each.size.height_mm:>8g}{kappa:>28}{100 * each.change:>6.0f} %{100 * each.strain:>6.0f} %"
        )
    yield from (f"note: {note}" for note in _notes(recipes))
    yield f"Millimetres; N/mm from {range_n[0]:g} to {range_n[1]:g} N, plates lubricated; change and strain over these."
    yield f"Castings differ: measure each one with emg2vsa tools stiffness. {SOURCE}."


def _notes(recipes: Sequence[Recipe]) -> Iterator[str]:
    """What the castings will not tell apart, and what is not near."""
    for each in recipes:
        if not _SHAPES[0] <= each.size.height_mm / each.size.diameter_mm <= _SHAPES[1]:
            shapes = f"{_SHAPES[0]:g} to {_SHAPES[1]:g} times the diameter"
            yield f"{each.specimen}: its height is not {shapes}: the ends decide, or it bends"
        if not each.low <= each.wanted_n_per_mm <= each.high:
            yield f"{each.specimen}: no silicone at this height is nearer to {each.wanted_n_per_mm:g} N/mm"
    for one, other in pairwise(sorted(recipes, key=lambda each: each.kappa_n_per_mm)):
        if other.low < one.high:
            pair = f"{other.specimen} and {one.specimen}"
            yield f"{pair} may come out in either order: cast several of each, measure them, and choose"


def specimens_toml(recipes: Sequence[Recipe], range_n: tuple[float, float]) -> str:
    """The recipes as ``[[specimens]]`` of a study file. range_n : of their stiffness, N."""
    text = f"# Specimens to be cast, as emg2vsa tools cast wrote them. {SOURCE}.\n"
    text += "# Stiffness is what is expected, not measured: emg2vsa tools stiffness --write measures it.\n"
    for each in recipes:
        text += f"""
[[specimens]] # {each.silicone.recipe}, {each.silicone.modulus_kpa:g} kPa
name = "{each.specimen}"
stiffness_n_per_mm = {each.kappa_n_per_mm:.3g}
stiffness_se_n_per_mm = {OFF_SD * each.kappa_n_per_mm:.2g}
stiffness_range_n = [{range_n[0]:g}, {range_n[1]:g}]
stiffness_change = {each.change:.2g}
diameter_mm = {each.size.diameter_mm:g}
height_mm = {each.size.height_mm:g}
"""
    return text


def write_specimens(path: Path, recipes: Sequence[Recipe], range_n: tuple[float, float]) -> None:
    """Write ``specimens_toml`` over ``range_n``, N. DataError where there is a file already."""
    if path.exists():
        raise DataError(path, wanted="a new file", found="one that is there", do="Choose another name.")
    write_text_atomic(path, specimens_toml(recipes, range_n))
