"""Where the project is, and how to install it, in every file that says so: from pyproject.toml alone.

``python scripts/metadata.py`` writes the install lines of README.md, codemeta.json, and version and addresses of
CITATION.cff. ``--check`` changes nothing and fails where a file differs.

The one setting of addresses is the table ``[project.urls]`` of pyproject.toml, with the keys Repository and Issues.
There is none today, and no file says an address. Lines of installation then begin in the folder of the sources.
"""

from __future__ import annotations

import json
import re
import sys
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
MARKS = "<!-- install: scripts/metadata.py writes this -->\n", "<!-- install: end -->\n"
NOT_RUN = "<!-- not run: tests/test_install.py tries these lines -->\n"
LINES = (
    ("pip install .", "the tactile side alone: casr"),
    ('pip install ".[study]"', "with people, schedules and the rig"),
    ('uv tool install ".[study]"', "or this: the commands in an environment of their own"),
)


def install(urls: dict[str, str]) -> str:
    """The lines that a stranger copies."""
    if repository := urls.get("Repository"):
        said, get = "From a clone:", [f"git clone {repository} emg2vsa && cd emg2vsa"]
    else:
        said, get = "No package index has emg2vsa yet. In the folder of its sources run one of these:", []
    width = max(len(line) for line, _ in LINES) + 3
    lines = get + [f"{line:{width}}# {about}" for line, about in LINES]
    return said + "\n\n" + NOT_RUN + "```sh\n" + "\n".join(lines) + "\n```\n"


def readme(old: str, project: dict[str, Any]) -> str:
    first, _, rest = old.partition(MARKS[0])
    return first + MARKS[0] + install(project.get("urls", {})) + MARKS[1] + rest.partition(MARKS[1])[2]


def citation(old: str, project: dict[str, Any]) -> str:
    """The same with today's version, and repository-code where there is an address."""
    kept = re.sub(r"^repository-code: .*\n", "", old, flags=re.M)
    address = project.get("urls", {}).get("Repository")
    new = f"version: {project['version']}\n" + (f'repository-code: "{address}"\n' if address else "")
    return re.sub(r"^version: .*\n", new, kept, count=1, flags=re.M)


def codemeta(project: dict[str, Any]) -> str:
    """CodeMeta 3.0. Its context is the name of the vocabulary, not an address of this project."""
    urls = project.get("urls", {})
    made: dict[str, Any] = {
        "@context": "https://w3id.org/codemeta/3.0",
        "@type": "SoftwareSourceCode",
        "name": project["name"],
        "description": project["description"],
        "version": project["version"],
        "license": f"https://spdx.org/licenses/{project['license']}",
        "author": [{"@type": "Organization", "name": one["name"]} for one in project["authors"]],
        "keywords": project["keywords"],
        "programmingLanguage": [{"@type": "ComputerLanguage", "name": "Python"}],
        "runtimePlatform": f"Python {project['requires-python']}",
        "operatingSystem": [one.split(" :: ")[-1] for one in project["classifiers"] if one.startswith("Operating")],
        "softwareRequirements": project["dependencies"],
        "developmentStatus": "wip",
        "readme": "README.md",
    }
    if "Repository" in urls:
        made["codeRepository"] = urls["Repository"]
    if "Issues" in urls:
        made["issueTracker"] = urls["Issues"]
    return json.dumps(made, indent=2, ensure_ascii=False) + "\n"


def project_of(root: Path) -> dict[str, Any]:
    """The table [project] with its version."""
    project: dict[str, Any] = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    found = re.search(r'^__version__ = "(.+)"$', (root / "casr" / "__init__.py").read_text(encoding="utf-8"), re.M)
    assert found is not None
    return project | {"version": found[1]}


def files(root: Path, project: dict[str, Any]) -> dict[str, str]:
    """Name to text of every file that says what pyproject.toml says."""
    old = {name: (root / name).read_text(encoding="utf-8") for name in ("README.md", "CITATION.cff")}
    return {
        "README.md": readme(old["README.md"], project),
        "CITATION.cff": citation(old["CITATION.cff"], project),
        "codemeta.json": codemeta(project),
    }


def main(words: list[str]) -> int:
    wanted = files(ROOT, project_of(ROOT))
    old = [
        name
        for name, text in wanted.items()
        if not (ROOT / name).is_file() or (ROOT / name).read_text(encoding="utf-8") != text
    ]
    if "--check" in words:
        for name in old:
            print(f"{name}: differs from pyproject.toml. Run python scripts/metadata.py.")
        return int(bool(old))
    for name in old:
        (ROOT / name).write_text(wanted[name], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
