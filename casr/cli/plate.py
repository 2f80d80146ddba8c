"""``casr calibrate --plate``: whether the domes that casr knows move as this sensor does."""

from __future__ import annotations

import argparse
from dataclasses import asdict

from casr.command_line import print_json


def check_plate(arguments: argparse.Namespace) -> int:
    """Exit status 1: the sensor is none of the library's."""
    from casr.contact_area.plate import check_on_plate
    from casr.dome.library import worlds
    from casr.errors import CameraError
    from casr.frame_files import open_frames, read_camera
    from casr.scoring import score

    given = arguments.out if arguments.out and arguments.out.exists() else None
    sequence = open_frames(arguments.plate, camera=given)
    camera = read_camera(given) if given else sequence.camera
    if camera is None:
        wanted, do = "a camera file beside the press, or one given with --out", "Calibrate the camera first."
        raise CameraError(arguments.plate, wanted=wanted, found="none", do=do)
    scored = score(sequence)
    found = check_on_plate(scored.rest.centroids_px, scored.pins_px, camera, worlds(arguments.domes))
    if arguments.json:
        print_json(asdict(found))
        return int(not found.fits)
    verdict = "it is like" if found.fits else "it is none of the library's; nearest is"
    print(f"{arguments.plate}: {found.misfit:.1%} of the pins' motion is left over: {verdict} dome {found.dome}")
    for length, misfit in found.misfit_of_length.items():
        print(f"  with pins of {length:.2g} mm: {misfit:.1%}")
    print("  (the length is not told by this: measure it)")
    if not found.fits:
        print("  Areas by the front depend on the dome assumed. Give tables of this sensor's own: casr score --domes")
    return int(not found.fits)
