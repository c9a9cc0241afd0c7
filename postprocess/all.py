#!/usr/bin/python3
# SPDX-License-Identifier: MIT
# SPDX-FileCopyrightText: 2026 the ryusa authors
"""All pictures of a result: NAME-flux.png, NAME-profiles.png, NAME-bed.png, NAME-relations.png, NAME.gif.

What a run has no data for (a dry one has no flow) is left out and said so."""
from pathlib import Path

from ryusa_result import UNEXPECTED, Result, ResultError, parser, run


def make_all(result, folder):
    import animate
    import bed
    import flux
    import profiles
    import relations
    pictures = [("-flux.png", flux.make, "q_star"), ("-profiles.png", profiles.make, "profile"),
                ("-bed.png", bed.make, "position"),
                ("-relations.png", lambda one, path: relations.make([one], path), "flux"),
                (".gif", animate.make, "position")]
    made = 0
    for ending, make, needed in pictures:
        path = folder / (result.stem + ending)
        if not result.has(needed):
            print(f"{path.name}: left out, the file has no {needed}")
            continue
        try:
            print(make(result, path), flush=True)
            made += 1
        except ResultError as error:
            print(f"{path.name}: left out, {error}", flush=True)
        except UNEXPECTED as error:
            print(f"{path.name}: left out, the file does not hold what is expected: {error}", flush=True)
    if made == 0:
        raise ResultError(f"{result.path}: nothing in it to draw")


def main():
    arguments = parser(__doc__)
    arguments.add_argument("file", help="result file, OUT.h5 or OUT.h5.part")
    arguments.add_argument("-o", "--output", metavar="FOLDER", help="folder for the pictures (default: beside the result)")
    given = arguments.parse_args()
    with Result(given.file) as result:
        folder = Path(given.output) if given.output else result.path.parent
        folder.mkdir(parents=True, exist_ok=True)
        make_all(result, folder)


if __name__ == "__main__":
    run(main)
