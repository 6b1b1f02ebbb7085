// What the actuators do over time: a lane each, target dashed, actual drawn through.

/** An element with a class and text or children. */
function make(tag, className, ...children) {
  const node = document.createElement(tag);
  if (className) node.className = className;
  node.append(...children);
  return node;
}

/** What an actuator's numbers are shown as: how many to one in SI units, and the unit. */
const MEASURES = { angle: [180 / Math.PI, "\u00b0"], distance: [1000, " mm"], speed: [180 / Math.PI, "\u00b0/s"], strain: [100, " %"] };

/** A number of a measure, whole. */
function shown(value, measure) {
  const [factor, unit] = MEASURES[measure];
  const whole = Math.round(value * factor);
  return String(whole === 0 ? 0 : whole).replace("-", "\u2212") + unit;
}

class Curves {
  /** `seek(t)` is called when someone points at a moment, `light(actuator)` at a lane. */
  constructor(box, recording, seek, light) {
    this.recording = recording;
    const { duration, curves, elements } = recording;
    // One scale for all lanes of a measure, from the least to the greatest value, zero within.
    this.scales = {};
    for (const { targets, bend, measure } of curves) {
      const scale = (this.scales[measure] ||= { low: 0, high: 0 });
      for (const values of [targets, bend]) {
        for (const value of values) [scale.low, scale.high] = [Math.min(scale.low, value), Math.max(scale.high, value)];
      }
    }
    for (const [measure, scale] of Object.entries(this.scales)) {
      const least = measure === "distance" ? 0.001 : 0.02;
      if (scale.high - scale.low < least) scale.high = scale.low + least;
    }
    // Cells that nothing ever strains are material, not actuators.
    const still = (curve) => curve.measure === "strain" && [...curve.targets].every((value) => value === 0);
    const shownLanes = curves.filter((curve) => !still(curve)).length;
    box.style.setProperty("--lane", `${Math.min(Math.max(Math.floor(150 / Math.max(shownLanes, 1)), 30), 60)}px`);
    box.append(this.ticks(duration));
    this.lanes = curves.map((curve, index) => {
      const colour = elements.find((element) => element.actuator === index)?.colour;
      const swatch = make("i");
      swatch.style.background = colour || "transparent";
      const name = make("div", "name", swatch, make("span", "", curve.name));
      name.title = curve.name;
      const now = make("div", "now"), plot = make("div", "plot", this.plot(curve, duration), now);
      const target = make("span"), actual = make("b"), numbers = make("div", "numbers", target, actual);
      const lane = make("div", "lane", name, plot, numbers);
      this.listen(lane, plot, index, seek, light);
      if (!still(curve)) box.append(lane);
      return { curve, lane, now, target, actual };
    });
  }

  listen(lane, plot, index, seek, light) {
    const to = (event) => {
      const { left, width } = plot.getBoundingClientRect();
      seek(Math.min(Math.max((event.clientX - left) / width, 0), 1) * this.recording.duration);
    };
    plot.addEventListener("pointerdown", (event) => {
      if (event.button !== 0) return;
      plot.setPointerCapture(event.pointerId);
      to(event);
    });
    plot.addEventListener("pointermove", (event) => plot.hasPointerCapture(event.pointerId) && to(event));
    lane.addEventListener("pointerenter", () => light(index));
    lane.addEventListener("pointerleave", () => light(null));
  }

  /** The curves of one actuator in a box of 1000 by 100, stretched to its place. */
  plot({ targets, interval, bend, measure }, duration) {
    const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    svg.setAttribute("viewBox", "0 0 1000 100");
    svg.setAttribute("preserveAspectRatio", "none");
    const { low, high } = this.scales[measure];
    const y = (value) => (97 - (94 * (value - low)) / (high - low)).toFixed(2);
    const path = (className, d) => {
      const node = document.createElementNS(svg.namespaceURI, "path");
      node.setAttribute("class", className);
      node.setAttribute("d", d);
      svg.append(node);
    };
    const line = (values, time) => {
      let d = "";
      for (let i = 0; i < values.length && time(i) <= duration * 1.0001; i++) d += `${i ? "L" : "M"}${((1000 * time(i)) / (duration || 1)).toFixed(2)} ${y(values[i])}`;
      return d;
    };
    path("zero", `M0 ${y(0)}H1000`);
    const last = targets.length ? `H1000` : "";
    path("target", line(targets, (i) => i * interval) + ((targets.length - 1) * interval < duration ? last : ""));
    path("actual", line(bend, (i) => this.recording.time(i)));
    return svg;
  }

  /** The scale of time, and what the lines mean. */
  ticks(duration) {
    const step = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500].find((step) => duration / step <= 10) || duration;
    const times = make("div", "times");
    for (let t = 0; t <= duration * 1.0001 && step > 0; t += step) {
      const tick = make("span", "", `${Number(t.toFixed(2))}${t === 0 ? " s" : ""}`);
      tick.style.left = `${(100 * t) / duration}%`;
      if (t > 0 && t < 0.97 * duration) tick.style.transform = "translateX(-50%)";
      times.append(tick);
    }
    // What the height of every lane stands for.
    const scales = Object.entries(this.scales).map(([measure, { low, high }]) => `${shown(low, measure)} to ${shown(high, measure)}`);
    const scale = make("span", "", scales.join(", "));
    const key = make("div", "key", make("span", "", make("i", "t"), "target"), make("span", "", make("i", "a"), "actual"));
    return make("div", "ticks", scale, times, key);
  }

  /** Marks the moment t. */
  show(t) {
    const { recording } = this, place = recording.place(t);
    const part = recording.duration > 0 ? (100 * t) / recording.duration : 0;
    for (const { curve, now, target, actual } of this.lanes) {
      now.style.left = `${part}%`;
      target.textContent = curve.targets.length ? shown(recording.target(curve, t), curve.measure) : "";
      actual.textContent = curve.bend.length ? shown(recording.between(curve.bend, place), curve.measure) : "";
    }
  }

  /** Marks the lane of an actuator, or none (null). */
  light(actuator) {
    this.lanes.forEach(({ lane }, index) => lane.classList.toggle("lit", index === actuator));
  }
}
