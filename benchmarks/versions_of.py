"""The environments that ``benchmarks.versions`` tries: libraries, extras, Python, kernel of BLAS."""

from __future__ import annotations

import platform
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

PYTHONS = ("3.11", "3.12", "3.13", "3.14")
_OLDEST = PYTHONS[0]
STUDY = ("study",)
EXTRAS = {
    "flow": ("tests/casr/flow/test_dense.py", "-k", "stretched_image"),
    "formats": (
        "tests/readers/test_matlab.py",
        "tests/readers/test_c3d.py",
        "tests/readers/test_shared_files.py",
        "tests/readers/test_neo_formats.py",
    ),
    "nwb": ("tests/cli/test_convert_nwb.py",),
    "daq": ("tests/devices/ni_daq",),
    "web": ("tests/live/test_session_routes.py", "-k", "token or command or page or report"),
    "lsl": ("tests/devices/lsl", "-k", "session_s_clock"),
    "dynamixel": ("tests/devices/dynamixel",),
    "solver": ("tests/casr/dome/test_solver.py", "-k", "hertz"),
    "cluster": ("tests/pipeline/test_cluster.py", "-k", "one_process_gives"),
}
"""Extra to the tests that use its library for real."""
TOOLS = ("pytest", "hypothesis", "httpx", "httpx2", "websockets", "mne", "mpmath", "pydantic", "annotated-types")
"What these tests need beside."


@dataclass(frozen=True)
class Environment:
    """libraries : ``locked``, ``lowest`` of what the project names, or ``newest``. extras : none leaves the tactile
    side alone. tests : extras whose tests run. variables : of the process."""

    name: str
    libraries: str
    python: str = _OLDEST
    extras: tuple[str, ...] = STUDY
    tests: tuple[str, ...] = ()
    variables: Mapping[str, str] = field(default_factory=dict)

    def installs(self, wheel: str, root: str) -> Iterator[list[str]]:
        """Arguments of ``uv pip install``, one after the other."""
        extras = [word for extra in self.extras for word in ("--extra", extra)]
        asked = ["-r", f"{root}/pyproject.toml", *extras]
        locks = [f"{root}/{name}" for name in ("requirements.lock", "requirements-dev.lock")]
        if self.libraries == "locked":
            # as scripts/setup installs them where nothing but a study is asked for
            yield (
                ["--no-deps", "--require-hashes", "-r", locks[0]]
                if self.extras == STUDY
                else [*asked, *(word for lock in locks for word in ("--constraint", lock))]
            )
        else:
            yield [*asked, "--resolution", {"lowest": "lowest-direct", "newest": "highest"}[self.libraries]]
        yield ["--no-deps", wheel]


def environments() -> Iterator[Environment]:
    """The first of each kind is what the others are compared with."""
    every, newest = (*STUDY, *EXTRAS), PYTHONS[-2]
    yield Environment("locked", "locked")
    for python in PYTHONS[1:]:
        yield Environment("locked", "locked", python)
    yield Environment("lowest", "lowest")
    yield Environment("lowest, every extra", "lowest", extras=every, tests=tuple(EXTRAS))
    yield Environment("newest, every extra", "newest", newest, extras=every)
    yield Environment("tactile side alone, locked", "locked", extras=())
    yield Environment("tactile side alone, lowest", "lowest", extras=())
    if platform.machine() in ("x86_64", "AMD64"):
        for kernel in ("Haswell", "Prescott"):
            yield Environment(f"OpenBLAS for {kernel}", "locked", variables={"OPENBLAS_CORETYPE": kernel})
