// Elements in three dimensions.

/** A cylinder along x with slightly rounded rims. */
function cylinder(radius, half) {
  const bevel = 0.16 * Math.min(radius, half), points = [new THREE.Vector2(0, -half)];
  for (const [side, from] of [[-1, 0], [1, 1]]) {
    for (let step = 0; step <= 4; step++) {
      const angle = (from ? 4 - step : step) / 4 * Math.PI / 2;
      points.push(new THREE.Vector2(radius - bevel + bevel * Math.sin(angle), side * (half - bevel + bevel * Math.cos(angle))));
    }
  }
  points.push(new THREE.Vector2(0, half));
  return new THREE.LatheGeometry(points, 40).rotateZ(-Math.PI / 2);
}

/** A capsule along x. */
function capsule(radius, half) {
  const points = [], steps = 12;
  for (const side of [-1, 1]) {
    for (let step = 0; step <= steps; step++) {
      const angle = (side < 0 ? step : steps - step) / steps * Math.PI / 2;
      points.push(new THREE.Vector2(radius * Math.sin(angle), side * (half + radius * Math.cos(angle))));
    }
  }
  return new THREE.LatheGeometry(points, 40).rotateZ(-Math.PI / 2);
}

/** The geometry of a shape; see `Look` in pieces.rs. */
function geometry([kind, lengths]) {
  if (kind === "ball") return new THREE.SphereGeometry(lengths[0], 40, 28);
  if (kind === "cylinder") return cylinder(...lengths);
  if (kind === "capsule") return capsule(...lengths);
  return new THREE.RoundedBoxGeometry(...lengths.map((half) => 2 * half), 3, 0.12 * Math.min(...lengths));
}

/** The radius of the ball around a shape. */
function radius([kind, lengths]) {
  if (kind === "capsule") return lengths[0] + lengths[1];
  return kind === "ball" ? lengths[0] : Math.hypot(...lengths);
}

/** Half the extent of a shape along its own axes. */
function halves([kind, lengths]) {
  if (kind === "capsule") return [lengths[0] + lengths[1], lengths[0], lengths[0]];
  return kind === "box" ? lengths : kind === "ball" ? Array(3).fill(lengths[0]) : [lengths[1], lengths[0], lengths[0]];
}

/** Whether a shape is round about its x axis alone. */
function isRound([kind]) {
  return kind === "cylinder" || kind === "capsule";
}

/** How far a shape reaches below its centre, where its axes rise by these. */
function depth(shape, rise) {
  const half = halves(shape);
  if (shape[0] === "ball") return half[0];
  if (shape[0] === "capsule") return shape[1][1] * Math.abs(rise[0]) + shape[1][0];
  if (isRound(shape)) return half[0] * Math.abs(rise[0]) + half[1] * Math.sqrt(Math.max(0, 1 - rise[0] * rise[0]));
  return half.reduce((sum, length, axis) => sum + length * Math.abs(rise[axis]), 0);
}

/** One instanced mesh for all elements of one shape: a few draw calls even for hundreds of balls. */
class Solids {
  /** `material` is theirs in common; without shadows they are marks, not bodies. */
  constructor(scene, elements, material, shadows) {
    const kinds = new Map();
    elements.forEach((element, index) => {
      const key = JSON.stringify(element.shape);
      if (!kinds.has(key)) kinds.set(key, []);
      kinds.get(key).push(index);
    });
    this.at = [];
    this.meshes = [...kinds.values()].map((indices) => {
      const mesh = new THREE.InstancedMesh(geometry(elements[indices[0]].shape), material, indices.length);
      mesh.castShadow = mesh.receiveShadow = shadows;
      mesh.frustumCulled = false;
      mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
      mesh.userData.indices = indices;
      indices.forEach((index, instance) => { this.at[index] = [mesh, instance]; });
      scene.add(mesh);
      return mesh;
    });
    this.tools = { matrix: new THREE.Matrix4(), at: new THREE.Vector3(), turn: new THREE.Quaternion(), grown: new THREE.Vector3() };
  }

  set visible(visible) {
    for (const mesh of this.meshes) mesh.visible = visible;
  }

  /** Puts an element at a pose, at a share of its size; gives its three axes. */
  place(index, pose, grown = [1, 1, 1]) {
    const { matrix, at, turn } = this.tools, [mesh, instance] = this.at[index];
    matrix.compose(at.fromArray(pose, 0), turn.fromArray(pose, 3), this.tools.grown.fromArray(grown));
    mesh.setMatrixAt(instance, matrix);
    const e = matrix.elements;
    return [[e[0], e[1], e[2]], [e[4], e[5], e[6]], [e[8], e[9], e[10]]];
  }

  /** Takes an element out of sight. */
  hide(index) {
    const [mesh, instance] = this.at[index];
    mesh.setMatrixAt(instance, this.tools.matrix.makeScale(0, 0, 0));
  }

  paint(index, colour) {
    const [mesh, instance] = this.at[index];
    mesh.setColorAt(instance, colour);
    mesh.instanceColor.needsUpdate = true;
  }

  /** To be called when all are placed. */
  placed() {
    for (const mesh of this.meshes) {
      mesh.instanceMatrix.needsUpdate = true;
      // A stale bound would make the pointer miss what has moved away.
      mesh.boundingSphere = null;
    }
  }

  /** The index of the element that a ray meets first, or -1. */
  pick(ray) {
    const [hit] = ray.intersectObjects(this.meshes, false);
    return hit ? hit.object.userData.indices[hit.instanceId] : -1;
  }
}
