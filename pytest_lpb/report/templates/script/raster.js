// Triangles and lines with a depth buffer, in plain arithmetic: the same picture in every browser, without a graphics
// card. Points are [x, y, w] with x and y in pixels and w the inverse depth, larger when nearer.
class Raster {
  constructor(width, height) {
    Object.assign(this, { width, height });
    this.image = new ImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.depth = new Float32Array(width * height);
  }

  static word([red, green, blue]) {
    return (255 << 24) | (blue << 16) | (green << 8) | red;
  }

  clear(rgb) {
    this.pixels.fill(Raster.word(rgb));
    this.depth.fill(0);
  }

  // `sparse`: every second pixel, which two pixels per dot of the screen make half transparent.
  triangle(a, b, c, word, sparse) {
    const { width, height, depth, pixels } = this;
    const area = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
    if (area === 0) return;
    const alongX = ((b[2] - a[2]) * (c[1] - a[1]) - (c[2] - a[2]) * (b[1] - a[1])) / area;
    const alongY = ((c[2] - a[2]) * (b[0] - a[0]) - (b[2] - a[2]) * (c[0] - a[0])) / area;
    const top = Math.max(0, Math.ceil(Math.min(a[1], b[1], c[1]) - 0.5));
    const bottom = Math.min(height - 1, Math.floor(Math.max(a[1], b[1], c[1]) - 0.5));
    for (let row = top; row <= bottom; row += 1) {
      const y = row + 0.5;
      let left = Infinity, right = -Infinity;
      for (const [p, q] of [[a, b], [b, c], [c, a]]) {
        if ((p[1] <= y) === (q[1] <= y)) continue;
        const x = p[0] + (y - p[1]) * (q[0] - p[0]) / (q[1] - p[1]);
        if (x < left) left = x;
        if (x > right) right = x;
      }
      const first = Math.max(0, Math.ceil(left - 0.5)), last = Math.min(width - 1, Math.floor(right - 0.5));
      let w = a[2] + alongX * (first + 0.5 - a[0]) + alongY * (y - a[1]);
      for (let column = first, at = row * width + first; column <= last; column += 1, at += 1, w += alongX) {
        if (w > depth[at] && !(sparse && (row + column) & 1)) {
          depth[at] = w;
          pixels[at] = word;
        }
      }
    }
  }

  line(a, b, word, thickness, nearer = 1.002) {
    const { width, height, depth, pixels } = this;
    const steps = Math.ceil(Math.max(Math.abs(b[0] - a[0]), Math.abs(b[1] - a[1]), 1));
    if (steps > 20000) return;
    const reach = thickness / 2;
    for (let step = 0; step <= steps; step += 1) {
      const share = step / steps;
      const x = a[0] + (b[0] - a[0]) * share, y = a[1] + (b[1] - a[1]) * share;
      const w = (a[2] + (b[2] - a[2]) * share) * nearer;
      for (let row = Math.max(0, Math.round(y - reach)); row < Math.min(height, Math.round(y + reach)); row += 1) {
        for (let column = Math.max(0, Math.round(x - reach)); column < Math.min(width, Math.round(x + reach)); column += 1) {
          const at = row * width + column;
          if (w > depth[at]) { depth[at] = w; pixels[at] = word; }
        }
      }
    }
  }
}
