"""``python -m emg2vsa.cli``, for where the command is not on the path."""

import sys

from emg2vsa.cli import main

if __name__ == "__main__":
    sys.exit(main())
