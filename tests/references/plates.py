"""A15, A16: frequencies of beams and plates on square cells, as eigenvalues.

The system is assembled and solved without time steps. The cells are those of
worker/fem/src/elements/stabilised_quad.rs for a square: one point, bending and shear stabilised.
The effect of the mass on a frequency has two parts:
  section  masses at the nodes, rotational inertia of the section (t^2/12 per mass): this is the
           error of the mesh and of lumped masses
  floor    with the inertia of the engine, at least A/7 for nu = 0 and A/11.7 for nu = 0.3
Prints the deviation from the references of the checks in percent, and next to it that of the
engine, from tests/VERIFICATION.md.

    python3 tests/references/plates.py > tests/references/plates.txt
"""

import numpy as np
from scipy.linalg import eigh

XI, ETA = np.array([-1.0, 1, 1, -1]), np.array([-1.0, -1, 1, 1])
H = XI * ETA


def cell(side, t, e, nu):
    """Stiffness of w, bx, by at four corners; b rotates the normal: gamma = grad w + b."""
    area, g = side * side, e / (2 * (1 + nu))
    d = e * t**3 / 12 / (1 - nu**2)
    zero = np.zeros(4)
    row = lambda w=zero, x=zero, y=zero: np.stack([w, x, y], 1).ravel()
    bx, by, mean = XI / (2 * side), ETA / (2 * side), np.full(4, 0.25)
    kappa = np.stack([row(x=bx), row(y=by), row(x=by, y=bx)])
    elastic = d * np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    k = area * kappa.T @ elastic @ kappa
    shear = 5 / 6 * g * t
    for gamma in (row(w=bx, x=mean), row(w=by, y=mean)):
        k += area * shear * np.outer(gamma, gamma)
    # E t^3/12 /32 Jxx q^2 with Jxx = 4/3, twice for the second derivative.
    for q in (row(x=H), row(y=H)):
        k += e * t**3 / 12 / 32 * 4 / 3 * 2 * np.outer(q, q)
    # 5/6 G t A/6 X X (s + M2 a)^2, reduced by the bending of sides.
    soft = 1 + shear * side**2 / (12 * d)
    for vary in (row(w=H / 4, x=ETA / 4 * side / 2), row(w=H / 4, y=XI / 4 * side / 2)):
        k += shear / soft * area / 3 * 4 / side**2 * np.outer(vary, vary)
    return k


def frequencies(n, m, side, t, e, nu, rho, inertia, held):
    number = lambda i, j: i * (m + 1) + j
    count = 3 * (n + 1) * (m + 1)
    k, mass = np.zeros((count, count)), np.zeros(count)
    one, corner = cell(side, t, e, nu), rho * t * side * side / 4
    for i in range(n):
        for j in range(m):
            nodes = [number(i, j), number(i + 1, j), number(i + 1, j + 1), number(i, j + 1)]
            at = np.concatenate([[3 * a, 3 * a + 1, 3 * a + 2] for a in nodes])
            k[np.ix_(at, at)] += one
            mass[at] += np.tile([corner, corner * inertia, corner * inertia], 4)
    free = np.array(
        [c for c in range(count) if not held(c % 3, c // 3 // (m + 1), c // 3 % (m + 1))]
    )
    root = 1 / np.sqrt(mass[free])
    values, vectors = eigh(root[:, None] * k[np.ix_(free, free)] * root[None, :])
    shapes = np.zeros((count, len(free)))
    shapes[free] = root[:, None] * vectors
    return np.sqrt(np.maximum(values, 0)) / (2 * np.pi), shapes


def nearest(values, shapes, wanted, near):
    """The frequency in `near` whose mode is most similar to the wanted shape of w."""
    best = max(near, key=lambda i: abs(shapes[0::3, i] @ wanted) / np.linalg.norm(shapes[0::3, i]))
    return values[best]


def floor(t, side, nu):
    """Rotational inertia per mass of a corner: Section::inertia_floor."""
    return max(t * t / 12, side * side * 0.25 / (2.75 / (1 - nu) - 1))


def show(name, reference, f, engine):
    section, raised = (100 * (x / reference - 1) for x in f)
    print(
        f"{name:28} {reference:8.4g} Hz   section {section:+.2f} %"
        f"   floor {raised:+.2f} %   engine {engine:+.2f} %"
    )


def beam(name, held, references, engine):
    e, rho, side, t = 210e9, 7850.0, 0.01, 0.004
    out = []
    for inertia in (t * t / 12, floor(t, side, 0.0)):
        values, shapes = frequencies(20, 2, side, t, e, 0.0, rho, inertia, held)
        # Bending along the strip: w does not vary across it.
        across = lambda w: np.ptp(w.reshape(21, 3), axis=1).max() < 0.05 * np.abs(w).max()
        bent = [f for i, f in enumerate(values) if f > 1.0 and across(shapes[0::3, i])]
        out.append(bent[:3])
    for i, reference in enumerate(references):
        show(f"{name}, frequency {i + 1}", reference, [o[i] for o in out], engine[i])


def plate(name, n, size, t, e, nu, rho, held, wanted):
    side = size / n
    grid = np.linspace(0, 1, n + 1)
    for number, (reference, of, engine) in enumerate(wanted, 1):
        shape = np.array([of(x, y) for x in grid for y in grid])
        out = []
        for inertia in (t * t / 12, floor(t, side, nu)):
            values, shapes = frequencies(n, n, side, t, e, nu, rho, inertia, held)
            near = [i for i, f in enumerate(values) if 0.85 * reference < f < 1.15 * reference]
            out.append(nearest(values, shapes, shape, near))
        show(f"{name}, {number}", reference, out, engine)


clamp = lambda c, i, j: i == 0
ends = lambda c, i, j: i in (0, 20)
beam("cantilever", clamp, [83.55, 523.6, 1466.1], [-0.17, -0.76, -1.49])
hinges = lambda c, i, j: i in (0, 20) and c == 0
beam("simply supported", hinges, [234.40, 936.0, 2110.8], [-0.06, -0.22, -1.01])
beam("clamped-clamped", ends, [531.7, 1465.5, 2873.0], [0.09, -0.13, -0.58])
beam("free-free", lambda c, i, j: False, [531.7, 1465.5, 2873.0], [-1.55, -2.81, -4.25])

N = 16
rim = lambda c, i, j: (i in (0, N) and c in (0, 2)) or (j in (0, N) and c in (0, 1))
sine = lambda p, q: lambda x, y: np.sin(p * np.pi * x) * np.sin(q * np.pi * y)
plate("supported (11 12 22 13)", N, 0.2, 0.004, 210e9, 0.3, 7850.0, rim,
      [(491.0, sine(1, 1), -0.54), (1224.8, sine(1, 2), -0.84),
       (1955.5, sine(2, 2), -2.15), (2440.9, sine(1, 3), -0.89)])
square = lambda of: lambda x, y: of(2 * x - 1, 2 * y - 1)
plate("free FV12", N, 10.0, 0.05, 200e9, 0.3, 8000.0, lambda c, i, j: False,
      [(1.622, square(lambda x, y: x * y), -1.03),
       (2.360, square(lambda x, y: x * x - y * y), -2.03),
       (2.922, square(lambda x, y: x * x + y * y - 2 / 3), -1.56)])
