"""Folders that are built once for each version of the code: by one of several workers, for all and for later runs."""

from __future__ import annotations

import hashlib
import os
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from importlib.metadata import distributions
from pathlib import Path

from emg2vsa.held_lock import taken

ROOT = Path(__file__).resolve().parent.parent
Build = Callable[[Path], object]
Once = Callable[[str, Build], Path]
KEPT_VERSIONS = 2
IN_USE_S = 2 * 3600
"""Of a checkout: older versions than so many go, unless a run of the last hours may still read them."""


def built(kept_in: Path, name: str, build: Build) -> Path:
    """The folder of this name in ``kept_in``, filled by ``build`` unless it is as it was left."""
    folder, done = kept_in / name, kept_in / f"{name}.done"
    with open(kept_in / f"{name}.lock", "w") as lock:
        while not taken(lock.fileno()):
            time.sleep(0.1)
        if not done.exists() or done.read_text() != _contents(folder):
            done.unlink(missing_ok=True)
            shutil.rmtree(folder, ignore_errors=True)
            folder.mkdir()
            version = _version()
            build(folder)
            if _version() == version:  # else somebody edits the code: the next test builds it again
                done.write_text(_contents(folder))
    return folder


@cache
def place_for(file: str) -> Path | None:
    """Where folders are kept that the functions in a file of tests build with the code of today; None for nowhere."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    of_checkout = base / "emg2vsa-tests" / hashlib.sha256(os.fsencode(ROOT)).hexdigest()[:12]
    version = of_checkout / _version()
    beside = [path for path in sorted(Path(file).parent.glob("*.py")) if not path.name.startswith("test_")]
    builders = b"".join(path.read_bytes() for path in (Path(file), *beside))
    folder = version / hashlib.sha256(builders).hexdigest()[:12]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
        version.touch()
    except OSError:
        return None
    _forget_old(of_checkout)
    return folder


def _forget_old(of_checkout: Path) -> None:
    """Several workers may do so at once: what another one has just removed is no error."""
    used_s = {}
    for version in of_checkout.iterdir():
        with suppress(FileNotFoundError):
            used_s[version] = version.stat().st_mtime
    for version in sorted(used_s, key=used_s.__getitem__)[:-KEPT_VERSIONS]:
        if time.time() - used_s[version] > IN_USE_S:
            shutil.rmtree(version, ignore_errors=True)


def _version() -> str:
    """Digest of the program, of what builds beside it, of Python and of all libraries."""
    found = hashlib.sha256(repr((sys.version, sorted(_libraries()))).encode())
    for top in ("emg2vsa", "casr", "benchmarks/small_study.py", "tests/small.py", "studies/palpation/study.toml"):
        for path in [ROOT / top, *sorted((ROOT / top).rglob("*"))]:
            if path.is_file() and path.suffix != ".pyc":
                found.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes())
    return found.hexdigest()[:16]


@cache
def _libraries() -> frozenset[str]:
    return frozenset(f"{each.name} {each.version}" for each in distributions())


def _contents(folder: Path) -> str:
    """Names and sizes of all files but those that looking at a study writes."""
    files = (path for path in folder.rglob("*") if path.is_file() and path.name not in ("fingerprints.json", ".lock"))
    listing = sorted(f"{path.relative_to(folder)} {path.stat().st_size}" for path in files)
    return hashlib.sha256("\n".join(listing).encode()).hexdigest()
