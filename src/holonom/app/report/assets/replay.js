// The replay, and the start of it all.
// What the page shows can be asked of `window.holonom`: ready, state, seek, play, pause, look, position, discs.

class Replay {
  constructor(stage) {
    this.stage = stage;
    this.state = { time: 0, playing: false, speed: 1, end: data.end, event: -1 };
    this.eventTimes = data.events.map((event) => event[0]);
    $("time").max = data.end;
    $("time").oninput = (event) => this.seek(+event.target.value);
    $("play").onclick = () => (this.state.playing ? this.pause() : this.play());
    $("speed").onchange = (event) => { this.state.speed = +event.target.value; };
    this.rows = new Map();
    for (const row of document.querySelectorAll(".events tbody tr")) {
      this.rows.set(+row.dataset.row, row);
      row.onclick = () => this.seek(+row.dataset.time);
    }
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
    for (const id of ["tool", "pace"]) $(id).parentElement.hidden = !track;
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
    const [, , , text, robot] = at < 0 ? [0, 0, "", "–", ""] : data.events[at];
    $("event").textContent = robot ? `${robot}: ${text}` : text;
    this.showLines(at);
    const row = at < 0 ? undefined : this.rows.get(data.events[at][5]);
    mark(this.rows.values(), row, row?.closest(".scroll"));
  }

  /** In each program the line of its robot's last event. */
  showLines(at) {
    for (const program of document.querySelectorAll(".program ol")) {
      let k = at;
      while (k >= 0 && !(data.events[k][1] && data.events[k][4] === program.dataset.robot)) k--;
      const lines = program.querySelectorAll("li");
      mark(lines, k < 0 ? null : lines[data.events[k][1] - 1], program);
    }
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
    stage.light(frame);
    stage.draw();
  };
  for (const element of elements) {
    element.onmouseenter = () => light(element.dataset.frame);
    element.onmouseleave = () => light("");
  }
}

/** The replay; without WebGL a flat one. */
function makeStage(arrays) {
  const solid = document.createElement("canvas").getContext("webgl2");
  solid?.getExtension("WEBGL_lose_context")?.loseContext();
  const stage = solid ? new Stage(arrays) : new Flat(arrays);
  $("empty").hidden = stage.tracks.size > 0;
  return stage;
}

async function start() {
  const arrays = await unpack();
  const photo = $("photo");
  if (photo) await photo.decode();
  const stage = makeStage(arrays);
  let replay = null;
  for (const box of document.querySelectorAll(".plot")) {
    plots.push(new Plot(box, arrays, (time) => replay.seek(time)));
  }
  replay = new Replay(stage);
  linkParts(stage);
  return { stage, replay };
}

const ready = start().then(({ stage, replay }) => {
  Object.assign(window.holonom, {
    state: replay.state,
    discs: stage.discs.length,
    flat: stage instanceof Flat,
    seek: (time) => replay.seek(time),
    play: () => replay.play(),
    pause: () => replay.pause(),
    look: (eye, target) => stage.look({ eye, target }),
    position: (frame) => stage.tracks.get(frame).group.position.toArray(),
    visible: (frame) => stage.shows(frame),
  });
  return true;
});
window.holonom = { ready };
