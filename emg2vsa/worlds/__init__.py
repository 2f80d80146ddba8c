"""Made worlds: people, contacts, tactile frames, the rig, and the far ends of the wires. Analyses never import them."""
