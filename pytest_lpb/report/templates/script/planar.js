// Trials in the plane on a canvas: equal axes, x to the right, y up.
class PlanarStage {
  constructor(canvas, tracks, box) {
    Object.assign(this, { canvas, tracks, box });
    canvas.style.aspectRatio = String(Math.min(Math.max((box[1][0] - box[0][0]) / (box[1][1] - box[0][1]), 1), 2.2));
  }

  draw(t) {
    const { canvas, tracks, box } = this;
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
    this.scale = Math.min((width - 2 * margin) / size[0], (height - 2 * margin) / size[1]);
    this.origin = [width / 2 - this.scale * (box[0][0] + size[0] / 2), height / 2 + this.scale * (box[0][1] + size[1] / 2)];
    this.axes(width, height);
    const scene = tracks[0].scene;
    scene.obstacles.forEach((obstacle) => this.obstacle(obstacle, t));
    if (scene.goal) this.goal(goalAt(scene.goal, t), scene.goal.tolerance);
    tracks.forEach((track) => this.robot(track, Math.min(t, track.end), t));
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
    for (const [kind, body, ...sizes] of track.parts) {
      const [x, y, angle] = track.poses.body(body, t);
      if (kind === "capsule") {
        const [first, second] = [placed(sizes.slice(0, 2), x, y, angle), placed(sizes.slice(2, 4), x, y, angle)];
        // A line without length is not drawn, whatever its ends look like.
        if (sizes[0] === sizes[2] && sizes[1] === sizes[3]) second[0] += 0.5 / this.scale;
        this.line([first, second], 0.65, Math.max(2 * sizes[4] * this.scale, 3));
      } else {
        context.strokeStyle = css(colour("--ink"));
        this.line([[x, y], placed([sizes[0], 0], x, y, angle)], 1, 2);
        context.strokeStyle = hue;
      }
    }
  }
}

const placed = ([x, y], atX, atY, angle) => [
  atX + x * Math.cos(angle) - y * Math.sin(angle),
  atY + x * Math.sin(angle) + y * Math.cos(angle),
];

const STAGES = { 2: PlanarStage };
