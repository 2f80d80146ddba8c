"""The two locks and scripts/setup: what a run needs is installed, once, by uv or else pip, and extended for tests."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parent.parent
LOCKS = ("requirements.lock", "requirements-dev.lock")
BASH = shutil.which("bash")


def requirements(lock: str) -> list[str]:
    """Lines of a lock, each requirement with its hashes on one line."""
    return (ROOT / lock).read_text().replace("\\\n", " ").splitlines()


def packages(lock: str) -> set[str]:
    return {line.split("==")[0] for line in requirements(lock)}


def names(dependencies: list[str]) -> set[str]:
    return {re.split(r"[<>=!\[ ;]", dependency)[0].lower() for dependency in dependencies}


@pytest.mark.parametrize("lock", LOCKS)
def test_every_locked_package_has_a_hash_and_no_lock_names_a_host(lock: str) -> None:
    assert all(re.match(r"[a-z0-9._-]+==\S+ .*--hash=sha256:[0-9a-f]{64}", line) for line in requirements(lock))
    assert "://" not in (ROOT / lock).read_text()


def test_the_locks_hold_what_the_project_asks_for_and_share_nothing() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = names([one for extra in project["optional-dependencies"].values() for one in extra])
    run, dev = (packages(lock) for lock in LOCKS)
    assert names(project["dependencies"]) <= run
    assert extras <= run | dev
    assert run & dev == set()
    assert not run & {"numba", "llvmlite", "pytest", "mypy", "ruff"}


FAKE_UV = """#!/bin/sh
echo "uv $*" >> "$CALLS"
if [ "$1" = venv ]; then
  for place; do :; done
  rm -rf "$place"
  mkdir -p "$place/bin"
  cp "$0.python" "$place/bin/python"
fi
"""
FAKE_PYTHON = """#!/bin/sh
echo "python $*" >> "$CALLS"
for last; do :; done
case "$*" in
  *--require-hashes*) cat "$last" >> "$CALLS.installed" ;;
  *--help*) echo "  --python <python>" ;;
esac
"""


class Place:
    """A source folder with tiny locks, and a uv and a python that write down how they are called."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.calls, tools = folder, folder / "calls", folder / "tools"
        (folder / "scripts").mkdir()
        tools.mkdir()
        shutil.copy(ROOT / "scripts" / "setup", folder / "scripts")
        for lock in LOCKS:
            (folder / lock).write_text(f"{lock}\n")
        for name, text in (("uv", FAKE_UV), ("uv.python", FAKE_PYTHON)):
            (tools / name).write_text(text)
            (tools / name).chmod(0o755)
        self.path = f"{tools}:/usr/bin:/bin"

    def setup(self, *arguments: str, python: str = sys.executable) -> tuple[int, list[str], str]:
        """Exit status, what was called (the compiling of the sources left out) and what was said."""
        self.calls.write_text("")
        environment = {**os.environ, "PATH": self.path, "PYTHON": python, "CALLS": str(self.calls)}
        command = [str(BASH), str(self.folder / "scripts" / "setup"), *arguments]
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        calls = [
            line
            for line in self.calls.read_text().splitlines()
            if not re.search("compileall|--help|environment.py|sys.executable", line)
        ]
        return done.returncode, calls, done.stderr

    def with_pip_alone(self) -> None:
        """No uv, and an environment that has what a run needs."""
        (self.folder / "tools" / "uv").unlink()
        (self.folder / ".venv" / "bin").mkdir(parents=True)
        shutil.copy(self.folder / "tools" / "uv.python", self.folder / ".venv" / "bin" / "python")
        shutil.copy(self.folder / LOCKS[0], self.folder / ".venv")


@pytest.fixture
def place(tmp_path: Path) -> Place:
    if BASH is None:
        pytest.skip("no bash")
    return Place(tmp_path)


INSTALL = "uv pip install --quiet --python .venv/bin/python --no-deps"


def test_a_run_gets_its_lock_and_the_tests_extend_it_without_a_new_environment(place: Place) -> None:
    status, calls, said = place.setup()
    assert status == 0
    assert calls[0].startswith("uv venv")
    assert calls[1:] == [f"{INSTALL} --require-hashes -r requirements.lock", f"{INSTALL} --editable ."]
    assert "installing requirements.lock into .venv with uv" in said
    assert place.setup("run") == (0, [], "")
    assert place.setup("test")[1] == [f"{INSTALL} --require-hashes -r requirements-dev.lock"]
    assert place.setup("test") == (0, [], "")
    assert place.setup("run") == (0, [], "")


@pytest.mark.parametrize(("lock", "what"), [(LOCKS[0], "run"), (LOCKS[0], "test"), (LOCKS[1], "test")])
def test_a_changed_lock_makes_the_environment_anew(lock: str, what: str, place: Place) -> None:
    place.setup("test")
    (place.folder / lock).write_text("another\n")
    calls = place.setup(what)[1]
    assert calls[0].startswith("uv venv")
    assert calls[-1].endswith("requirements-dev.lock" if what == "test" else "--editable .")
    assert place.setup(what) == (0, [], "")


def test_an_installation_that_failed_is_done_again(place: Place) -> None:
    uv = place.folder / "tools" / "uv"
    uv.write_text(FAKE_UV + '[ "$2" != install ]\n')
    assert place.setup()[0] != 0
    uv.write_text(FAKE_UV)
    assert place.setup()[1][0].startswith("uv venv")


def test_without_uv_pip_installs(place: Place) -> None:
    place.with_pip_alone()
    lock = ["a==1 \\\n    --hash=sha256:0\n", "b==2 \\\n    --hash=sha256:1\n", "c==3\n"]
    (place.folder / LOCKS[1]).write_text("".join(lock))
    _, calls, said = place.setup("test", python=str(place.folder / ".venv" / "bin" / "python"))
    assert len(calls) == 2
    assert all("install --quiet --disable-pip-version-check" in call for call in calls)
    assert all("--no-deps --require-hashes -r" in call for call in calls)
    installed = Path(f"{place.calls}.installed").read_text()
    assert sorted(re.split(r"^(?=\w)", installed, flags=re.M)[1:]) == lock  # each once, with its hashes
    assert "with pip" in said


@pytest.mark.parametrize(("forbidden", "compiles"), [("", "--no-compile"), ("1", "--compile")])
def test_pip_compiles_where_python_may_not_do_it_at_import(
    forbidden: str, compiles: str, place: Place, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", forbidden)
    place.with_pip_alone()
    calls = place.setup("test", python=str(place.folder / ".venv" / "bin" / "python"))[1]
    assert calls
    assert all(f" {compiles} " in call for call in calls)


def test_an_unknown_argument_and_an_old_python_are_refused(place: Place) -> None:
    status, calls, said = place.setup("everything")
    assert (status, calls) == (2, [])
    assert said == 'setup: the argument is "run" or "test", not "everything".\n'
    old = place.folder / "tools" / "old"
    old.write_text('#!/bin/sh\ncase "$*" in --version) echo Python 3.9.2 ;; *version_info*) exit 1 ;; esac\n')
    old.chmod(0o755)
    status, _, said = place.setup(python=str(old))
    assert status == 2
    assert said.endswith("/old is Python 3.9.2. Python 3.11 or newer is needed. Set PYTHON=/path/to/python3.\n")


def test_what_cannot_be_is_refused_in_a_sentence(place: Place) -> None:
    assert place.setup("run", "test")[::2] == (
        2, 'setup: one argument is expected, "run" or "test", but found 2: run test.\n',
    )  # fmt: skip
    status, _, said = place.setup(python="/nowhere/python")
    assert status == 2
    assert said.startswith("setup: /nowhere/python does not start, or is no Python. Python 3.11 or newer is needed.")
    (place.folder / ".venv").write_text("")
    assert place.setup()[::2] == (2, "setup: .venv is no folder. Remove it, and run this again.\n")


def test_an_installation_that_failed_says_that_it_is_not_done(place: Place) -> None:
    (place.folder / "tools" / "uv").write_text(FAKE_UV + '[ "$2" != install ]\n')
    assert place.setup()[2].endswith("setup: .venv is not done. Mend what is said above, and run this again.\n")


def test_an_environment_that_cannot_be_used_is_made_anew(place: Place) -> None:
    place.setup()
    (place.folder / ".venv" / "bin" / "python").write_text("#!/bin/sh\necho numpy is gone >&2\nexit 1\n")
    _, calls, said = place.setup()
    assert calls[0].startswith("uv venv")
    assert said.startswith("setup: .venv is made anew: numpy is gone\n")
    (place.folder / ".venv" / "bin" / "python").unlink()  # as where the Python that it was made of was removed
    assert place.setup()[1][0].startswith("uv venv")
    assert place.setup() == (0, [], "")


def said_of_ours(*words: str) -> str:
    """What is wrong with the environment of these sources."""
    environment = ROOT / ".venv"
    if environment.is_symlink() or not environment.is_dir():
        pytest.skip("no .venv of this folder")
    command = [str(environment / "bin" / "python"), "-I", "scripts/environment.py", *words]
    return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False).stderr.strip()


def test_an_environment_is_held_against_locks_and_python(tmp_path: Path) -> None:
    lock = tmp_path / "a.lock"
    text = (ROOT / LOCKS[0]).read_text()
    assert said_of_ours(LOCKS[0], "--", sys.executable) == ""
    lock.write_text(re.sub("^packaging==.*? ", "packaging==1.0 ", text, flags=re.M))
    assert re.fullmatch(r"packaging is \S+ in place of 1\.0", said_of_ours(str(lock)))
    lock.write_text(text + "not-there==1.0 \\\n    --hash=sha256:0\n")
    assert said_of_ours(str(lock)) == "not-there is gone"
    lock.write_text(text + "not-there==1.0 ; sys_platform == 'win32' \\\n    --hash=sha256:0\n")
    assert said_of_ours(str(lock)) == ""
    other = tmp_path / "python"
    other.write_text("#!/bin/sh\necho /elsewhere\n")
    other.chmod(0o755)
    assert said_of_ours("--", str(other)).startswith("it is of another Python, ")


def test_an_environment_of_a_copied_folder_is_known(tmp_path: Path) -> None:
    if said_of_ours():
        pytest.fail("the environment of these sources is not sound")
    python = str(ROOT / ".venv" / "bin" / "python")
    script = str(ROOT / "scripts" / "environment.py")
    (tmp_path / ".venv" / "bin").mkdir(parents=True)
    shutil.copy(ROOT / ".venv" / "bin" / "emg2vsa", tmp_path / ".venv" / "bin")
    done = subprocess.run([python, "-I", script], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.stderr == "its commands are of another folder\n"
