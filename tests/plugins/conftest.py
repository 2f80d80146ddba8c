"""The example packages of docs/architecture.md and docs/how-to/add-a-device.md as installed distributions."""

from __future__ import annotations

import re
import shutil
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from casr.plugins import found_plugins
from emg2vsa.devices import registry

ROOT = Path(__file__).resolve().parents[2]
Install = Callable[..., Path]


def example() -> tuple[str, str]:
    """pyproject.toml and module of the example, as the documentation prints them."""
    text = (ROOT / "docs" / "architecture.md").read_text(encoding="utf-8").partition("### Outside the project")[2]
    toml, code = re.search(r"```toml\n(.+?)```", text, re.S), re.search(r"```python\n(.+?)```", text, re.S)
    assert toml is not None
    assert code is not None
    return toml[1], code[1]


def device_example() -> tuple[dict[str, dict[str, str]], dict[str, str]]:
    """Entry points and modules of the page on devices."""
    text = (ROOT / "docs" / "how-to" / "add-a-device.md").read_text(encoding="utf-8")
    toml = re.search(r"```toml\n(\[build-system.+?)```", text, re.S)
    assert toml is not None
    modules = dict(re.findall(r"<!-- (lab_\w+)\.py -->\n```python\n(.+?)```", text, re.S))
    return tomllib.loads(toml[1])["project"]["entry-points"], modules


@pytest.fixture
def install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Install]:
    """Install the example into a folder on sys.path, perhaps in another version, or with other code or entry points."""
    folder = tmp_path / "site"
    folder.mkdir()
    monkeypatch.syspath_prepend(str(folder))

    def build(
        version: str = "1.0", code: str = "", entries: dict[str, dict[str, str]] | None = None,
        modules: dict[str, str] | None = None,
    ) -> Path:  # fmt: skip
        toml, example_code = example()
        project = tomllib.loads(toml)["project"]
        for old in folder.glob("*.dist-info"):
            shutil.rmtree(old)
        info = folder / f"lab_tools-{version}.dist-info"
        info.mkdir()
        (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {version}\n")
        groups = project["entry-points"] if entries is None else entries
        lines = [f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in of.items()) for group, of in groups.items()]
        (info / "entry_points.txt").write_text("\n".join(lines))
        for name, text in (modules or {"lab_tools": code or example_code}).items():
            (folder / f"{name}.py").write_text(text)
        forget()
        return folder

    yield build
    forget()


def forget() -> None:
    """As a program that starts anew."""
    found_plugins.cache_clear()
    registry._of_plugin.cache_clear()
    for name in [name for name in sys.modules if name.startswith("lab_")]:
        del sys.modules[name]
