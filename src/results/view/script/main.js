// Playing, keys and buttons. The root element's data attributes tell tests and
// other programs what goes on: state (loading, playing, paused, failed), time,
// frames, webgl, errors.

const root = document.documentElement;
const by = (id) => document.getElementById(id);
window.addEventListener("error", () => { root.dataset.errors = Number(root.dataset.errors) + 1; });
window.addEventListener("unhandledrejection", () => { root.dataset.errors = Number(root.dataset.errors) + 1; });

/** Says something in the middle of the stage. */
function notice(text) {
  by("notice").textContent = text;
  by("notice").hidden = false;
}

class Player {
  constructor(recording) {
    this.recording = recording;
    Object.assign(this, { t: 0, speed: 1, playing: false, loop: true, held: 0, shown: null });
    this.stage = this.makeStage();
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
    try {
      const stage = new Stage(by("view"), this.recording);
      by("scale").textContent = `grid ${centimetres(stage.ground.minor, 2).replace(/\.?0+(?=\u00a0)/, "")}, numbers in cm from where the core started`;
      by("scale").hidden = by("cameras").hidden = false;
      root.dataset.webgl = "yes";
      return stage;
    } catch (error) {
      root.dataset.webgl = "no";
      by("view").hidden = true;
      notice("This browser cannot draw in 3D here (WebGL is missing or switched off). The curves and numbers still work.");
      return null;
    }
  }

  /** Starts the clock; what the address says after # comes first, such as `#t=2.5&view=whole`. */
  start() {
    const wish = new URLSearchParams(location.hash.slice(1));
    const still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    if (wish.get("view") === "whole" && this.stage) this.whole();
    if (wish.has("t")) this.seek(Number(wish.get("t")) || 0);
    this.play(!still && !wish.has("t") && this.recording.duration > 0);
    // Without a picture there is nothing to keep in step with the screen.
    const next = this.stage ? requestAnimationFrame : (act) => setTimeout(() => act(performance.now()), 40);
    const tick = (now) => {
      this.step(Math.min((now - (this.now ?? now)) / 1000, 0.25));
      this.now = now;
      next(tick);
    };
    next(tick);
    if (wish.get("count") === "colours" && this.stage) root.dataset.colours = this.stage.colours();
  }

  /** Goes on by some seconds of the viewer's time. */
  step(seconds) {
    const { duration } = this.recording;
    if (this.playing) {
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

  play(playing) {
    if (playing && this.t >= this.recording.duration) this.t = 0;
    this.held = 0;
    this.playing = playing;
    root.dataset.state = playing ? "playing" : "paused";
    root.classList.toggle("playing", playing);
    by("play").setAttribute("aria-label", playing ? "Pause" : "Play");
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
    this.stage.show(this.t);
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
    this.stage.near(this.t);
    by("follow").setAttribute("aria-pressed", true);
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
    on("play", () => this.play(!this.playing));
    on("loop", () => this.setLoop(!this.loop));
    on("follow", () => this.setFollow(!this.stage.follow));
    on("whole", () => this.whole());
    on("near", () => this.near());
    by("scrub").addEventListener("input", () => this.seek(Number(by("scrub").value)));
    by("speed").addEventListener("change", () => {
      this.speed = Number(by("speed").value);
      by("speed").blur();
    });
  }

  keys() {
    const frame = this.recording.interval || 0.02;
    const acts = {
      ArrowLeft: (shift) => this.seek(this.t - (shift ? 1 : frame)),
      ArrowRight: (shift) => this.seek(this.t + (shift ? 1 : frame)),
      ArrowUp: () => this.faster(1),
      ArrowDown: () => this.faster(-1),
      Home: () => this.seek(0),
      End: () => this.seek(this.recording.duration),
      " ": () => this.play(!this.playing),
      f: () => this.setFollow(!this.stage?.follow),
      w: () => this.whole(),
      r: () => this.near(),
      l: () => this.setLoop(!this.loop),
    };
    window.addEventListener("keydown", (event) => {
      const act = acts[event.key.length === 1 ? event.key.toLowerCase() : event.key];
      const taken = event.target.closest?.("select") || (event.key === " " && event.target.closest?.("button"));
      if (!act || taken || event.ctrlKey || event.metaKey || event.altKey) return;
      event.preventDefault();
      // One frame at a time only makes sense when it does not run away.
      if (event.key.startsWith("Arrow") && /Left|Right/.test(event.key) && !event.shiftKey) this.play(false);
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
      const element = this.recording.elements[this.stage.pick(event.offsetX, event.offsetY)];
      if (!element) return hide();
      const curve = this.recording.curves[element.actuator];
      tip.textContent = curve ? `${element.label}, ${curve.name}` : element.label;
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
    new Player(recording).start();
  } catch (error) {
    root.dataset.state = "failed";
    notice(`The motion cannot be shown: ${error.message}.`);
    console.error(error);
  }
}

main();
