"""Made worlds: people, contacts, tactile frames, the rig, and the far ends of the wires. Analyses never import them."""

VERSION = 4
"""Of what the worlds draw; whatever changes a byte of it raises the version. Every truth file holds it.

1 : recordings and runs as at commit 4a6cfa7a (tests/worlds/fixture). 2 : the same recordings and runs; a live
participant is measured by the electrodes and force sensors of recordings, which drift. 3 : the same recordings; the
skin of the rig's runs moves by tables of casr dome. 4 : by tables at 3.35 and 7.63 N/mm, too.
"""
