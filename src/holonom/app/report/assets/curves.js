// The curves, tied to the time of the replay.

class Plot {
  constructor(box, arrays, seek) {
    const { key, title, unit, names, time } = data.curves.find((curve) => curve.key === box.dataset.curve);
    this.box = box;
    this.names = names;
    this.hover = false;
    this.times = arrays[time].cols[0];
    const heading = document.createElement("h3");
    heading.textContent = title;
    heading.append(Object.assign(document.createElement("small"), { textContent: `  ${unit}` }));
    box.append(heading);
    this.chart = new vendor.uPlot(this.options(), [this.times, ...arrays[`curve:${key}`].cols], box);
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
    const grid = { stroke: () => ink("--line"), width: 1 };
    const axis = { stroke: () => ink("--soft"), grid, ticks: { show: false }, font: "12px system-ui, sans-serif" };
    const short = (value) => (Math.abs(value) < 10 ? (value !== 0 && Math.abs(value) < 0.1 ? `${+value.toPrecision(2)}` : value.toFixed(2)) : value.toFixed(1));
    const number = (_, value) => (value == null ? "–" : short(value).replace(/^-(0\.0+)$/, "$1"));
    return {
      width: this.box.clientWidth, height: 230,
      scales: { x: { time: false }, y: { range: (_, low, high) => room(low, high) } },
      axes: [
        { ...axis, size: 30, space: 62, values: (_, ticks) => ticks.map((tick) => `${+tick.toFixed(3)} s`) },
        { ...axis, size: 58, values: (_, ticks) => ticks.map((tick) => `${+tick.toPrecision(6)}`) },
      ],
      cursor: { sync: { key: "run", scales: ["x", null] }, points: { size: 6 } },
      series: [
        { label: "t", value: (_, value) => (value == null ? "–" : `${value.toFixed(2)} s`) },
        ...this.names.map((label, i) => ({
          label, stroke: () => hue(i), width: 1.2, value: number, points: { show: false },
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

/** What an axis shows of values from `low` to `high`; of those that stay as they are, one to either side. */
function room(low, high) {
  if (low == null || high - low < 1e-9) return [(low ?? 0) - 1, (high ?? 0) + 1];
  return vendor.uPlot.rangeNum(low, high, 0.1, true);
}

const dark = window.matchMedia("(prefers-color-scheme: dark)");
dark.addEventListener("change", () => { for (const { chart } of plots) chart.redraw(); });

/** A colour of the page's style. */
function ink(name) { return getComputedStyle(document.documentElement).getPropertyValue(name).trim(); }

/** Colour of the i-th line. */
function hue(i) { return (dark.matches ? BRIGHT : COLOURS)[i % COLOURS.length]; }

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
