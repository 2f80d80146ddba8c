"""Fixtures of all tests."""

from __future__ import annotations

import ctypes
import os
import sys
from collections.abc import Callable, Generator
from contextlib import suppress
from functools import cache
from pathlib import Path

from casr.one_thread import VARIABLES

os.environ.update(dict.fromkeys(VARIABLES, "1"))  # before NumPy is loaded, as every command does

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from emg2vsa.run_scores import ALGORITHMS, ContactPicture, FirstContact, PressCurve, RunScores
from tests.lateness import LIMIT_MS, Watched, lateness_ms
from tests.once import Build, Once, built, place_for

settings.register_profile("busy computer", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("busy computer")

ROOT = Path(__file__).resolve().parent.parent
SHARED = Path(os.environ.get("EMG2VSA_TEST_DATA", ROOT.parent / "shared" / "data"))


LONGEST = [
    "end_to_end/test_rig_study.py", "end_to_end/test_run.py", "pipeline/test_key_covers_what_runs.py",
    "casr/test_robust_frames.py", "casr/test_press_forces.py", "casr/test_stream.py", "casr/cli/test_score.py",
    "casr/test_score.py", "pipeline/test_damage.py", "rig/commissioning/test_checks.py",
]  # fmt: skip
"""Files that are given out first: what is left at the end is short, and no processor waits for it."""


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--renew-pages", action="store_true", help="write into pages what their commands say now")


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put the files of LONGEST first, and keep the order of all else."""
    place = {ROOT / "tests" / name: row for row, name in enumerate(LONGEST)}
    items.sort(key=lambda item: place.get(item.path, len(place)))


@pytest.hookimpl(wrapper=True)
def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> Generator[None, None, None]:
    """What the tests of a file kept goes back to the system when the next file begins: workers stay small."""
    yield
    if nextitem is not None and nextitem.path == item.path:
        return
    for value in list(vars(item.module).values()) if isinstance(item, pytest.Function) else ():
        if hasattr(value, "cache_clear") and getattr(value, "__module__", "") == item.module.__name__:
            value.cache_clear()
    if sys.platform == "linux":
        with suppress(OSError, AttributeError):  # other C libraries have no such call
            ctypes.CDLL("libc.so.6").malloc_trim(0)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    """A test that keeps real time needs a machine that does."""
    if item.get_closest_marker("realtime") and (late_ms := lateness_ms()) > LIMIT_MS:
        pytest.skip(f"the machine is late by {late_ms:.1f} ms before the test; at most {LIMIT_MS:g} ms are allowed")


@pytest.hookimpl(wrapper=True)
def pytest_runtest_call(item: pytest.Item) -> Generator[None, None, None]:
    """Nor does a test of real time fail where the machine was late meanwhile."""
    if not item.get_closest_marker("realtime"):
        return (yield)
    watched = Watched()
    try:
        with watched:
            return (yield)
    except (Exception, pytest.fail.Exception):
        if (late_ms := max(watched.latest_ms, lateness_ms())) > LIMIT_MS:
            pytest.skip(f"failed, and the machine was late by {late_ms:.1f} ms; at most {LIMIT_MS:g} ms are allowed")
        raise


@pytest.fixture
def shared_data() -> Callable[[str], Path]:
    """Path of a folder or file of real recordings; the test is skipped where they are absent."""

    def find(relative: str) -> Path:
        path = SHARED / relative
        if not path.exists():
            pytest.skip(f"real data absent: {relative} (set EMG2VSA_TEST_DATA to the folder that holds it)")
        return path

    return find


@pytest.fixture(scope="session")
def built_once(tmp_path_factory: pytest.TempPathFactory) -> Once:
    """A folder of this name that ``build`` fills, once for each version of the code; see ``tests.once``.

    It is for all tests: they read or copy it, and never change it.
    """
    base = tmp_path_factory.getbasetemp()
    here = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def make(name: str, build: Build) -> Path:
        return built(place_for(build.__code__.co_filename) or here, f"once-{name}", build)

    return make


@pytest.fixture
def blank_drawings(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reports that this process writes have empty figures of the right size: for tests that look at no figure."""
    from matplotlib.figure import Figure

    from emg2vsa.report import drawing

    drawn = drawing.svg_text
    monkeypatch.setattr(drawing, "svg_text", lambda figure: drawn(Figure(figsize=figure.get_size_inches())))


KAPPA_N_PER_MM = {"S1": 7.63, "S_new": 5.32, "S3": 3.35, "S5": 1.11}
_ANGLES_DEG = {"high-stiffness": (0.0, 30.0, 45.0), "modular": (0.0, 30.0, 45.0)} | {
    f"constant-{level}": (0.0,) for level in ("min", "mean", "max")
}
_TILTED = {0.0: 1.0, 30.0: 1.15, 45.0: 1.41}
"""How much too large the previous algorithm's circle is."""


def area_mm2(specimen: str, angle_deg: float, force_n: np.ndarray | float) -> np.ndarray:
    """The larger the softer, and in the image plane the smaller the more it is tilted."""
    compliance = 1 / 0.4 + 10 / KAPPA_N_PER_MM[specimen]
    return np.asarray(15 * np.sqrt(compliance * force_n) * np.cos(np.radians(angle_deg)))


def make_run(specimen: str, angle_deg: float, condition: str, presses: int = 10) -> RunScores:
    """Rates vary by 2 % from press to press (12 % at the lowest constant stiffness), initial areas by 1 %."""
    rng = np.random.default_rng([*f"{specimen}{angle_deg}{condition}".encode()])
    force = np.linspace(0.5, 7, 25)
    rate = np.polyfit(force, area_mm2(specimen, angle_deg, force), 1)[0]
    noise = 1 + (0.12 if condition == "constant-min" else 0.02) * rng.standard_normal(presses)
    area = area_mm2(specimen, angle_deg, 0.5) * (1 + 0.01 * rng.standard_normal(presses))
    wide = _TILTED[angle_deg] * (1 + 0.05 * rng.standard_normal(presses))
    step = 6.0  # a hexagon
    began_s = 1e6 * np.random.default_rng([*f"{condition}{angle_deg}{specimen}".encode()]).random()
    curves = tuple(
        PressCurve(force, area_mm2(specimen, angle_deg, force) * n + rng.normal(0, 0.3, force.size), 0.5) for n in noise
    )
    return RunScores(
        specimen=specimen,
        angle_deg=angle_deg,
        condition=condition,
        simulated=True,
        algorithm="front",
        repetitions=np.arange(1, presses + 1),
        mounting=np.ones(presses, dtype=np.int64),
        pressed_at=began_s + np.arange(presses),
        verdicts=("ok",) * presses,
        reasons=("",) * presses,
        area_unit="mm2",
        pins_selected=np.round(area / step).astype(np.int64),
        first_n=np.full(presses, 0.5),
        a_c0=dict.fromkeys(ALGORITHMS, area)
        | {"hexagon": step * np.round(area / step), "circle": area * wide, "paper": area * 1.1},
        start_area=dict.fromkeys(ALGORITHMS, 0.9 * area) | {"circle": area * wide, "paper": area * 1.1},
        casr=dict.fromkeys(ALGORITHMS, rate * noise) | {"circle": rate * noise * wide, "paper": 3 * rate * noise},
        over_array=dict.fromkeys(ALGORITHMS, np.full(presses, np.nan)),
        true_a_c0=np.full(presses, float(area_mm2(specimen, angle_deg, 0.5))),
        indent_n_per_mm=4
        * (2.5 + 10 / KAPPA_N_PER_MM[specimen]) ** (-2 / 3)
        * (1 + 0.02 * rng.standard_normal(presses)),
        peak_n=7.3 + 0.1 * rng.random(presses),
        curves=curves,
        picture=_picture(float(area[0])),
        first_contact=_first_contact(),
        notes=("frames dropped: 0",),
    )


def _pins_at_rest() -> np.ndarray:
    pitch = 20.0
    grid = np.stack(np.meshgrid(np.arange(-7, 8), np.arange(-7, 8)), axis=-1).reshape(-1, 2)
    pins = 150 + pitch * grid @ np.array([[1.0, 0.0], [0.5, np.sqrt(0.75)]])
    return np.asarray(pins[np.linalg.norm(pins - 150, axis=1) < 125])


def _image(pins_px: np.ndarray) -> np.ndarray:
    across, down = (np.exp(-((np.arange(300) - at[:, None]) ** 2) / 18) for at in pins_px.T)
    return np.clip(12 + 200 * down.T @ across, 0, 255).astype(np.uint8)


def _picture(area: float) -> ContactPicture:
    turn = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    outline = 150 + 16 * np.sqrt(area / np.pi) * np.column_stack([np.cos(turn), np.sin(turn)])
    return ContactPicture(_image(_pins_at_rest()), 1.02, outline, area)


@cache
def _first_contact() -> FirstContact:
    """Pins within 60 px of the middle move outwards, by up to 4 px and then by up to 6."""
    rest = _pins_at_rest()
    out = rest - 150
    share = np.clip(1 - np.linalg.norm(out, axis=1) / 60, 0, 1)[:, None] * out / 15
    moved = np.linalg.norm(4 * share, axis=1)
    frames = np.stack([_image(rest + by * share) for by in (0, 4, 6)])
    return FirstContact(1, frames, np.array([0.61, 1.12]), rest, rest + 4 * share, np.flatnonzero(moved > 2))


@pytest.fixture(scope="session")
def run_of() -> Callable[..., RunScores]:
    """``make_run``: one run of a specimen, angle and condition."""
    return make_run


@pytest.fixture(scope="session")
def runs() -> tuple[RunScores, ...]:
    """All 36 runs of the experiment."""
    return tuple(
        make_run(specimen, angle, condition)
        for condition, angles in _ANGLES_DEG.items()
        for angle in angles
        for specimen in KAPPA_N_PER_MM
    )


@pytest.fixture(scope="session")
def stiffness_n_per_mm() -> dict[str, float]:
    """Of the specimens of ``runs``."""
    return dict(KAPPA_N_PER_MM)
