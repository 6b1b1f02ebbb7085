// The robot in three dimensions.

class Stage {
  constructor(renderer, recording, making) {
    this.canvas = renderer.domElement;
    this.recording = recording;
    this.making = making;
    this.renderer = renderer;
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = THREE.PCFShadowMap;
    this.scene = new THREE.Scene();
    this.tools = { matrix: new THREE.Matrix4(), colour: new THREE.Color() };
    this.measure();
    this.ground = new Ground(this.scene, recording, this.size, this.span, Math.max(recording.elements.length, making?.pieces.length ?? 0));
    this.addLights();
    this.addElements();
    this.camera = new THREE.PerspectiveCamera(32, 1, 0.02 * this.size, 60 * this.ground.reach);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    Object.assign(this.controls, { enableDamping: true, dampingFactor: 0.12, maxPolarAngle: 0.495 * Math.PI, minDistance: 0.8 * this.size, maxDistance: 6 * this.ground.reach, zoomToCursor: false });
    this.followWay = recording.smoothed(recording.centreWay, 0.8);
    this.follow = true;
    this.lit = null;
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
    const reach = 1.5 * Math.max(this.size, this.making?.size ?? 0), shadow = this.lamp.shadow.camera;
    Object.assign(shadow, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.1 * this.size, far: 3 * this.size + 3 * reach });
    this.lamp.shadow.normalBias = 0.004 * this.size;
    this.lamp.shadow.bias = -0.0006;
    this.lamp.shadow.radius = 7;
    // From above and a little from the viewer's side, so that the faces one sees are lit.
    const [dx, dz] = this.side();
    this.lampFrom = new THREE.Vector3(-0.42 * dz - 0.3 * dx, 1, 0.42 * dx - 0.3 * dz);
    this.scene.add(this.sky, this.lamp, this.lamp.target);
  }

  addElements() {
    const solid = () => new THREE.MeshStandardMaterial({ roughness: 0.62, metalness: 0 });
    this.robot = new Solids(this.scene, this.recording.elements, solid(), true);
    this.light(null);
    if (this.recording.elsewhere) {
      // The same robot in another world, to be seen through.
      const faint = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.26, depthWrite: false });
      this.other = new Solids(this.scene, this.recording.elements, faint, false);
      this.recording.elements.forEach((element, index) => this.other.paint(index, this.tools.colour.set("#6b7078")));
    }
    if (!this.making) return;
    // The design as it grew; the rims of what a step did, from the back of slightly larger
    // elements (1 is three.js's BackSide); and what was there before it.
    const ghost = new THREE.MeshBasicMaterial({ transparent: true, opacity: 0.34, depthWrite: false });
    this.grown = new Solids(this.scene, this.making.pieces, solid(), true);
    this.rims = new Solids(this.scene, this.making.pieces, new THREE.MeshBasicMaterial({ side: 1, toneMapped: false }), false);
    this.ghosts = new Solids(this.scene, this.making.pieces, ghost, false);
    for (const solids of [this.grown, this.rims, this.ghosts]) solids.visible = false;
    // Colours must be there from the first picture on.
    this.making.pieces.forEach((_, index) => [this.grown, this.rims, this.ghosts].forEach((solids) => solids.paint(index, this.tools.colour)));
  }

  /** Picks out the elements of one actuator, or none (null). */
  light(actuator) {
    this.lit = actuator;
    const { colour } = this.tools, grey = new THREE.Color("#80858c");
    this.recording.elements.forEach((element, index) => {
      colour.set(element.colour);
      if (actuator !== null && element.actuator !== actuator) colour.lerp(grey, 0.78);
      this.robot.paint(index, colour);
    });
  }

  /** Takes the colours of the page. */
  paint() {
    const style = getComputedStyle(document.documentElement), colours = {};
    for (const name of ["sky", "ground", "grid", "axis", "shade", "accent", "centre", "quiet", "lamp", "glow", "added", "changed"]) colours[name] = style.getPropertyValue("--" + name).trim();
    this.scene.background = new THREE.Color(colours.sky);
    this.lamp.intensity = Number(colours.lamp);
    this.sky.intensity = Number(colours.glow);
    this.ground.paint(colours);
    this.palette = colours;
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

  /** Draws the moment t of the motion. */
  show(t) {
    const { recording } = this, place = recording.place(t);
    recording.elements.forEach((element, index) => {
      const pose = recording.poseOf(element, place);
      this.ground.shade(index, element.shape, pose, this.robot.place(index, pose), this.tools);
    });
    this.robot.placed();
    if (this.other) {
      recording.elements.forEach((element, index) => this.other.place(index, recording.poseOf(element, place, recording.elsewhere)));
      this.other.placed();
    }
    this.ground.show(place, recording.elements.length);
    const focus = this.focus(t);
    if (this.follow) {
      const shift = focus.clone().sub(this.last);
      this.controls.target.add(shift);
      this.camera.position.add(shift);
    }
    this.last = focus;
    const [x, , z] = recording.along(recording.centreWay, place);
    this.draw(x, z);
  }

  /** Turns to the design as it grew, or back to the motion. */
  turnTo(making) {
    this.isMaking = making;
    for (const solids of [this.grown, this.rims, this.ghosts]) solids.visible = making;
    this.robot.visible = !making;
    this.showOther(this.isOtherShown);
    this.ground.showWays(!making);
    if (making) {
      this.before = [this.camera.position.clone(), this.controls.target.clone()];
      this.sight = null;
    } else {
      this.camera.position.copy(this.before[0]);
      this.controls.target.copy(this.before[1]);
    }
  }

  /** Whether the motion in another world is there, and whether it is wanted. */
  get isOtherShown() {
    return Boolean(this.other) && this.wantsOther !== false;
  }

  showOther(shown) {
    if (!this.other) return;
    this.wantsOther = shown;
    this.other.visible = shown && !this.isMaking;
  }

  /** Keeps the design in sight as it grows, from the direction and as near as one has chosen. */
  attend(step, part) {
    if (this.sight?.step !== step) {
      const [middle, size] = this.making.box(step);
      // The first parts need not fill the picture.
      const to = { middle: new THREE.Vector3(...middle), size: Math.max(size, 0.4 * this.making.size) };
      const now = this.sight?.now;
      this.sight = { step, from: now ?? to, to, now };
    }
    const { from, to, now } = this.sight, share = part * part * (3 - 2 * part);
    const next = { middle: from.middle.clone().lerp(to.middle, share), size: from.size + (to.size - from.size) * share };
    this.sight.now = next;
    if (!now) return this.beside();
    const away = this.camera.position.clone().sub(this.controls.target).multiplyScalar(next.size / now.size);
    this.controls.target.add(next.middle).sub(now.middle);
    this.camera.position.copy(this.controls.target).add(away);
  }

  /** Puts the camera beside the design as it grows. */
  beside() {
    const [dx, dz] = this.side(), { middle, size } = this.sight.now;
    this.aim(middle, new THREE.Vector3(-dz - 0.45 * dx, 0.62, dx - 0.45 * dz), this.distance(size) * 0.95);
  }

  /** Draws the design after a step, or on the way there from the step before; gives what the step did with
   * the elements, and "before" where ghosts show what was. */
  showStep(step, part) {
    this.attend(step, part);
    const { making, grown, rims, ghosts, palette, tools: { colour } } = this, grey = new THREE.Color("#8b9097");
    const changes = making.pieces.map((piece) => making.change(piece, step));
    let haunted = false;
    // What comes or goes does so one element after the other, each part by itself.
    const many = new Map(), seen = new Map(), add = (map, name) => map.set(name, (map.get(name) ?? 0) + 1).get(name);
    making.pieces.forEach((piece, index) => ["added", "gone"].includes(changes[index]) && add(many, making.name(piece, step)));
    making.pieces.forEach((piece, index) => {
      const change = changes[index];
      rims.hide(index);
      ghosts.hide(index);
      if (!making.isThere(piece, step) && change !== "gone") {
        grown.hide(index);
        return this.ground.hide(index, this.tools);
      }
      const pose = change === "changed" ? making.between(piece, step, part) : making.pose(piece, step);
      const name = making.name(piece, step), comes = change === "added" || change === "gone";
      const turn = comes ? (0.6 * (add(seen, name) - 1)) / many.get(name) : 0;
      const share = Math.min(Math.max((part - turn) / 0.4, 0), 1), smooth = share * share * (3 - 2 * share);
      const size = Math.max(change === "added" ? smooth : change === "gone" ? 1 - smooth : 1, 1e-4);
      const axes = grown.place(index, pose, [size, size, size]);
      if (size > 0.99) this.ground.shade(index, piece.shape, pose, axes, this.tools);
      else this.ground.hide(index, this.tools);
      colour.set(piece.colour);
      if (step > 0 && !change) colour.lerp(grey, 0.62);
      grown.paint(index, colour);
      if (change === "added" || change === "changed") {
        const rim = 0.02 * this.making.size;
        rims.place(index, pose, halves(piece.shape).map((half) => size * (half + Math.min(rim, 0.1 * half)) / half));
        rims.paint(index, colour.set(palette[change]));
      }
      if (change === "gone" || change === "changed") {
        const old = making.pose(piece, step - 1);
        if (change === "gone" || old.some((x, i) => Math.abs(x - pose[i]) > 1e-5)) {
          ghosts.place(index, old, [0.98, 0.98, 0.98]);
          haunted = true;
          ghosts.paint(index, colour.set(palette.quiet));
        }
      }
    });
    for (const solids of [grown, rims, ghosts]) solids.placed();
    this.ground.showBlobs(making.pieces.length);
    this.draw(making.shift[0], making.shift[2]);
    return haunted ? [...changes, "before"] : changes;
  }

  /** Draws what has been placed; the lamp stands over a place of the ground. */
  draw(x, z) {
    this.lamp.target.position.set(x, 0.3 * this.size, z);
    this.lamp.position.copy(this.lamp.target.position).addScaledVector(this.lampFrom, 3 * Math.max(this.size, this.making?.size ?? 0));
    this.controls.update();
    this.ground.look(this.controls.target, this.camera);
    this.renderer.render(this.scene, this.camera);
  }

  /** The index of the element below a point of the canvas, or -1: of the motion's or of the design's as it grew. */
  pick(x, y) {
    const { clientWidth: wide, clientHeight: high } = this.canvas;
    const ray = new THREE.Raycaster();
    ray.setFromCamera(new THREE.Vector2((x / wide) * 2 - 1, 1 - (y / high) * 2), this.camera);
    return (this.isMaking ? this.grown : this.robot).pick(ray);
  }
}
