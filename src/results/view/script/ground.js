// The ground: a grid with a scale in cm, contact shading, and the ways on it.

/** Draws the grid: thin lines each cell, stronger ones each `major`, the axes
 * through the start stronger still, all fading into the sky with distance. */
const GRID = {
  vertex: `
    varying vec2 place;
    void main() {
      vec4 world = modelMatrix * vec4(position, 1.0);
      place = world.xz;
      gl_Position = projectionMatrix * viewMatrix * world;
    }`,
  fragment: `
    varying vec2 place;
    uniform vec3 ground, grid, axis, sky;
    uniform vec2 origin, focus;
    uniform float minor, major, reach;
    float lines(vec2 p, float cell, float width) {
      vec2 q = p / cell, d = max(fwidth(q), 1e-6);
      vec2 near = abs(fract(q - 0.5) - 0.5) / d;
      vec2 ink = clamp(width * 0.5 + 0.5 - near, 0.0, 1.0) * (1.0 - smoothstep(0.12, 0.45, d));
      return max(ink.x, ink.y);
    }
    void main() {
      vec2 p = place - origin;
      vec2 cross = clamp(1.35 - abs(p) / max(fwidth(p), 1e-9), 0.0, 1.0);
      vec3 colour = mix(ground, grid, 0.34 * lines(p, minor, 1.0));
      colour = mix(colour, grid, lines(p, major, 1.2));
      colour = mix(colour, axis, max(cross.x, cross.y));
      colour = mix(colour, sky, smoothstep(0.25, 1.0, distance(place, focus) / reach));
      gl_FragColor = vec4(colour, 1.0);
      #include <colorspace_fragment>
    }`,
};

class Ground {
  /** `size` is the radius of the robot, `span` the extent of the whole motion, in m; `count` the most elements at once. */
  constructor(scene, recording, size, span, count) {
    this.recording = recording;
    this.size = size;
    this.major = round(Math.max(span / 4, size / 2));
    this.start = recording.along(recording.coreWay, { low: 0, high: 0, part: 0 });
    // The ways are as wide as the core is small, however long the robot.
    this.grain = Math.min(radius(recording.elements[0].shape), 0.2 * size);
    this.reach = Math.max(14 * size, 2.5 * span);
    const digits = String(this.major * 1e4).replace(/0+$/, "");
    this.minor = this.major / (digits === "2" ? 4 : 5);
    this.plane = this.addPlane(scene);
    this.shadow = new THREE.Mesh(this.plane.geometry, new THREE.ShadowMaterial({ depthWrite: false, polygonOffset: true, polygonOffsetFactor: -2, polygonOffsetUnits: -2 }));
    this.shadow.receiveShadow = true;
    this.shadow.renderOrder = 3;
    scene.add(this.shadow);
    this.blobs = this.addBlobs(scene, count);
    this.ways = [
      // The wider below, so that both are seen where they lie on each other.
      this.addWay(scene, recording.coreWay, 0.1, 1.1),
      this.addWay(scene, recording.centreWay, 0.04, 1.2),
    ];
    this.labels = this.addLabels(scene, span);
  }

  addPlane(scene) {
    const colours = {};
    for (const name of ["ground", "grid", "axis", "sky"]) colours[name] = { value: new THREE.Color() };
    const material = new THREE.ShaderMaterial({
      vertexShader: GRID.vertex,
      fragmentShader: GRID.fragment,
      uniforms: {
        ...colours,
        origin: { value: new THREE.Vector2(this.start[0], this.start[2]) },
        focus: { value: new THREE.Vector2() },
        minor: { value: this.minor },
        major: { value: this.major },
        reach: { value: this.reach },
      },
    });
    const geometry = new THREE.PlaneGeometry(1, 1).rotateX(-Math.PI / 2);
    const plane = new THREE.Mesh(geometry, material);
    plane.frustumCulled = false;
    scene.add(plane);
    return plane;
  }

  /** Soft dark patches where elements touch or nearly touch: multiplied onto the ground. */
  addBlobs(scene, count) {
    const size = 64, canvas = document.createElement("canvas");
    canvas.width = canvas.height = size;
    const context = canvas.getContext("2d"), image = context.createImageData(size, size);
    for (let i = 0; i < size * size; i++) {
      const x = Math.abs(((i % size) + 0.5) / size * 2 - 1), y = Math.abs((Math.floor(i / size) + 0.5) / size * 2 - 1);
      // A rounded square that fades smoothly to nothing at its rim.
      const edge = Math.max(0, 1 - Math.pow(Math.pow(x, 3) + Math.pow(y, 3), 1 / 3));
      const ink = 255 * edge * edge * (3 - 2 * edge);
      image.data.set([ink, ink, ink, 255], 4 * i);
    }
    context.putImageData(image, 0, 0);
    const material = new THREE.MeshBasicMaterial({
      map: new THREE.CanvasTexture(canvas), transparent: true, depthWrite: false, toneMapped: false,
      blending: THREE.CustomBlending, blendSrc: THREE.ZeroFactor, blendDst: THREE.OneMinusSrcColorFactor,
      // The picture itself stays opaque, or the page would shine through.
      blendSrcAlpha: THREE.ZeroFactor, blendDstAlpha: THREE.OneFactor,
      polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1,
    });
    const geometry = new THREE.PlaneGeometry(2, 2).rotateX(-Math.PI / 2);
    const blobs = new THREE.InstancedMesh(geometry, material, count);
    blobs.instanceMatrix.setUsage(THREE.DynamicDrawUsage);
    blobs.frustumCulled = false;
    blobs.renderOrder = 2;
    scene.add(blobs);
    return blobs;
  }

  /** A ribbon on the ground along a way: all of it faint, what has passed strong. */
  addWay(scene, way, width, order) {
    const frames = way.length / 3, half = width * this.grain;
    const points = new Float32Array(6 * frames), index = [];
    let side = [0, half];
    for (let i = 0; i < frames; i++) {
      const before = Math.max(i - 1, 0), after = Math.min(i + 1, frames - 1);
      const dx = way[3 * after] - way[3 * before], dz = way[3 * after + 2] - way[3 * before + 2];
      const length = Math.hypot(dx, dz);
      // Where it stands still the direction is noise: the side stays.
      if (length > half * 0.05) side = [-dz / length * half, dx / length * half];
      points.set([way[3 * i] - side[0], 0, way[3 * i + 2] - side[1], way[3 * i] + side[0], 0, way[3 * i + 2] + side[1]], 6 * i);
      if (i > 0) index.push(2 * i - 2, 2 * i - 1, 2 * i, 2 * i - 1, 2 * i + 1, 2 * i);
    }
    const ribbon = (opacity) => {
      const geometry = new THREE.BufferGeometry();
      geometry.setAttribute("position", new THREE.BufferAttribute(points, 3));
      geometry.setIndex(index);
      const mesh = new THREE.Mesh(geometry, this.flat(opacity));
      mesh.frustumCulled = false;
      mesh.renderOrder = order;
      scene.add(mesh);
      return mesh;
    };
    const dot = new THREE.Mesh(new THREE.CircleGeometry(2.6 * half, 24).rotateX(-Math.PI / 2), this.flat(1));
    dot.renderOrder = order;
    scene.add(dot);
    return { way, all: ribbon(0.28), passed: ribbon(1), dot };
  }

  /** A plain colour on the ground. */
  flat(opacity) {
    return new THREE.MeshBasicMaterial({ transparent: true, opacity, depthWrite: false, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: -1, polygonOffsetUnits: -1 });
  }

  /** Numbers in cm along both axes, as far as the motion goes. */
  addLabels(scene, span) {
    const labels = [], count = Math.min(Math.ceil((1.15 * span + 2 * this.size) / this.major), 40);
    for (let step = -count; step <= count; step++) {
      labels.push(this.addLabel(scene, step, 1, 0));
      if (step !== 0) labels.push(this.addLabel(scene, step, 0, 1));
    }
    return labels;
  }

  addLabel(scene, step, x, z) {
    const sprite = new THREE.Sprite(new THREE.SpriteMaterial({ sizeAttenuation: false, depthWrite: false, transparent: true }));
    sprite.position.set(this.start[0] + x * step * this.major, 0, this.start[2] + z * step * this.major);
    sprite.center.set(0.5, 0);
    sprite.renderOrder = 4;
    scene.add(sprite);
    const number = Number((100 * step * this.major).toPrecision(6)).toString().replace("-", "\u2212");
    return { sprite, text: step === 0 ? "0" : number };
  }

  /** Takes the colours of the page. */
  paint(colours) {
    const uniforms = this.plane.material.uniforms;
    for (const name of ["ground", "grid", "axis", "sky"]) uniforms[name].value.set(colours[name]);
    this.shadow.material.opacity = Number(colours.shade);
    [colours.accent, colours.centre].forEach((colour, i) => {
      for (const mesh of [this.ways[i].all, this.ways[i].passed, this.ways[i].dot]) mesh.material.color.set(colour);
    });
    for (const label of this.labels) this.paintLabel(label, colours.quiet);
  }

  paintLabel({ sprite, text }, colour) {
    const canvas = document.createElement("canvas"), scale = 3, size = 11.5;
    const font = `500 ${size * scale}px system-ui, sans-serif`;
    let context = canvas.getContext("2d");
    context.font = font;
    canvas.width = Math.ceil(context.measureText(text).width) + 4 * scale;
    canvas.height = 15 * scale;
    context = canvas.getContext("2d");
    context.font = font;
    context.fillStyle = colour;
    context.textAlign = "center";
    context.fillText(text, canvas.width / 2, 11.5 * scale);
    if (sprite.material.map) sprite.material.map.dispose();
    sprite.material.map = new THREE.CanvasTexture(canvas);
    sprite.material.map.colorSpace = THREE.SRGBColorSpace;
    sprite.material.needsUpdate = true;
    sprite.userData.pixels = [canvas.width / scale, canvas.height / scale];
  }

  /** Keeps the labels at one size on a screen of this height and camera. */
  resize(height, camera) {
    this.unit = 2 * Math.tan((camera.fov * Math.PI) / 360) / height;
    for (const { sprite } of this.labels) {
      const [wide, high] = sprite.userData.pixels;
      sprite.scale.set(wide * this.unit, high * this.unit, 1);
    }
  }

  /** Moves what depends on where one looks. */
  look(focus, camera) {
    for (const mesh of [this.plane, this.shadow]) {
      mesh.position.set(focus.x, 0, focus.z);
      mesh.scale.setScalar(4 * this.reach);
    }
    this.plane.material.uniforms.focus.value.set(focus.x, focus.z);
    // Far labels would crowd: one in two, in four ... as they come nearer to each other.
    const near = Math.max(camera.position.distanceTo(focus), 1e-6), apart = this.major / (this.unit * near);
    const every = Math.pow(2, Math.max(0, Math.ceil(Math.log2(34 / Math.max(apart, 1e-3)))));
    for (const { sprite, text } of this.labels) {
      const step = Math.round(Math.max(Math.abs(sprite.position.x - this.start[0]), Math.abs(sprite.position.z - this.start[2])) / this.major);
      sprite.visible = text === "0" || step % every === 0;
      // Far behind what one looks at they would pile up at the horizon.
      const away = camera.position.distanceTo(sprite.position) / near;
      sprite.material.opacity = Math.min(1, Math.max(0, 2.9 - away));
    }
  }

  /** The ways up to a place, and the patches of so many elements. */
  show(place, count) {
    for (const { way, passed, dot } of this.ways) {
      passed.geometry.setDrawRange(0, 6 * (place.part > 0 ? place.high : place.low));
      const [x, , z] = this.recording.along(way, place);
      dot.position.set(x, 0, z);
    }
    this.showBlobs(count);
  }

  showWays(visible) {
    for (const { all, passed, dot } of this.ways) all.visible = passed.visible = dot.visible = visible;
  }

  showBlobs(count) {
    this.blobs.count = count;
    this.blobs.instanceMatrix.needsUpdate = true;
    if (this.blobs.instanceColor) this.blobs.instanceColor.needsUpdate = true;
  }

  /** No patch for an element. */
  hide(index, { matrix, colour }) {
    this.blobs.setMatrixAt(index, matrix.makeScale(0, 0, 0));
    this.blobs.setColorAt(index, colour.setRGB(0, 0, 0));
  }

  /** The patch below one element: its shape's part nearest to the ground, as
   * long and wide as that is flat, and the fainter the higher it is. */
  shade(index, shape, at, axes, tools) {
    const { matrix, colour } = tools;
    const [kind, lengths] = shape;
    const half = kind === "ball" ? [0, 0, 0] : halves(shape), isAxial = isRound(shape);
    const least = Math.min(...lengths);
    let x = at[0], z = at[2], gap = at[1];
    const spread = [0, 0, 0], flat = 0.06 * least;
    if (kind === "ball") gap -= lengths[0];
    const round = isAxial ? Math.hypot(axes[1][1], axes[2][1]) : 0;
    for (let k = 0; k < 3; k++) {
      const rise = axes[k][1];
      // A round side has one lowest line; its share of each radial axis follows from the rise.
      const reach = isAxial && k > 0 ? half[k] * Math.abs(rise) / (round || 1) : half[k];
      gap -= reach * Math.abs(rise);
      const lean = Math.max(-1, Math.min(1, (rise * half[k]) / flat));
      const shift = isAxial && k > 0 ? (reach * Math.sign(rise)) * Math.min(1, (round * half[k]) / flat) : half[k] * lean;
      x -= shift * axes[k][0];
      z -= shift * axes[k][2];
      spread[k] = isAxial && k > 0 ? half[k] * (1 - Math.min(1, (round * half[k]) / flat)) : half[k] * (1 - Math.abs(lean));
    }
    // The two most level axes carry the patch.
    const order = [0, 1, 2].sort((a, b) => Math.abs(axes[a][1]) - Math.abs(axes[b][1]) || a - b);
    const [first, second] = order;
    const length = Math.hypot(axes[first][0], axes[first][2]) || 1;
    const ux = axes[first][0] / length, uz = axes[first][2] / length;
    const margin = 0.45 * least + 0.6 * Math.max(gap, 0);
    const a = spread[first] + margin, b = spread[second] + margin;
    matrix.set(a * ux, 0, -b * uz, x, 0, 1, 0, 0, a * uz, 0, b * ux, z, 0, 0, 0, 1);
    this.blobs.setMatrixAt(index, matrix);
    const strength = 0.62 * Math.exp(-Math.max(gap, 0) / (0.22 * least));
    this.blobs.setColorAt(index, colour.setRGB(strength, strength, strength));
  }
}
