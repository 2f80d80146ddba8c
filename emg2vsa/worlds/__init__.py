"""Made worlds: people, contacts, tactile frames, the rig, and the far ends of the wires. Analyses never import them."""

VERSION = 1
"Of all draws. 1: recordings and frames of the demo study as at commit 4a6cfa7a (tests/worlds/fixture)."
