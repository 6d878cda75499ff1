"use strict";
// The replay and the curves of a run report. `vendor` holds three.js, its orbit control and uPlot.
// What the page shows can be asked of `window.holonom`: ready, state, seek, play, pause, position, discs.

const COLOURS = ["#0b7285", "#d9480f", "#5f3dc4", "#2b8a3e", "#c2255c", "#9c6f00", "#1864ab", "#495057"];
const $ = (id) => document.getElementById(id);
const data = JSON.parse($("data").textContent);

/** Arrays of the page by name: { rows, cols: [Float32Array, ...] }. */
async function unpack() {
  const packed = Uint8Array.from(atob($("blob").textContent), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  const numbers = new Float32Array(await new Response(stream).arrayBuffer());
  const arrays = {};
  for (const [name, [offset, rows, columns]] of Object.entries(data.index)) {
    const cols = [];
    for (let c = 0; c < columns; c++) cols.push(numbers.subarray(offset + c * rows, offset + (c + 1) * rows));
    arrays[name] = { rows, cols };
  }
  return arrays;
}

// ---------------------------------------------------------------- the scene

/** A frame of the recording as a group that follows it. */
class Track {
  constructor(name, array) {
    this.name = name;
    this.array = array;
    this.group = new vendor.Group();
    this.next = new vendor.Quaternion();
  }

  /** Put the group where the frame is at `row`, a sample number with a fraction. */
  place(row) {
    const { rows, cols } = this.array;
    const last = rows - 1;
    const i = Math.min(Math.floor(row), last);
    const j = Math.min(i + 1, last);
    const f = Math.min(row - i, 1);
    const { position, quaternion } = this.group;
    position.set(...[0, 1, 2].map((c) => cols[c][i] + f * (cols[c][j] - cols[c][i])));
    quaternion.set(cols[3][i], cols[4][i], cols[5][i], cols[6][i]);
    quaternion.slerp(this.next.set(cols[3][j], cols[4][j], cols[5][j], cols[6][j]), f);
  }
}

const material = (colour, more) =>
  new vendor.MeshStandardMaterial({ color: colour, roughness: 0.55, metalness: 0.08, ...more });

/** One mesh per kind of shape, in coordinates of its frame. */
const build = {
  tube(shape) {
    const start = new vendor.Vector3(...shape.start);
    const axis = new vendor.Vector3(...shape.end).sub(start);
    const length = axis.length();
    const geometry = shape.rounded
      ? new vendor.CapsuleGeometry(shape.radius, length, 8, 40)
      : new vendor.CylinderGeometry(shape.end_radius ?? shape.radius, shape.radius, length, 48);
    const mesh = new vendor.Mesh(geometry, material(shape.colour));
    mesh.position.copy(start).addScaledVector(axis, 0.5);
    mesh.quaternion.setFromUnitVectors(new vendor.Vector3(0, 1, 0), axis.divideScalar(length));
    return mesh;
  },

  box(shape) {
    const round = Math.min(0.12 * Math.min(...shape.size), 0.02);
    const mesh = new vendor.Mesh(new vendor.RoundedBoxGeometry(...shape.size, 3, round), material(shape.colour));
    setPose(mesh, shape.pose);
    return mesh;
  },

  disc(shape) {
    const side = material(shape.colour, { metalness: 0.35, roughness: 0.5 });
    const geometry = new vendor.CylinderGeometry(shape.radius, shape.radius, shape.thickness, 48);
    geometry.rotateX(Math.PI / 2);
    const photo = shape.pixel && $("photo");
    const top = photo ? pictureOf(shape, geometry, photo) : side;
    const mesh = new vendor.Mesh(geometry, [side, top, side]);
    mesh.userData.frame = shape.frame;
    return mesh;
  },

  label(shape) {
    const canvas = document.createElement("canvas");
    const size = 96;
    const context = canvas.getContext("2d");
    const font = `600 ${size}px system-ui, sans-serif`;
    context.font = font;
    canvas.width = Math.ceil(context.measureText(shape.text).width) + size / 2;
    canvas.height = Math.ceil(1.4 * size);
    Object.assign(context, { font, fillStyle: shape.colour, textAlign: "center", textBaseline: "middle" });
    context.fillText(shape.text, canvas.width / 2, canvas.height / 2);
    const map = new vendor.CanvasTexture(canvas);
    map.colorSpace = vendor.SRGBColorSpace;
    map.anisotropy = 8;
    const height = 1.4 * shape.height;
    const mesh = new vendor.Mesh(
      new vendor.PlaneGeometry((height * canvas.width) / canvas.height, height),
      new vendor.MeshBasicMaterial({ map, transparent: true, depthWrite: false }),
    );
    setPose(mesh, shape.pose);
    mesh.userData.flat = true;
    return mesh;
  },
};

/** The part of the photograph that shows this disc, as the material of its upper face. */
function pictureOf(shape, geometry, photo) {
  const { position, normal, uv } = geometry.attributes;
  const [[ux, uy], [vx, vy]] = shape.pixel_axes;
  for (let i = 0; i < position.count; i++) {
    if (normal.getZ(i) < 0.9) continue;
    const x = position.getX(i), y = position.getY(i);
    const u = shape.pixel[0] + ux * x + uy * y, v = shape.pixel[1] + vx * x + vy * y;
    uv.setXY(i, u / photo.naturalWidth, 1 - v / photo.naturalHeight);
  }
  pictureOf.texture ??= photoTexture(photo);
  return material("#ffffff", { map: pictureOf.texture, metalness: 0 });
}

function photoTexture(photo) {
  const canvas = document.createElement("canvas");
  Object.assign(canvas, { width: photo.naturalWidth, height: photo.naturalHeight });
  canvas.getContext("2d").drawImage(photo, 0, 0);
  const texture = new vendor.CanvasTexture(canvas);
  texture.colorSpace = vendor.SRGBColorSpace;
  texture.anisotropy = 8;
  return texture;
}

/** Pose of a mesh from the rows of a 4 by 4 matrix. */
function setPose(mesh, rows) {
  mesh.matrix.set(...rows.flat());
  mesh.matrix.decompose(mesh.position, mesh.quaternion, mesh.scale);
}

class Stage {
  constructor(arrays) {
    const canvas = $("view");
    this.renderer = new vendor.WebGLRenderer({ canvas, antialias: true, alpha: true });
    this.renderer.shadowMap.enabled = true;
    this.renderer.shadowMap.type = vendor.PCFShadowMap;
    this.renderer.shadowMap.autoUpdate = false; // shadows change with time, not with the camera
    this.scene = new vendor.Scene();
    this.camera = new vendor.PerspectiveCamera(38, 1, 0.02, 30);
    this.camera.up.set(0, 0, 1);
    this.orbit = new vendor.OrbitControls(this.camera, canvas);
    this.orbit.addEventListener("change", () => this.draw());
    this.orbit.maxPolarAngle = 0.49 * Math.PI;
    this.orbit.minDistance = 0.15;
    this.orbit.maxDistance = 6;
    this.tracks = new Map();
    this.discs = [];
    this.light();
    for (const shape of data.scene.shapes) this.add(shape, arrays);
    this.addTrail(arrays[`frame:${data.scene.tool}`]);
    this.addViews();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  light() {
    this.scene.add(new vendor.HemisphereLight("#ffffff", "#c9d2dd", 2.4));
    const sun = new vendor.DirectionalLight("#fff7ea", 2.2);
    sun.position.set(2.0, -1.2, 2.6);
    sun.target.position.set(0.3, 0, 0.3);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.bias = -0.0004;
    sun.shadow.normalBias = 0.004;
    Object.assign(sun.shadow.camera, { left: -1.1, right: 1.1, top: 1.1, bottom: -1.1, near: 0.5, far: 6 });
    this.scene.add(sun, sun.target);
    const floor = new vendor.Mesh(
      new vendor.PlaneGeometry(12, 12), new vendor.ShadowMaterial({ opacity: 0.16 }));
    floor.receiveShadow = true;
    const grid = new vendor.GridHelper(6, 24, "#c3ccd8", "#d9e0e8");
    grid.rotation.x = Math.PI / 2;
    grid.position.z = -0.001;
    this.scene.add(floor, grid);
  }

  add(shape, arrays) {
    const mesh = build[shape.kind](shape);
    mesh.castShadow = mesh.receiveShadow = !mesh.userData.flat;
    this.parent(shape.frame, arrays).add(mesh);
    if (shape.kind === "disc") this.discs.push(mesh);
  }

  parent(frame, arrays) {
    if (frame === "world") return this.scene;
    if (!this.tracks.has(frame)) {
      const track = new Track(frame, arrays[`frame:${frame}`]);
      this.scene.add(track.group);
      this.tracks.set(frame, track);
    }
    return this.tracks.get(frame).group;
  }

  addTrail(array) {
    this.trail = null;
    if (!array) return;
    const [x, y, z] = array.cols;
    const points = new Float32Array(3 * array.rows);
    for (let i = 0; i < array.rows; i++) points.set([x[i], y[i], z[i]], 3 * i);
    const geometry = new vendor.BufferGeometry();
    geometry.setAttribute("position", new vendor.Float32BufferAttribute(points, 3));
    this.trail = new vendor.Line(geometry, new vendor.LineBasicMaterial({ color: "#e8590c" }));
    this.trail.frustumCulled = false;
    this.scene.add(this.trail);
  }

  addViews() {
    for (const view of data.scene.views) {
      const button = Object.assign(document.createElement("button"), { type: "button", textContent: view.name });
      button.onclick = () => this.look(view);
      if (data.scene.views.length > 1) $("views").append(button);
    }
    this.look(data.scene.views[0]);
  }

  look(view) {
    this.camera.position.set(...view.eye);
    this.orbit.target.set(...view.target);
    this.orbit.update();
  }

  resize() {
    const { clientWidth, clientHeight } = $("view");
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    this.renderer.setSize(clientWidth, clientHeight, false);
    this.camera.aspect = clientWidth / clientHeight;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  place(time) {
    const row = time * data.scene.rate;
    for (const track of this.tracks.values()) track.place(row);
    if (this.trail) {
      const first = Math.max(0, Math.floor(row - data.scene.trail * data.scene.rate));
      this.trail.geometry.setDrawRange(first, Math.floor(row) - first + 1);
    }
    this.renderer.shadowMap.needsUpdate = true;
    this.draw();
  }

  draw() { this.renderer.render(this.scene, this.camera); }
}

// ---------------------------------------------------------------- the curves

class Plot {
  constructor(box, arrays, seek) {
    const { curve, time, title, unit } = box.dataset;
    const array = arrays[`curve:${curve}`];
    this.box = box;
    this.hover = false;
    if (!array || !array.rows) { box.remove(); return; }
    this.times = arrays[`time:${time}`].cols[0];
    const heading = document.createElement("h3");
    heading.textContent = title;
    heading.append(Object.assign(document.createElement("small"), { textContent: `  ${unit}` }));
    box.append(heading);
    this.chart = new vendor.uPlot(this.options(), [this.times, ...array.cols], box);
    this.line = Object.assign(document.createElement("div"), { className: "playhead" });
    this.chart.over.append(this.line);
    this.chart.over.addEventListener("mouseenter", () => { this.hover = true; });
    this.chart.over.addEventListener("mouseleave", () => { this.hover = false; });
    this.chart.over.addEventListener("click", (event) => {
      if (!this.dragged(event)) seek(this.chart.posToVal(event.offsetX, "x"));
    });
    this.chart.over.addEventListener("mousedown", (event) => { this.down = event.clientX; });
    new ResizeObserver(() => this.chart.setSize({ width: box.clientWidth, height: 230 })).observe(box);
  }

  dragged(event) { return Math.abs(event.clientX - this.down) > 3; }

  options() {
    const grid = { stroke: "#eceff3", width: 1 };
    const axis = { stroke: "#5b6878", grid, ticks: { show: false }, font: "12px system-ui, sans-serif" };
    const number = (_, value) => (value == null ? "–" : value.toFixed(Math.abs(value) < 10 ? 2 : 1));
    return {
      width: this.box.clientWidth, height: 230,
      scales: { x: { time: false } },
      axes: [
        { ...axis, size: 30, values: (_, ticks) => ticks.map((tick) => `${+tick.toFixed(3)} s`) },
        { ...axis, size: 52 },
      ],
      cursor: { sync: { key: "run", scales: ["x", null] }, points: { size: 6 } },
      series: [
        { label: "t", value: (_, value) => (value == null ? "–" : `${value.toFixed(2)} s`) },
        ...data.joints.map((label, i) => ({
          label, stroke: COLOURS[i % COLOURS.length], width: 1.2, value: number, points: { show: false },
        })),
      ],
      hooks: { setScale: [(chart, key) => { if (key === "x") zoomAll(chart.scales.x); this.mark(); }] },
    };
  }

  /** Move the line of the replay, and the numbers of the legend unless the mouse asks for others. */
  mark(time = this.time) {
    this.time = time;
    if (!this.line || time === undefined) return;
    const at = this.chart.valToPos(time, "x");
    const inside = at >= 0 && at <= this.chart.over.clientWidth;
    this.line.style.display = inside ? "" : "none";
    this.line.style.left = `${at}px`;
    if (!plots.some((plot) => plot.hover)) {
      this.chart.setLegend({ idx: nearest(this.times, time) }, false);
    }
  }
}

const plots = [];

/** All plots show the same stretch of time. */
function zoomAll({ min, max }) {
  for (const { chart } of plots) {
    if (chart && (chart.scales.x.min !== min || chart.scales.x.max !== max)) chart.setScale("x", { min, max });
  }
}

/** Index of the last of the sorted `times` not after `time`, at least 0. */
function nearest(times, time) {
  let low = 0, high = times.length;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time + 1e-6) low = middle; else high = middle;
  }
  return low;
}

// ---------------------------------------------------------------- the replay

class Replay {
  constructor(stage) {
    this.stage = stage;
    this.state = { time: 0, playing: false, speed: 1, end: data.end, event: -1 };
    this.eventTimes = data.events.map((event) => event[0]);
    $("time").max = data.end;
    $("time").oninput = (event) => this.seek(+event.target.value);
    $("play").onclick = () => (this.state.playing ? this.pause() : this.play());
    $("speed").onchange = (event) => { this.state.speed = +event.target.value; };
    for (const row of document.querySelectorAll(".events tbody tr")) row.onclick = () => this.seek(+row.dataset.time);
    this.addTicks();
    this.seek(0);
  }

  addTicks() {
    for (const [time, , level] of data.events) {
      const tick = document.createElement("i");
      tick.className = level;
      tick.style.left = `calc(8px + (100% - 16px) * ${time / (data.end || 1)})`;
      $("ticks").append(tick);
    }
  }

  play() {
    if (this.state.time >= data.end) this.seek(0);
    this.state.playing = true;
    $("play").textContent = "❚❚";
    this.last = performance.now();
    requestAnimationFrame(() => this.step());
  }

  pause() {
    this.state.playing = false;
    $("play").textContent = "▶";
  }

  step() {
    if (!this.state.playing) return;
    const now = performance.now();
    const time = this.state.time + (this.state.speed * (now - this.last)) / 1000;
    this.last = now;
    this.seek(time);
    if (time >= data.end) this.pause();
    else requestAnimationFrame(() => this.step());
  }

  /** Show the run at `time`, in s. */
  seek(time) {
    this.state.time = Math.min(Math.max(time, 0), data.end);
    this.stage.place(this.state.time);
    for (const plot of plots) plot.mark(this.state.time);
    $("time").value = this.state.time;
    $("clock").textContent = `${this.state.time.toFixed(2)} / ${data.end.toFixed(2)} s`;
    this.showTool();
    this.showEvent();
  }

  showTool() {
    const track = this.stage.tracks.get(data.scene.tool);
    if (!track) return;
    const { x, y, z } = track.group.position;
    $("tool").textContent = [x, y, z].map((value) => (1000 * value).toFixed(1)).join(" · ") + " mm";
    const { rows, cols } = track.array;
    const i = Math.max(1, Math.min(Math.round(this.state.time * data.scene.rate), rows - 1));
    const step = rows > 1 ? Math.hypot(...[0, 1, 2].map((c) => cols[c][i] - cols[c][i - 1])) : 0;
    $("pace").textContent = `${(1000 * step * data.scene.rate).toFixed(0)} mm/s`;
  }

  showEvent() {
    const times = this.eventTimes;
    const at = times.length && times[0] <= this.state.time + 1e-6 ? nearest(times, this.state.time) : -1;
    if (at === this.state.event) return;
    this.state.event = at;
    const [, line, , text] = at < 0 ? [0, 0, "", "–"] : data.events[at];
    $("event").textContent = text;
    const rows = document.querySelectorAll(".events tbody tr");
    mark(rows, rows[at], document.querySelector("#log .scroll"));
    const lines = document.querySelectorAll("#program li");
    mark(lines, line ? lines[line - 1] : null, $("program"));
  }
}

/** Make `one` of the elements the current one, and bring it into sight within its box. */
function mark(all, one, box) {
  for (const element of all) element.classList.toggle("current", element === one);
  if (!one || !box) return;
  const above = one.offsetTop - 40, below = one.offsetTop + one.offsetHeight + 40 - box.clientHeight;
  if (box.scrollTop > above) box.scrollTop = above;
  else if (box.scrollTop < below) box.scrollTop = below;
}

/** A part under the mouse lights up on the photograph, in the table of parts and in the scene. */
function linkParts(stage) {
  const elements = [...document.querySelectorAll("#photograph [data-frame]")];
  const light = (frame) => {
    for (const element of elements) element.classList.toggle("lit", element.dataset.frame === frame);
    for (const disc of stage.discs) {
      for (const one of disc.material) one.emissive.set(disc.userData.frame === frame ? "#c77700" : "#000000");
    }
    stage.draw();
  };
  for (const element of elements) {
    element.onmouseenter = () => light(element.dataset.frame);
    element.onmouseleave = () => light("");
  }
}

// ---------------------------------------------------------------- start

async function start() {
  const arrays = await unpack();
  const photo = $("photo");
  if (photo) await photo.decode();
  const stage = new Stage(arrays);
  let replay = null;
  for (const box of document.querySelectorAll(".plot")) {
    plots.push(new Plot(box, arrays, (time) => replay.seek(time)));
  }
  replay = new Replay(stage);
  linkParts(stage);
  $("empty").hidden = stage.tracks.size > 0;
  return { stage, replay };
}

const ready = start().then(({ stage, replay }) => {
  Object.assign(window.holonom, {
    state: replay.state,
    discs: stage.discs.length,
    seek: (time) => replay.seek(time),
    play: () => replay.play(),
    pause: () => replay.pause(),
    look: (eye, target) => stage.look({ eye, target }),
    position: (frame) => stage.tracks.get(frame).group.position.toArray(),
    visible: (frame) => stage.discs.some((disc) => disc.userData.frame === frame && disc.visible),
  });
  return true;
});
window.holonom = { ready };
