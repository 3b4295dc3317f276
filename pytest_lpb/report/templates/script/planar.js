// Trials in the plane on a canvas: equal axes, x to the right, y up.
class PlanarStage {
  constructor(canvas, tracks, box, camera) {
    Object.assign(this, { canvas, tracks, box, camera });
    this.whole = [0, 1].map((end) => box[end].map((edge, axis) => Math[end ? "max" : "min"](edge, ...tracks.map(({ scene }) => [scene.low, scene.high][end][axis]))));
    canvas.style.aspectRatio = String(Math.min(Math.max((box[1][0] - box[0][0]) / (box[1][1] - box[0][1]), 1), 2.2));
  }

  draw(t) {
    const { canvas, tracks, box, camera } = this;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    const margin = 26;
    if (Math.min(width, height) <= 2 * margin) return; // not laid out yet
    const density = Math.max(devicePixelRatio, 1);
    canvas.width = width * density;
    canvas.height = height * density;
    const context = this.context = canvas.getContext("2d");
    context.scale(density, density);
    context.fillStyle = css(colour("--card"));
    context.fillRect(0, 0, width, height);
    const size = box[1].map((high, axis) => high - box[0][axis]);
    this.scale = camera.zoom * Math.min((width - 2 * margin) / size[0], (height - 2 * margin) / size[1]);
    const middle = box[0].map((low, axis) => low + size[axis] / 2 + camera.shift[axis]);
    this.origin = [width / 2 - this.scale * middle[0], height / 2 + this.scale * middle[1]];
    canvas.style.touchAction = camera.zoom > 1.01 ? "none" : "pan-y"; // a finger scrolls the page until it is nearer
    this.axes(width, height);
    const scene = tracks[0].scene;
    scene.obstacles.forEach((obstacle) => this.obstacle(obstacle, t));
    if (scene.goal) this.goal(goalAt(scene.goal, t), scene.goal.tolerance);
    tracks.forEach((track) => this.robot(track, Math.min(t, track.end), t));
  }

  world([x, y]) { return [(x - this.origin[0]) / this.scale, (this.origin[1] - y) / this.scale]; }

  // Name of the obstacle at a place [px].
  hit(place, t) {
    if (!this.origin) return "";
    const at = this.world(place);
    return this.tracks[0].scene.obstacles.findLast((obstacle) => {
      const [x, y, angle] = obstacle.poses.body(0, t);
      const own = placed([at[0] - x, at[1] - y], 0, 0, -angle);
      return obstacle.parts.some(([kind, , shape]) => (kind === "disc" ? Math.hypot(...own) <= shape : within(shape, own)));
    })?.name;
  }

  px([x, y]) { return [this.origin[0] + this.scale * x, this.origin[1] - this.scale * y]; }

  axes(width, height) {
    const { context } = this;
    const low = [-this.origin[0] / this.scale, (this.origin[1] - height) / this.scale];
    const high = [low[0] + width / this.scale, low[1] + height / this.scale];
    context.strokeStyle = css(colour("--grid"));
    context.fillStyle = css(colour("--quiet"));
    context.font = "12px system-ui, sans-serif";
    context.lineWidth = 1;
    context.beginPath();
    for (const [x, text] of ticks(low[0], high[0], 8)) {
      const at = this.px([x, 0])[0];
      context.moveTo(at, 0);
      context.lineTo(at, height);
      context.fillText(text, at + 3, height - 4);
    }
    for (const [y, text] of ticks(low[1], high[1], 6)) {
      const at = this.px([0, y])[1];
      context.moveTo(0, at);
      context.lineTo(width, at);
      if (at < height - 24 && at > 12) context.fillText(text, 3, at - 3);
    }
    context.stroke();
    context.fillText("x [m]", width - 34, height - 18);
    context.fillText("y [m]", 3, 12);
  }

  obstacle(obstacle, t) {
    const { context } = this;
    const struck = struckAt(obstacle, this.tracks, t);
    const [x, y, angle] = obstacle.poses.body(0, t);
    context.fillStyle = css(colour("--obstacle"));
    context.strokeStyle = css(colour(struck ? "--contact" : "--obstacle-edge"));
    context.lineWidth = struck ? 3 : 1.2;
    for (const [kind, , shape] of obstacle.parts) {
      context.beginPath();
      if (kind === "disc") context.arc(...this.px([x, y]), shape * this.scale, 0, 7);
      else shape.forEach((corner) => context.lineTo(...this.px(placed(corner, x, y, angle))));
      context.closePath();
      context.fill();
      context.stroke();
    }
  }

  goal(target, tolerance) {
    if (!target.every(Number.isFinite)) return;
    const { context } = this;
    const [x, y] = this.px(target);
    context.strokeStyle = css(colour("--goal"));
    context.fillStyle = css(colour("--goal"), 0.18);
    context.lineWidth = 2;
    context.beginPath();
    if (tolerance) { context.arc(x, y, tolerance * this.scale, 0, 7); context.fill(); }
    context.moveTo(x - 6, y);
    context.lineTo(x + 6, y);
    context.moveTo(x, y - 6);
    context.lineTo(x, y + 6);
    context.stroke();
  }

  line(points, opacity, width, dash) {
    const { context } = this;
    context.globalAlpha = opacity;
    context.lineWidth = width;
    context.setLineDash(dash ? dash.split(" ").map(Number) : []);
    context.beginPath();
    points.forEach((point) => context.lineTo(...this.px(point)));
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  robot(track, t) {
    const { context } = this;
    const hue = css(colour("--p" + track.style.colour));
    context.strokeStyle = hue;
    context.lineCap = "round";
    context.lineJoin = "round";
    this.line(wholePath(track), 0.25, 1.5);
    this.line(pathUntil(track, t), 1, 2.5, track.style.dash);
    const bodies = [...new Set(track.parts.map(([, body]) => body))];
    if (bodies.length > 1) this.line(bodies.map((body) => track.poses.body(body, t).slice(0, 2)), 0.65, 2.5); // its skeleton
    for (const [, body, ...sizes] of track.parts) {
      const pose = track.poses.body(body, t);
      const [first, second] = [placed(sizes.slice(0, 2), ...pose), placed(sizes.slice(2, 4), ...pose)];
      // A line without length is not drawn, whatever its ends look like.
      if (sizes[0] === sizes[2] && sizes[1] === sizes[3]) second[0] += 0.5 / this.scale;
      this.line([first, second], 0.65, Math.max(2 * sizes[4] * this.scale, 3));
    }
    if (track.heading) {
      context.strokeStyle = css(colour("--ink"));
      const [body, length] = track.heading;
      const pose = track.poses.body(body, t);
      for (const part of arrow(Math.max(length, 12 / this.scale))) this.line(part.map((point) => placed(point, ...pose)), 1, 2);
    }
  }
}

// Shaft and head along x; as in environment/heading.py.
const arrow = (length) => [[[0, 0], [length, 0]], [[0.7 * length, 0.16 * length], [length, 0], [0.7 * length, -0.16 * length]]];

// Whether a polygon holds a point: rays to the right cross its sides an odd number of times.
const within = (polygon, [x, y]) => polygon.reduce((inside, [ax, ay], place) => {
  const [bx, by] = polygon[(place + 1) % polygon.length];
  return (ay > y) !== (by > y) && x < ax + (y - ay) * (bx - ax) / (by - ay) ? !inside : inside;
}, false);

const placed = ([x, y], atX, atY, angle) => [
  atX + x * Math.cos(angle) - y * Math.sin(angle),
  atY + x * Math.sin(angle) + y * Math.cos(angle),
];

const STAGES = { 2: PlanarStage };
const CAMERAS = { 2: PlaneView };
