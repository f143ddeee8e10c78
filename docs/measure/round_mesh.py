"""The triangle mesh of a round silo, for the measurements that compare a mesh with cylinder and cone."""

import math


def obj_text(line, around):
    """The OBJ text of the surface that the points (r, z), m, of `line` describe around the z axis, with `around` points in a circle."""
    rows = []
    for r, z in line:
        angles = (2 * math.pi * turn / around for turn in range(around))
        rows += [f"v {r * math.cos(a)!r} {r * math.sin(a)!r} {z!r}" for a in angles]
    for ring in range(len(line) - 1):
        for turn in range(around):
            a, b = (ring * around + n % around + 1 for n in (turn, turn + 1))
            rows += [f"f {a} {b} {a + around}", f"f {b} {b + around} {a + around}"]
    return "\n".join(rows) + "\n"
