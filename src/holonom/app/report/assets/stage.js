"use strict";
// What the replay shows: frames that move as recorded, with shapes in them. `vendor` holds three.js, its orbit
// control and uPlot. The page runs stage.js, flat.js, curves.js and replay.js as one script.

const COLOURS = ["#0b7285", "#d9480f", "#5f3dc4", "#2b8a3e", "#c2255c", "#9c6f00", "#1864ab", "#495057"];
const BRIGHT = ["#3bc9db", "#ff922b", "#b197fc", "#69db7c", "#f783ac", "#ffd43b", "#74c0fc", "#ced4da"];
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
    const room = Math.max(1, data.scene.extent / 4); // a wide room needs farther eyes, of which near things suffer
    this.camera = new vendor.PerspectiveCamera(38, 1, 0.02 * room, 30 * room);
    this.camera.up.set(0, 0, 1);
    this.orbit = new vendor.OrbitControls(this.camera, canvas);
    this.orbit.addEventListener("change", () => this.draw());
    this.orbit.maxPolarAngle = 0.49 * Math.PI;
    this.orbit.minDistance = 0.15;
    this.orbit.maxDistance = 5.5 * data.scene.extent;
    this.tracks = new Map();
    this.discs = [];
    this.addLights();
    for (const shape of data.scene.shapes) this.add(shape, arrays);
    for (const name of [data.scene.tool, ...data.scene.views.map((view) => view.follow)]) {
      if (arrays[`frame:${name}`]) this.parent(name, arrays); // nothing may be drawn in it
    }
    this.addTrail(arrays[`frame:${data.scene.tool}`]);
    this.addViews();
    new ResizeObserver(() => this.resize()).observe(canvas);
    this.resize();
  }

  addLights() {
    this.scene.add(new vendor.HemisphereLight("#ffffff", "#c9d2dd", 2.4));
    const sun = new vendor.DirectionalLight("#fff7ea", 2.2);
    const reach = data.scene.extent;
    sun.position.set(0.3 + 1.7 * reach, -1.2 * reach, 0.3 + 2.3 * reach);
    sun.target.position.set(0.3, 0, 0.3);
    sun.castShadow = true;
    sun.shadow.mapSize.set(2048, 2048);
    sun.shadow.bias = -0.0004;
    sun.shadow.normalBias = 0.004;
    Object.assign(sun.shadow.camera, { left: -reach, right: reach, top: reach, bottom: -reach, near: 0.4, far: 5.5 * reach });
    this.scene.add(sun, sun.target);
    const wide = Math.max(6, 2 * Math.ceil(data.scene.extent));
    const floor = new vendor.Mesh(
      new vendor.PlaneGeometry(wide * 2, wide * 2), new vendor.ShadowMaterial({ opacity: 0.16 }));
    floor.receiveShadow = true;
    const grid = new vendor.GridHelper(wide, wide > 6 ? wide : 24, ...(dark.matches ? ["#46566b", "#36445a"] : ["#c3ccd8", "#d9e0e8"]));
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
    this.followed = view.follow ? this.tracks.get(view.follow) : null;
    this.at = new vendor.Vector3();
    this.goAlong();
    this.orbit.update();
  }

  /** Move camera and target as far as the followed frame went. */
  goAlong() {
    if (!this.followed) return;
    const way = this.followed.group.position.clone().sub(this.at);
    this.at.copy(this.followed.group.position);
    this.camera.position.add(way);
    this.orbit.target.add(way);
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
    this.goAlong();
    if (this.trail) {
      const first = Math.max(0, Math.floor(row - data.scene.trail * data.scene.rate));
      this.trail.geometry.setDrawRange(first, Math.floor(row) - first + 1);
    }
    this.renderer.shadowMap.needsUpdate = true;
    this.draw();
  }

  /** The part in this frame lights up, others do not. */
  light(frame) {
    for (const disc of this.discs) {
      for (const one of disc.material) one.emissive.set(disc.userData.frame === frame ? "#c77700" : "#000000");
    }
  }

  shows(frame) { return this.discs.some((disc) => disc.userData.frame === frame && disc.visible); }

  draw() { this.renderer.render(this.scene, this.camera); }
}
