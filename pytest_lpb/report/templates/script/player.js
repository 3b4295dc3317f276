// One or two trials in motion, with one slider for time; charts follow it.
const SPEEDS = [0.25, 0.5, 1, 2, 4, 8];

class Player {
  constructor(tracks, layout, changed) {
    this.tracks = tracks;
    this.changed = changed;
    this.end = Math.max(...tracks.map((track) => track.end));
    this.t = 0;
    this.playing = false;
    const box = boxOf(tracks);
    const dimension = tracks[0].scene.dimension;
    this.camera = new CAMERAS[dimension](() => this.draw());
    const groups = layout === "overlay" ? [tracks] : tracks.map((track) => [track]);
    this.stages = groups.map((group) => this.stage(group, dimension, box));
    this.charts = this.chartFigures();
    this.node = el("div", { class: "player" + (groups.length > 1 ? " two" : "") },
      el("div", {}, el("div", { class: "stages" }, this.stages.map((stage) => stage.node)), this.bar(), this.camera.controls()),
      el("div", { class: "timelines" }, this.charts.filter((chart) => !chart.below).map((chart) => chart.node)),
      el("div", { class: "timelines below" }, this.charts.filter((chart) => chart.below).map((chart) => chart.node)));
    this.watch = new ResizeObserver(() => this.draw());
    this.watch.observe(this.node);
    this.stages.forEach(({ view }) => view.ready?.then(() => this.draw()));
  }

  stage(group, dimension, box) {
    const names = group.map((track) => track.style.name).join(" and ");
    const among = group[0].scene.obstacles.slice(0, 20).map((obstacle) => obstacle.name);
    const canvas = el("canvas", { role: "img", "aria-label": `Motion of ${names}` + (among.length ? ` among ${among.join(", ")}` : ""), tabindex: 0 });
    const view = new STAGES[dimension](canvas, group, box, this.camera);
    this.camera.attach(canvas, view);
    const name = el("span", { class: "name-tip", hidden: true });
    this.names(canvas, view, name);
    const captions = group.map((track) => el("span", {}, planner(track.style), " ", chip(track.trial)));
    return { view, node: el("figure", {}, el("figcaption", {}, captions), el("div", { class: "stage" }, canvas, name)) };
  }

  // Names of obstacles under the pointer, or where a finger is put.
  names(canvas, view, tip) {
    const show = ({ offsetX, offsetY, type, buttons: pressed }) => {
      const name = type === "pointermove" && pressed ? "" : view.hit([offsetX, offsetY], this.t);
      tip.hidden = !name;
      tip.textContent = name || "";
      const left = offsetX > canvas.clientWidth / 2;
      tip.style.cssText = `${left ? "right" : "left"}:${left ? canvas.clientWidth - offsetX + 8 : offsetX + 14}px;top:${offsetY + 12}px`;
    };
    canvas.addEventListener("pointermove", show);
    canvas.addEventListener("pointerdown", show);
    canvas.addEventListener("pointerleave", ({ pointerType }) => { tip.hidden ||= pointerType === "mouse"; });
  }

  chartFigures() {
    const titles = new Map(this.tracks.flatMap((track) => track.charts).map((chart) => [chart.title, chart]));
    return [...titles.values()].map((chart) => chartFigure(chart, this.tracks, this.end, (t) => this.seek(t)));
  }

  bar() {
    this.button = el("button", { type: "button", class: "play" }, "▶ play");
    this.button.addEventListener("click", () => (this.playing ? this.pause() : this.play()));
    this.slider = el("input", { type: "range", min: 0, max: this.end, step: this.end / 200, value: 0, "aria-label": "Time", autocomplete: "off" });
    this.slider.addEventListener("input", () => { this.pause(); this.show(Number(this.slider.value)); });
    this.slider.addEventListener("change", () => this.changed(this.t));
    this.clock = el("output", {});
    this.speed = el("select", { "aria-label": "Speed", autocomplete: "off" }, SPEEDS.map((speed) => el("option", { value: speed }, speed + "×")));
    this.speed.value = "1";
    return el("div", { class: "bar" }, this.button, this.slider, this.clock, this.speed);
  }

  play() {
    this.playing = true;
    this.button.textContent = "❚❚ pause";
    if (this.t >= this.end - 1e-9) this.t = 0;
    let last = null;
    const frame = (now) => {
      if (!this.playing || !this.node.isConnected) return;
      if (last !== null) this.show(Math.min(this.t + (now - last) / 1000 * Number(this.speed.value), this.end));
      last = now;
      if (this.t >= this.end) this.pause(); else requestAnimationFrame(frame);
    };
    requestAnimationFrame(frame);
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this.button.textContent = "▶ play";
    this.changed(this.t);
  }

  seek(t) {
    this.pause();
    this.show(t);
    this.changed(t);
  }

  show(t) {
    this.t = Math.min(Math.max(t, 0), this.end);
    this.slider.value = this.t;
    const text = `${this.t.toFixed(2)} of ${this.end.toFixed(2)} s`;
    this.clock.textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.charts.forEach((chart) => chart.show(this.t));
    all(".name-tip", this.node).forEach((tip) => { tip.hidden = true; });
    this.draw();
  }

  draw() {
    if (this.node.isConnected) this.stages.forEach(({ view }) => view.draw(this.t));
  }

  close() {
    this.playing = false;
    this.watch.disconnect();
  }
}
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => trialPlayer?.draw());
