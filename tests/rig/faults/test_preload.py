"""A force before the press is no contact: the zero is wrong, or something is in the way."""

from __future__ import annotations

from collections.abc import Callable


def test_no_press_begins_on_a_loaded_sensor(check: Callable[[str, str], None]) -> None:
    check("force jumps", "activation")
