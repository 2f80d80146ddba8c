"""What the person is asked while a rig is set up."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from emg2vsa.errors import SettingError
from emg2vsa.lab.commissioning import AtThePad, mend_settings
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.rig.commissioning.checks import Check
from emg2vsa.rig_file import RigFile, load_rig


def answering(said: list[str], heard: list[str] | None = None) -> tuple[AtThePad, Iterator[str]]:
    """Somebody with these answers, and the answers that are still to come."""
    left = iter(said)
    return AtThePad(Person(say=(heard or []).append, ask=lambda question: next(left))), left


@pytest.mark.parametrize(
    ("said", "moved_mm"), [(["3.2"], 3.2), (["3,2"], 3.2), (["far", "3.2"], 3.2), ([""], None), (["far", ""], None)]
)
def test_a_distance_is_taken_with_point_or_comma_and_asked_again_where_it_is_no_number(
    said: list[str], moved_mm: float | None
) -> None:
    heard = ["begin"]
    somebody, left = answering(said, heard)
    assert somebody.moved_mm(20.0) == moved_mm
    assert next(left, None) is None
    assert ("Type a number of millimetres, such as 3.2." in heard) is (said[0] == "far")


@pytest.mark.parametrize(("said", "towards"), [(["y"], True), (["No"], False), (["perhaps", "yes"], True)])
def test_a_direction_is_asked_for_until_it_is_yes_or_no(said: list[str], towards: bool) -> None:
    assert answering(said)[0].towards(5.0) is towards


def test_settings_that_are_wrong_are_written_where_the_person_agrees(file: RigFile) -> None:
    wrong, before = [Check("push_sign", 1, -1, False, "")], file.path.read_text()
    asked: list[str] = []
    assert not mend_settings(file, wrong, Person(ask=lambda question: asked.append(question) or "n"))
    assert asked == [f"Write push_sign into {file.path}? [y/N] "]
    assert file.path.read_text() == before
    assert mend_settings(file, wrong, Person(yes=True))
    assert file.path.read_text() == f"{before}\n[rig]\npush_sign = -1\n"


def test_a_serial_number_is_offered_and_nothing_is_wrong_without_it(file: RigFile) -> None:
    offered, before = [Check("serial_number", None, "FT1", True, "", "force")], file.path.read_text()
    assert mend_settings(file, offered, Person(ask=lambda question: "n"))
    assert file.path.read_text() == before
    assert mend_settings(file, offered, Person(yes=True))
    assert load_rig(file.path).devices.force.serial_number == "FT1"
    known = [Check("serial_number", "FT1", "FT1", True, "", "force")]
    assert mend_settings(file, known, Person(ask=lambda question: pytest.fail(question)))


def test_who_says_yes_beforehand_is_not_asked() -> None:
    somebody = Person(yes=True)
    pad = AtThePad(somebody)
    pad.zero_calliper()
    assert pad.towards(5.0) is pad.moved_mm(20.0) is None
    assert somebody.agrees("Ready?")


def test_by_default_nobody_agrees() -> None:
    for asked in (
        lambda: NOBODY.agrees("Ready?"),
        lambda: NOBODY.answer("Ready?"),
        lambda: AtThePad(NOBODY).towards(5.0),
    ):
        with pytest.raises(SettingError, match=r"expected an answer to .* but found nobody who is asked"):
            asked()


def test_a_program_that_never_answers_rightly_is_not_asked_for_ever() -> None:
    with pytest.raises(SettingError, match="expected one of '', 's', 'q', but found 'y'"):
        Person(ask=lambda question: "y").answer("Place it.", ("", "s", "q"))


@pytest.mark.parametrize(("said", "agrees"), [("y", True), ("YES", True), ("", False), ("no", False), ("yo", False)])
def test_only_yes_is_yes(said: str, agrees: bool) -> None:
    assert Person(ask=lambda question: said).agrees("Ready?") is agrees


def test_a_question_that_nobody_can_answer_is_refused() -> None:
    with pytest.raises(SettingError, match="expected an answer, but found the end of the input"):
        Person(ask=lambda question: None).agrees("Ready?")
