"""The rules of RO-Crate 1.1 (https://www.researchobject.org/ro-crate/specification/1.1) that this crate can break."""

from __future__ import annotations

import hashlib
import json

import pytest

from emg2vsa.deposit.crate import CONTEXT, METADATA, Publication, description, encoding_format, metadata, parts_of

FILES = {"README.txt": b"read", "tables/a b.csv": b"x,y\n", "figures/f.pdf": b"%PDF", "study.toml": b"[study]"}
INPUTS = {"data/P01 é.bdf": "ab" * 32}
PUBLISHED = Publication("2026-01-31", "https://creativecommons.org/licenses/by/4.0/")


def made(publication: Publication | None = None) -> dict:
    publication = publication or Publication()
    return json.loads(metadata("A study", "About it.", FILES, INPUTS, {"numpy": "2.0"}, publication))


def entities(crate: dict) -> dict[str, dict]:
    found = {entity["@id"]: entity for entity in crate["@graph"]}
    assert len(found) == len(crate["@graph"])
    return found


def links(value: object) -> list[str]:
    if isinstance(value, list):
        return [link for item in value for link in links(item)]
    return [value["@id"]] if isinstance(value, dict) else []


def test_the_descriptor_and_the_root_have_what_the_specification_demands():
    crate = made()
    assert crate["@context"] == CONTEXT
    descriptor, root = (entities(crate)[name] for name in (METADATA, "./"))
    assert descriptor["@type"] == "CreativeWork"
    assert descriptor["conformsTo"] == {"@id": "https://w3id.org/ro/crate/1.1"}
    assert descriptor["about"] == {"@id": "./"}
    assert root["@type"] == "Dataset"
    assert {"name", "description", "datePublished", "license"} <= set(root)
    assert root["datePublished"] == "1980-01-01"
    assert entities(crate)["#licence"]["name"].startswith("No licence has been chosen")
    told = entities(made(PUBLISHED))["./"]
    assert told["datePublished"] == "2026-01-31"
    assert told["license"] == {"@id": "https://creativecommons.org/licenses/by/4.0/"}


def test_every_file_is_a_described_part_with_its_digest():
    crate = entities(made())
    files = {name: entity for name, entity in crate.items() if entity["@type"] == "File"}
    assert sorted(links(crate["./"]["hasPart"])) == sorted(files)
    assert {entity["name"]: entity["sha256"] for entity in files.values()} == {
        name: hashlib.sha256(data).hexdigest() for name, data in FILES.items()
    }
    assert "tables/a%20b.csv" in files  # @id is a URI
    assert all(entity["description"] and entity["encodingFormat"] for entity in files.values())


def test_every_link_leads_somewhere():
    crate = made(PUBLISHED)
    known = entities(crate)
    outside = {"https://w3id.org/ro/crate/1.1"}
    targets = {link for entity in crate["@graph"] for value in entity.values() for link in links(value)}
    assert targets - outside <= set(known)
    # and every entity is reached, but for the descriptor
    assert set(known) - targets == {METADATA}


def test_the_run_says_what_it_took_and_made_and_with_what():
    crate = entities(made())
    run = crate["#run"]
    assert run["@type"] == "CreateAction"
    assert {crate[link]["name"] for link in links(run["instrument"])} == {"emg2vsa", "numpy"}
    assert {crate[link]["name"] for link in links(run["object"])} == {"data/P01 é.bdf", "study.toml"}
    assert {crate[link]["name"] for link in links(run["result"])} == set(FILES) - {"study.toml"}
    assert crate["#input/data/P01%20%C3%A9.bdf"]["sha256"] == "ab" * 32


def test_the_files_of_a_package_are_read_back_and_another_crate_is_not_taken_for_one():
    text = metadata("A study", "About it.", FILES, INPUTS, {}, Publication())
    assert set(parts_of(text)) == {METADATA, *FILES}
    for other in ("[]", "{}", '{"@graph": []}', text.replace("emg2vsa report --paper", "their own run")):
        with pytest.raises((ValueError, KeyError, TypeError)):
            parts_of(other)


@pytest.mark.parametrize(
    ("name", "kind", "said"),
    [
        ("results.json", "application/json", "Every number by name"),
        ("figures/fig08.pdf", "application/pdf", "Figure fig08, vector"),
        ("tables/pairs.csv", "text/csv", "Table pairs, every digit"),
        ("something/new.xyz", "application/octet-stream", "Result new"),
    ],
)
def test_every_file_has_a_media_type_and_a_line(name, kind, said):
    assert encoding_format(name) == kind
    assert description(name).startswith(said)
