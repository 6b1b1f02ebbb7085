"""Simulates a saved design in MuJoCo, from what `sgc export` writes of it."""

import io

import mujoco
import numpy as np

from program import call

# Rows of a motion in a second; steps of 1/1000 s and 1/2000 s meet them exactly.
ROWS = 50


def table(text):
    """A table of numbers without its header and its times."""
    return np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)[:, 1:]


def load(design, step, solref=None, solimp=None):
    """The model at a time step, and the targets of its servos, a row for each step."""
    model = mujoco.MjModel.from_xml_string(call("export", design, "--to", "mjcf", "--step", repr(step)))
    for soft, given in (("solref", solref), ("solimp", solimp)):
        if given is not None:
            for what in ("geom", "pair"):
                getattr(model, f"{what}_{soft}")[:, : len(given)] = given
    return model, table(call("export", design, "--to", "drive", "--step", repr(step)))


def poses(model, data):
    """Place and rotation of every element in sgc's frame (y up), a row for each element."""
    rows = []
    for index in range(model.ngeom - 1):
        geom = model.geom(f"element{index}").id
        x, y, z = data.geom_xpos[geom]
        turn = data.geom_xmat[geom].reshape(3, 3)
        if model.geom_type[geom] == mujoco.mjtGeom.mjGEOM_CYLINDER:
            # sgc's cylinders lie along x, MuJoCo's along z.
            turn = turn @ [[0, 0, -1], [0, 1, 0], [1, 0, 0]]
        turn = np.array([turn[0], turn[2], -turn[1]])
        quaternion = np.empty(4)
        mujoco.mju_mat2Quat(quaternion, turn.reshape(9))
        rows.append([x, z, -y, *quaternion])
    return np.array(rows)


def simulate(model, drive):
    """The poses of all elements at times from zero: [row, element, 7]. None if it blows up."""
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    every = round(1 / ROWS / model.opt.timestep)
    rows = [poses(model, data)]
    for now, targets in enumerate(drive, 1):
        data.ctrl[:] = targets
        mujoco.mj_step(model, data)
        if data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
            return None
        if now % every == 0:
            # Places and rotations are those before the step until they are computed anew.
            mujoco.mj_kinematics(model, data)
            rows.append(poses(model, data))
    return np.array(rows)


def motion(rows):
    """A motion as the table that `sgc eval --motion` reads."""
    names = ["x", "y", "z", "qw", "qx", "qy", "qz"]
    head = ["time", *(f"element{e}.{n}" for e in range(rows.shape[1]) for n in names)]
    lines = [",".join(head)]
    for now, row in enumerate(rows):
        lines.append(",".join(map(repr, [now / ROWS, *map(float, row.reshape(-1))])))
    return "\n".join(lines) + "\n"
