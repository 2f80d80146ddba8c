"""Whatever a stranger copies to install the project works from the folder of its sources: no index has it yet."""

from __future__ import annotations

import importlib.util
import re
import tomllib
from pathlib import Path
from types import ModuleType

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

import casr.cli
import emg2vsa.cli
from casr.errors import install_extra

ROOT = Path(__file__).resolve().parent.parent
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS = PROJECT["optional-dependencies"]
TEXTS = [
    path
    for folder, kinds in {
        ".": ("*.md",), "docs": ("**/*.md",), "benchmarks": ("**/*.md",), "emg2vsa": ("**/*.py",), "casr": ("**/*.py",),
        "scripts": ("*", "container/*"), ".github": ("**/*.yml",),
    }.items()
    for kind in kinds
    for path in sorted((ROOT / folder).glob(kind))
    if path.is_file() and not {"_build", "made"} & set(path.parts)
]  # fmt: skip


@pytest.fixture(scope="module")
def metadata() -> ModuleType:
    spec = importlib.util.spec_from_file_location("metadata", ROOT / "scripts" / "metadata.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def asked_extras(text: str) -> list[str]:
    """Extras of lines such as ``pip install ".[study,web]"``."""
    return [name.strip() for names in re.findall(r"""["']\.\[([^\]]+)\]["']""", text) for name in names.split(",")]


def test_no_text_installs_from_an_index_that_does_not_have_the_project() -> None:
    wrong = [
        f"{path.relative_to(ROOT)}: {line.strip()}"
        for path in TEXTS
        for line in path.read_text(encoding="utf-8").splitlines()
        if re.search(r"""\b(pip3?|pipx|tool) install(\s+-[\w-]+(=\S+)?)*\s+["']?(emg2vsa|casr)\b""", line)
    ]
    assert wrong == []


def test_every_extra_that_a_text_asks_for_is_one_of_the_project() -> None:
    asked = {(path.name, extra) for path in TEXTS for extra in asked_extras(path.read_text(encoding="utf-8"))}
    assert len(asked) > 15
    assert {(name, extra) for name, extra in asked if extra not in EXTRAS and "{" not in extra} == set()


def test_every_extra_that_the_program_names_is_one_of_the_project() -> None:
    named = {
        extra
        for package in ("emg2vsa", "casr")
        for path in (ROOT / package).rglob("*.py")
        for extra in re.findall(r"""install_extra\(['"](\w+)['"]\)""", path.read_text(encoding="utf-8"))
    }
    named |= {*emg2vsa.cli.PROGRAM.extras.values(), *casr.cli.PROGRAM.extras.values()}
    assert {"study", "web", "flow", "formats", "solver", "daq", "lsl", "dynamixel", "cluster"} <= named <= set(EXTRAS)
    assert install_extra("web") == 'pip install ".[web]" in the folder of the sources'


def locked() -> dict[str, set[str]]:
    """Versions of each package in the two locks."""
    found: dict[str, set[str]] = {}
    for lock in ("requirements.lock", "requirements-dev.lock"):
        for name, version in re.findall(r"^([a-z0-9._-]+)==(\S+)", (ROOT / lock).read_text(), flags=re.M):
            found.setdefault(canonicalize_name(name), set()).add(version)
    return found


@pytest.mark.parametrize("extra", [None, *EXTRAS])
def test_what_an_installation_asks_for_was_resolved(extra: str | None) -> None:
    versions = locked()
    asked = [Requirement(text) for text in (PROJECT["dependencies"] if extra is None else EXTRAS[extra])]
    assert asked
    for one in asked:
        found = versions[canonicalize_name(one.name)]
        assert any(one.specifier.contains(version) for version in found), f"{one}: the locks have {found}"


def test_the_page_lists_every_extra_with_its_line() -> None:
    table = (ROOT / "docs" / "how-to" / "install.md").read_text(encoding="utf-8").partition("| extra |")[2]
    lines = [row for row in table.splitlines()[2:] if row.startswith("|")]
    rows = {name: row for row in lines for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    assert set(rows) == set(EXTRAS)
    users = set(EXTRAS) - {"test", "lint", "docs", "bench"}
    assert {name for name in users if f'pip install ".[{name}]"' not in rows[name]} == set()


def test_files_say_what_pyproject_says(metadata: ModuleType) -> None:
    wanted = metadata.files(ROOT, metadata.project_of(ROOT))
    assert {name for name, text in wanted.items() if (ROOT / name).read_text(encoding="utf-8") != text} == set()


def test_an_address_enters_every_file_from_one_setting(metadata: ModuleType) -> None:
    project = metadata.project_of(ROOT)
    assert "://" not in str(project.get("urls", "")) or "Repository" in project["urls"]
    address = "https://example.org/people/emg2vsa"
    texts = metadata.files(ROOT, project | {"urls": {"Repository": address}})
    assert f"git clone {address} emg2vsa && cd emg2vsa\npip install .  " in texts["README.md"]
    assert f'repository-code: "{address}"' in texts["CITATION.cff"]
    assert f'"codeRepository": "{address}"' in texts["codemeta.json"]
    # and leaves them again
    again = metadata.citation(texts["CITATION.cff"], {key: value for key, value in project.items() if key != "urls"})
    assert address not in again
