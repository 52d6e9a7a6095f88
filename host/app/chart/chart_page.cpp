#include "host/app/chart/chart_output.hpp"
#include "host/input/safe_text.hpp"

namespace weft::app {
namespace {

constexpr const char* head = R"page(<!doctype html>
<html lang="en"><head><meta charset="utf-8">
<meta http-equiv="Content-Security-Policy"
      content="default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>weft chart</title>
<style>
:root { color-scheme: light dark; --ink: #222; --soft: #666; --line: #ddd; --paper: #fff; --shade: #eaeaea;
        --note: #fffff4; --bad: #a00; }
@media (prefers-color-scheme: dark) {
  :root { --ink: #e6e6e6; --soft: #a0a0a0; --line: #3c3c3c; --paper: #1b1b1b; --shade: #2a2a2a;
          --note: #2c2c22; --bad: #ff8080; }
}
body { font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem auto; max-width: 72rem; padding: 0 1rem;
       color: var(--ink); background: var(--paper); }
h1 { font-size: 1.5rem; overflow-wrap: anywhere; }
h2 { font-size: 1.15rem; }
#about { color: var(--soft); overflow-wrap: anywhere; }
#legend { display: flex; flex-wrap: wrap; gap: .2rem 1.1rem; list-style: none; padding: 0; margin: .5rem 0; }
#legend li { display: flex; align-items: center; gap: .4rem; }
#legend svg { width: 24px; height: 24px; flex: none; }
#chart svg { display: block; width: 100%; overflow: visible; }
#chart text { font-size: 13px; fill: var(--ink); }
#chart text.soft { fill: var(--soft); }
#chart text.label { font-size: 12px; paint-order: stroke; stroke: var(--paper); stroke-width: 3px;
                    stroke-linejoin: round; }
#chart text.own { font-weight: 600; }
.table { overflow-x: auto; margin: 1rem 0; }
table { border-collapse: collapse; }
td, th { padding: .2rem .7rem .2rem 0; text-align: left; vertical-align: top; border-bottom: 1px solid var(--line); }
td.n { text-align: right; font-variant-numeric: tabular-nums; }
td.command { font: .8em/1.4 ui-monospace, monospace; min-width: 22rem; overflow-wrap: anywhere; }
tr.own td { font-weight: 600; }
#note { box-sizing: border-box; position: fixed; display: none; max-width: min(34rem, calc(100vw - 2rem)); background: var(--note);
        padding: .5rem .7rem; border: 1px solid var(--soft); border-radius: 4px; pointer-events: none;
        font-size: .85em; overflow-wrap: anywhere; }
.failed { color: var(--bad); }
</style></head><body>
<h1></h1><p id="about"></p><ul id="legend"></ul><div id="chart"></div><div id="note"></div>
<h2>Least time to an error</h2><div class="table"><table id="times"></table></div>
<h2>Points</h2><div class="table"><table id="points"></table></div>
<script>
const chart = )page";

constexpr const char* script = R"page(;
const colours = ["#2b7bba", "#c8553d", "#3a8f4c", "#9361b0", "#b8860b", "#777777"];
const methods = [...new Set(chart.points.map(p => p.method))];
const colour = p => colours[methods.indexOf(p.method) % colours.length];
const median = p => p.seconds.length ? p.seconds[Math.floor(p.seconds.length / 2)] : null;
const isDrawn = p => !p.failure && p.error !== null && p.seconds.length > 0;
const isOwn = p => p.series === "scene";
const isPlanned = p => p.series === "planned";
const isModel = p => p.series === "model" || p.series === "mesh";
const drawn = chart.points.filter(isDrawn);
const front = chart.front.map(k => chart.points[k]);
const error = p => Math.max(p.error, 1e-16);
const range = values => values.length ? [Math.min(...values) / 1.6, Math.max(...values) * 1.6] : [1e-3, 1];
const xs = range(drawn.map(error));
const ys = range(chart.points.filter(p => p.seconds.length).map(median));
const NS = "http://www.w3.org/2000/svg";
const number = v => v === null || v === undefined ? "" : Number(v.toPrecision(3)).toString();
function element(parent, name, attributes, text) {
  const e = document.createElementNS(NS, name);
  for (const [k, v] of Object.entries(attributes)) e.setAttribute(k, v);
  if (text !== undefined) e.textContent = text;
  parent.append(e);
  return e;
}

// ------------------------------------------------------------------------------------- symbols
/// Circle: numerics; square: less of the model; diamond: chosen by `weft plan`; cross: failed; a
/// ring around it: the scene's own settings.
function symbol(parent, p, x, y) {
  const group = element(parent, "g", {});
  const fill = { fill: colour(p), stroke: "var(--paper)", "stroke-width": 1 };
  if (!isDrawn(p))
    element(group, "path", { d: `M${x - 5} ${y - 5}L${x + 5} ${y + 5}M${x - 5} ${y + 5}L${x + 5} ${y - 5}`,
                             stroke: colour(p), "stroke-width": 3, fill: "none" });
  else if (isPlanned(p))
    element(group, "path", { d: `M${x} ${y - 8}L${x + 8} ${y}L${x} ${y + 8}L${x - 8} ${y}Z`, ...fill });
  else if (isModel(p)) element(group, "rect", { x: x - 5, y: y - 5, width: 10, height: 10, ...fill });
  else element(group, "circle", { cx: x, cy: y, r: 5.5, ...fill });
  if (isOwn(p))
    element(group, "circle", { cx: x, cy: y, r: 10, fill: "none", stroke: "var(--ink)", "stroke-width": 2.5 });
  element(group, "circle", { cx: x, cy: y, r: 12, fill: "transparent" });  // for fingers
  return group;
}
function legend(text, draw) {
  const item = document.createElement("li");
  draw(element(item, "svg", { viewBox: "0 0 24 24" }));
  item.append(text);
  document.getElementById("legend").append(item);
}
methods.forEach((m, k) => legend(m, svg => element(svg, "rect", { x: 3, y: 7, width: 18, height: 10, rx: 3,
  fill: colours[k % colours.length] })));
const sample = (series, failure) => ({ series, method: methods[0], failure, error: 1, seconds: [1] });
const has = test => chart.points.some(test);
if (has(isOwn)) legend("your settings", svg => symbol(svg, { ...sample("scene", ""),
  method: chart.points.find(isOwn).method }, 12, 12));
legend("numerics", svg => symbol(svg, sample("", ""), 12, 12));
if (has(isModel)) legend("less of the model", svg => symbol(svg, sample("model", ""), 12, 12));
if (has(isPlanned)) legend("chosen by weft plan", svg => symbol(svg, sample("planned", ""), 12, 12));
if (has(p => !isDrawn(p))) legend("failed, at the right edge", svg => symbol(svg, sample("", "x"), 12, 12));
const line = dashes => svg => element(svg, "line", { x1: 0, x2: 24, y1: 12, y2: 12, stroke: "var(--ink)",
  "stroke-width": 1.3, "stroke-dasharray": dashes });
legend("no other point is better in both", line("none"));
legend("order 1", line("7 5"));
legend("order 2", line("2 4"));

// --------------------------------------------------------------------------------------- notes
const note = document.getElementById("note");
function describe(p) {
  const lines = [`${isOwn(p) ? "your settings" : p.series}: ${p.label} (${p.method}${p.device ? ", " + p.device : ""})`];
  if (p.failure) lines.push("failed: " + p.failure);
  else lines.push(`error ${number(p.error)}, ${number(median(p))} s per simulated s`);
  if (p.hausdorff !== null) lines.push(`Hausdorff ${number(p.hausdorff)}, curvature ${number(p.curvature)}`);
  if (p.intersections !== null) lines.push(`intersections ${p.intersections}`);
  lines.push(p.command, `commit ${p.commit}  state ${p.state_hash}`);
  return lines;
}
function explain(mark, p) {
  const show = event => {
    note.replaceChildren(...describe(p).map(text => {
      const d = document.createElement("div");
      d.textContent = text;
      return d;
    }));
    note.style.display = "block";
    const box = note.getBoundingClientRect();
    note.style.left = Math.max(8, Math.min(event.clientX + 14, innerWidth - box.width - 8)) + "px";
    note.style.top = Math.max(8, event.clientY + 14 + box.height > innerHeight
      ? event.clientY - box.height - 14 : event.clientY + 14) + "px";
  };
  for (const name of ["pointermove", "pointerdown"]) mark.addEventListener(name, show);
  mark.addEventListener("pointerleave", event => { if (event.pointerType === "mouse") note.style.display = "none"; });
}
document.addEventListener("pointerdown", event => {
  if (!event.target.closest("#chart g")) note.style.display = "none";
}, true);

// --------------------------------------------------------------------------------------- chart
/// Decades, with 2 and 5 between them where there are few.
function ticks(r) {
  const list = [], few = Math.log10(r[1] / r[0]) < 2.2;
  for (let e = Math.floor(Math.log10(r[0])); e <= Math.log10(r[1]); ++e)
    for (const m of few ? [1, 2, 5] : [1]) {
      const v = Number(`${m}e${e}`);
      if (v >= r[0] && v <= r[1]) list.push(v);
    }
  return list;
}
const short = v => v >= 1e-3 && v < 1e5 ? number(v) : v.toExponential(0);

/// A place for a text beside a point where nothing else is; null: there is none.
function place(width, x, y, taken, right, low, high) {
  const tall = 14;
  for (const gap of [9, 14])
    for (const [dx, dy] of [[1, -1], [1, 1], [1, 0], [-1, -1], [-1, 1], [-1, 0], [0, -1], [0, 1]]) {
      const left = dx > 0 ? x + gap : dx < 0 ? x - gap - width : x - width / 2;
      const box = [left, y + dy * gap - tall / 2, left + width, y + dy * gap + tall / 2];
      if (box[0] < 2 || box[2] > right || box[1] < low || box[3] > high) continue;
      if (taken.every(t => box[2] < t[0] || box[0] > t[2] || box[3] < t[1] || box[1] > t[3])) return box;
    }
  return null;
}

function draw() {
  const holder = document.getElementById("chart");
  holder.replaceChildren();
  const W = Math.max(280, holder.clientWidth), H = Math.round(Math.min(620, Math.max(380, 0.62 * W)));
  const left = 46, right = 12, top = 26, bottom = 44;
  const svg = element(holder, "svg", { viewBox: `0 0 ${W} ${H}`, height: H });
  const put = (name, attributes, text) => element(svg, name, attributes, text);
  const scale = (r, a, b) => v => a + (b - a) * Math.log(v / r[0]) / Math.log(r[1] / r[0]);
  const X = scale(xs, left, W - right - 26), Y = scale(ys, H - bottom, top);
  if (chart.reference_limited) {
    const edge = X(Math.min(Math.max(chart.reference_floor, xs[0]), xs[1]));
    put("rect", { x: left, y: top, width: edge - left, height: H - bottom - top, fill: "var(--shade)" });
    put("text", { x: left + 6, y: H - bottom - 8, class: "soft" }, "reference-limited");
  }
  const grid = { stroke: "var(--line)", "stroke-width": 1 };
  for (const v of ticks(xs)) {
    put("line", { x1: X(v), x2: X(v), y1: top, y2: H - bottom, ...grid });
    put("text", { x: X(v), y: H - bottom + 17, "text-anchor": "middle", class: "soft" }, short(v));
  }
  for (const v of ticks(ys)) {
    put("line", { x1: left, x2: W - right, y1: Y(v), y2: Y(v), ...grid });
    put("text", { x: left - 6, y: Y(v) + 4, "text-anchor": "end", class: "soft" }, short(v));
  }
  put("text", { x: W - right, y: H - 6, "text-anchor": "end" }, "error over the diagonal \u2192");
  put("text", { x: 0, y: 14 }, "\u2191 wall s per simulated s");
  for (const order of [1, 2]) {
    // Through the middle; drawn where it stays inside.
    const points = [];
    for (let k = 0; k <= 100; ++k) {
      const x = xs[0] * (xs[1] / xs[0]) ** (k / 100);
      const y = Math.sqrt(ys[0] * ys[1]) * (Math.sqrt(xs[0] * xs[1]) / x) ** (1 / order);
      if (y >= ys[0] && y <= ys[1]) points.push(`${X(x)},${Y(y)}`);
    }
    put("polyline", { points: points.join(" "), fill: "none", stroke: "var(--soft)", opacity: 0.7,
                      "stroke-dasharray": order === 1 ? "7 5" : "2 4" });
  }
  const stairs = [];
  front.forEach((p, k) => {
    if (k) stairs.push(`${X(error(front[k - 1]))},${Y(median(p))}`);
    stairs.push(`${X(error(p))},${Y(median(p))}`);
  });
  put("polyline", { points: stairs.join(" "), fill: "none", stroke: "var(--ink)", "stroke-width": 1.3 });

  // The scene's own point last: it must not lie under others.
  const order = p => isOwn(p) ? 2 : isPlanned(p) ? 1 : 0;
  const taken = [], places = new Map();
  for (const p of [...chart.points].sort((a, b) => order(a) - order(b))) {
    const x = isDrawn(p) ? X(error(p)) : W - right - 10;
    const y = p.seconds.length ? Y(median(p)) : top + 10;
    if (isDrawn(p))
      put("line", { x1: x, x2: x, y1: Y(p.seconds[0]), y2: Y(p.seconds.at(-1)), stroke: colour(p) });
    explain(symbol(svg, p, x, y), p);
    places.set(p, [x, y]);
    const reach = isOwn(p) ? 11 : 6;
    taken.push([x - reach, y - reach, x + reach, y + reach]);
  }
  // Most wanted first; a point whose label has no room has its note.
  const rank = p => isOwn(p) ? 0 : front.includes(p) ? 1 : isPlanned(p) ? 2 : p.series === "method" ? 3 : 4;
  const shown = new Set();
  for (const p of [...chart.points].sort((a, b) => rank(a) - rank(b))) {
    const text = isOwn(p) ? "your settings" : p.series === "method" ? p.label
      : p.series === "mesh" || p.series === "model" || p.series === "devices" ? p.label : `${p.series} ${p.label}`;
    if (text.length > 44 || shown.has(text)) continue;
    const label = put("text", { class: "label" + (isOwn(p) ? " own" : "") }, text);
    const box = place(label.getComputedTextLength(), ...places.get(p), taken, W - 2, top, H - bottom);
    if (!box) { label.remove(); continue; }
    shown.add(text);
    label.setAttribute("x", box[0]);
    label.setAttribute("y", box[3] - 3);
    label.setAttribute("pointer-events", "none");
    taken.push(box);
  }
}

// -------------------------------------------------------------------------------------- tables
document.title = chart.scene + " \u2013 weft chart";
document.querySelector("h1").textContent = chart.scene + ": speed against accuracy";
document.getElementById("about").textContent =
  `${chart.about} ${chart.machine}. ${chart.finished}. Bars: fastest and slowest run. Point at a symbol for its command.`;
function fill(id, heads, rows, marked) {
  const table = document.getElementById(id);
  const row = (cells, tag, own) => {
    const tr = document.createElement("tr");
    if (own) tr.className = "own";
    cells.forEach((c, k) => {
      const td = document.createElement(tag);
      td.textContent = c;
      if (/^[-+.\d]+(e[-+]?\d+)?$/.test(c)) td.className = "n";
      if (heads[k] === "command" && tag === "td") td.className = "command";
      if (String(c).startsWith("failed")) td.className = "failed";
      tr.append(td);
    });
    table.append(tr);
  };
  row(heads, "th", false);
  rows.forEach((r, k) => row(r, "td", marked(k)));
}
const best = (m, limit) => drawn.filter(p => p.method === m && p.error <= limit)
  .sort((a, b) => median(a) - median(b))[0];
fill("times", ["method", "to 10 %", "to 1 %", "to 0.1 %"], methods.map(m => [m, ...[0.1, 0.01, 0.001]
  .map(limit => { const p = best(m, limit); return p ? `${number(median(p))} s (${p.series}: ${p.label})` : "none"; })]),
  () => false);
fill("points", ["series", "value", "method", "error", "s per s", "curvature", "intersections", "command"],
  chart.points.map(p => [isOwn(p) ? "your settings" : p.series, p.label, p.method,
    p.failure ? "failed: " + p.failure : number(p.error), number(median(p)), number(p.curvature),
    number(p.intersections), p.command]), k => isOwn(chart.points[k]));
draw();
addEventListener("resize", draw);
</script></body></html>
)page";

}  // namespace

std::string chart_page(const Chart& chart) {
  return head + script_json(chart_json(chart)) + script;
}

}  // namespace weft::app
