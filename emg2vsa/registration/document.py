"""The file of a registration: JSON that its own SHA-256 signs, and the same for people, as OSF and AsPredicted ask.

A hash shows that a file is as it was written; when it was written, a deposit of the file or of its hash shows.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from casr.atomic import write_new
from emg2vsa.errors import DataError
from emg2vsa.registration.plan import Plain
from emg2vsa.registration.questions import answers, collected

FORM = "emg2vsa registration 1"
SIGNED: dict[str, type] = {
    "form": str, "registered_at": str, "study": str, "title": str, "amends": str, "rig_file": str, "plan": dict,
    "claims": dict, "code": dict, "data": dict, "collected": str, "aspredicted": dict, "osf": dict,
}  # fmt: skip
"""Fields of a registration and what they hold."""
_RESTORE = "Restore the file as it was registered; a new plan is a registration of its own: emg2vsa register --out."


def document(
    study: str, title: str, *, now: Mapping[str, Any], registered_at: str, rig_file: str = "", amends: str = ""
) -> Plain:
    """The registration of what the study is ``now``: plan, claims, code and data. rig_file : beside the study file."""
    said = {"form": FORM, "registered_at": registered_at, "study": study, "title": title, "amends": amends}
    content = said | {"rig_file": rig_file, "collected": collected(now)}
    content |= {name: now[name] for name in ("plan", "claims", "code", "data")}
    return _signed(content | answers(content))


def _signed(content: Plain) -> Plain:
    """With a hash of every field, which tells where a file was edited, and one of all of it."""
    whole = content | {"sha256_of": {name: _sha256(value) for name, value in content.items()}}
    return whole | {"sha256": _sha256(whole)}


def _sha256(value: Any) -> str:
    """SHA-256 of the value as JSON with sorted keys, no blanks, and as many digits as each number has."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    return hashlib.sha256(text.encode()).hexdigest()


def write_registration(path: Path, content: Plain) -> list[Path]:
    """Write the file, and the text for people beside it. DataError : one is there already; nothing is overwritten."""
    text = path.with_suffix(".md")
    files = {path: json.dumps(content, indent=1, sort_keys=True, ensure_ascii=False) + "\n", text: _markdown(content)}
    do = "Keep it: it is what was registered. For a changed plan give another name with --out."
    for file in files:
        if file.exists():
            raise DataError(file, wanted="a name for a new registration", found="a file", do=do)
    for file, said in files.items():
        try:
            write_new(file, said.encode())
        except FileExistsError:
            raise DataError(file, wanted="a name for a new registration", found="a file", do=do) from None
    return list(files)


def read_registration(path: Path, study: str | None) -> Plain:
    """The registration of the study of this name, None for any. DataError : there is none, or it, or the text for
    people beside it, is not as it was written."""

    content = _parsed(path)
    form = content.get("form")
    if form != FORM:
        do = "Read it with the version of emg2vsa that wrote it, or restore the file."
        raise _refused(path, f"the form {FORM!r}", repr(form) if form else "another file", do)
    _check_signed(path, content)
    if study not in (None, content["study"]):
        do = (
            "Put the registration beside the study file that it is of. If you renamed the study, write a registration "
            "with emg2vsa register --out FILE, which amends this one, and name it under [study]: registration = FILE."
        )
        raise _refused(path, f"the registration of the study {study!r}", f"that of {content['study']!r}", do)
    text = path.with_suffix(".md")
    if text.is_file() and content["sha256"].encode() not in text.read_bytes():
        wanted = f"the text of {path.name}, SHA-256 {content['sha256'][:12]}"
        raise _refused(text, wanted, "another", "Restore both as they were registered.")
    return content


def _refused(path: Path, wanted: str, found: str, do: str = _RESTORE) -> DataError:
    return DataError(path, wanted=wanted, found=found, do=do)


def _parsed(path: Path) -> Plain:
    """The object of JSON in the file; empty where it holds another value. DataError : no file, or no JSON."""
    try:
        content = json.loads(path.read_bytes().decode(), object_pairs_hook=_once)
    except OSError as error:
        do = "Correct registration under [study], or write one: emg2vsa register."
        found = {FileNotFoundError: "no such file", IsADirectoryError: "a folder"}.get(type(error), error.strerror)
        raise _refused(path, "a registration", found or "no file", do) from None
    except (ValueError, RecursionError) as error:
        found = f"text that is cut off or edited ({error})"
        raise _refused(path, "a registration, which is JSON", found) from None
    return content if isinstance(content, dict) else {}


def _check_signed(path: Path, content: Plain) -> None:
    """DataError : fields are absent, besides, edited, or of another kind."""
    absent = [name for name in (*SIGNED, "sha256_of", "sha256") if name not in content]
    more = [name for name in content if name not in (*SIGNED, "sha256_of", "sha256")]
    if absent or more:
        told = [f"no {', '.join(absent)}"] * bool(absent) + [f"{', '.join(more)} besides"] * bool(more)
        raise _refused(path, "the fields of a registration", " and ".join(told))
    hashes = content["sha256_of"] if isinstance(content["sha256_of"], dict) else {}
    edited = [name for name in SIGNED if hashes.get(name) != _sha256(content[name])]
    now = _sha256({name: value for name, value in content.items() if name != "sha256"})
    if edited or now != content["sha256"]:
        where = f" (edited: {', '.join(edited)})" if edited else ""
        signed = f"the content that SHA-256 {str(content['sha256'])[:12]} signs"
        raise _refused(path, signed, f"that of {now[:12]}{where}")
    odd = [name for name, kind in SIGNED.items() if not isinstance(content[name], kind)]
    if odd:
        raise _refused(path, "a registration as emg2vsa register writes it", f"other values of {', '.join(odd)}")


def _once(pairs: list[tuple[str, Any]]) -> Plain:
    """An object of JSON; a key that stands there twice would have two values."""
    content = dict(pairs)
    if len(content) < len(pairs):
        raise ValueError(f"the key {Counter(key for key, _ in pairs).most_common(1)[0][0]!r} twice")
    return content


def _markdown(content: Plain) -> str:
    """The answers under the headings of both forms, the claims, and how to prove that all of it is unchanged."""
    claims = [
        f"- {each['says']}: {each['estimand']}; {'above 0' if each['asserts'] == 'more' else 'within'}, margin "
        f"{each['margin']:g}" for each in content["claims"].values()
    ]  # fmt: skip
    parts = [
        f"# {content['title']}",
        f"Registered {content['registered_at']}. SHA-256 of the registration: `{content['sha256']}`. "
        + (f"It amends the registration {content['amends']}. " if content["amends"] else "")
        + "Deposit the file, or at least this hash, where its date is public.",
        *(f"## AsPredicted: {question}\n\n{answer}" for question, answer in content["aspredicted"].items()),
        *(f"## OSF: {heading}\n\n{answer}" for heading, answer in content["osf"].items()),
        "## Claims\n\n" + "\n".join(claims),
    ]
    return "\n\n".join(parts) + "\n"
