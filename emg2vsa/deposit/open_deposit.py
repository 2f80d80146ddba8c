"""An authors' package as somebody finds it: its files held against its own manifest."""

from __future__ import annotations

import json
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from emg2vsa.deposit.crate import METADATA, SUPPLEMENT, parts_of, sha256_of
from emg2vsa.errors import DataError

_WANTED = "an authors' package, as emg2vsa report STUDY --paper writes it"
_DO = "Name the folder of the package, or its supplement.zip."
_INPUT = "#input/"
_PROGRAM = "#software/emg2vsa"


@dataclass(frozen=True)
class Deposit:
    """A package in a folder.

    source : what the user named. sha256 : of each file, as the manifest has it. inputs : path of each file of data, as
    seen from the study file, to its SHA-256. version : of the program that wrote it.
    """

    source: Path
    folder: Path
    sha256: dict[str, str]
    inputs: dict[str, str]
    version: str

    def text(self, name: str) -> str:
        """Content of a text file. DataError : it is not there, or no text."""
        try:
            return (self.folder / name).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            found = "no such file" if isinstance(error, OSError) else "bytes that are no UTF-8 text"
            raise DataError(f"{self.source}: {name}", wanted="a text file", found=found, do=_MEND) from None

    def json(self, name: str) -> dict[str, Any]:
        """A JSON object. DataError : the file holds none."""
        try:
            found = json.loads(self.text(name))
        except ValueError as error:
            where = f"{self.source}: {name}"
            raise DataError(where, wanted="JSON", found=f"other text ({error})", do=_MEND) from None
        if not isinstance(found, dict):
            raise DataError(f"{self.source}: {name}", wanted="a JSON object", found=type(found).__name__, do=_MEND)
        return found

    def has(self, name: str) -> bool:
        """Whether the file is there."""
        return (self.folder / name).is_file()

    def damage(self) -> Iterator[tuple[str, str]]:
        """(file, what is wrong with it): missing, changed, or not in the manifest."""
        for name, expected in self.sha256.items():
            path = self.folder / name
            if not path.is_file():
                yield name, "missing"
            elif sha256_of(path) != expected:
                yield name, "changed"
        known = {*self.sha256, *self.inputs, METADATA, SUPPLEMENT}
        for path in sorted(self.folder.rglob("*")):
            name = path.relative_to(self.folder).as_posix()
            if path.is_file() and name not in known:
                yield name, "not in the manifest"
        if self.has(SUPPLEMENT):
            yield from self._damage_of_supplement()

    def _damage_of_supplement(self) -> Iterator[tuple[str, str]]:
        """The archive in the package holds its other files once more, the manifest among them."""
        try:
            with zipfile.ZipFile(self.folder / SUPPLEMENT) as archive:
                inside = set(archive.namelist())
                for name in sorted({METADATA, *self.sha256}):
                    if name not in inside:
                        yield f"{SUPPLEMENT}: {name}", "missing"
                    elif self.has(name) and archive.read(name) != (self.folder / name).read_bytes():
                        yield f"{SUPPLEMENT}: {name}", "differs from the file beside the archive"
        except _ZIP_ERRORS as error:
            yield SUPPLEMENT, f"no sound archive ({error})"


_MEND = "Get the package again: this file was changed."
_ZIP_ERRORS = (zipfile.BadZipFile, EOFError, NotImplementedError, RuntimeError, OSError)


def open_deposit(source: Path, unpacked: Path) -> Deposit:
    """The package in a folder or an archive. unpacked : empty folder, for the files of an archive.

    DataError : there is none, or its manifest cannot be read.
    """
    folder = source if source.is_dir() else _unpacked(source, unpacked)
    try:
        text = (folder / METADATA).read_text(encoding="utf-8")
        names = parts_of(text)
        entities = {entity["@id"]: entity for entity in json.loads(text)["@graph"]}
        digests = {unquote(key): str(entity["sha256"]) for key, entity in entities.items() if "sha256" in entity}
        version = str(entities[_PROGRAM]["softwareVersion"])
        sha256 = {name: digests[name] for name in names if name != METADATA}
    except FileNotFoundError:
        raise DataError(source, wanted=_WANTED, found=f"no {METADATA}", do=_DO) from None
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        found = f"a {METADATA} that is not of such a package ({error})"
        raise DataError(source, wanted=_WANTED, found=found, do=_DO) from None
    outside = [name for name in sha256 if not (folder / name).resolve().is_relative_to(folder.resolve())]
    if outside:
        raise DataError(source, wanted="files inside the package", found=outside[0], do=_MEND)
    inputs = {key.removeprefix(_INPUT): value for key, value in digests.items() if key.startswith(_INPUT)}
    return Deposit(source, folder, sha256, inputs, version)


def _unpacked(source: Path, into: Path) -> Path:
    """The folder that holds the package: all of the archive, or the one folder in it."""
    try:
        with zipfile.ZipFile(source) as archive:
            archive.extractall(into)
    except FileNotFoundError:
        raise DataError(source, wanted=_WANTED, found="no such file", do=_DO) from None
    except _ZIP_ERRORS as error:
        found = f"no sound zip archive ({error})"
        raise DataError(source, wanted=_WANTED, found=found, do="Get the archive again, or name a folder.") from None
    tops = list(into.iterdir())
    return tops[0] if len(tops) == 1 and tops[0].is_dir() else into
