"""The far ends of the wires: emulated devices that share one physical world."""
