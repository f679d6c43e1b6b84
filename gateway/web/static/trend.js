// The last half minute of one axis, drawn by uPlot.
import { h } from "./dom.js";
import { load } from "./plot.js";

const KEPT = 300;

export class Trend {
  constructor(t) {
    this.t = t;
    this.title = h("h2");
    this.box = h("div", { class: "plot" });
    this.element = h("div", {}, this.title, this.box);
    this.watch = new ResizeObserver(() => this.plot?.setSize({ width: this.box.clientWidth, height: 240 }));
    this.watch.observe(this.box);
    this.clear("");
    load().then((uPlot) => { this.uPlot = uPlot; this.make(); });
  }

  clear(name) {
    this.name = name;
    this.data = [[], [], [], [], []];
  }

  make() {
    if (!this.uPlot || !this.unit) return;
    this.plot?.destroy();
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => style.getPropertyValue(name).trim();
    const axis = { stroke: colour("--text"), grid: { stroke: colour("--line") }, ticks: { stroke: colour("--line") } };
    const t = this.t;
    this.plot = new this.uPlot({
      width: this.box.clientWidth || 600, height: 240, ms: 1e-3, scales: { x: { time: false } },
      series: [{ label: "s" }, { label: `${t("set")} ${this.unit}`, stroke: colour("--accent"), width: 2 }, { label: `${t("actual")} ${this.unit}`, stroke: colour("--good"), width: 2, dash: [6, 4] },
        { label: `${t("lag")} ${this.unit}`, stroke: colour("--warn"), width: 1.5, scale: "lag" }, { label: `${t("torque")} %`, stroke: colour("--bad"), width: 1.5, scale: "lag" }],
      axes: [{ ...axis }, { ...axis, size: 70, label: this.unit, stroke: colour("--text") }, { ...axis, scale: "lag", side: 1, size: 60, grid: { show: false } }],
    }, this.data, this.box);
  }

  add(seconds, row, info) {
    if (this.name !== row.name || this.unit !== info.unit) {
      this.clear(row.name);
      this.unit = info.unit;
      this.title.textContent = `${row.name}: ${this.t("set, actual, lag, torque")}`;
      this.make();
    }
    const last = this.data[0].at(-1);
    if (last !== undefined && seconds <= last) { if (seconds < last) this.clear(row.name); return; }
    [seconds, row.set, row.actual, row.lag, row.torque].forEach((value, i) => { this.data[i].push(value); if (this.data[i].length > KEPT) this.data[i].shift(); });
    this.plot?.setData(this.data);
  }

  theme() { this.make(); }

  close() { this.watch.disconnect(); this.plot?.destroy(); this.plot = null; }
}
