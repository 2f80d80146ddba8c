"""The far end of a Trigno system: base and SDK server."""
