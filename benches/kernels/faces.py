"""Error of an interpolating B-spline near the volume's faces, for Marschner and Lobb's signal, by boundary condition.

Samples as in builtin:marschner-lobb@41 (bytes), compared at random positions of a given depth below one of the six faces, and deeper below
the five others: values, and magnitudes of gradient differences, rms, in 8-bit steps (per voxel).
"""

import numpy

from scenes import table

N, PLACES, RADIUS, PAD, BACKGROUND = 41, 20_000, 10, 16, 0.0
POLE = 3**0.5 - 2
DEPTHS = [0, 0.25, 0.5, 0.75, 1, 1.5, 2, 2.5, 3, 3.5, 4]


def signal(p):
    """The signal at (3, n) positions in voxels, and its gradient."""
    half, scale = (N - 1) / 2, 255 / 2.5
    x, y, z = p / half - 1
    r = numpy.hypot(x, y)
    phase = 12 * numpy.pi * numpy.cos(numpy.pi * r / 2)
    value = scale * (1 - numpy.sin(numpy.pi * z / 2) + 0.25 * (1 + numpy.cos(phase)))
    along_r = 0.25 * numpy.sin(phase) * 6 * numpy.pi**2 * numpy.sin(numpy.pi * r / 2) / numpy.maximum(r, 1e-12)
    return value, scale / half * numpy.array([along_r * x, along_r * y, -numpy.pi / 2 * numpy.cos(numpy.pi * z / 2)])


def filtered(numbers):
    """The device's prefilter along all axes, mirrored at the borders."""
    taps = POLE ** numpy.abs(numpy.arange(-RADIUS, RADIUS + 1.0))
    taps /= taps.sum()
    for axis in range(3):
        wide = numpy.pad(numbers, [(RADIUS, RADIUS) if a == axis else (0, 0) for a in range(3)], mode="reflect")
        numbers = sum(t * wide.take(range(k, k + numbers.shape[axis]), axis) for k, t in enumerate(taps))
    return numbers


def weights(t):
    """Weights of the four nearest coefficients, and of the slope."""
    s = 1 - t
    value = [s**3 / 6, 2 / 3 - t**2 + t**3 / 2, 2 / 3 - s**2 + s**3 / 2, t**3 / 6]
    slope = [-(s**2) / 2, 1.5 * t**2 - 2 * t, -(1.5 * s**2 - 2 * s), t**2 / 2]
    return value, slope


def spline(coefficients, pad, p):
    """Value and gradient at (3, n) positions, from coefficients whose first voxel is at `pad`."""
    cell = numpy.floor(p).astype(int)
    of = [weights(t) for t in p - cell]
    sums = numpy.zeros((4, p.shape[1]))
    for k in range(64):
        tap = [k & 3, k >> 2 & 3, k >> 4]
        c = coefficients[tuple(cell[a] + tap[a] - 1 + pad for a in range(3))]
        for which in range(4):  # the value, then the slope along each axis
            sums[which] += c * numpy.prod([of[a][1 if a + 1 == which else 0][tap[a]] for a in range(3)], axis=0)
    return sums[0], sums[1:]


def main():
    random = numpy.random.default_rng(1)
    grid = numpy.stack(numpy.meshgrid(*[numpy.arange(N)] * 3, indexing="ij")).reshape(3, -1).astype(float)
    voxels = numpy.round(signal(grid)[0]).reshape(N, N, N)
    inside = filtered(voxels)
    ways = {
        "mirrored, and so beyond": numpy.pad(inside, PAD, mode="reflect"),
        "mirrored, background beyond": numpy.pad(inside, PAD, constant_values=BACKGROUND),
        "background's padding": filtered(numpy.pad(voxels, PAD, constant_values=BACKGROUND)),
    }
    rows = []
    for depth in DEPTHS:
        p = random.uniform(depth, N - 1 - depth, (3, PLACES))
        axis, far = random.integers(0, 3, PLACES), random.integers(0, 2, PLACES)
        p[axis, numpy.arange(PLACES)] = numpy.where(far, N - 1 - depth, depth)
        value, gradient = signal(p)
        row = [f"{depth:g}"]
        for coefficients in ways.values():
            found, slope = spline(coefficients, PAD, p)
            rms = [numpy.sqrt(numpy.mean(e)) for e in ((found - value) ** 2, ((slope - gradient) ** 2).sum(0))]
            row.append(f"{rms[0]:.2f} / {rms[1]:.2f}")
        rows.append(row)
    print(table(["depth, voxels", *ways], rows))


main()
