"""Whether .venv can be used as it stands: run by its own Python, from the folder of the sources; says why not.

    .venv/bin/python -I scripts/environment.py LOCK... [-- PYTHON]

Locks are those that were installed. PYTHON : the one that is asked for, where one is. Standard library only.
"""

from __future__ import annotations

import os
import re
import subprocess
import sys
from importlib.metadata import PackageNotFoundError, distribution
from importlib.util import find_spec
from pathlib import Path


def trouble(locks: list[str], python: str) -> str:
    """What is wrong; "" for nothing."""
    script = Path(".venv/bin/emg2vsa")
    begins = script.read_bytes()[:1000].decode(errors="replace") if script.is_file() else ""
    runs = re.search(r"(/[^\n\"']*?/bin)/python", begins)
    if runs is None or not os.path.isdir(runs[1]) or not os.path.samefile(runs[1], ".venv/bin"):
        return "its commands are of another folder"
    ours = find_spec("emg2vsa")
    if ours is None or not os.path.samefile(os.path.dirname(str(ours.origin)), "emg2vsa"):
        return "it holds the sources of another folder"
    if python and os.path.realpath(_base(python)) != os.path.realpath(sys.base_prefix):
        return f"it is of another Python, {sys.base_prefix}"
    for name, versions in _locked("".join(Path(lock).read_text() for lock in locks)).items():
        try:
            found = distribution(name)
        except PackageNotFoundError:
            return f"{name} is gone"
        if found.version not in versions:
            return f"{name} is {found.version} in place of {' or '.join(versions)}"
        if (first := _first_file(found.read_text("RECORD") or "")) and not found.locate_file(first).exists():
            return f"files of {name} are gone"
    return ""


def _locked(text: str) -> dict[str, list[str]]:
    """Name to its versions for one Python or another, of what every system needs."""
    versions: dict[str, list[str]] = {}
    for name, version, condition in re.findall(r"^([\w.-]+)==(\S+) *(;[^\\\n]*)?", text, re.M):
        if not condition or set(re.findall(r"[a-z]\w+", condition)) <= {"python_full_version", "and", "or"}:
            versions.setdefault(name, []).append(version)
    return versions


def _base(python: str) -> str:
    return subprocess.check_output([python, "-c", "import sys; print(sys.base_prefix)"], text=True).strip()


def _first_file(record: str) -> str:
    """The first code of a distribution, as its record names it."""
    files = (line.partition(",")[0] for line in record.splitlines())
    return next((file for file in files if file.endswith(".py") and not file.startswith("..")), "")


if __name__ == "__main__":
    words = sys.argv[1:]
    cut = words.index("--") if "--" in words else len(words)
    if said := trouble(words[:cut], "".join(words[cut + 1 :])):
        sys.exit(said)
