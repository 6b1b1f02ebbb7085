"""MuJoCo's kinematics, inertia and collisions with Coulomb's law as it stands.

    python coulomb.py DESIGN|RUN|FOLDER... [--rate HZ]

MuJoCo's contacts are the solution of a convex problem, which lifts a contact that slides off the
ground: its normal acceleration has a term mu * b * (sliding speed), b = 2 / time constant. A
contact that slides therefore hops, the more so the stiffer it is (sliding.py), and what hops goes
elsewhere. To tell whether that is why a gait differs, this takes from MuJoCo all that it knows
of bodies and shapes, in double precision, but does the contacts by time stepping (Moreau; Stewart and
Trinkle): rigid, a round cone, implicit servos, iterated until solved. It shares no code with sgc.
"""

import argparse

import mujoco
import numba
import numpy as np

import in_mujoco
from program import designs, score, value

# Twice this gap in m, a pair of geoms is a contact.
NEAR = 0.0005
# At most so many sweeps over the contacts; with 300, the 40-hinge body went millimetres astray.
SWEEPS = 5000


@numba.njit(cache=True)
def solve(g, free, friction, impulse, sweeps, tolerance):
    """Impulses of contacts, three rows each: normal first. `free` has the allowances in it."""
    for sweep in range(sweeps):
        change = 0.0
        for c in range(len(friction)):
            k = 3 * c
            speed = free[k : k + 3].copy()
            for row in range(3):
                for column in range(len(impulse)):
                    speed[row] += g[k + row, column] * impulse[column]
            old = impulse[k : k + 3].copy()
            impulse[k] = max(0.0, old[0] - speed[0] / g[k, k])
            speed += g[k : k + 3, k] * (impulse[k] - old[0])
            aa, bb, ab = g[k + 1, k + 1], g[k + 2, k + 2], g[k + 1, k + 2]
            most = (aa + bb) / 2 + np.sqrt((aa - bb) ** 2 / 4 + ab * ab)
            radius = friction[c] * impulse[k]
            det = aa * bb - ab * ab
            a, b = old[1], old[2]
            if det > 1e-12 * most * most:
                a -= (bb * speed[1] - ab * speed[2]) / det
                b -= (aa * speed[2] - ab * speed[1]) / det
            if det <= 1e-12 * most * most or a * a + b * b > radius * radius:
                # What stops it is too much: down the gradient, projected onto the disc, until at rest.
                a, b = old[1], old[2]
                for _ in range(50):
                    da, db = a - old[1], b - old[2]
                    x = a - (speed[1] + aa * da + ab * db) / most
                    y = b - (speed[2] + ab * da + bb * db) / most
                    size = np.sqrt(x * x + y * y)
                    if size > radius:
                        x, y = x * radius / size, y * radius / size
                    still = abs(x - a) + abs(y - b) <= 1e-9 * (radius + 1e-30)
                    a, b = x, y
                    if still:
                        break
            impulse[k + 1], impulse[k + 2] = a, b
            change = max(change, np.abs(impulse[k : k + 3] - old).max())
        if change <= tolerance * np.abs(impulse).max():
            return sweep
    return sweeps


class Stepper:
    """A model and its state."""

    def __init__(self, model):
        self.model, self.data = model, mujoco.MjData(model)
        model.geom_margin[:] = NEAR
        self.kp, self.kv = model.actuator_gainprm[:, 0], -model.actuator_biasprm[:, 2]
        self.torque = np.where(model.actuator_forcelimited, model.actuator_forcerange[:, 1], np.inf)
        self.memory = {}

    def contacts(self):
        """Rows, gaps and frictions of what may touch, and a name for each."""
        model, data = self.model, self.data
        rows, gaps, friction, names, count = [], [], [], [], {}
        one, two = np.zeros((3, model.nv)), np.zeros((3, model.nv))
        for contact in data.contact:
            pair = tuple(contact.geom)
            for jacobian, geom in zip((one, two), pair):
                mujoco.mj_jac(model, data, jacobian, None, contact.pos, model.geom_bodyid[geom])
            rows.append(contact.frame.reshape(3, 3) @ (two - one))
            gaps.append(contact.dist)
            friction.append(contact.friction[0])
            count[pair] = count.get(pair, 0) + 1
            names.append((*pair, count[pair]))
        return rows, np.array(gaps), np.array(friction), names

    def step(self, targets):
        """Moves on by one step."""
        model, data, h = self.model, self.data, self.model.opt.timestep
        mujoco.mj_fwdPosition(model, data)
        mujoco.mj_fwdVelocity(model, data)
        mass = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, mass)
        angles = data.qpos[7:]
        rows, gaps, friction, names = self.contacts()
        mend = np.minimum(np.maximum(-gaps - 2e-5, 0) * 0.2 / h, 0.2)
        allowance = np.where(gaps >= 0, gaps / h, -mend)
        # Hard limits: rows of a contact without friction, one way each.
        low, high = model.jnt_range[1:].T
        for sign, room in ((1, angles - low), (-1, high - angles)):
            for hinge in np.flatnonzero(room < 0.05):
                row = np.zeros((3, model.nv))
                row[0, 6 + hinge] = sign
                rows.append(row)
                gap = room[hinge]
                allowance = np.append(allowance, gap / h if gap >= 0 else 0.2 * gap / h)
                friction = np.append(friction, 0.0)
                names.append(("limit", sign, hinge))
        jacobian = np.concatenate(rows) if rows else np.zeros((0, model.nv))
        impulse = np.concatenate([self.memory.get(n, np.zeros(3)) for n in names]) if names else np.zeros(0)
        strained = np.zeros(model.nu)
        for _ in range(5):
            matrix = mass.copy()
            push = mass @ data.qvel - h * data.qfrc_bias
            held = strained == 0
            dofs = 6 + np.flatnonzero(held)
            matrix[dofs, dofs] += (h * self.kv + h * h * self.kp)[held]
            push[6:] += np.where(held, h * self.kp * (targets - angles), h * strained * np.where(held, 0, self.torque))
            inverse = np.linalg.inv(matrix)
            free = inverse @ push
            if len(jacobian):
                g = jacobian @ inverse @ jacobian.T
                # Rows of limits have no tangents.
                g[np.diag_indices(len(g))] = np.maximum(g.diagonal(), 1e-12)
                base = jacobian @ free
                base[::3] += allowance
                solve(g, base, friction, impulse, SWEEPS, 1e-7)
                free = free + inverse @ (jacobian.T @ impulse)
            servo = self.kp * (targets - angles - h * free[6:]) - self.kv * free[6:]
            now = np.where(np.abs(servo) > self.torque * 1.0001, np.sign(servo), 0.0)
            if (now == strained).all():
                break
            strained = now
        self.memory = {n: impulse[3 * i : 3 * i + 3].copy() for i, n in enumerate(names)}
        data.qvel[:] = free
        mujoco.mj_integratePos(model, data.qpos, data.qvel, h)


def simulate(model, drive):
    """The poses of all elements at times from zero: [row, element, 7]."""
    stepper = Stepper(model)
    mujoco.mj_forward(model, stepper.data)
    every = round(1 / in_mujoco.ROWS / model.opt.timestep)
    rows = [in_mujoco.poses(model, stepper.data)]
    for now, targets in enumerate(drive, 1):
        stepper.step(targets)
        if now % every == 0:
            mujoco.mj_kinematics(model, stepper.data)
            rows.append(in_mujoco.poses(model, stepper.data))
    return np.array(rows)


def main():
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("paths", nargs="+", metavar="DESIGN|RUN|FOLDER")
    parser.add_argument("--rate", type=int, default=1000, help="steps in a second [1000]")
    options = parser.parse_args()
    for name, design in designs(options.paths):
        model, drive = in_mujoco.load(design, 1 / options.rate)
        third = score(design, in_mujoco.motion(simulate(model, drive)))
        own = value(design, "--step", repr(1 / 1920))
        model, drive = in_mujoco.load(design, 1 / options.rate)
        rows = in_mujoco.simulate(model, drive)
        other = float("nan") if rows is None else score(design, in_mujoco.motion(rows))
        print(f"{name:<14} Coulomb {third:8.2f}   sgc at 1/1920 s {own:8.2f}   MuJoCo {other:8.2f}", flush=True)


if __name__ == "__main__":
    main()
