"""What the pull along the surface does to areas of the contact front: in worlds without one, and of several makes.

Run with ``python -m benchmarks.tactile.sheared_contacts [--write FILE]``, about three minutes of a processor. Places of
pins come from the worlds of ``casr bench presses`` with the scatter of the tracker, without frames; each press is
scored once as it is, and once with the pull switched off.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from unittest.mock import patch

import numpy as np
from numpy.typing import NDArray

from benchmarks.bench.record import print_page
from benchmarks.tactile.world_scores import named, world_named
from casr.contact_area import library_front as pulled
from casr.contact_area.follow import contact_front
from casr.contact_area.front import ContactFront
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import ContactState, Points, PressSettings, Scene

Way = Callable[[Points, Points, ContactState, Scene, float], Points]
"""Motion by a shear that is added, px: of pins at rest at (N, 2), now at (N, 2), in a state; its size in mm."""
PINS_SD_PX = 0.05
FORCES_N = np.linspace(0.5, 7.0, 20)
SPECIMENS_PRESSED = ("S1", "S5")
UNSHEARED = tuple(name for name in named(["all"]) if not name.startswith("full"))
SHEARED_IN = ("tabulated", "tabulated-frictionless", "dome-J-stick")
SHEARED_MM = 0.8
"At 7 N; in proportion to the radius cubed, as of a contact that sticks on a straight way at 45 degrees."


def main() -> None:
    """Print both tables."""
    print_page(__doc__, _page)


def _depth(at: Points, state: ContactState, scene: Scene) -> Points:
    return scene.contact(state).depth(at)


def _direction(at: Points, size_px: Points) -> Points:
    return np.asarray(size_px[:, None] * np.array([1.0, 0.0]) + 0 * at)


def decaying(rest: Points, at: Points, state: ContactState, scene: Scene, size_px: float) -> Points:
    """Uniform inside, and exponentially less outside, over half of the radius."""
    depth = _depth(at, state, scene)
    return _direction(at, size_px * np.exp(-2 * np.maximum(depth - 1, 0.0)))


def rounded(rest: Points, at: Points, state: ContactState, scene: Scene, size_px: float) -> Points:
    """Gaussian over the distance from the middle."""
    return _direction(at, size_px * np.exp(-(_depth(at, state, scene) ** 2) / 2))


def turned(rest: Points, at: Points, state: ContactState, scene: Scene, size_px: float) -> Points:
    """`decaying`, and a turn of the contact about its middle that moves its edge by half as much."""
    contact = scene.contact(state)
    depth = contact.depth(at)
    across = (at - contact.centre_px)[:, ::-1] * (-1.0, 1.0)
    share = np.exp(-2 * np.maximum(depth - 1, 0.0))
    edge_px = float(np.mean(contact.semi_axes_px))
    return np.asarray(decaying(rest, at, state, scene, size_px) + 0.5 * size_px * (share / edge_px)[:, None] * across)


def tips(rest: Points, at: Points, state: ContactState, scene: Scene, size_px: float) -> Points:
    """Tips of the pins in the contact, and no other skin."""
    return _direction(at, np.where(_depth(at, state, scene) <= 1, size_px, 0.0))


WAYS: dict[str, Way] = {"decaying": decaying, "Gaussian": rounded, "with a turn": turned, "pins' tips only": tips}
"Makes of shear besides that of the emulated rig."


@dataclass(frozen=True)
class Compared:
    """One press: (F,) ln of area over the true one with the pull and without; whether intervals of areas hold."""

    with_pull: Points
    without: Points
    held: Points
    held_without: Points
    acted: bool


def compared(world: str, specimen: str, angle_deg: float, way: Way | None = None, own_mm: float = 0.0) -> Compared:
    """Score places of pins both ways. own_mm : of the world's own shear at 7 N."""
    bench = world_named(world)
    assert bench.world is not None
    settings = PressSettings(stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle_deg, world=bench.world)
    scene = Scene(settings)
    rng = np.random.default_rng(round(angle_deg))
    states = [scene.skin.state(float(force)) for force in FORCES_N]
    share = np.array([(state.radius_mm / states[-1].radius_mm) ** 3 for state in states])
    if own_mm:
        states = [ContactState(s.radius_mm, s.normal_n, own_mm * k) for s, k in zip(states, share, strict=True)]
    frames = [scene.pins_px(state) for state in states]
    if way:
        size_px = SHEARED_MM / settings.camera.mm_per_px[0] * share
        frames = [
            at + way(scene.rest_px, at, state, scene, size)
            for at, state, size in zip(frames, states, size_px.tolist(), strict=True)
        ]
    pins = np.array(frames) + PINS_SD_PX * rng.standard_normal((len(frames), *scene.rest_px.shape))
    true = np.array([scene.area_mm2(state) for state in states])
    fronts = [contact_front(scene.rest_px, pins, settings.camera, bench.library)]
    with patch.object(pulled, "SHEARED_MISFIT", np.inf):
        fronts.append(contact_front(scene.rest_px, pins, settings.camera, bench.library))
    used = fronts[0].determined & fronts[1].determined
    logs = [np.log(front.area / true)[used] for front in fronts]
    held = [_held(front, log, used) for front, log in zip(fronts, logs, strict=True)]
    acted = not np.array_equal(fronts[0].area, fronts[1].area)
    return Compared(logs[0], logs[1], held[0], held[1], acted)


def _held(front: ContactFront, log: Points, used: NDArray[np.bool_]) -> Points:
    return np.asarray(np.abs(log) <= 1.96 * front.relative_sd[used])


def _page() -> Iterator[str]:
    heading = (
        "| {} | presses | pull acts in | median error with it, % | without, % | largest with it, % | without, % "
        "| held with it, % | without, % |"
    )
    yield "# The pull along the surface, where it is and where it is not"
    yield ""
    yield "`python -m benchmarks.tactile.sheared_contacts`: error of the front's area against the true one, over frames"
    yield f"from 0.5 to 7 N in which it is determined; {', '.join(SPECIMENS_PRESSED)} at 0, 30 and 45 degrees; held: by"
    yield "the total 95 % interval of the area."
    yield ""
    yield heading.format("world without shear")
    yield "|---|---|---|---|---|---|---|---|---|"
    for name in UNSHEARED:
        yield _row(name, [compared(name, s, a) for s in SPECIMENS_PRESSED for a in (0.0, 30.0, 45.0)])
    yield ""
    yield f"The same presses with skin that is sheared by {SHEARED_MM:g} mm at 7 N, at 30 and 45 degrees."
    yield ""
    yield heading.format("world, shear")
    yield "|---|---|---|---|---|---|---|---|---|"
    for name in SHEARED_IN:
        presses = [(name, s, a) for s in SPECIMENS_PRESSED for a in (30.0, 45.0)]
        yield _row(f"{name}, the world's own", [compared(*press, own_mm=SHEARED_MM) for press in presses])
        for way_name, way in WAYS.items():
            yield _row(f"{name}, {way_name}", [compared(*press, way) for press in presses])


def _row(name: str, found: list[Compared]) -> str:
    logs = [np.concatenate([getattr(each, side) for each in found]) for side in ("with_pull", "without")]
    held = [100 * np.mean(np.concatenate([getattr(each, side) for each in found])) for side in ("held", "held_without")]
    middle = [100 * np.median(np.abs(log)) if log.size else np.nan for log in logs]
    largest = [100 * np.abs(log).max(initial=0.0) for log in logs]
    cells = [f"{value:.1f}" for value in (*middle, *largest)] + [f"{value:.0f}" for value in held]
    return f"| {name} | {len(found)} | {sum(each.acted for each in found)} | {' | '.join(cells)} |"


if __name__ == "__main__":
    main()
