"""``casr completion``: completion in the shell."""

from __future__ import annotations

from casr.command_line import command_of

add_to = command_of("casr")
