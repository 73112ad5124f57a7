"""The sound field of an array by a direct sum, written from the formula of a piston in a baffle and in no hurry.

Every transducer n sends cos(omega t - phi_n). It arrives at distance r after r / c, weakened by 1 / r, by the directivity
2 J1(x) / x with x = k R sin(theta), and by the air. Positions in m, pressures in Pa.
"""
import cmath
import math

FREQUENCY = 40000.0                                     # Hz
SOUND_SPEED = 331.3 * math.sqrt(1.0 + 20.0 / 273.15)    # m/s, at 20 degrees C
WAVENUMBER = 2.0 * math.pi * FREQUENCY / SOUND_SPEED    # rad/m
RADIUS = 0.0045                                         # m
REFERENCE = 3.4                                         # Pa m, of a transducer at full drive
ATTENUATION = 0.15                                      # Np/m


def bessel_j1(x):
    """J1 by its integral, (1/pi) integral of cos(t - x sin t) from 0 to pi; the trapezoid rule is exact here to rounding."""
    steps = 24
    ends = 0.5 * (math.cos(0.0) + math.cos(math.pi))
    inner = sum(math.cos(t - x * math.sin(t)) for t in (math.pi * i / steps for i in range(1, steps)))
    return (ends + inner) / steps


# 2 J1(x) / x over sin(theta), as a table: the sum is plain Python.
_TABLE = [1.0] + [2.0 * bessel_j1(x) / x for x in (WAVENUMBER * RADIUS * i / 2000.0 for i in range(1, 2001))]


def pressure(sources, point):
    """Peak pressure at a point. `sources`: (x, y, phase) of each transducer that plays, at height 0 and looking up."""
    total = 0j
    for x, y, phase in sources:
        dx, dy = point[0] - x, point[1] - y
        aside = math.hypot(dx, dy)
        r = math.hypot(aside, point[2])
        directivity = _TABLE[int(2000.0 * aside / r + 0.5)]
        total += cmath.rect(directivity / r * math.exp(-ATTENUATION * r), WAVENUMBER * r + phase)
    return REFERENCE * abs(total)


def peak(sources, start, reach=0.008, finest=0.0002):
    """The local maximum of the pressure that is reached uphill from `start`, in the plane of its height.

    Returns (point, pressure). Ends at `reach` aside of the start, where no peak is found nearer.
    """
    here, best, step = tuple(start), pressure(sources, start), 0.0016
    while step >= finest:
        around = [(here[0] + dx * step, here[1] + dy * step, here[2])
                  for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy]
        found = max((pressure(sources, point), point) for point in around)
        if found[0] > best and math.dist(found[1], start) <= reach:
            best, here = found
        else:
            step /= 2.0
    return here, best
