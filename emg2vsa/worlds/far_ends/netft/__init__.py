"""The far end of a Net F/T box: datagrams, page, faults."""
