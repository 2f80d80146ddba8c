"""The far ends of a session's wires: an emulated participant, and the devices that measure it.

``participant`` presses as its page tells it; ``muscles`` are its EMG and the force sensor's signal, of which
``simulated`` makes sources within the process, ``trigno_server``, ``ni_task``, ``lsl_outlets`` and ``net_ft`` devices.
"""
