// A recording drawn over time by uPlot, with two cursors, or one channel over another.
import { h } from "./dom.js";

export const COLOURS = { light: ["#0b5a8f", "#a3161c", "#12652f", "#6a1b9a", "#7a4b00", "#00646e", "#b1006b", "#454f00"], dark: ["#6cb8ee", "#ff9a97", "#7fdc9c", "#dcb0f5", "#ffc966", "#6fdde8", "#ff8fd0", "#d4e157"] };
let loaded = null;

export function load() {
  loaded ??= new Promise((resolve, reject) => {
    document.head.append(h("link", { rel: "stylesheet", href: "/static/vendor/uplot/uPlot.min.css" }));
    const script = h("script", { src: "/static/vendor/uplot/uPlot.iife.min.js" });
    script.onload = () => resolve(window.uPlot);
    script.onerror = reject;
    document.head.append(script);
  });
  return loaded;
}

export const dark = () => document.documentElement.dataset.theme === "dark";
export const colour = (n) => { const list = COLOURS[dark() ? "dark" : "light"]; return list[n % list.length]; };
const style = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

// A file of `axisgate scope`: a line of JSON, then float64 rows, time first.
export function parse(buffer) {
  const bytes = new Uint8Array(buffer);
  const end = bytes.indexOf(10);
  const head = JSON.parse(new TextDecoder().decode(bytes.subarray(0, end)));
  const width = head.channels.length + 1;
  const body = buffer.slice(end + 1);
  const rows = new Float64Array(body, 0, Math.floor(body.byteLength / 8 / width) * width);
  const count = rows.length / width;
  const columns = Array.from({ length: width }, (_, c) => { const column = new Float64Array(count); for (let n = 0; n < count; n += 1) column[n] = rows[n * width + c]; return column; });
  return { ...head, time: columns[0], columns: columns.slice(1) };
}

export class Plot {
  constructor(box, moved) {
    this.box = box;
    this.moved = moved;
    this.cursors = [null, null];
    this.watch = new ResizeObserver(() => this.plot?.setSize({ width: box.clientWidth, height: this.height() }));
    this.watch.observe(box);
  }

  height() { return Math.max(260, Math.min(460, Math.round(innerHeight * 0.48))); }

  // channels: [[name, unit]]; columns: values of each; shown: which of them; scales: { joint: one scale a unit, ranges: name -> [from, to] }.
  async show(channels, time, columns, shown, scales = { joint: true, ranges: {} }) {
    const mine = (this.wanted = Symbol("drawing"));
    const uPlot = await load();
    if (mine !== this.wanted || !this.box.isConnected) return;
    const made = JSON.stringify([channels, shown, scales, dark(), this.box.clientWidth > 700]);
    if (this.plot && this.made === made && this.rolls) { this.plot.setData([time, ...columns]); this.time = time; return; }
    this.made = made;
    const fixed = (name) => scales.ranges[name] || [null, null];
    const own = (name) => !scales.joint || fixed(name).some((end) => end !== null);
    const key = channels.map(([name, unit], n) => (own(name) ? `c${n}` : unit || "1"));
    const ranges = Object.fromEntries(channels.flatMap(([name], n) => (own(name) ? [[key[n], { range: (u, low, high) => range(fixed(name), low, high) }]] : [])));
    const axis = { stroke: style("--text"), grid: { stroke: style("--line") }, ticks: { stroke: style("--line") }, font: "12px system-ui, sans-serif" };
    const first = [...new Set(channels.map((_, n) => n).filter((n) => shown[n] && (own(channels[n][0]) || key.findIndex((other, m) => other === key[n] && shown[m]) === n)))].slice(0, this.box.clientWidth > 700 ? 4 : 2);
    const title = (n) => (own(channels[n][0]) ? `${channels[n][0]}${channels[n][1] ? `, ${channels[n][1]}` : ""}` : channels[n][1] || "1");
    this.plot?.destroy();
    this.plot = new uPlot({
      width: this.box.clientWidth || 600, height: this.height(), ms: 1e-3, scales: { x: { time: false }, ...ranges }, legend: { show: false },
      cursor: { drag: { x: true, y: false } },
      series: [{}, ...channels.map(([name], n) => ({ label: name, scale: key[n], stroke: colour(n), width: 1.6, show: shown[n], points: { show: false } }))],
      axes: [{ ...axis, label: "s", labelSize: 20 }, ...first.map((n, place) => ({ ...axis, scale: key[n], side: place % 2 ? 1 : 3, size: 60, label: title(n), labelSize: 20, labelFont: "12px system-ui, sans-serif", stroke: own(channels[n][0]) ? colour(n) : style("--text"), grid: { show: !place, stroke: style("--line") } }))],
      hooks: { draw: [(plot) => this.lines(plot)] },
    }, [time, ...columns], this.box);
    this.box.dataset.scales = String(new Set(key).size);
    this.time = time;
    let down = null;
    this.plot.over.addEventListener("pointerdown", (event) => { down = event.offsetX; });
    this.plot.over.addEventListener("pointerup", (event) => { if (down !== null && Math.abs(event.offsetX - down) < 4) this.moved(event.shiftKey ? 1 : 0, this.plot.posToVal(event.offsetX, "x")); down = null; });
  }

  setCursor(which, seconds) { this.cursors[which] = seconds; this.plot?.redraw(false); }

  // Number of the record next to a time; the times rise.
  place(seconds) {
    let low = 0;
    let high = this.time.length - 1;
    while (high - low > 1) { const middle = (low + high) >> 1; if (this.time[middle] > seconds) high = middle; else low = middle; }
    return Math.abs(this.time[low] - seconds) <= Math.abs(this.time[high] - seconds) ? low : high;
  }

  lines(plot) {
    const c = plot.ctx;
    const { left, top, width, height } = plot.bbox;
    const ratio = devicePixelRatio;
    [...this.cursors, 0].forEach((seconds, n) => {
      if (seconds === null) return;
      const x = plot.valToPos(seconds, "x", true);
      if (x < left || x > left + width) return;
      c.save();
      c.strokeStyle = c.fillStyle = n === 2 ? style("--soft") : style("--bad");
      c.lineWidth = ratio;
      c.setLineDash(n === 2 ? [2 * ratio, 4 * ratio] : n ? [7 * ratio, 4 * ratio] : []);
      c.beginPath(); c.moveTo(x, top); c.lineTo(x, top + height); c.stroke();
      c.font = `${12 * ratio}px system-ui, sans-serif`;
      c.fillText(["A", "B", "T"][n], x + 3 * ratio, top + 13 * ratio);
      c.restore();
    });
  }

  close() { this.wanted = null; this.watch.disconnect(); this.plot?.destroy(); this.plot = null; }
}

// The ends somebody chose, else those of the values with a little room.
function range([from, to], low, high) {
  if (low === null || low === undefined) { low = 0; high = 1; }
  const room = high > low ? 0.06 * (high - low) : Math.max(1e-3, Math.abs(high) * 0.05);
  const ends = [from ?? low - room, to ?? high + room];
  return ends[0] < ends[1] ? ends : [ends[0], ends[0] + 1];
}

// One channel over another, on a canvas of its own: uPlot wants times that rise.
export function drawXy(canvas, xs, ys, xTitle, yTitle) {
  const ratio = devicePixelRatio;
  const [w, hgt] = [canvas.clientWidth, canvas.clientHeight];
  canvas.width = w * ratio; canvas.height = hgt * ratio;
  const c = canvas.getContext("2d");
  c.scale(ratio, ratio);
  const range = (values) => { let low = Infinity; let high = -Infinity; for (const value of values) { if (value < low) low = value; if (value > high) high = value; } if (!(high > low)) { low -= 1; high += 1; } const room = 0.05 * (high - low); return [low - room, high + room]; };
  const [x0, x1] = range(xs);
  const [y0, y1] = range(ys);
  const [l, r, t, b] = [64, 14, 14, 42];
  const px = (value) => l + ((value - x0) / (x1 - x0)) * (w - l - r);
  const py = (value) => hgt - b - ((value - y0) / (y1 - y0)) * (hgt - t - b);
  c.font = "12px system-ui, sans-serif";
  c.strokeStyle = style("--line"); c.fillStyle = style("--text"); c.lineWidth = 1;
  for (let n = 0; n <= 4; n += 1) {
    const [vx, vy] = [x0 + ((x1 - x0) * n) / 4, y0 + ((y1 - y0) * n) / 4];
    c.beginPath(); c.moveTo(px(vx), t); c.lineTo(px(vx), hgt - b); c.moveTo(l, py(vy)); c.lineTo(w - r, py(vy)); c.stroke();
    c.textAlign = "center"; c.fillText(vx.toPrecision(4), px(vx), hgt - b + 16);
    c.textAlign = "right"; c.fillText(vy.toPrecision(4), l - 6, py(vy) + 4);
  }
  c.textAlign = "center"; c.fillText(xTitle, (l + w - r) / 2, hgt - 8);
  c.save(); c.translate(13, (t + hgt - b) / 2); c.rotate(-Math.PI / 2); c.fillText(yTitle, 0, 0); c.restore();
  c.strokeStyle = colour(0); c.lineWidth = 1.6; c.beginPath();
  xs.forEach((value, n) => (n ? c.lineTo(px(value), py(ys[n])) : c.moveTo(px(value), py(ys[n]))));
  c.stroke();
}
