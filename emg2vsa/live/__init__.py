"""The live page: a process of its own that follows the folder of a run as it grows."""
