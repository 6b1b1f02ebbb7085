// The panel that tells how the design was made: its steps one by one, by hand or by themselves.

class Steps {
  /** `stage` may be missing: then there are only words. `changed` is called when it starts or stops to play. */
  constructor(section, making, stage, changed) {
    Object.assign(this, { section, making, stage, changed, step: 0, part: 1, playing: false, held: 0 });
    // Steps by themselves take a second each, many of them half a minute in all.
    this.each = Math.min(Math.max(30 / (making.last || 1), 0.12), 1.2);
    this.still = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.rows = [...section.querySelectorAll("button")];
    this.rows.forEach((row, step) => row.addEventListener("click", (event) => {
      this.play(false);
      this.go(step, step === this.step + 1);
      // After a click of the mouse the space bar belongs to playing again.
      if (event.detail > 0) row.blur();
    }));
    for (const [id, to] of [["first", () => 0], ["previous", () => this.step - 1], ["next", () => this.step + 1], ["last", () => making.last]]) {
      by(id).addEventListener("click", () => {
        this.play(false);
        this.go(to(), id === "next");
      });
    }
  }

  /** Goes to a step; `grow` shows how it comes about. */
  go(step, grow) {
    const to = Math.min(Math.max(Math.round(step) || 0, 0), this.making.last);
    this.part = grow && to > 0 && to !== this.step && !this.still ? 0 : 1;
    this.step = to;
    this.held = 0;
    this.tell();
  }

  play(playing) {
    if (playing && this.step >= this.making.last) this.go(0, false);
    this.playing = playing && this.making.last > 0;
    this.changed();
  }

  /** Goes on by some seconds. */
  advance(seconds) {
    if (this.part < 1) this.part = Math.min(this.part + seconds / Math.min(0.8, 0.6 * this.each), 1);
    if (!this.playing) return;
    this.held += seconds;
    if (this.held < this.each) return;
    if (this.step >= this.making.last) this.play(false);
    else this.go(this.step + 1, true);
  }

  draw() {
    if (!this.stage) return;
    const changes = this.stage.showStep(this.step, this.part);
    for (const line of by("legend").children) line.hidden = !changes.includes(line.dataset.of);
  }

  /** The words and marks that belong to the step. */
  tell() {
    const { step, making: { last } } = this, row = this.rows[step];
    this.rows.forEach((other, index) => {
      if (index === step) other.setAttribute("aria-current", "step");
      else other.removeAttribute("aria-current");
      other.classList.toggle("later", index > step);
    });
    by("caption").replaceChildren(...[...row.childNodes].map((node) => node.cloneNode(true)));
    by("clock").textContent = step === 0 ? "begin" : `step ${step} of ${last}`;
    by("scrub").value = step;
    by("scrub").style.setProperty("--done", `${last > 0 ? (100 * step) / last : 0}%`);
    for (const [id, at] of [["first", 0], ["previous", 0], ["next", last], ["last", last]]) by(id).disabled = step === at;
    // Only the list scrolls: in a narrow window the picture would be scrolled away with it.
    const box = this.section.closest("aside"), top = row.offsetTop, margin = 60;
    if (top - margin < box.scrollTop) box.scrollTop = top - margin;
    else if (top + row.offsetHeight + margin > box.scrollTop + box.clientHeight) box.scrollTop = top + row.offsetHeight + margin - box.clientHeight;
    root.dataset.step = step;
  }
}
