"""One participant's session: acquired, judged and saved while it runs.

Data flow: ``sources`` hand over blocks of samples on one clock; ``run`` (the turn of the session, 200 a second) appends
them to ``raw_files``, moves the session from command to command, judges each press, and tells what pages show
(``views``); every change is a line of the ``journal``. ``dataset`` turns a folder of raw files and its journal into
BIDS-EMG. ``emulated`` holds the far ends of the wires and the simulated participant.
"""
