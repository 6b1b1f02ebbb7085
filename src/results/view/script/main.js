// Playing, keys and buttons. The root element's data attributes tell tests and
// other programs what goes on: state (loading, playing, paused, failed), time,
// frames, webgl, errors, and step while the page shows how the design was made.

const root = document.documentElement;
const by = (id) => document.getElementById(id);
for (const kind of ["error", "unhandledrejection"]) {
  window.addEventListener(kind, (event) => {
    root.dataset.errors = Number(root.dataset.errors) + 1;
    notice(`A mistake in this page: ${event.message || event.reason?.message || "unknown"}. Please report it.`);
  });
}

/** Says something in the middle of the stage. */
function notice(text) {
  by("notice").textContent = text;
  by("notice").hidden = false;
}

class Player {
  constructor(recording, making) {
    Object.assign(this, { recording, making, t: 0, speed: 1, playing: false, loop: true, held: 0, shown: null, made: false });
    this.stage = this.makeStage();
    this.steps = making ? new Steps(by("making"), making, this.stage, () => this.tell()) : null;
    by("modes").hidden = !making;
    root.classList.toggle("ready", Boolean(making));
    this.curves = recording.curves.length ? new Curves(by("curves"), recording, (t) => this.seek(t), (actuator) => this.light(actuator)) : null;
    by("curves").hidden = !this.curves;
    by("readout").hidden = false;
    by("scrub").max = recording.duration;
    root.dataset.frames = recording.frames;
    this.buttons();
    this.keys();
    if (this.stage) this.pointer();
    window.addEventListener("resize", () => this.resize());
    // The stage also changes size when the curves come and go.
    new ResizeObserver(() => this.resize()).observe(by("stage"));
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
      if (this.stage) this.stage.paint();
      this.draw();
    });
  }

  makeStage() {
    const canvas = by("view");
    let renderer;
    try {
      renderer = new THREE.WebGLRenderer({ canvas, antialias: true });
    } catch {
      root.dataset.webgl = "no";
      canvas.hidden = true;
      notice("This browser cannot draw in 3D here (WebGL is missing or switched off). The curves and numbers still work.");
      return null;
    }
    const stage = new Stage(renderer, this.recording, this.making);
    by("scale").textContent = `grid ${centimetres(stage.ground.minor, 2).replace(/\.?0+(?=\u00a0)/, "")}, numbers in cm from where the core started`;
    by("scale").hidden = by("cameras").hidden = false;
    by("elsewhere").hidden = !stage.other;
    root.dataset.webgl = "yes";
    return stage;
  }

  /** Starts the clock; what the address says after # comes first, such as `#t=2.5&view=whole` or `#step=3`. */
  start() {
    const wish = new URLSearchParams(location.hash.slice(1));
    if (wish.get("view") === "whole" && this.stage) this.whole();
    if (wish.has("t")) this.seek(Number(wish.get("t")) || 0);
    this.play(!this.still && !wish.has("t") && this.recording.duration > 0);
    if (wish.has("step")) {
      this.turnTo(true, false);
      this.steps?.go(Number(wish.get("step")), false);
    }
    // Without a picture there is nothing to keep in step with the screen.
    const next = this.stage ? requestAnimationFrame : (act) => setTimeout(() => act(performance.now()), 40);
    const tick = (now) => {
      this.step(Math.min((now - (this.now ?? now)) / 1000, 0.25));
      this.now = now;
      next(tick);
    };
    next(tick);
  }

  /** Goes on by some seconds of the viewer's time. */
  step(seconds) {
    const { duration } = this.recording;
    if (this.made) this.steps.advance(seconds);
    else if (this.playing) {
      this.t += seconds * this.speed;
      if (this.t >= duration) this.atEnd(seconds);
    }
    this.draw();
  }

  /** Rests at the end for a moment before it starts again. */
  atEnd(seconds) {
    this.t = this.recording.duration;
    this.held += seconds;
    if (!this.loop) this.play(false);
    else if (this.held > 0.8) [this.t, this.held] = [0, 0];
  }

  draw() {
    const { t, recording } = this;
    if (this.made) return this.steps.draw();
    // The stage is drawn again even at rest: the camera may still glide.
    if (this.stage) this.stage.show(t);
    if (this.shown === t) return;
    this.shown = t;
    if (this.curves) this.curves.show(t);
    const place = recording.place(t);
    for (const [id, way] of [["core-way", recording.coreWay], ["centre-way", recording.centreWay]]) {
      const [x, , z] = recording.along(way, place);
      by(id).textContent = centimetres(Math.hypot(x - way[0], z - way[2]), 1);
    }
    by("clock").textContent = `${t.toFixed(2)} s`;
    by("scrub").value = t;
    by("scrub").style.setProperty("--done", `${recording.duration > 0 ? (100 * t) / recording.duration : 0}%`);
    root.dataset.time = t.toFixed(3);
  }

  get still() {
    return matchMedia("(prefers-reduced-motion: reduce)").matches;
  }

  play(playing) {
    if (this.made) return this.steps.play(playing);
    if (playing && this.t >= this.recording.duration) this.t = 0;
    this.held = 0;
    this.playing = playing;
    this.tell();
  }

  get isPlaying() {
    return this.made ? this.steps.playing : this.playing;
  }

  /** Says whether it plays. */
  tell() {
    root.dataset.state = this.isPlaying ? "playing" : "paused";
    root.classList.toggle("playing", this.isPlaying);
    by("play").setAttribute("aria-label", this.isPlaying ? "Pause" : "Play");
  }

  /** Shows how the design was made, or the motion again. */
  turnTo(made, playing) {
    if (!this.steps || made === this.made) return;
    this.play(false);
    this.made = made;
    root.classList.toggle("made", made);
    by("to-motion").setAttribute("aria-selected", !made);
    by("to-making").setAttribute("aria-selected", made);
    Object.assign(by("scrub"), made ? { max: this.making.last, step: 1 } : { max: this.recording.duration, step: "any" });
    by("scrub").setAttribute("aria-label", made ? "Step" : "Time");
    by("scrub").title = made ? "Arrows: one step; Home, End" : "Arrows: one frame, with shift one second; Home, End";
    by("tip").hidden = true;
    if (this.stage) this.stage.turnTo(made);
    if (made) {
      this.steps.tell();
      this.play(playing && this.steps.step === 0);
    } else {
      delete root.dataset.step;
      this.shown = null;
      this.tell();
    }
    this.resize();
    this.draw();
  }

  /** Goes to a moment. */
  seek(t) {
    this.t = Math.min(Math.max(t, 0), this.recording.duration);
    this.held = 0;
    this.draw();
  }

  light(actuator) {
    if (this.stage && this.stage.lit !== actuator) this.stage.light(actuator);
    if (this.curves) this.curves.light(actuator);
  }

  resize() {
    if (!this.stage) return;
    this.stage.resize();
    this.draw();
  }

  setFollow(follow) {
    if (!this.stage) return;
    this.stage.setFollow(follow, this.t);
    by("follow").setAttribute("aria-pressed", follow);
  }

  whole() {
    if (!this.stage) return;
    this.stage.whole();
    by("follow").setAttribute("aria-pressed", false);
  }

  near() {
    if (!this.stage) return;
    if (this.made) return this.stage.beside();
    this.stage.near(this.t);
    by("follow").setAttribute("aria-pressed", true);
  }

  /** Shows the motion in the other world, or not. */
  elsewhere() {
    if (!this.stage?.other) return;
    this.stage.showOther(!this.stage.isOtherShown);
    by("elsewhere").setAttribute("aria-pressed", this.stage.isOtherShown);
    this.draw();
  }

  setLoop(loop) {
    this.loop = loop;
    by("loop").setAttribute("aria-pressed", loop);
  }

  buttons() {
    const on = (id, act) => by(id).addEventListener("click", (event) => {
      act();
      // After a click of the mouse the space bar belongs to playing again.
      if (event.detail > 0) by(id).blur();
    });
    on("to-motion", () => this.turnTo(false));
    on("to-making", () => this.turnTo(true, !this.still));
    on("play", () => this.play(!this.isPlaying));
    on("loop", () => this.setLoop(!this.loop));
    on("follow", () => this.setFollow(!this.stage.follow));
    on("whole", () => this.whole());
    on("near", () => this.near());
    on("elsewhere", () => this.elsewhere());
    by("scrub").addEventListener("input", () => {
      const at = Number(by("scrub").value);
      if (!this.made) return this.seek(at);
      this.play(false);
      this.steps.go(at, false);
    });
    by("speed").addEventListener("change", () => {
      this.speed = Number(by("speed").value);
      by("speed").blur();
    });
  }

  keys() {
    const frame = this.recording.interval || 0.02;
    const to = (step, grow) => {
      this.play(false);
      this.steps.go(step(), grow);
    };
    const [back, on] = [() => to(() => this.steps.step - 1), () => to(() => this.steps.step + 1, true)];
    const shared = {
      " ": () => this.play(!this.isPlaying),
      r: () => this.near(),
      g: () => this.turnTo(!this.made, !this.still),
    };
    const making = {
      ...shared,
      ArrowLeft: back,
      ArrowUp: back,
      ArrowRight: on,
      ArrowDown: on,
      Home: () => to(() => 0),
      End: () => to(() => this.making.last),
      Escape: () => this.turnTo(false),
    };
    const motion = {
      ...shared,
      ArrowLeft: (shift) => this.seek(this.t - (shift ? 1 : frame)),
      ArrowRight: (shift) => this.seek(this.t + (shift ? 1 : frame)),
      ArrowUp: () => this.faster(1),
      ArrowDown: () => this.faster(-1),
      Home: () => this.seek(0),
      End: () => this.seek(this.recording.duration),
      f: () => this.setFollow(!this.stage?.follow),
      w: () => this.whole(),
      e: () => this.elsewhere(),
      l: () => this.setLoop(!this.loop),
    };
    window.addEventListener("keydown", (event) => {
      const act = (this.made ? making : motion)[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      const taken = event.target.closest?.("select") || (event.key === " " && event.target.closest?.("button"));
      if (!act || taken || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      // One frame at a time only makes sense when it does not run away.
      if (!this.made && event.key.startsWith("Arrow") && /Left|Right/.test(event.key) && !event.shiftKey) this.play(false);
      act(event.shiftKey);
    });
  }

  /** The next speed of the list, up or down. */
  faster(by_) {
    const list = by("speed");
    list.selectedIndex = Math.min(Math.max(list.selectedIndex + by_, 0), list.options.length - 1);
    this.speed = Number(list.value);
  }

  /** Tells what is below the pointer and marks its lane. */
  pointer() {
    const view = by("view"), tip = by("tip");
    const hide = () => {
      tip.hidden = true;
      if (this.curves) this.curves.light(null);
    };
    view.addEventListener("pointermove", (event) => {
      if (event.buttons) return hide();
      const index = this.stage.pick(event.offsetX, event.offsetY);
      const element = this.made ? this.making.pieces[index] : this.recording.elements[index];
      if (!element) return hide();
      const curve = this.recording.curves[element.actuator];
      const name = this.made ? this.making.name(element, this.steps.step) : element.label;
      tip.textContent = curve && curve.name !== name ? `${name}, ${curve.name}` : name;
      tip.hidden = false;
      const left = Math.min(event.offsetX + 14, view.clientWidth - tip.offsetWidth - 6);
      tip.style.transform = `translate(${left}px, ${Math.max(event.offsetY - 30, 4)}px)`;
      if (this.curves) this.curves.light(element.actuator);
    });
    view.addEventListener("pointerleave", hide);
  }
}

async function main() {
  try {
    const data = JSON.parse(by("data").textContent);
    if (typeof DecompressionStream === "undefined") throw new Error("this browser is too old to unpack it (it has no DecompressionStream)");
    const recording = new Recording(data, await unpack(data.groups, data.stream));
    if (recording.empty) {
      root.dataset.state = "empty";
      notice("No motion was recorded.");
      return;
    }
    const steps = by("making")?.querySelectorAll("li").length, pieces = looking(data.pieces, data.looks);
    const making = steps && pieces.length ? new Making(pieces, steps, recording.coreWay) : null;
    new Player(recording, making).start();
  } catch (error) {
    root.dataset.state = "failed";
    notice(`The motion cannot be shown: ${error.message}.`);
    console.error(error);
  }
}

main();
