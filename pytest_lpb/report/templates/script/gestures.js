// What is done to a picture with mouse, fingers, wheel and keys, told as moves [px] and zooms about a place [px].
const KEY_MOVES = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

// Who scrolls the page must not be stopped by a picture that comes under the pointer.
let scrolled = -Infinity;
addEventListener("wheel", (event) => { if (!event.defaultPrevented) scrolled = event.timeStamp; }, { passive: true });

// `to` has move(dx, dy, place), zoom(factor, place), key(x, y), reset(); each is about one canvas.
function listen(canvas, to) {
  const fingers = new Map();
  const place = (event) => {
    const box = canvas.getBoundingClientRect();
    return [event.clientX - box.left, event.clientY - box.top];
  };
  const middle = () => [0, 1].map((axis) => [...fingers.values()].reduce((sum, at) => sum + at[axis], 0) / fingers.size);
  const spread = () => { const [a, b] = [...fingers.values()]; return b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0; };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, place(event));
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const [before, size] = [middle(), spread()];
    fingers.set(event.pointerId, place(event));
    const after = middle();
    if (size > 0 && spread() > 0) to.zoom(spread() / size, after);
    to.move(after[0] - before[0], after[1] - before[1]);
  });
  for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) canvas.addEventListener(name, (event) => fingers.delete(event.pointerId));
  canvas.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && event.timeStamp - scrolled < 300) return;
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === 1 ? 30 : 1);
    to.zoom(Math.exp(-Math.min(Math.max(pixels, -300), 300) * 0.002), place(event));
  }, { passive: false });
  canvas.addEventListener("dblclick", () => to.reset());
  canvas.addEventListener("keydown", (event) => {
    const centre = [canvas.clientWidth / 2, canvas.clientHeight / 2];
    if (KEY_MOVES[event.key]) to.key(...KEY_MOVES[event.key]);
    else if (event.key === "+" || event.key === "=") to.zoom(1.25, centre);
    else if (event.key === "-") to.zoom(0.8, centre);
    else if (event.key === "0" || event.key === "Home") to.reset();
    else return;
    event.preventDefault();
  });
}

// Buttons below a picture: [text, name, what it does].
const buttons = (entries) => entries.map(([text, name, act]) => {
  const button = el("button", { type: "button", "aria-label": name }, text);
  button.addEventListener("click", act);
  return button;
});

// The part of the plane that is seen, the same in both pictures of a comparison.
class PlaneView {
  constructor(changed) {
    Object.assign(this, { changed, stages: [] });
    this.home();
  }
  home() { [this.zoom, this.shift] = [1, [0, 0]]; } // times the first picture; [m] from its middle
  reset() { this.home(); this.changed(); }
  set(zoom, shift) {
    this.zoom = Math.min(Math.max(zoom, 0.02), 60);
    this.shift = shift;
    this.changed();
  }
  attach(canvas, stage) {
    this.stages.push(stage);
    listen(canvas, {
      move: (dx, dy) => this.set(this.zoom, [this.shift[0] - dx / stage.scale, this.shift[1] + dy / stage.scale]),
      key: (x, y) => this.set(this.zoom, [this.shift[0] + 40 * x / stage.scale, this.shift[1] - 40 * y / stage.scale]),
      zoom: (factor, place) => this.about(stage, factor, place),
      reset: () => this.reset(),
    });
  }
  // What is at a place stays there.
  about(stage, factor, place) {
    const at = stage.world(place), middle = stage.world([stage.canvas.clientWidth / 2, stage.canvas.clientHeight / 2]);
    const share = 1 - this.zoom / Math.min(Math.max(this.zoom * factor, 0.02), 60);
    this.set(this.zoom * factor, this.shift.map((value, axis) => value + share * (at[axis] - middle[axis])));
  }
  closer(factor) {
    const { canvas } = this.stages[0];
    this.about(this.stages[0], factor, [canvas.clientWidth / 2, canvas.clientHeight / 2]);
  }
  everything() {
    const { box, whole } = this.stages[0];
    const sizes = [0, 1].map((axis) => (box[1][axis] - box[0][axis]) / (whole[1][axis] - whole[0][axis]));
    this.set(Math.min(...sizes, 1), [0, 1].map((axis) => (whole[0][axis] + whole[1][axis] - box[0][axis] - box[1][axis]) / 2));
  }
  controls() {
    return el("p", { class: "camera" }, buttons([
      ["+", "Closer", () => this.closer(1.25)], ["−", "Farther", () => this.closer(0.8)],
      ["robot and path", "Show robot, goal and path", () => this.reset()], ["all obstacles", "Show all obstacles", () => this.everything()],
    ]), el("small", {}, "drag or arrow keys: move · wheel, pinch, + and −: zoom · double-click: reset"));
  }
}
