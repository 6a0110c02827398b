"""A14: a ball of inertia 2/5 m R^2 hits a plane obliquely.

The ball has a normal and a tangential spring of the same stiffness, held within the friction cone,
as in a penalty law. (Compare Maw, Barber & Fawcett 1976, where the ratio of the stiffnesses is that
of elastic half spaces.) No damping. The contact ends when the normal spring is no longer
compressed.

    python3 tests/references/balls.py > tests/references/balls.txt
"""

from math import copysign, pi

MU, NORMAL, STEPS = 0.2, 1.0, 400_000


def bounced(tangential):
    """Final velocity along the plane and spin times radius, for m = k = R = 1."""
    dt = pi / STEPS
    z, w, u, spin, stretch = 0.0, -NORMAL, tangential, 0.0, 0.0
    while True:
        # Midpoint rule for the normal spring, which does not depend on the tangential motion.
        force = max(0.0, -(z + 0.5 * dt * w))
        w += dt * force
        z += dt * w
        if z > 0.0:
            return u, spin
        stretch += dt * (u - spin)
        limit = MU * force
        if abs(stretch) > limit:
            stretch = copysign(limit, stretch)
        u -= dt * stretch
        spin += 2.5 * dt * stretch


for tangential in [0.7, 3.0]:
    u, spin = bounced(tangential)
    print(f"v_t {tangential}: velocity after {u:.5f}, spin times radius {spin:.5f}")
