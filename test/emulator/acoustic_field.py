"""The sound field of an array by a direct sum, written from the formula of a piston in a baffle.

Every transducer n sends cos(omega t - phi_n). It arrives at distance r after r / c, weakened by 1 / r, by the
directivity 2 J1(x) / x with x = k R sin(theta), and by the air. Positions in m, pressures in Pa.
"""
import math

import numpy

FREQUENCY = 40000.0                                     # Hz
SOUND_SPEED = 331.3 * math.sqrt(1.0 + 20.0 / 273.15)    # m/s, at 20 degrees C
WAVENUMBER = 2.0 * math.pi * FREQUENCY / SOUND_SPEED    # rad/m
RADIUS = 0.0045                                         # m
REFERENCE = 3.4                                         # Pa m, of a transducer at full drive
ATTENUATION = 0.15                                      # Np/m


def bessel_j1(x):
    """J1 by its integral, (1/pi) integral of cos(t - x sin t) from 0 to pi; the trapezoid rule is exact here to
    rounding."""
    steps = 24
    ends = 0.5 * (math.cos(0.0) + math.cos(math.pi))
    inner = sum(math.cos(t - x * math.sin(t)) for t in (math.pi * i / steps for i in range(1, steps)))
    return (ends + inner) / steps


_TABLE_STEPS = 2000
# 2 J1(x) / x over sin(theta), as a table.
_TABLE = numpy.array([1.0] + [2.0 * bessel_j1(x) / x for x in
                              (WAVENUMBER * RADIUS * i / _TABLE_STEPS for i in range(1, _TABLE_STEPS + 1))])


def pressures(sources, points, normals=None):
    """Peak pressure at each of N points, N x 3. `sources`: M x 3, (x, y, phase) of each transducer that plays, at
    height 0 and looking up. With `normals` of skin there, N x 3, outward and unit: of what presses on it, each wave
    times the cosine of its incidence, and 0 from behind."""
    x, y, phase = numpy.asarray(sources, dtype=float).reshape(-1, 3).T
    points = numpy.asarray(points, dtype=float)
    aside = numpy.hypot(points[:, :1] - x, points[:, 1:2] - y)
    r = numpy.hypot(aside, points[:, 2:])
    directivity = _TABLE[(_TABLE_STEPS * aside / r + 0.5).astype(int)]
    if normals is not None:
        a, b, c = (column[:, None] for column in numpy.asarray(normals, dtype=float).T)
        along = a * (x - points[:, :1]) + b * (y - points[:, 1:2]) - c * points[:, 2:]
        directivity = directivity * numpy.maximum(along / r, 0.0)
    waves = directivity / r * numpy.exp(-ATTENUATION * r + 1j * (WAVENUMBER * r + phase))
    return REFERENCE * abs(waves.sum(axis=1))


def pressure(sources, point, normal=None):
    """Peak pressure at a point; with a normal, of what presses on skin there."""
    return float(pressures(sources, [point], None if normal is None else [normal])[0])


def peak(sources, start, reach=0.008, finest=0.0002):
    """The local maximum of the pressure that is reached uphill from `start`, in the plane of its height.

    Returns (point, pressure). Ends at `reach` aside of the start, where no peak is found nearer.
    """
    sources = numpy.asarray(sources, dtype=float)
    here, best, step = tuple(start), pressure(sources, start), 0.0016
    while step >= finest:
        around = [(here[0] + dx * step, here[1] + dy * step, here[2])
                  for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
        found = max(zip(pressures(sources, around), around))
        if found[0] > best and math.dist(found[1], start) <= reach:
            best, here = found
        else:
            step /= 2.0
    return here, best
