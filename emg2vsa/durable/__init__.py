"""Files that grow while they are recorded, and one writer that gives them to the disk in their order."""
