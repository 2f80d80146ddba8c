"""Does the solver of ``casr dome`` agree with what others' mechanics and other elements say of contact?

``python -m benchmarks.dome_solver CONTACT_FEM | python -m benchmarks.bench.record dome_solver``: six minutes of one
process. CONTACT_FEM: tables of four-node elements, the folder that scripts/dome_tables gathers. Needs scikit-fem, and
ContactMechanics (in the extra test) for the table of layers, which is left out without it.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from casr.dome.solver.bodies import Rubber
from casr.dome.solver.cases import AREA_AT_N, area_error, areas_mm2
from casr.dome.solver.press import Dome, Pressed, Pressing, Specimen, press
from casr.dome.solver.punch import punch_on_block_mm
from casr.dome.tables import ContactTable, read_table

SKIN, GEL_SHARE = Rubber(0.8), {"A": 0.0375, "C": 0.0125, "E": 0.33, "G": 2.0}
"""Modulus of the gel over that of the skin, of the tables' domes. Of A both are told; of the others only this."""
TABLES = ("A_k1.1", "A_k5.3", "A_k20", "A_krigid", "library/C_k5.3", "library/E_k5.3", "library/G_k5.3")
BLOCK_MM = 41.8
"Stiffness over modulus of the tables' block of 35 x 25 mm, 1 mm deep under a punch of 10 mm radius."
STIFF = Rubber(1000.0, 0.3)
LAYER = Rubber(0.1)
LAYER_AT_N = (0.2, 0.4, 0.8)
POINTS, SIDE_MM = 768, 36.0
USUAL, COARSER = (0.5, 0.12, 1.0), ((1.0, 0.24, 1.0), (0.5, 0.12, 0.5))
FINER = (*COARSER, USUAL, (0.25, 0.12, 1.0), (0.5, 0.03, 1.0), (0.5, 0.12, 4.0), (0.25, 0.06, 4.0))
"""Mesh and longest step, mm, and penalty in usual ones."""


def dome_of(name: str, modulus_mpa: float = SKIN.modulus_mpa) -> Dome:
    return Dome(20.0, 1.0, Rubber(modulus_mpa), Rubber(GEL_SHARE[name] * modulus_mpa))


def scaled(name: str, folder: Path) -> Dome:
    """With the modulus, to which force is proportional, that gives the force of its table on a rigid plate."""
    if name == "A":
        return dome_of(name)
    found = press(Pressing(dome_of(name), Specimen(None), force_n=3.0))
    with np.load(folder / "library" / f"{name}_krigid_frictionless.npz") as table:
        depth = min(table["depth_mm"][-1], found.depth_mm[-1]) * np.linspace(0.5, 1.0, 20)
        force = np.interp(depth, table["depth_mm"], table["force_n"]).mean()
    mine = np.interp(depth, found.depth_mm, found.force_n).mean()
    return dome_of(name, SKIN.modulus_mpa * float(force / mine))


def specimen_of(stiffness_n_per_mm: float, height_mm: float = 25.0) -> Specimen:
    """By the modulus that a block of 25 mm of this stiffness has."""
    if np.isinf(stiffness_n_per_mm):
        return Specimen(None)
    return Specimen(Rubber(stiffness_n_per_mm / BLOCK_MM), 35.0, height_mm)


def rate(found: Pressed) -> float:
    """Slope of the area over .5 to 4 N, mm2/N."""
    at = np.linspace(0.5, 4.0, 50)
    return float(np.polyfit(at, areas_mm2(found, list(at)), 1)[0])


def against_tables(folder: Path) -> Iterator[str]:
    head = " | ".join(f"area at {n:g} N, off (%)" for n in AREA_AT_N)
    yield f"| table | {head} | u_r off (% of R) | u_z off (% of R) | tilt off (mrad) | balance | rows | time (s) |"
    yield "|---|" + "---:|" * 10
    for start in TABLES:
        dome = scaled(start.rpartition("/")[2][0], folder)
        for friction in ("frictionless", "stick"):
            table = read_table(folder / f"{start}_{friction}.npz")
            began = time.process_time()
            found = press(Pressing(dome, specimen_of(table.stiffness_n_per_mm), np.inf if friction == "stick" else 0.0))
            took = time.process_time() - began
            theirs = np.pi * np.interp(AREA_AT_N, table.force_n, table.contact_radius_mm) ** 2
            off = 100 * (np.array(areas_mm2(found, AREA_AT_N)) / theirs - 1)
            moved = motion_off(found, table)
            cells = [f"{each:+.1f}" for each in off] + [f"{5 * each:.2f}" for each in moved[:2]]
            cells += [f"{1e3 * moved[2]:.1f}", f"{found.unbalance:.0e}", str(len(found.force_n)), f"{took:.0f}"]
            yield f"| {start.rpartition('/')[2]}, {friction} | {' | '.join(cells)} |"


def motion_off(found: Pressed, table: ContactTable) -> np.ndarray:
    """Largest difference of u_r, u_z (mm) and tilt (rad) at .5 to 4 N, up to an arc of 27 mm."""
    arc = table.s_mm[table.s_mm < 27]
    worst = np.zeros(3)
    for force in AREA_AT_N:
        for axis, name in enumerate(("u_r_mm", "u_z_mm", "tilt_rad")):
            mine = np.array([np.interp(force, found.force_n, each) for each in getattr(found, name).T])
            theirs = np.array([np.interp(force, table.force_n, each) for each in table.motion[:, : arc.size, axis].T])
            worst[axis] = max(worst[axis], np.abs(np.interp(arc, found.s_mm, mine) - theirs).max())
    return worst


def hertz() -> Iterator[str]:
    yield "| ball on | force (N) | a / R | radius over Hertz's | depth over Hertz's |"
    yield "|---|" + "---:|" * 4
    ball = Rubber(0.5)
    for on, specimen in (("plate", None), ("equal block", ball), ("block of a fifth", Rubber(0.1))):
        wide = Specimen(specimen, 80.0, 80.0)
        found = press(Pressing(Dome(20.0, 1.0, ball, ball), wide, force_n=0.8, mesh_mm=0.25))
        soft = sum((1 - each.poisson**2) / each.modulus_mpa for each in (ball, specimen) if each)
        for force in (0.2, 0.4, 0.8):
            radius = np.sqrt(areas_mm2(found, [force])[0] / np.pi)
            theirs = np.cbrt(0.75 * force * 20.0 * soft)
            depth = np.interp(force, found.force_n, found.depth_mm) / (theirs**2 / 20.0)
            yield f"| {on} | {force} | {radius / 20:.3f} | {radius / theirs:.3f} | {depth:.3f} |"


def layer_area_mm2(height_mm: float, at_n: Sequence[float], mesh_mm: float = 0.25) -> list[float]:
    """Of a rigid ball on a layer bonded to a rigid plate."""
    ball, layer = Dome(20.0, 1.0, STIFF, STIFF), Specimen(LAYER, 35.0, height_mm)
    return areas_mm2(press(Pressing(ball, layer, force_n=at_n[-1], mesh_mm=mesh_mm)), at_n)


def others_area_mm2(force_n: float, height_mm: float, points: int = POINTS) -> float:
    """The same: linear elastic, periodic, by FFT."""
    from ContactMechanics import PeriodicFFTElasticHalfSpace, make_system
    from SurfaceTopography import Topography

    x = (np.arange(points) + 0.5 - points / 2) * SIDE_MM / points
    heights = np.sqrt(np.maximum(400.0 - x[:, None] ** 2 - x**2, 0.0)) - 20.0
    surface = Topography(heights, (SIDE_MM, SIDE_MM), periodic=True)
    shape = ((points, points), LAYER.modulus_mpa, (SIDE_MM, SIDE_MM))
    layer = PeriodicFFTElasticHalfSpace(*shape, thickness=height_mm, poisson=LAYER.poisson)
    system = make_system(substrate=layer, surface=surface)
    found = system.minimize_proxy(external_force=force_n, pentol=1e-7, maxiter=2000)
    assert found.success
    return float(system.compute_contact_area())


def layers() -> Iterator[str]:
    try:
        import ContactMechanics  # noqa: F401
    except ModuleNotFoundError:
        yield "ContactMechanics is not installed: its table is left out."
        return
    yield "| layer (mm) | force (N) | area by ContactMechanics (mm2) | here (mm2) | off (%) |"
    yield "|---:|" + "---:|" * 4
    for height in (10.0, 4.0):
        for force, area in zip(LAYER_AT_N, layer_area_mm2(height, LAYER_AT_N), strict=True):
            other = others_area_mm2(force, height)
            yield f"| {height:g} | {force} | {other:.2f} | {area:.2f} | {100 * (area / other - 1):+.1f} |"


def meshes() -> Iterator[str]:
    areas = " | ".join(f"A({n:g} N)" for n in AREA_AT_N)
    rest = "slope .5–4 N (mm2/N) | balance | work not stored | time (s)"
    yield f"| case | mesh (mm) | longest step (mm) | penalty | {areas} | {rest} |"
    yield "|---|" + "---:|" * 11
    rigid = Pressing(dome_of("A"), Specimen(None))
    soft = replace(rigid, specimen=specimen_of(5.3))
    stuck = replace(rigid, friction=np.inf)
    stated = []
    for name, case in (("rigid, frictionless", rigid), ("rigid, stick", stuck), ("5.3 N/mm, frictionless", soft)):
        found = {}
        for of in FINER:
            began = time.process_time()
            mesh, step, penalty = of
            found[of] = press(replace(case, mesh_mm=mesh, step_mm=step, penalty=penalty))
            took = time.process_time() - began
            one = found[of]
            cells = [f"{area:.1f}" for area in areas_mm2(one, AREA_AT_N)]
            cells += [f"{rate(one):.2f}", f"{one.unbalance:.0e}", f"{one.unstored:.0e}", f"{took:.0f}"]
            yield f"| {name} | {mesh:g} | {step:g} | {penalty:g} | {' | '.join(cells)} |"
        usual = found[USUAL]
        parts = [100 * area_error(found[of], usual) for of in COARSER]
        off = [f"{100 * area_error(usual, found[of]):.1f}" for of in (FINER[-2], FINER[-1])]
        stated.append(f"| {name} | {parts[0]:.1f} | {parts[1]:.1f} | {sum(parts):.1f} | {' | '.join(off)} |")
    yield "\nThe error that a table states, and how far its area is from finer solutions at worst (%):\n"
    yield "| case | of mesh and steps | of the penalty | stated | four penalties | also half the mesh and steps |"
    yield "|---|" + "---:|" * 5
    yield from stated


def worlds() -> Iterator[str]:
    """How much what the shipped tables leave out changes, on the material of dome A."""
    areas = " | ".join(f"A({n:g} N), change (%)" for n in AREA_AT_N)
    yield f"| changed | {areas} |"
    yield "|---|" + "---:|" * len(AREA_AT_N)
    base = Pressing(dome_of("A"), Specimen(None), force_n=4.2)
    soft = replace(base, specimen=specimen_of(5.3))
    pairs = (
        ("skin of 1.5 mm, rigid plate", replace(base, dome=replace(base.dome, skin_mm=1.5)), base),
        ("radius 25 mm, rigid plate", replace(base, dome=replace(base.dome, radius_mm=25.0)), base),
        ("gel of 5 kPa, rigid plate", replace(base, dome=replace(base.dome, gel=Rubber(0.005))), base),
        ("specimen of 10 mm, the modulus of 5.3 N/mm", replace(base, specimen=specimen_of(5.3, 10.0)), soft),
        ("Coulomb's friction .15, rigid plate", replace(base, friction=0.15), base),
    )
    for name, changed, plain in pairs:
        new, old = (np.array(areas_mm2(press(each), AREA_AT_N)) for each in (changed, plain))
        yield f"| {name} | {' | '.join(f'{each:+.1f}' for each in 100 * (new / old - 1))} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("contact_fem", type=Path)
    given = parser.parse_args()
    print("# The solver of domes against others\n")
    print("Tables of four-node elements with one volume each, .125 to .25 mm (dome A) and .5 mm (C, E, G) in the")
    print("contact, against nine-node elements of .5 mm. Of C, E and G the ratio of the moduli is known; their size is")
    print("taken from the force on a rigid plate.\n")
    print("\n".join(against_tables(given.contact_fem)), flush=True)
    print("\nA ball of one rubber (.5 MPa) on a wide specimen; Hertz's is the limit of a / R = 0:\n")
    print("\n".join(hertz()), flush=True)
    boussinesq = punch_on_block_mm(400.0, 400.0, 0.49) * (1 - 0.49**2) / 20
    print(f"\nA rigid punch of 10 mm radius on a block of 400 mm, over Boussinesq's half-space: {boussinesq:.3f}.")
    block = punch_on_block_mm(35.0, 25.0, 0.49)
    print(
        f"Stiffness over modulus of the tables' block at small depth: {block:.2f} mm; theirs, 1 mm deep: {BLOCK_MM} mm."
    )
    print("\nA rigid ball on a layer bonded to a rigid plate:\n")
    print("\n".join(layers()), flush=True)
    print("\nFiner meshes and steps:\n")
    print("\n".join(meshes()), flush=True)
    print("\nWhat the tables that come with casr hold fixed:\n")
    print("\n".join(worlds()), flush=True)


if __name__ == "__main__":
    main()
