// How the design was made: which elements there are after each step, and where.

/** The entry of a list of [step, value] that holds after a step. */
function holding(list, step) {
  let found = list[0];
  for (const entry of list) if (entry[0] <= step) found = entry;
  return found[1];
}

/** How far a shape reaches below its centre, turned by i, j, k, w. */
function below(shape, [, , , i, j, k, w]) {
  return depth(shape, [2 * (i * j + k * w), 1 - 2 * (i * i + k * k), 2 * (j * k - i * w)]);
}

class Making {
  /** `start` is where the core stood when the motion began. */
  constructor(pieces, steps, start) {
    this.pieces = pieces;
    this.last = steps - 1;
    let low = Infinity;
    for (const piece of pieces) for (const [, pose] of piece.poses) low = Math.min(low, pose[1] - below(piece.shape, pose));
    // One place for the core in all steps, such that nothing ever is below the ground.
    this.shift = [start[0], -low, start[2]];
    this.size = this.box(null)[1];
  }

  /** The middle and the radius of what is there after a step, or of all that ever was (null). */
  box(step) {
    const reach = [0, 1, 2].map(() => [Infinity, -Infinity]);
    for (const piece of this.pieces) {
      if (step !== null && !this.isThere(piece, step)) continue;
      const around = radius(piece.shape);
      for (const pose of step === null ? piece.poses.map(([, pose]) => pose) : [holding(piece.poses, step)]) {
        reach.forEach((ends, axis) => {
          [ends[0], ends[1]] = [Math.min(ends[0], pose[axis] - around), Math.max(ends[1], pose[axis] + around)];
        });
      }
    }
    const size = Math.hypot(...reach.map(([least, most]) => (most - least) / 2));
    return [reach.map(([least, most], axis) => (least + most) / 2 + this.shift[axis]), size || 0.1];
  }

  isThere(piece, step) {
    return piece.from <= step && !(piece.until <= step);
  }

  /** What a step did with an element: "added", "changed", "gone" or nothing. */
  change(piece, step) {
    if (step === 0) return "";
    if (piece.from === step) return "added";
    if (piece.until === step) return "gone";
    return this.isThere(piece, step) && piece.poses.some(([at]) => at === step) ? "changed" : "";
  }

  name(piece, step) {
    return holding(piece.names, step);
  }

  /** The pose of an element after a step: x, y, z, i, j, k, w. */
  pose(piece, step) {
    const pose = holding(piece.poses, step).slice();
    for (let axis = 0; axis < 3; axis++) pose[axis] += this.shift[axis];
    return pose;
  }

  /** The pose on the way from the step before: the turn about the one axis that leads there, so that
   * what hangs together stays together. */
  between(piece, step, part) {
    const to = this.pose(piece, step);
    if (part >= 1) return to;
    const from = this.pose(piece, step - 1);
    const [p, q] = [from, to].map((pose) => new THREE.Vector3(...pose.slice(0, 3)));
    const [r, s] = [from, to].map((pose) => new THREE.Quaternion(...pose.slice(3)));
    const turn = s.clone().multiply(r.clone().invert());
    if (turn.w < 0) turn.set(-turn.x, -turn.y, -turn.z, -turn.w);
    const axis = new THREE.Vector3(turn.x, turn.y, turn.z), sine = axis.length();
    if (sine < 1e-6) return [...p.lerp(q, part).toArray(), ...to.slice(3)];
    axis.divideScalar(sine);
    // A point of the axis, from where the turn takes `from`.
    const gap = q.clone().sub(p), along = gap.dot(axis);
    const across = gap.clone().addScaledVector(axis, -along);
    const centre = across.clone().addScaledVector(axis.clone().cross(across), turn.w / sine).multiplyScalar(0.5).add(p);
    const share = new THREE.Quaternion().setFromAxisAngle(axis, 2 * part * Math.atan2(sine, turn.w));
    p.sub(centre).applyQuaternion(share).add(centre).addScaledVector(axis, part * along);
    return [...p.toArray(), ...share.multiply(r).toArray()];
  }
}
