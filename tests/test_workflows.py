"""Workflows of GitHub: what they run is there, what they use is pinned, and only a release may sign or write."""

from __future__ import annotations

import importlib.util
import re
import shlex
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).resolve().parent.parent
FILES = sorted((ROOT / ".github" / "workflows").glob("*.yml"))
SYSTEM = {"test", "cp", "mkdir", "mv", "gh"}
"""Commands that every runner has."""


def parsed(path: Path) -> dict[Any, Any]:
    document = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert isinstance(document, dict)
    return document


def jobs(path: Path) -> dict[str, Any]:
    found = parsed(path)["jobs"]
    assert isinstance(found, dict)
    return found


def steps(path: Path) -> list[dict[str, Any]]:
    return [step for job in jobs(path).values() for step in job.get("steps", [])]


def commands(path: Path) -> list[list[str]]:
    """Words of each command, without what it writes to."""
    lines = [part for step in steps(path) for line in step.get("run", "").splitlines() for part in line.split("&&")]
    return [shlex.split(line.partition(" > ")[0]) for line in lines]


def tools() -> set[str]:
    return set(re.findall(r"^([a-z0-9._-]+)==", (ROOT / ".github" / "tools.lock").read_text(), flags=re.M))


def exists(words: list[str]) -> bool:
    """Whether the command, and the module or the script that it names, are there."""
    name = words[0]
    if name.endswith("python"):
        name, words = "python", words[1:]
        if words[0] == "-m":
            return importlib.util.find_spec(words[1]) is not None
        return (ROOT / words[0]).is_file()
    if name.startswith(".venv/bin/"):
        return (Path(sys.executable).parent / Path(name).name).exists()
    if "/" in name:
        return (ROOT / name).is_file() and (ROOT / name).stat().st_mode & 0o111 != 0
    return name in SYSTEM | tools()


def test_there_are_tests_lint_docs_and_a_release() -> None:
    assert {path.stem for path in FILES} >= {"ci", "lint", "docs", "release", "fuzz", "security"}
    systems = str(jobs(ROOT / ".github" / "workflows" / "ci.yml"))
    assert all(system in systems for system in ("ubuntu-latest", "macos-latest", "windows-latest"))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_command_is_there(path: Path) -> None:
    assert [words for words in commands(path) if not exists(words)] == []
    files = {word for words in commands(path) for word in words if re.fullmatch(r"[\w./-]+\.(lock|cff|py)", word)}
    assert {name for name in files if not (ROOT / name).is_file()} == set()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_every_action_is_pinned_to_a_commit_whose_version_stands_beside_it(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    used = re.findall(r"uses: (.+)$", text, flags=re.M)
    assert used
    for one in used:
        if one.startswith("./"):
            assert (ROOT / one).is_file()
        else:
            assert re.fullmatch(r"[\w-]+(/[\w-]+)+@[0-9a-f]{40} # v\d+\.\d+\.\d+", one), one


def test_an_action_is_pinned_to_one_commit_everywhere() -> None:
    used = {one for path in FILES for one in re.findall(r"uses: (\S+@\S+)", path.read_text(encoding="utf-8"))}
    assert len({one.partition("@")[0] for one in used}) == len(used)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_workflow_names_no_host_keeps_no_secret_and_may_only_read(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert "://" not in text
    assert "secrets." not in text
    assert parsed(path)["permissions"] == {"contents": "read"}
    assert "pull_request_target" not in text
    # what anybody may name, such as a branch, does not get into a shell
    assert [step["run"] for step in steps(path) if "${{" in step.get("run", "")] == []
    assert all("timeout-minutes" in job or "uses" in job for job in jobs(path).values())


def test_only_a_tag_releases_and_only_after_tests_build_and_signature() -> None:
    path = ROOT / ".github" / "workflows" / "release.yml"
    assert parsed(path)[True] == {"push": {"tags": ["v*"]}}  # YAML reads the key "on" as a truth value
    order = {name: job.get("needs") for name, job in jobs(path).items()}
    assert order == {"test": None, "build": "test", "attest": "build", "publish": "attest"}
    signing = {
        (file.stem, name)
        for file in FILES
        for name, job in jobs(file).items()
        if "write" in [level for what, level in job.get("permissions", {}).items() if what != "security-events"]
    }
    assert signing == {("release", "attest"), ("release", "publish")}


def test_tools_of_the_workflows_are_locked_by_hash() -> None:
    text = (ROOT / ".github" / "tools.lock").read_text().replace("\\\n", " ")
    assert "://" not in text
    assert all(re.match(r"[a-z0-9._-]+==\S+ .*--hash=sha256:[0-9a-f]{64}", line) for line in text.splitlines())
    assert set((ROOT / ".github" / "tools.in").read_text().split()) <= tools()
