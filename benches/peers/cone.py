"""Rigid contacts with Coulomb's law: complementarity along the normal, maximum dissipation in the tangent plane.

Of n contacts the 3 n impulses r, normal first, obey, with the velocities u = G r + b,

    0 <= r_n, 0 <= u_n, r_n u_n = 0,    r_t = the point of the disc of radius mu r_n that is nearest to r_t - u_t

as they stand: no cone of velocities, so that nothing lifts off because it slides. Solved by semi-smooth Newton steps
(Alart and Curnier, 1991) from the last solution; where these do not get on, by sweeps of Gauss and Seidel over the
contacts. (After a change here delete __pycache__: numba does not see that coulomb.py compiles this in.)
"""

import numba
import numpy as np

# Give of contacts, as a share of the mean of G's diagonal: makes impulses of more contacts than needed unique.
GIVE = 1e-9
# Newton steps in a row, and rounds of Newton steps and sweeps.
NEWTON = 12
ROUNDS = 60


@numba.njit(cache=True)
def solve_linear(matrix, vector):
    """Overwrites `vector` with the solution (Gauss, partial pivots) and spoils `matrix`. False if it is singular."""
    n = len(vector)
    for k in range(n):
        pivot = k
        for i in range(k + 1, n):
            if abs(matrix[i, k]) > abs(matrix[pivot, k]):
                pivot = i
        if not abs(matrix[pivot, k]) > 0:
            return False
        if pivot != k:
            for j in range(k, n):
                matrix[k, j], matrix[pivot, j] = matrix[pivot, j], matrix[k, j]
            vector[k], vector[pivot] = vector[pivot], vector[k]
        for i in range(k + 1, n):
            if matrix[i, k] != 0:
                factor = matrix[i, k] / matrix[k, k]
                for j in range(k + 1, n):
                    matrix[i, j] -= factor * matrix[k, j]
                vector[i] -= factor * vector[k]
    for k in range(n - 1, -1, -1):
        for j in range(k + 1, n):
            vector[k] -= matrix[k, j] * vector[j]
        vector[k] /= matrix[k, k]
    return True


@numba.njit(cache=True)
def velocities(g, b, r):
    """u = G r + b."""
    u = b.copy()
    for i in range(len(r)):
        if r[i] != 0:
            for j in range(len(r)):
                u[j] += g[i, j] * r[i]
    return u


@numba.njit(cache=True)
def scales(g, k):
    """Step lengths of the natural map of the contact whose rows begin at k: along the normal, in the tangent plane."""
    return 1 / g[k, k], 1 / max(g[k + 1, k + 1] + g[k + 2, k + 2], 1e-3 * g[k, k])


@numba.njit(cache=True)
def residual(g, mu, r, u):
    """How far the impulses are from what the law makes of them (the natural map), the greatest component."""
    worst = 0.0
    for c in range(len(mu)):
        k = 3 * c
        along, across = scales(g, k)
        worst = max(worst, abs(r[k] - max(0.0, r[k] - along * u[k])))
        radius = mu[c] * max(0.0, r[k])
        a, b = r[k + 1] - across * u[k + 1], r[k + 2] - across * u[k + 2]
        size = np.hypot(a, b)
        shrink = radius / size if size > radius else 1.0
        worst = max(worst, abs(r[k + 1] - shrink * a), abs(r[k + 2] - shrink * b))
    return worst


@numba.njit(cache=True)
def newton(g, mu, r, u):
    """The impulses after one semi-smooth Newton step on the natural map, and whether there is such a step."""
    # Rows whose impulse is not nought as it stands.
    rows = np.empty(len(r), np.int64)
    count = 0
    for c in range(len(mu)):
        k = 3 * c
        if r[k] - u[k] / g[k, k] > 0:
            for row in range(3 if mu[c] > 0 else 1):
                rows[count] = k + row
                count += 1
    matrix = np.empty((count, count))
    vector = np.empty(count)
    for p in range(count):
        for q in range(count):
            matrix[p, q] = g[rows[p], rows[q]]
        # Impulses of open contacts go with this step.
        vector[p] = u[rows[p]]
    lost = np.zeros(len(r))
    closed = np.zeros(len(r), np.bool_)
    for p in range(count):
        closed[rows[p]] = True
    for i in range(len(r)):
        if not closed[i] and r[i] != 0:
            lost[i] = r[i]
            for p in range(count):
                vector[p] -= g[rows[p], i] * r[i]
    p = 0
    while p < count:
        k = rows[p]
        c = k // 3
        if mu[c] == 0:
            p += 1
            continue
        _, across = scales(g, k)
        radius = mu[c] * max(r[k], 0.0)
        a, b = r[k + 1] - across * u[k + 1], r[k + 2] - across * u[k + 2]
        size = np.hypot(a, b)
        if size > radius:
            a, b = a / size, b / size
            share = min(radius / size, 1.0)
            # r_t - mu r_n d = 0, where d turns with r_t - u_t * across.
            for q in range(count):
                x, y = -across * matrix[p + 1, q], -across * matrix[p + 2, q]
                if q == p + 1:
                    x += 1
                if q == p + 2:
                    y += 1
                turn = -b * x + a * y
                x, y = share * b * turn, -share * a * turn
                if q == p:
                    x, y = x - mu[c] * a, y - mu[c] * b
                if q == p + 1:
                    x += 1
                if q == p + 2:
                    y += 1
                matrix[p + 1, q], matrix[p + 2, q] = x, y
            # The right side at the present impulses; what open contacts lose is in u only.
            x, y = vector[p + 1] - u[k + 1], vector[p + 2] - u[k + 2]
            turn = share * (-across) * (-b * x + a * y)
            vector[p + 1] = r[k + 1] - radius * a + b * turn
            vector[p + 2] = r[k + 2] - radius * b - a * turn
        p += 3
    if not solve_linear(matrix, vector):
        return r, False
    new = r - lost
    for p in range(count):
        new[rows[p]] -= vector[p]
    return new, np.isfinite(new).all()


@numba.njit(cache=True)
def sweep(g, mu, r, u):
    """One sweep over the contacts; r and u are kept up to date."""
    for c in range(len(mu)):
        k = 3 * c
        old0, old1, old2 = r[k], r[k + 1], r[k + 2]
        r[k] = max(0.0, old0 - u[k] / g[k, k])
        if mu[c] > 0:
            # The velocity in the tangent plane after the normal impulse, and the disc's point that agrees with it.
            dn = r[k] - old0
            s, t = u[k + 1] + g[k + 1, k] * dn, u[k + 2] + g[k + 2, k] * dn
            aa, bb, ab = g[k + 1, k + 1], g[k + 2, k + 2], g[k + 1, k + 2]
            radius = mu[c] * r[k]
            det = aa * bb - ab * ab
            most = (aa + bb) / 2 + np.sqrt((aa - bb) ** 2 / 4 + ab * ab)
            a, b = old1, old2
            inside = False
            if det > 1e-12 * most * most:
                a, b = old1 - (bb * s - ab * t) / det, old2 - (aa * t - ab * s) / det
                inside = a * a + b * b <= radius * radius
            if not inside:
                a, b = old1, old2
                for _ in range(30):
                    da, db = a - old1, b - old2
                    x, y = a - (s + aa * da + ab * db) / most, b - (t + ab * da + bb * db) / most
                    size = np.hypot(x, y)
                    if size > radius:
                        x, y = x * radius / size, y * radius / size
                    still = abs(x - a) + abs(y - b) <= 1e-10 * radius
                    a, b = x, y
                    if still:
                        break
            r[k + 1], r[k + 2] = a, b
        for row, old in ((k, old0), (k + 1, old1), (k + 2, old2)):
            if r[row] != old:
                change = r[row] - old
                for j in range(len(u)):
                    u[j] += g[row, j] * change


@numba.njit(cache=True)
def solve(g, b, mu, r, floor, tolerance):
    """Solves for the impulses r in place, from those given.

    Returns what the residual is of the greatest impulse (or of `floor`, in N s, if that is more), and the sweeps made.
    """
    best, least, swept, sweeps = r.copy(), np.inf, r.copy(), 0
    for attempt in range(ROUNDS):
        r[:] = swept
        u = velocities(g, b, r)
        for _ in range(NEWTON):
            off = residual(g, mu, r, u) / max(floor, np.abs(r).max())
            if off < least:
                best[:], least = r, off
            if off <= tolerance:
                break
            r[:], done = newton(g, mu, r, u)
            if not done:
                break
            u = velocities(g, b, r)
        if least <= tolerance or attempt == ROUNDS - 1:
            break
        # Newton's steps may end anywhere; sweeps go on from where sweeps were.
        u = velocities(g, b, swept)
        for _ in range(4 + 4 * attempt):
            sweep(g, mu, swept, u)
            sweeps += 1
    r[:] = best
    return least, sweeps
