// Trials in space: solids and meshes, seen by a camera that turns about the middle of the scene.
const AROUND = 20; // corners of what is round
const QUARTER = Array.from({ length: 6 }, (_, step) => step * Math.PI / 10);

// A surface made by turning an outline [[radius, height], ...] about z.
function turned(outline) {
  const vertices = [], faces = [];
  outline.forEach(([radius, height]) => {
    for (let k = 0; k < AROUND; k += 1) vertices.push([radius * Math.cos(2 * Math.PI * k / AROUND), radius * Math.sin(2 * Math.PI * k / AROUND), height]);
  });
  for (let ring = 0; ring + 1 < outline.length; ring += 1) {
    for (let k = 0; k < AROUND; k += 1) {
      const here = ring * AROUND + k, beside = ring * AROUND + (k + 1) % AROUND;
      faces.push([here, beside, here + AROUND], [beside, beside + AROUND, here + AROUND]);
    }
  }
  return [vertices, faces];
}
const cap = (radius, height, up) => (up ? QUARTER : [...QUARTER].reverse())
  .map((angle) => [radius * Math.cos(angle), height + (up ? 1 : -1) * radius * Math.sin(angle)]);

const CORNERS = [0, 1, 2, 3, 4, 5, 6, 7].map((n) => [n & 1 ? 0.5 : -0.5, n & 2 ? 0.5 : -0.5, n & 4 ? 0.5 : -0.5]);
const SIDES = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]];
const SOLIDS = {
  sphere: ([radius]) => turned([...cap(radius, 0, false), ...cap(radius, 0, true)]),
  capsule: ([radius, length]) => turned([...cap(radius, -length / 2, false), ...cap(radius, length / 2, true)]),
  cylinder: ([radius, length]) => turned([[0, -length / 2], [radius, -length / 2], [radius, length / 2], [0, length / 2]]),
  box: (size) => [CORNERS.map((corner) => corner.map((share, axis) => share * size[axis])), SIDES.flatMap(([a, b, c, d]) => [[a, b, c], [a, c, d]])],
};

const moved = (m, [x, y, z]) => [m[0] * x + m[1] * y + m[2] * z + m[3], m[4] * x + m[5] * y + m[6] * z + m[7], m[8] * x + m[9] * y + m[10] * z + m[11]];

// Vertices and faces of a part in the frame of its body.
async function partMesh([kind, , size, pose, file]) {
  let [vertices, faces] = [[], []];
  if (kind !== "mesh") [vertices, faces] = SOLIDS[kind](size);
  else {
    const block = await unpack("mesh:" + file);
    if (block?.vertices) {
      const rows = (list) => { const found = columns(list); return Array.from(found[0], (_, row) => found.map((column) => column[row])); };
      vertices = rows(block.vertices).map((point) => point.map((value, axis) => value * size[axis]));
      faces = rows(block.faces);
    }
  }
  return { vertices: vertices.map((point) => moved(pose, point)), faces };
}

// Position and quaternion as a pose of 12 numbers.
function poseOf([x, y, z, w, i, j, k]) {
  return [
    1 - 2 * (j * j + k * k), 2 * (i * j - w * k), 2 * (i * k + w * j), x,
    2 * (i * j + w * k), 1 - 2 * (i * i + k * k), 2 * (j * k - w * i), y,
    2 * (i * k - w * j), 2 * (j * k + w * i), 1 - 2 * (i * i + j * j), z,
  ];
}

const VIEWS = { oblique: [-0.9, 0.42], above: [-Math.PI / 2, Math.PI / 2 - 0.001], side: [-Math.PI / 2, 0.02] };
const LENS = 2.2; // focal length over half the smaller side of the picture

class SpatialStage {
  constructor(canvas, tracks, box, camera) {
    Object.assign(this, { canvas, tracks, box, camera });
    canvas.style.aspectRatio = "4 / 3";
    this.middle = box[0].map((low, axis) => (low + box[1][axis]) / 2);
    this.radius = Math.max(Math.hypot(...box[1].map((high, axis) => high - box[0][axis])) / 2, 0.1);
    this.ready = this.load();
  }

  async load() {
    const meshes = (parts) => Promise.all(parts.map(async (part) => ({ body: part[1], ...(await partMesh(part)) })));
    const every = (list) => Promise.all(list.map((entry) => meshes(entry.parts)));
    const obstacles = await every(this.tracks[0].scene.obstacles);
    [this.bodies, this.obstacles] = [await every(this.tracks), obstacles]; // both at once: then it can be drawn
  }

  draw(t) {
    if (!this.bodies || !this.canvas.clientWidth) return;
    const [width, height] = [2 * this.canvas.clientWidth, 2 * this.canvas.clientHeight];
    if (this.raster?.width !== width || this.raster.height !== height) {
      this.raster = new Raster(width, height);
      [this.canvas.width, this.canvas.height] = [width, height];
    }
    this.look(width, height);
    this.raster.clear(colour("--card"));
    this.ground();
    this.obstacles.forEach((meshes, place) => this.obstacle(meshes, this.tracks[0].scene.obstacles[place], t));
    if (this.tracks[0].scene.goal) this.goal(this.tracks[0].scene.goal, t);
    this.tracks.forEach((track, place) => this.robot(track, this.bodies[place], Math.min(t, track.end)));
    this.canvas.getContext("2d").putImageData(this.raster.image, 0, 0);
  }

  look(width, height) {
    const { yaw, pitch, zoom } = this.camera;
    const forward = [-Math.cos(pitch) * Math.cos(yaw), -Math.cos(pitch) * Math.sin(yaw), -Math.sin(pitch)];
    const right = [-Math.sin(yaw), Math.cos(yaw), 0];
    const up = cross(right, forward);
    const distance = 2.4 * this.radius / zoom;
    this.eye = this.middle.map((value, axis) => value - distance * forward[axis]);
    this.toLight = unit(forward.map((value, axis) => -0.5 * value + 0.45 * up[axis] - 0.35 * right[axis] + (axis === 2 ? 0.6 : 0)));
    const focal = LENS * Math.min(width, height) / 2;
    const near = 0.02 * this.radius;
    this.project = (point) => {
      const away = [point[0] - this.eye[0], point[1] - this.eye[1], point[2] - this.eye[2]];
      const depth = dot(away, forward);
      if (depth < near) return null;
      return [width / 2 + focal * dot(away, right) / depth, height / 2 - focal * dot(away, up) / depth, 1 / depth];
    };
  }

  mesh({ vertices, faces }, pose, rgb, sparse = false) {
    const world = vertices.map((point) => moved(pose, point));
    const seen = world.map(this.project);
    for (const [a, b, c] of faces) {
      if (!seen[a] || !seen[b] || !seen[c]) continue;
      const normal = unit(cross(minus(world[b], world[a]), minus(world[c], world[a])));
      const toEye = minus(this.eye, world[a]);
      const side = dot(normal, toEye) < 0 ? -1 : 1; // surfaces are seen from both sides
      const light = 0.5 + 0.55 * Math.max(0, side * dot(normal, this.toLight));
      this.raster.triangle(seen[a], seen[b], seen[c], Raster.word(rgb.map((value) => Math.min(255, value * light))), sparse);
    }
  }

  // Name of the nearest obstacle at a place [px].
  hit([x, y], t) {
    if (!this.project) return "";
    let [nearest, name] = [0, ""];
    this.obstacles.forEach((meshes, place) => {
      const obstacle = this.tracks[0].scene.obstacles[place];
      const pose = poseOf(obstacle.poses.body(0, t));
      for (const { vertices, faces } of meshes) {
        const seen = vertices.map((point) => this.project(moved(pose, point)));
        for (const face of faces) {
          const corners = face.map((corner) => seen[corner]);
          if (corners.every(Boolean) && corners[0][2] > nearest && within(corners, [2 * x, 2 * y])) [nearest, name] = [corners[0][2], obstacle.name];
        }
      }
    });
    return name;
  }

  line(points, rgb, thickness, nearer) {
    const seen = points.map(this.project);
    for (let row = 1; row < seen.length; row += 1) {
      if (seen[row - 1] && seen[row]) this.raster.line(seen[row - 1], seen[row], Raster.word(rgb), thickness, nearer);
    }
  }

  ground() {
    const [low, high] = this.box;
    const step = ticks(0, 2 * this.radius, 8)[1][0];
    const ends = [0, 1].map((axis) => [Math.floor(low[axis] / step - 0.5) * step, Math.ceil(high[axis] / step + 0.5) * step]);
    const hue = mixed(colour("--card"), colour("--quiet"), 0.35);
    const count = (axis) => Math.round((ends[axis][1] - ends[axis][0]) / step);
    for (let k = 0; k <= count(0); k += 1) this.line(ends[1].map((y) => [ends[0][0] + k * step, y, 0]), hue, 2, 1);
    for (let k = 0; k <= count(1); k += 1) this.line(ends[0].map((x) => [x, ends[1][0] + k * step, 0]), hue, 2, 1);
    const length = 0.25 * this.radius;
    [[length, 0, 0], [0, length, 0], [0, 0, length]].forEach((end, axis) => {
      this.line([[0, 0, 0], end], [[200, 60, 60], [60, 160, 70], [70, 100, 220]][axis], 4);
    });
  }

  obstacle(meshes, obstacle, t) {
    const struck = struckAt(obstacle, this.tracks, t);
    const hue = colour(struck ? "--contact" : "--obstacle");
    const pose = poseOf(obstacle.poses.body(0, t));
    meshes.forEach((mesh) => this.mesh(mesh, pose, hue, this.camera.through));
  }

  goal(goal, t) {
    const target = goalAt(goal, t);
    const known = target.map((value, axis) => (Number.isFinite(value) ? value : axis === 2 ? 0 : this.middle[axis]));
    const hue = colour("--goal");
    const pose = [1, 0, 0, known[0], 0, 1, 0, known[1], 0, 0, 1, known[2]];
    this.mesh(SphereOf(Math.max(goal.tolerance || 0, 0.012 * this.radius)), pose, hue, true);
    const reach = 0.06 * this.radius;
    [0, 1, 2].forEach((axis) => {
      const end = (sign) => known.map((value, other) => value + (other === axis ? sign * reach : 0));
      this.line([end(-1), end(1)], hue, 4, 1.02);
    });
  }

  robot(track, meshes, t) {
    const hue = colour("--p" + track.style.colour);
    const skin = mixed(hue, [235, 235, 235], 0.45);
    const poses = new Map();
    for (const mesh of meshes) {
      if (!poses.has(mesh.body)) poses.set(mesh.body, poseOf(track.poses.body(mesh.body, t)));
      this.mesh(mesh, poses.get(mesh.body), skin);
    }
    if (track.heading) {
      const [body, length] = track.heading;
      const pose = poseOf(track.poses.body(body, t));
      for (const part of arrow(length)) this.line(part.map(([x, y]) => moved(pose, [x, y, 0.02 * length])), colour("--ink"), 4, 1.002);
    }
    this.line(wholePath(track), mixed(hue, colour("--card"), 0.6), 2, 1.004);
    this.line(pathUntil(track, t), hue, 5, 1.006);
  }
}

const SphereOf = (radius) => { const [vertices, faces] = SOLIDS.sphere([radius]); return { vertices, faces }; };
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const unit = (a) => { const length = Math.hypot(...a) || 1; return a.map((value) => value / length); };

// Turning by drag and by keys; both pictures of a comparison share the camera.
class Camera {
  constructor(changed) {
    Object.assign(this, { zoom: 1, through: false, changed });
    [this.yaw, this.pitch] = VIEWS.oblique;
  }
  turn(yaw, pitch) {
    this.yaw += yaw;
    this.pitch = Math.min(Math.max(this.pitch + pitch, -1.5), Math.PI / 2 - 0.001);
    this.changed();
  }
  closer(factor) {
    this.zoom = Math.min(Math.max(this.zoom * factor, 0.4), 8);
    this.changed();
  }
  attach(canvas) {
    listen(canvas, {
      move: (dx, dy) => this.turn(-dx * 0.01, dy * 0.01),
      key: (x, y) => this.turn(0.1 * x, -0.1 * y),
      zoom: (factor) => this.closer(factor),
      reset: () => this.view("oblique"),
    });
  }
  view(name) {
    [this.yaw, this.pitch] = VIEWS[name];
    this.zoom = 1;
    this.changed();
  }
  controls() {
    const box = el("input", { type: "checkbox", autocomplete: "off" });
    box.addEventListener("change", () => { this.through = box.checked; this.changed(); });
    return el("p", { class: "camera" }, buttons([
      ["oblique", "View: oblique", () => this.view("oblique")], ["from above", "View: from above", () => this.view("above")],
      ["from the side", "View: from the side", () => this.view("side")],
      ["+", "Closer", () => this.closer(1.25)], ["−", "Farther", () => this.closer(0.8)],
    ]), el("label", {}, box, " see through obstacles"),
    el("small", {}, "drag or arrow keys: turn · wheel, pinch, + and −: zoom · double-click: reset"));
  }
}

STAGES[3] = SpatialStage;
CAMERAS[3] = Camera;
