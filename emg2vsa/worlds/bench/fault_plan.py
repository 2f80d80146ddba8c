"""What is to happen on the emulated rig at a time, or as soon as the specimen is pressed with a force."""

from __future__ import annotations

from collections.abc import Callable

Action = Callable[[], None]


class FaultPlan:
    """Actions that wait; each is carried out once."""

    def __init__(self) -> None:
        self._at_times: list[tuple[float, Action]] = []
        self._at_forces: list[tuple[float, Action]] = []

    def at_time(self, time_s: float, action: Action) -> None:
        """Once the clock shows ``time_s``."""
        self._at_times.append((time_s, action))

    def at_force(self, force_n: float, action: Action) -> None:
        """As soon as the true force on the specimen is ``force_n`` or more."""
        self._at_forces.append((force_n, action))

    def clear(self) -> None:
        """Nothing is to happen any more."""
        self._at_times.clear()
        self._at_forces.clear()

    def look(self, now_s: float, force_n: Callable[[float], float]) -> None:
        """Carry out what is due at the clock's time; ``force_n`` tells the force at a time."""
        if not (self._at_times or self._at_forces):
            return
        reached = force_n(now_s) if self._at_forces else 0.0
        due = [each for each in self._at_times if each[0] <= now_s] + [
            each for each in self._at_forces if each[0] <= reached
        ]
        for each in due:
            # an action may plan its own end
            (self._at_times if each in self._at_times else self._at_forces).remove(each)
            each[1]()
