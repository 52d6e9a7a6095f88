#include "host/app/chart/chart_output.hpp"
#include "host/input/safe_text.hpp"

namespace weft::app {
namespace {

constexpr const char* head = R"(<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">
<title>weft chart</title>
<style>
body { font: 15px/1.45 system-ui, sans-serif; margin: 2rem auto; max-width: 72rem; padding: 0 1rem;
       color: #222; background: #fff; }
svg { width: 100%; height: auto; }
table { border-collapse: collapse; margin: 1rem 0; }
td, th { padding: .2rem .7rem; text-align: left; border-bottom: 1px solid #ddd; }
td.n { text-align: right; font-variant-numeric: tabular-nums; }
code { font-size: .85em; overflow-wrap: anywhere; }
#note { position: fixed; display: none; max-width: 34rem; background: #fffff4; padding: .5rem .7rem;
        border: 1px solid #999; border-radius: 4px; pointer-events: none; font-size: .85em; }
.failed { color: #a00; }
</style></head><body>
<h1></h1><p id="about"></p><div id="chart"></div><div id="note"></div>
<h2>Least time to an error</h2><table id="times"></table>
<h2>Points</h2><table id="points"></table>
<script>
const chart = )";

constexpr const char* script = R"(;
const colours = ["#1b6ca8", "#c8553d", "#3a7d44", "#8e5aa8", "#b8860b", "#555555"];
const W = 960, H = 600, left = 70, right = 180, top_ = 20, bottom = 50;
const methods = [...new Set(chart.points.map(p => p.method))];
const colour = p => colours[methods.indexOf(p.method) % colours.length];
const median = p => p.seconds.length ? p.seconds[Math.floor(p.seconds.length / 2)] : null;
const drawn = chart.points.filter(p => !p.failure && p.error !== null && p.seconds.length);
const error = p => Math.max(p.error, 1e-16);
const range = values => values.length ? [Math.min(...values) / 2, Math.max(...values) * 2] : [1e-3, 1];
const xs = range(drawn.map(error));
const ys = range(chart.points.filter(p => p.seconds.length).map(median));
const scale = (r, a, b) => v => a + (b - a) * Math.log(v / r[0]) / Math.log(r[1] / r[0]);
const X = scale(xs, left, W - right), Y = scale(ys, H - bottom, top_);
const NS = "http://www.w3.org/2000/svg";
const svg = document.createElementNS(NS, "svg");
svg.setAttribute("viewBox", `0 0 ${W} ${H}`);
document.getElementById("chart").append(svg);
function put(name, attributes, text) {
  const e = document.createElementNS(NS, name);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  if (text !== undefined) e.textContent = text;
  svg.append(e);
  return e;
}
const number = v => v === null || v === undefined ? "" : Number(v.toPrecision(3)).toString();
function decades(r) {
  const list = [];
  for (let e = Math.ceil(Math.log10(r[0])); e <= Math.log10(r[1]); ++e) list.push(10 ** e);
  return list;
}
const grey = { stroke: "#ccc", "stroke-width": 1 };
if (chart.reference_limited) {
  const edge = Math.min(Math.max(chart.reference_floor, xs[0]), xs[1]);
  put("rect", { x: left, y: top_, width: X(edge) - left, height: H - bottom - top_, fill: "#e6e6e6" });
  put("text", { x: left + 6, y: top_ + 16, fill: "#666" }, "reference-limited");
}
for (const v of decades(xs)) {
  put("line", { x1: X(v), x2: X(v), y1: top_, y2: H - bottom, ...grey });
  put("text", { x: X(v), y: H - bottom + 18, "text-anchor": "middle" }, v.toExponential(0));
}
for (const v of decades(ys)) {
  put("line", { x1: left, x2: W - right, y1: Y(v), y2: Y(v), ...grey });
  put("text", { x: left - 6, y: Y(v) + 5, "text-anchor": "end" }, number(v));
}
put("text", { x: (left + W - right) / 2, y: H - 10, "text-anchor": "middle" }, "error over the diagonal");
put("text", { x: 16, y: H / 2, transform: `rotate(-90 16 ${H / 2})`, "text-anchor": "middle" },
    "wall s per simulated s");
for (const order of [1, 2]) {
  // Through the middle; drawn where it stays inside.
  const points = [];
  for (let k = 0; k <= 100; ++k) {
    const x = xs[0] * (xs[1] / xs[0]) ** (k / 100);
    const y = Math.sqrt(ys[0] * ys[1]) * (Math.sqrt(xs[0] * xs[1]) / x) ** (1 / order);
    if (y >= ys[0] && y <= ys[1]) points.push(`${X(x)},${Y(y)}`);
  }
  put("polyline", { points: points.join(" "), fill: "none", stroke: "#999",
                    "stroke-dasharray": order === 1 ? "7 5" : "2 4" });
  put("text", { x: W - right + 24, y: H - bottom - 40 + 18 * order, fill: "#777" },
      (order === 1 ? "-- " : "... ") + "order " + order);
}
const stairs = [];
chart.front.map(k => chart.points[k]).forEach((p, k, all) => {
  if (k) stairs.push(`${X(error(all[k - 1]))},${Y(median(p))}`);
  stairs.push(`${X(error(p))},${Y(median(p))}`);
});
put("polyline", { points: stairs.join(" "), fill: "none", stroke: "#000", "stroke-width": 1.2 });
const note = document.getElementById("note");
function explain(element, p) {
  element.addEventListener("mousemove", event => {
    note.replaceChildren();
    const lines = [`${p.series}: ${p.label} (${p.method}${p.device ? ", " + p.device : ""})`];
    if (p.failure) lines.push("failed: " + p.failure);
    else lines.push(`error ${number(p.error)}, ${number(median(p))} s per simulated s`);
    if (p.hausdorff !== null) lines.push(`Hausdorff ${number(p.hausdorff)}, curvature ${number(p.curvature)}`);
    if (p.intersections !== null) lines.push(`intersections ${p.intersections}`);
    lines.push(p.command, `commit ${p.commit}  state ${p.state_hash}`);
    for (const line of lines) { const d = document.createElement("div"); d.textContent = line; note.append(d); }
    note.style.display = "block";
    note.style.left = Math.min(event.clientX + 14, innerWidth - 360) + "px";
    note.style.top = event.clientY + 14 + "px";
  });
  element.addEventListener("mouseleave", () => { note.style.display = "none"; });
}
for (const p of chart.points) {
  const y = p.seconds.length ? Y(median(p)) : top_ + 8;
  if (drawn.includes(p)) {
    const x = X(error(p));
    put("line", { x1: x, x2: x, y1: Y(p.seconds[0]), y2: Y(p.seconds.at(-1)), stroke: colour(p) });
    const model = p.series === "model" || p.series === "mesh";
    explain(model ? put("rect", { x: x - 5, y: y - 5, width: 10, height: 10, fill: colour(p) })
                  : put("circle", { cx: x, cy: y, r: 5.5, fill: colour(p) }), p);
  } else {
    const x = W - right - 8;
    explain(put("path", { d: `M${x - 6} ${y - 6}L${x + 6} ${y + 6}M${x - 6} ${y + 6}L${x + 6} ${y - 6}`,
                          stroke: colour(p), "stroke-width": 3, "pointer-events": "bounding-box" }), p);
  }
}
methods.forEach((m, k) => {
  put("circle", { cx: W - right + 30, cy: top_ + 14 + 20 * k, r: 5, fill: colours[k % colours.length] });
  put("text", { x: W - right + 42, y: top_ + 19 + 20 * k }, m);
});
document.querySelector("h1").textContent = chart.scene + ": speed against accuracy";
document.getElementById("about").textContent = `${chart.about} ${chart.machine}. ${chart.finished}. ` +
  "Circles: numerics; squares: less of the model; crosses at the edge: failed. Bars: fastest and slowest run.";
function fill(id, heads, rows) {
  const table = document.getElementById(id);
  const row = (cells, tag) => {
    const tr = document.createElement("tr");
    for (const c of cells) {
      const td = document.createElement(tag);
      td.textContent = c;
      if (/^[-+.\d]+(e[-+]?\d+)?$/.test(c)) td.className = "n";
      if (String(c).startsWith("failed")) td.className = "failed";
      tr.append(td);
    }
    table.append(tr);
  };
  row(heads, "th");
  rows.forEach(r => row(r, "td"));
}
const best = (m, limit) => drawn.filter(p => p.method === m && p.error <= limit)
  .sort((a, b) => median(a) - median(b))[0];
fill("times", ["method", "to 10 %", "to 1 %", "to 0.1 %"], methods.map(m => [m, ...[0.1, 0.01, 0.001]
  .map(limit => { const p = best(m, limit); return p ? `${number(median(p))} s (${p.series}: ${p.label})` : "none"; })]));
fill("points", ["series", "value", "method", "error", "s a s", "curvature", "intersections", "command"],
  chart.points.map(p => [p.series, p.label, p.method, p.failure ? "failed: " + p.failure : number(p.error),
    number(median(p)), number(p.curvature), number(p.intersections), p.command]));
</script></body></html>
)";

}  // namespace

std::string chart_page(const Chart& chart) {
  return head + script_json(chart_json(chart)) + script;
}

}  // namespace weft::app
