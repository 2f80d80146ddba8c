"""The qbmove on its serial line: packets, conversation, driver; the rigid motor speaks the same protocol."""
