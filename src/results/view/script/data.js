// What the page knows: the packed numbers of a scene and what follows from them.
// Lengths are metres, angles radians, times seconds; y is up.

/** The bytes of a base64 text after zlib unpacking. */
async function inflate(text) {
  const packed = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

/** The channels of every group: [group][channel] is a Float32Array. See encode.rs. */
async function unpack(groups, text) {
  const bytes = await inflate(text);
  const count = groups.reduce((sum, group) => sum + group.channels * group.length, 0);
  if (bytes.length !== 2 * count) throw new Error("the recording in this page is damaged");
  let at = 0;
  const channel = (group) => {
    const values = new Float32Array(group.length);
    let before = 0, last = 0;
    for (let i = 0; i < group.length; i++, at++) {
      const zigzag = bytes[at] | (bytes[at + count] << 8);
      const now = (((zigzag >> 1) ^ -(zigzag & 1)) + 2 * last - before) & 0xffff;
      before = last;
      last = now;
      values[i] = group.low + group.step * now;
    }
    return values;
  };
  return groups.map((group) => Array.from({ length: group.channels }, () => channel(group)));
}

/** Elements with their looks: shape, colour and label. */
function looking(elements, looks) {
  return elements.map((element) => ({ ...looks[element.look], ...element }));
}

/** A recording that can be asked for the pose of any element at any time. */
class Recording {
  constructor(data, channels) {
    Object.assign(this, { interval: data.interval, duration: data.duration, frames: data.frames, elements: looking(data.elements, data.looks) });
    [this.x, this.y, this.z, this.turn] = channels;
    const bends = channels.slice(4, 4 + data.actuators), rest = channels.slice(4 + data.actuators);
    this.curves = data.curves.map((curve, i) => ({ ...curve, targets: rest[i][0] || [], bend: bends[i]?.[0] || [] }));
    const [x, y, z, turn] = rest.slice(data.curves.length);
    /** Where the bodies are in another world; null if that is not known. */
    this.elsewhere = data.elsewhere ? { x, y, z, turn } : null;
    this.pose = new Float32Array(7);
    this.coreWay = this.way([0]);
    this.centreWay = this.way(this.elements.map((_, index) => index));
  }

  get empty() {
    return this.frames === 0 || this.elements.length === 0;
  }

  /** The time of a frame; the last may come early. */
  time(frame) {
    return Math.min(frame * this.interval, this.duration);
  }

  /** The frames around a time and how far it is between them. */
  place(t) {
    const last = Math.max(this.frames - 1, 0);
    const low = this.interval > 0 ? Math.min(Math.floor(Math.max(t, 0) / this.interval + 1e-9), last) : 0;
    const high = Math.min(low + 1, last);
    const span = this.time(high) - this.time(low);
    const part = span > 0 ? Math.min(Math.max((t - this.time(low)) / span, 0), 1) : 0;
    return { low, high, part };
  }

  /** A channel at a place, straight between its frames. */
  between(channel, { low, high, part }) {
    return channel.length ? channel[low] + (channel[high] - channel[low]) * part : 0;
  }

  /** The pose of an element: x, y, z, i, j, k, w in an array that the next call uses again; here or elsewhere. */
  poseOf(element, place, where = this) {
    const { body, local } = element;
    const [a, b, c, d] = [0, 1, 2, 3].map((i) => this.between(where.turn[4 * body + i], place));
    const norm = 1 / (Math.hypot(a, b, c, d) || 1);
    const [i, j, k, w] = [a * norm, b * norm, c * norm, d * norm];
    const [px, py, pz, li, lj, lk, lw] = local;
    // Rotates the local position: v + 2 q x (q x v + w v).
    const ux = j * pz - k * py + w * px, uy = k * px - i * pz + w * py, uz = i * py - j * px + w * pz;
    const out = this.pose;
    out[0] = this.between(where.x[body], place) + px + 2 * (j * uz - k * uy);
    out[1] = this.between(where.y[body], place) + py + 2 * (k * ux - i * uz);
    out[2] = this.between(where.z[body], place) + pz + 2 * (i * uy - j * ux);
    out[3] = w * li + i * lw + j * lk - k * lj;
    out[4] = w * lj - i * lk + j * lw + k * li;
    out[5] = w * lk + i * lj - j * li + k * lw;
    out[6] = w * lw - i * li - j * lj - k * lk;
    return out;
  }

  /** The mean position of some elements in every frame: [x, y, z, x, y, z, ...]. */
  way(indices) {
    const way = new Float32Array(3 * this.frames);
    for (let frame = 0; frame < this.frames; frame++) {
      const place = { low: frame, high: frame, part: 0 };
      for (const index of indices) {
        const element = this.elements[index];
        if (!element) continue;
        const pose = this.poseOf(element, place);
        for (let axis = 0; axis < 3; axis++) way[3 * frame + axis] += pose[axis] / indices.length;
      }
    }
    return way;
  }

  /** A point of a way at a place. */
  along(way, { low, high, part }) {
    return [0, 1, 2].map((axis) => way[3 * low + axis] + (way[3 * high + axis] - way[3 * low + axis]) * part);
  }

  /** A way smoothed over `span` seconds either side, so that a camera on it does not shake. */
  smoothed(way, span) {
    const reach = Math.max(1, Math.round(span / (this.interval || 1)));
    let smooth = way;
    // Two running means: no jerk where the first one has corners.
    for (let pass = 0; pass < 2; pass++) {
      const from = smooth;
      smooth = new Float32Array(from.length);
      for (let axis = 0; axis < 3; axis++) {
        for (let frame = 0; frame < this.frames; frame++) {
          const near = Math.min(reach, frame, this.frames - 1 - frame);
          let sum = 0;
          for (let other = frame - near; other <= frame + near; other++) sum += from[3 * other + axis];
          smooth[3 * frame + axis] = sum / (2 * near + 1);
        }
      }
    }
    return smooth;
  }

  /** The target of an actuator at a time. */
  target(curve, t) {
    const last = curve.targets.length - 1;
    if (last < 0) return 0;
    const at = curve.interval > 0 ? Math.min(Math.max(t, 0) / curve.interval, last) : 0;
    const low = Math.floor(at), high = Math.min(low + 1, last);
    return curve.targets[low] + (curve.targets[high] - curve.targets[low]) * (at - low);
  }
}

/** The largest of 1, 2, 5, 10, 20 ... times a tenth of a millimetre not above `length`. */
function round(length) {
  let best = 1e-4;
  for (let decade = 1e-4; decade <= 1e4; decade *= 10) {
    for (const step of [1, 2, 5]) if (step * decade <= length * 1.000001) best = step * decade;
  }
  return best;
}

/** A length in m as text in cm. */
function centimetres(length, digits) {
  const text = (100 * length).toFixed(digits);
  return (Number(text) === 0 ? (0).toFixed(digits) : text).replace("-", "\u2212") + "\u00a0cm";
}
