"""``python stat_of_all.py FOLDER KEPT``: whether any file below a folder changed, as make asks: by size and times.

Exit status 1 where one did; without KEPT's file that is written.
"""

import json
import os
import sys


def states(folder: str) -> dict[str, list[int]]:
    """Size and both times of every file."""
    found, left = {}, [folder]
    while left:
        with os.scandir(left.pop()) as entries:
            for entry in entries:
                if entry.is_dir(follow_symlinks=False):
                    left.append(entry.path)
                else:
                    of = entry.stat()
                    found[entry.path] = [of.st_size, of.st_mtime_ns, of.st_ctime_ns]
    return found


if __name__ == "__main__":
    folder, kept = sys.argv[1:]
    now = states(folder)
    if os.path.exists(kept):
        with open(kept) as file:
            sys.exit(int(json.load(file) != now))
    with open(kept, "w") as file:
        json.dump(now, file)
