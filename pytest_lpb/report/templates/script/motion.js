// Poses between the recorded ones.

// Row before a time, and how far it lies towards the next one.
function between(times, t) {
  let low = 0, high = times.length - 1;
  if (high < 1 || t <= times[0]) return [0, 0];
  if (t >= times[high]) return [high - 1, 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= t) low = middle; else high = middle;
  }
  return [low, (t - times[low]) / (times[high] - times[low])];
}
const blended = (column, [row, share]) => (column.length < 2 ? column[0] : column[row] * (1 - share) + column[row + 1] * share);

// Where bodies are: `at` and `turn` are columns, body after body.
class Poses {
  constructor(data, times, dimension) {
    this.times = times;
    this.at = columns(data.at);
    this.turn = columns(data.turn);
    this.dimension = dimension;
  }
  // [x, y, angle], or [x, y, z, and a unit quaternion wxyz].
  body(number, t) {
    const place = between(this.times, t);
    const sizes = this.dimension === 2 ? [2, 1] : [3, 4];
    const take = (list, size) => list.slice(number * size, (number + 1) * size).map((column) => blended(column, place));
    const turn = take(this.turn, sizes[1]);
    const length = this.dimension === 2 ? 1 : Math.hypot(...turn) || 1;
    return [...take(this.at, sizes[0]), ...turn.map((value) => value / length)];
  }
}

async function loadScene(key) {
  const data = await unpack(key);
  return {
    dimension: data.dimension, low: data.low, high: data.high,
    obstacles: data.obstacles.map((obstacle) => {
      const count = obstacle.at.n;
      const times = Float64Array.from({ length: count }, (_, row) => (count > 1 ? obstacle.duration * row / (count - 1) : 0));
      return { name: obstacle.name, parts: obstacle.parts, poses: new Poses(obstacle, times, data.dimension) };
    }),
    goal: data.goal && { tolerance: data.goal.tolerance, t: columns(data.goal.t)[0], at: columns(data.goal.at) },
  };
}

// Target of the goal at a time; NaN along axes it says nothing of.
const goalAt = (goal, t) => goal.at.map((column) => blended(column, between(goal.t, t)));

// A trial ready to be drawn and plotted.
async function loadTrack(place, style, trial) {
  const data = await unpack("trial:" + place);
  const scene = await loadScene(data.scene);
  return {
    trial, style, scene, end: data.end, low: data.low, high: data.high, touched: data.touched,
    contact: data.contact, more: data.more, ...(await unpack(data.robot)),
    poses: new Poses(data, columns(data.t)[0], scene.dimension),
    path: { t: columns(data.path.t)[0], at: columns(data.path.at) },
    charts: data.charts.map((chart) => ({
      ...chart, lines: chart.lines.map((line) => ({ ...line, step: line.v.s, t: columns(line.t)[0], v: columns(line.v)[0] })),
    })),
  };
}

// Points of a path up to a time, the last one where it is then.
function pathUntil(track, t) {
  const points = [];
  for (let row = 0; row < track.path.t.length && track.path.t[row] <= t; row += 1) points.push(track.path.at.map((column) => column[row]));
  points.push(track.path.at.map((column) => blended(column, between(track.path.t, t))));
  return points;
}
const wholePath = (track) => Array.from(track.path.t, (_, row) => track.path.at.map((column) => column[row]));

// Corners of what all tracks need.
function boxOf(tracks) {
  const low = tracks[0].low.map((_, axis) => Math.min(...tracks.map((track) => track.low[axis])));
  const high = tracks[0].high.map((_, axis) => Math.max(...tracks.map((track) => track.high[axis])));
  return [low, high];
}

// Whether a trial just ended at an obstacle; beside a longer trial the obstacle moves on.
const struckAt = (obstacle, tracks, t) => tracks.some((track) =>
  track.touched === obstacle.name && t >= track.end - 1e-9 && t < track.end + 0.5);
