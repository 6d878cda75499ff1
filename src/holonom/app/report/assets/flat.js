// What the replay shows without WebGL: the same shapes on a flat canvas, seen from above and from the side.

const PANES = [
  { name: "from above", right: 0, up: 1, toward: 2 },
  { name: "from the side", right: 0, up: 2, toward: 1, sign: -1 },
];
const AXES = ["x", "y", "z"];

class Flat {
  constructor(arrays) {
    const old = $("view");
    this.canvas = old.cloneNode(false); // one that no other context was asked of
    old.replaceWith(this.canvas);
    this.context = this.canvas.getContext("2d");
    this.discs = data.scene.shapes.filter((shape) => shape.kind === "disc");
    this.lit = "";
    this.tracks = new Map();
    this.shapes = data.scene.shapes.map((shape) => ({ ...shape, track: this.track(shape.frame, arrays), parts: solids(shape) }));
    this.trail = this.track(data.scene.tool, arrays);
    this.sticks = data.scene.shapes.length ? [] : [...this.tracks.values()];
    this.room = this.measure();
    this.row = 0;
    $("hint").textContent = "no WebGL in this browser: seen from above and from the side";
    this.canvas.style.cursor = "default";
    new ResizeObserver(() => this.draw()).observe(this.canvas);
  }

  track(frame, arrays) {
    if (frame === "world" || !arrays[`frame:${frame}`]) return null;
    if (!this.tracks.has(frame)) this.tracks.set(frame, new Track(frame, arrays[`frame:${frame}`]));
    return this.tracks.get(frame);
  }

  /** Corners of what is ever shown: shapes where they stand at a few moments. */
  measure() {
    const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
    const rows = Math.max(1, ...[...this.tracks.values()].map((track) => track.array.rows));
    for (let k = 0; k <= 24; k++) {
      for (const track of this.tracks.values()) track.place(((rows - 1) * k) / 24);
      for (const { points, ground } of this.solids()) {
        for (const point of ground ? [] : points) {
          for (let c = 0; c < 3; c++) {
            low[c] = Math.min(low[c], point[c]);
            high[c] = Math.max(high[c], point[c]);
          }
        }
      }
    }
    return low[0] > high[0] ? { low: [-1, -1, 0], high: [1, 1, 1] } : { low, high };
  }

  /** Everything in the world: { points, radius, colour, kind, text, lit }. */
  solids() {
    const found = [];
    for (const { track, parts, kind, frame } of this.shapes) {
      if (track) track.group.updateMatrix();
      for (const part of parts) {
        const points = part.points.map((p) => {
          const v = new vendor.Vector3(...p);
          return (track ? v.applyMatrix4(track.group.matrix) : v).toArray();
        });
        found.push({ ...part, points, kind, lit: frame === this.lit });
      }
    }
    for (const track of this.sticks) found.push({ points: [track.group.position.toArray()], radius: 0.02, colour: COLOURS[0], kind: "tube" });
    return found;
  }

  place(time) {
    this.row = time * data.scene.rate;
    for (const track of this.tracks.values()) track.place(this.row);
    this.draw();
  }

  look() {}

  light(frame) { this.lit = frame; }

  shows(frame) { return this.discs.some((disc) => disc.frame === frame); }

  draw() {
    const { clientWidth, clientHeight } = this.canvas, ratio = Math.min(window.devicePixelRatio, 2);
    if (!clientWidth) return;
    this.canvas.width = clientWidth * ratio;
    this.canvas.height = clientHeight * ratio;
    this.context.scale(ratio, ratio);
    const solids = this.solids(), wide = clientWidth > 620;
    PANES.forEach((pane, k) => {
      const box = wide
        ? { x: (k * clientWidth) / 2, y: 0, w: clientWidth / 2, h: clientHeight }
        : { x: 0, y: (k * clientHeight) / 2, w: clientWidth, h: clientHeight / 2 };
      this.pane(pane, box, solids);
    });
  }

  pane(pane, box, solids) {
    const c = this.context, { low, high } = this.room, { right, up, toward, sign = 1 } = pane;
    const spans = [right, up].map((axis) => Math.max(high[axis] - low[axis], 0.05));
    const scale = Math.min((box.w - 70) / spans[0], (box.h - 130) / spans[1]);
    const x0 = box.x + box.w / 2 - (scale * (low[right] + high[right])) / 2;
    const y0 = box.y + box.h / 2 - 6 + (scale * (low[up] + high[up])) / 2;
    const at = (p) => [x0 + scale * p[right], y0 - scale * p[up]];
    c.save();
    c.beginPath();
    c.rect(box.x, box.y, box.w, box.h);
    c.clip();
    const ticks = [this.ticks(right, scale), this.ticks(up, scale)];
    this.grid(pane, box, at, ticks);
    const depth = (solid) => sign * Math.max(...solid.points.map((p) => p[toward]));
    for (const solid of [...solids].sort((a, b) => depth(a) - depth(b))) this.solid(solid, at, scale, pane);
    this.way(at);
    this.numbers(pane, box, at, ticks);
    c.restore();
  }

  /** Round metres along an axis, far enough apart to be written. */
  ticks(axis, scale) {
    const { low, high } = this.room, found = [];
    const step = [0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100].find((s) => s * scale >= 56) ?? 200;
    for (let v = Math.ceil(low[axis] / step) * step; v <= high[axis] + 1e-9; v += step) found.push(v);
    return found;
  }

  grid({ right, up }, box, at, [across, upwards]) {
    const { low } = this.room;
    Object.assign(this.context, { strokeStyle: ink("--line"), lineWidth: 1 });
    for (const v of across) {
      const [x] = at({ [right]: v, [up]: low[up] });
      this.stroke([[x, box.y + 44], [x, box.y + box.h - 56]]);
    }
    for (const v of upwards) {
      const [, y] = at({ [right]: low[right], [up]: v });
      this.stroke([[box.x + 50, y], [box.x + box.w - 8, y]]);
    }
  }

  numbers({ name, right, up }, box, at, [across, upwards]) {
    const c = this.context, { low } = this.room, number = (value) => `${+value.toFixed(2)} m`;
    const write = (text, x, y) => { c.strokeText(text, x, y); c.fillText(text, x, y); };
    Object.assign(c, { fillStyle: ink("--text"), strokeStyle: ink("--inset"), lineWidth: 3, lineJoin: "round" });
    Object.assign(c, { font: "11px system-ui, sans-serif", textBaseline: "middle", textAlign: "center" });
    for (const v of across) write(number(v), at({ [right]: v, [up]: low[up] })[0], box.y + box.h - 46);
    c.textAlign = "left";
    for (const v of upwards) write(number(v), box.x + 6, at({ [right]: low[right], [up]: v })[1]);
    c.font = "600 12px system-ui, sans-serif";
    write(`${name}: ${AXES[right]} to the right, ${AXES[up]} up`, box.x + 16, box.y + 22);
  }

  stroke(points) {
    this.context.beginPath();
    points.forEach(([x, y], k) => (k ? this.context.lineTo(x, y) : this.context.moveTo(x, y)));
    this.context.stroke();
  }

  solid({ points, radius, colour, kind, text, lit }, at, scale, pane) {
    const c = this.context, flat = points.map(at);
    Object.assign(c, { fillStyle: lit ? "#c77700" : colour, strokeStyle: "#33415c66", lineWidth: 1, lineCap: "round", lineJoin: "round" });
    if (kind === "label") {
      if (pane.up !== 1) return;
      Object.assign(c, { font: `600 ${Math.max(9, radius * scale)}px system-ui, sans-serif`, textAlign: "center" });
      c.fillText(text, ...flat[0]);
      return;
    }
    if (radius) { // a bar as thick as it is, with its edge
      const r = Math.max(radius * scale, 1);
      for (const [width, style] of [[2 * r + 1.5, "#33415c88"], [2 * r, c.fillStyle]]) {
        Object.assign(c, { lineWidth: width, strokeStyle: style });
        this.stroke(flat.length > 1 ? flat : [flat[0], flat[0]]);
      }
      return;
    }
    c.beginPath();
    hull(flat).forEach(([x, y], k) => (k ? c.lineTo(x, y) : c.moveTo(x, y)));
    c.closePath();
    c.fill();
    c.stroke();
  }

  way(at) {
    if (!this.trail) return;
    const { cols, rows } = this.trail.array, last = Math.min(Math.floor(this.row), rows - 1);
    const first = Math.max(0, Math.floor(this.row - data.scene.trail * data.scene.rate)), points = [];
    for (let i = first; i <= last; i++) points.push(at([cols[0][i], cols[1][i], cols[2][i]]));
    Object.assign(this.context, { strokeStyle: "#e8590c", lineWidth: 1.5 });
    if (points.length) this.stroke(points);
  }
}

/** A shape as points in its frame whose hull, or joining bar, is what is seen of it. */
function solids(shape) {
  const { kind, colour } = shape;
  if (kind === "tube") {
    const start = new vendor.Vector3(...shape.start), end = new vendor.Vector3(...shape.end);
    if (shape.rounded) return [{ points: [shape.start, shape.end], radius: shape.radius, colour }];
    return [{ points: rings(start, end, shape.radius, shape.end_radius ?? shape.radius), colour }];
  }
  if (kind === "box") {
    const points = [];
    for (const x of [-0.5, 0.5]) for (const y of [-0.5, 0.5]) for (const z of [-0.5, 0.5]) {
      points.push(moved(shape.pose, [x * shape.size[0], y * shape.size[1], z * shape.size[2]]));
    }
    return [{ points, colour, ground: shape.frame === "world" && shape.pose[2][3] < 0 }];
  }
  if (kind === "disc") {
    const half = new vendor.Vector3(0, 0, shape.thickness / 2);
    return [{ points: rings(half.clone().negate(), half, shape.radius, shape.radius), colour }];
  }
  return [{ points: [moved(shape.pose, [0, 0, 0])], radius: shape.height, colour, text: shape.text }];
}

/** Points on the two rims of a short bar. */
function rings(start, end, r1, r2) {
  const axis = end.clone().sub(start).normalize();
  const turn = new vendor.Quaternion().setFromUnitVectors(new vendor.Vector3(0, 0, 1), axis);
  const points = [];
  for (const [middle, r] of [[start, r1], [end, r2]]) {
    for (let k = 0; k < 20; k++) {
      const a = (2 * Math.PI * k) / 20;
      points.push(new vendor.Vector3(r * Math.cos(a), r * Math.sin(a), 0).applyQuaternion(turn).add(middle).toArray());
    }
  }
  return points;
}

function moved(T, [x, y, z]) {
  return [0, 1, 2].map((i) => T[i][0] * x + T[i][1] * y + T[i][2] * z + T[i][3]);
}

/** The convex hull of points on the page (monotone chain). */
function hull(points) {
  const sorted = [...points].sort((a, b) => a[0] - b[0] || a[1] - b[1]);
  const cross = (o, a, b) => (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0]);
  const half = (all) => {
    const chain = [];
    for (const p of all) {
      while (chain.length > 1 && cross(chain.at(-2), chain.at(-1), p) <= 0) chain.pop();
      chain.push(p);
    }
    return chain.slice(0, -1);
  };
  return sorted.length < 3 ? sorted : [...half(sorted), ...half(sorted.reverse())];
}
