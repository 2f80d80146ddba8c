"""``python -m casr.cli``, for where the command is not on the path."""

import sys

from casr.cli import main

if __name__ == "__main__":
    sys.exit(main())
