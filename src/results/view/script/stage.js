// The robot in three dimensions.

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

/** The geometry of a shape; see `Part` in encode.rs. */
function geometry([kind, lengths]) {
  if (kind === "ball") return new THREE.SphereGeometry(lengths[0], 40, 28);
  if (kind === "cylinder") return cylinder(...lengths);
  return new THREE.RoundedBoxGeometry(...lengths.map((half) => 2 * half), 3, 0.12 * Math.min(...lengths));
}

/** The radius of the ball around a shape. */
function radius([kind, lengths]) {
  return kind === "ball" ? lengths[0] : Math.hypot(...lengths);
}

class Stage {
  /** Throws when there is no WebGL. */
  constructor(canvas, recording) {
    this.canvas = canvas;
    this.recording = recording;
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.measure();
    this.ground = new Ground(this.scene, recording, this.size, this.span);
    this.addLights();
    this.addElements();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.02 * this.size, 60 * this.ground.reach);
    this.controls = new THREE.OrbitControls(this.camera, canvas);
    Object.assign(this.controls, { enableDamping: true, dampingFactor: 0.12, maxPolarAngle: 0.495 * Math.PI, minDistance: 0.8 * this.size, maxDistance: 6 * this.ground.reach, zoomToCursor: false });
    this.followWay = recording.smoothed(recording.centreWay, 0.8);
    this.follow = true;
    this.lit = null;
    this.tools = { matrix: new THREE.Matrix4(), colour: new THREE.Color() };
    this.resize();
    this.paint();
    this.near(0);
  }

  /** The robot's radius about its middle, and the box of everywhere that it goes. */
  measure() {
    const { recording } = this, outline = [], low = [Infinity, Infinity], high = [-Infinity, -Infinity];
    let size = 0;
    const stride = Math.max(1, Math.floor(recording.frames / 120));
    for (let frame = 0; frame < recording.frames; frame += stride) {
      const place = { low: frame, high: frame, part: 0 }, middle = recording.along(recording.centreWay, place);
      for (const element of recording.elements) {
        const pose = recording.poseOf(element, place), around = radius(element.shape);
        size = Math.max(size, Math.hypot(pose[0] - middle[0], pose[1] - middle[1], pose[2] - middle[2]) + around);
        for (const [dx, dz] of [[around, 0], [-around, 0], [0, around], [0, -around]]) outline.push([pose[0] + dx, pose[2] + dz]);
        [0, 2].forEach((axis, i) => {
          low[i] = Math.min(low[i], pose[axis] - around);
          high[i] = Math.max(high[i], pose[axis] + around);
        });
      }
    }
    this.size = size || 0.1;
    this.outline = outline;
    this.middle = [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2];
    this.extent = [high[0] - low[0], high[1] - low[1]];
    this.span = Math.max(...this.extent);
  }

  addLights() {
    this.sky = new THREE.HemisphereLight(0xffffff, 0x9a958c, 1);
    this.lamp = new THREE.DirectionalLight(0xffffff, 1);
    this.lamp.castShadow = true;
    this.lamp.shadow.mapSize.set(2048, 2048);
    const reach = 1.5 * this.size, shadow = this.lamp.shadow.camera;
    Object.assign(shadow, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1 * this.size, far: 8 * this.size });
    this.lamp.shadow.normalBias = 0.004 * this.size;
    this.lamp.shadow.bias = -0.0006;
    this.lamp.shadow.radius = 7;
    // From above and a little from the viewer's side, so that the faces one sees are lit.
    const [dx, dz] = this.side();
    this.lampFrom = new THREE.Vector3(-0.42 * dz - 0.3 * dx, 1, 0.42 * dx - 0.3 * dz);
    this.scene.add(this.sky, this.lamp, this.lamp.target);
  }

  /** One instanced mesh for all elements of one shape: a few draw calls even for hundreds of balls. */
  addElements() {
    const kinds = new Map();
    this.recording.elements.forEach((element, index) => {
      const key = JSON.stringify(element.shape);
      if (!kinds.has(key)) kinds.set(key, []);
      kinds.get(key).push(index);
    });
    this.meshes = [...kinds.values()].map((indices) => {
      const material = new THREE.MeshStandardMaterial({ roughness: 0.62, metalness: 0 });
      const mesh = new THREE.InstancedMesh(geometry(this.recording.elements[indices[0]].shape), material, indices.length);
      mesh.castShadow = mesh.receiveShadow = true;
      mesh.frustumCulled = false;
      mesh.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
      mesh.userData.indices = indices;
      this.scene.add(mesh);
      return mesh;
    });
    this.light(null);
  }

  /** Picks out the elements of one actuator, or none (null). */
  light(actuator) {
    this.lit = actuator;
    const colour = new THREE.Color(), grey = new THREE.Color("#80858c");
    for (const mesh of this.meshes) {
      mesh.userData.indices.forEach((index, instance) => {
        const element = this.recording.elements[index];
        colour.set(element.colour);
        if (actuator !== null && element.actuator !== actuator) colour.lerp(grey, 0.78);
        mesh.setColorAt(instance, colour);
      });
      mesh.instanceColor.needsUpdate = true;
    }
  }

  /** Takes the colours of the page. */
  paint() {
    const style = getComputedStyle(document.documentElement), colours = {};
    for (const name of ["sky", "ground", "grid", "axis", "shade", "accent", "centre", "quiet", "lamp", "glow"]) colours[name] = style.getPropertyValue("--" + name).trim();
    this.scene.background = new THREE.Color(colours.sky);
    this.lamp.intensity = Number(colours.lamp);
    this.sky.intensity = Number(colours.glow);
    this.ground.paint(colours);
    this.resize();
  }

  /** Fits the picture to the canvas's place in the page. */
  resize() {
    const { clientWidth: wide, clientHeight: high } = this.canvas;
    if (!wide || !high) return;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.setSize(wide, high, false);
    this.camera.aspect = wide / high;
    this.camera.updateProjectionMatrix();
    if (this.ground.labels[0].sprite.userData.pixels) this.ground.resize(high, this.camera);
  }

  /** How far the camera must be for a ball of this radius to fill the picture. */
  distance(radius) {
    const half = (this.camera.fov * Math.PI) / 360;
    return radius / Math.sin(Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect)));
  }

  /** How far the camera must be in a direction to see everywhere that the robot goes. */
  fit(focus, toward) {
    const right = new THREE.Vector3(0, 1, 0).cross(toward).normalize(), up = toward.clone().cross(right);
    const high = Math.tan((this.camera.fov * Math.PI) / 360), wide = high * this.camera.aspect;
    let distance = 0;
    for (const [x, z] of this.outline) {
      for (const y of [0, 0.8 * this.size]) {
        const point = new THREE.Vector3(x, y, z).sub(focus);
        const need = Math.max(Math.abs(point.dot(right)) / wide, Math.abs(point.dot(up)) / high);
        distance = Math.max(distance, need + point.dot(toward));
      }
    }
    return distance;
  }

  /** The direction from which the robot is seen going to the right. */
  side() {
    const way = this.recording.coreWay, last = way.length - 3;
    let dx = way[last] - way[0], dz = way[last + 2] - way[2];
    if (Math.hypot(dx, dz) < 0.3 * this.size) [dx, dz] = [1, 0];
    const length = Math.hypot(dx, dz);
    return [dx / length, dz / length];
  }

  /** Puts the camera beside the robot and lets it follow. */
  near(t) {
    const [dx, dz] = this.side(), distance = this.distance(this.size) * 0.98;
    const focus = this.focus(t);
    // A little from behind, so that one sees where it goes.
    this.aim(focus, new THREE.Vector3(-dz - 0.45 * dx, 0.52, dx - 0.45 * dz), distance);
    this.last = focus.clone();
    this.follow = true;
  }

  /** Shows the whole way from above and stands still. */
  whole() {
    const [dx, dz] = this.side();
    const focus = new THREE.Vector3(this.middle[0], 0.2 * this.size, this.middle[1]);
    const toward = new THREE.Vector3(-dz, 1.1, dx).normalize();
    this.aim(focus, toward, this.fit(focus, toward) * 1.06);
    this.follow = false;
  }

  /** Looks at a point from a direction and a distance. */
  aim(focus, from, distance) {
    this.controls.target.copy(focus);
    this.camera.position.copy(focus).addScaledVector(from.normalize(), distance);
    this.controls.update();
  }

  /** The point that the camera follows. */
  focus(t) {
    const [x, y, z] = this.recording.along(this.followWay, this.recording.place(t));
    return new THREE.Vector3(x, 0.9 * y, z);
  }

  setFollow(follow, t) {
    this.follow = follow;
    if (!follow) return;
    // Keeps direction and distance, whatever one looked at.
    const focus = this.focus(t);
    this.camera.position.add(focus).sub(this.controls.target);
    this.controls.target.copy(focus);
    this.last = focus;
  }

  /** Draws the moment t. */
  show(t) {
    const { recording, tools } = this, place = recording.place(t);
    const at = new THREE.Vector3(), turn = new THREE.Quaternion(), one = new THREE.Vector3(1, 1, 1);
    for (const mesh of this.meshes) {
      mesh.userData.indices.forEach((index, instance) => {
        const element = recording.elements[index], pose = recording.poseOf(element, place);
        tools.matrix.compose(at.fromArray(pose, 0), turn.fromArray(pose, 3), one);
        mesh.setMatrixAt(instance, tools.matrix);
        const e = tools.matrix.elements;
        this.ground.shade(index, element.shape, pose, [[e[0], e[1], e[2]], [e[4], e[5], e[6]], [e[8], e[9], e[10]]], tools);
      });
      mesh.instanceMatrix.needsUpdate = true;
      // A stale bound would make the pointer miss what has moved away.
      mesh.boundingSphere = null;
    }
    this.ground.show(place);
    const focus = this.focus(t);
    if (this.follow) {
      const shift = focus.clone().sub(this.last);
      this.controls.target.add(shift);
      this.camera.position.add(shift);
    }
    this.last = focus;
    const [x, , z] = recording.along(recording.centreWay, place);
    this.lamp.target.position.set(x, 0.3 * this.size, z);
    this.lamp.position.copy(this.lamp.target.position).addScaledVector(this.lampFrom, 3 * this.size);
    this.controls.update();
    this.ground.look(this.controls.target, this.camera);
    this.renderer.render(this.scene, this.camera);
  }

  /** The index of the element below a point of the canvas, or -1. */
  pick(x, y) {
    const { clientWidth: wide, clientHeight: high } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((x / wide) * 2 - 1, 1 - (y / high) * 2), this.camera);
    const [hit] = ray.intersectObjects(this.meshes, false);
    return hit ? hit.object.userData.indices[hit.instanceId] : -1;
  }

  /** How many different colours the picture has: a test's way to see that there is one. */
  colours() {
    const context = this.renderer.getContext();
    const { drawingBufferWidth: wide, drawingBufferHeight: high } = context;
    const pixels = new Uint8Array(4 * wide * high);
    // Read in the same task as it is drawn, for then the picture is still there.
    this.renderer.render(this.scene, this.camera);
    context.readPixels(0, 0, wide, high, context.RGBA, context.UNSIGNED_BYTE, pixels);
    return new Set(new Uint32Array(pixels.buffer)).size;
  }
}
