"""On what a benchmark ran: processor, load, libraries. No host names and no paths."""

from __future__ import annotations

import os
import platform
import re
import subprocess
from importlib import metadata
from pathlib import Path
from typing import Any

import emg2vsa

ALWAYS = ("numpy", "scipy", "pandas", "opencv-contrib-python-headless", "numba")


def machine(peers: tuple[str, ...] = ()) -> dict[str, Any]:
    """processor, cores, load (1 min), system, python, emg2vsa, revision, libraries (name -> version)."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "load": round(os.getloadavg()[0], 1) if hasattr(os, "getloadavg") else None,
        "system": platform.system(),
        "python": platform.python_version(),
        "emg2vsa": emg2vsa.__version__,
        "revision": revision(),
        "libraries": {name: version for name in sorted({*ALWAYS, *peers}) if (version := _version(name))},
    }


def revision(folder: Path | None = None) -> str | None:
    """Short hash of the checkout, with ``+`` where the sources were changed; None without git."""
    where = folder or Path(__file__).resolve().parents[2]
    try:
        said = [
            subprocess.run(["git", "-C", str(where), *words], capture_output=True, text=True, check=True).stdout.strip()
            for words in (
                ("rev-parse", "--short=9", "HEAD"),
                ("status", "--porcelain", "-uno", "--", "emg2vsa", "casr", "benchmarks"),
            )
        ]
    except (OSError, subprocess.CalledProcessError):
        return None
    return said[0] + ("+" if said[1] else "")


def _processor() -> str:
    try:
        found = re.search(r"model name\s*:\s*(.+)", Path("/proc/cpuinfo").read_text())
    except OSError:
        found = None
    return found.group(1).strip() if found else platform.processor() or platform.machine()


def _version(name: str) -> str | None:
    try:
        return metadata.version(name)
    except metadata.PackageNotFoundError:
        return None
