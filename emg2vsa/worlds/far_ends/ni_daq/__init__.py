"""The far end of an NI card: a task of nidaqmx."""
