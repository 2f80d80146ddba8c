"""``emg2vsa tools completion``: completion in the shell."""

from __future__ import annotations

from casr.completion import command_of

add_to = command_of("emg2vsa", "emg2vsa tools")
