"use strict";
// Data of the run: axes slowest first, and one number for each cell in every column.
const run = JSON.parse(document.getElementById("data").textContent);
const place = run.axes.map((axis) => Math.floor((axis.values.length - 1) / 2));
const strides = run.axes.map((_, i) => run.axes.slice(i + 1).reduce((n, axis) => n * axis.values.length, 1));
const cellAt = (at) => at.reduce((cell, position, i) => cell + position * strides[i], 0);
const cellWith = (changes) => cellAt(place.map((position, i) => (i in changes ? changes[i] : position)));
const number = (value) => (value === null ? "unknown" : Number(value.toPrecision(5)).toString());
const named = (axis, i) => `${axis.title} = ${number(axis.values[i])}${axis.unit ? " " + axis.unit : ""}`;
const heading = (axis) => (axis.unit ? `${axis.title} (${axis.unit})` : axis.title);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const { vertical, horizontal } = run;
const details = document.querySelector("#map-section details");
const isMap = vertical !== null && horizontal !== null;
const config = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d"] };

// What is known of a cell, in words.
function told(cell) {
  const interval = `${number(run.low[cell])} to ${number(run.high[cell])}`;
  const counts = run.samples[cell] > 0 ? `; ${run.unstable[cell]} of ${run.samples[cell]} samples unstable` : "";
  return `P = ${number(run.p[cell])} (${run.interval_name}: ${interval})${counts}`;
}

function layout(x, y, extra) {
  const line = colour("--line"), text = colour("--text");
  const axis = (of) => ({ title: { text: of }, gridcolor: line, linecolor: line, zeroline: false, automargin: true });
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: text, size: 12 },
    margin: { l: 60, r: 20, t: 20, b: 50 }, showlegend: false, hovermode: "closest",
    xaxis: axis(x), yaxis: axis(y), ...extra,
  };
}

// Colours are those of the bands between the levels, all of one width, since small probabilities matter too.
const bands = run.colours.length;
const band = (p) => (p === null ? null : run.levels.filter((level) => level <= p).length + 0.5);
const steps = run.colours.flatMap((fill, i) => [[i / bands, fill], [(i + 1) / bands, fill]]);

function drawMap() {
  const across = run.axes[horizontal], up = run.axes[vertical];
  const cells = up.values.map((_, row) => across.values.map((_, column) =>
    cellWith({ [vertical]: row, [horizontal]: column })));
  const z = cells.map((row) => row.map((cell) => run.p[cell]));
  const text = cells.map((row, i) => row.map((cell, j) =>
    `${named(up, i)}<br>${named(across, j)}<br>${told(cell)}`));
  const scaled = (axis) => (axis.logarithmic ? { type: "log" } : {});
  const traces = [{
    type: "heatmap", x: across.values, y: up.values, z: z.map((row) => row.map(band)), text,
    hovertemplate: "%{text}<extra></extra>", zmin: 0, zmax: bands, colorscale: steps,
    colorbar: {
      title: { text: "P" }, tickvals: run.levels.map((_, i) => i + 1), ticktext: run.level_names, tickfont: { size: 10 },
    },
  }];
  for (const level of run.lines) {
    traces.push({
      type: "contour", x: across.values, y: up.values, z, hoverinfo: "skip", showscale: false, autocontour: false,
      contours: { start: level, end: level, size: 1, coloring: "none", showlabels: true,
        labelfont: { size: 10, color: level > 0.6 ? "#fff" : "#000" } },
      line: { color: level > 0.6 ? "#fff" : "#000", width: 1 },
    });
  }
  traces.push({
    type: "scatter", mode: "markers", x: [across.values[place[horizontal]]], y: [up.values[place[vertical]]],
    marker: { size: 13, symbol: "circle-open", color: colour("--mark"), line: { width: 3 } }, hoverinfo: "skip",
  });
  const sides = layout(heading(across), heading(up));
  Object.assign(sides.xaxis, scaled(across));
  Object.assign(sides.yaxis, scaled(up));
  Plotly.react("map", traces, sides, config);
}

// The numbers of the map, made when they are looked at: a large table takes seconds.
function fillTable() {
  const across = run.axes[horizontal], up = run.axes[vertical];
  const table = document.getElementById("numbers");
  table.replaceChildren();
  const head = table.insertRow();
  const cellOf = (row, content, isHead) => {
    const cell = document.createElement(isHead ? "th" : "td");
    cell.textContent = content;
    row.append(cell);
  };
  cellOf(head, `${up.title} \\ ${across.title}`, true);
  across.values.forEach((value) => cellOf(head, number(value), true));
  [...up.values.keys()].reverse().forEach((i) => {
    const row = table.insertRow();
    cellOf(row, number(up.values[i]), true);
    across.values.forEach((_, j) => cellOf(row, number(run.p[cellWith({ [vertical]: i, [horizontal]: j })]), false));
  });
}

// The probability along an axis through the selected point, with its band.
function drawSection(target, index) {
  const axis = run.axes[index];
  const cells = axis.values.map((_, i) => cellWith({ [index]: i }));
  const pick = (column) => cells.map((cell) => (run.p[cell] === null ? null : column[cell]));
  const shade = "rgba(60, 110, 180, 0.3)";
  const traces = [
    { x: axis.values, y: pick(run.low), mode: "lines", line: { width: 0 }, hoverinfo: "skip" },
    { x: axis.values, y: pick(run.high), mode: "lines", line: { width: 0 }, fill: "tonexty", fillcolor: shade, hoverinfo: "skip" },
    { x: axis.values, y: pick(run.p), mode: "lines+markers", line: { color: "#3c6eb4", width: 2 }, marker: { size: 5 },
      text: cells.map((cell, i) => `${named(axis, i)}<br>${told(cell)}`), hovertemplate: "%{text}<extra></extra>" },
    { x: [axis.values[place[index]]], y: [run.p[cellAt(place)]], mode: "markers", hoverinfo: "skip",
      marker: { size: 13, symbol: "circle-open", color: colour("--mark"), line: { width: 3 } } },
  ];
  const sides = layout(heading(axis), "Probability of instability P");
  if (axis.logarithmic) sides.xaxis.type = "log";
  sides.yaxis.rangemode = "tozero";
  Plotly.react(target, traces, sides, config);
}

function draw() {
  const shown = run.axes.map((axis, i) => [axis, i]).filter(([axis]) => axis.values.length > 1);
  document.getElementById("selected").textContent =
    [...shown.map(([axis, i]) => named(axis, place[i])), told(cellAt(place))].join(", ");
  if (isMap) {
    drawMap();
    if (details.open) fillTable();
    drawSection("along-horizontal", horizontal);
    drawSection("along-vertical", vertical);
  } else if (horizontal !== null) {
    drawSection("map", horizontal);
  }
}

function select(changes) {
  for (const [axis, position] of Object.entries(changes)) {
    place[axis] = Math.min(Math.max(position, 0), run.axes[axis].values.length - 1);
  }
  draw();
}

function addControls() {
  run.axes.forEach((axis, i) => {
    if (axis.values.length < 2 || i === vertical || i === horizontal) return;
    const label = document.createElement("label");
    const output = document.createElement("output");
    const slider = Object.assign(document.createElement("input"), {
      type: "range", min: 0, max: axis.values.length - 1, step: 1, value: place[i], id: `axis-${i}`,
    });
    const tell = () => { output.textContent = named(axis, place[i]); };
    slider.addEventListener("input", () => { select({ [i]: Number(slider.value) }); tell(); });
    tell();
    label.append(output, slider);
    document.getElementById("controls").append(label);
  });
}

const nearest = (values, wanted) =>
  values.reduce((best, value, i) => (Math.abs(value - wanted) < Math.abs(values[best] - wanted) ? i : best), 0);

addControls();
if (isMap) {
  details.addEventListener("toggle", () => details.open && fillTable());
} else {
  document.getElementById("sections").remove();
  details.remove();
}
if (horizontal === null) document.getElementById("map").style.display = "none";
draw();
const map = document.getElementById("map");
if (map.on) {
  map.on("plotly_click", (event) => {
    const { x, y } = event.points[0];
    const changes = horizontal === null ? {} : { [horizontal]: nearest(run.axes[horizontal].values, x) };
    if (isMap) changes[vertical] = nearest(run.axes[vertical].values, y);
    select(changes);
  });
}
map.addEventListener("keydown", (event) => {
  const moves = { ArrowLeft: [horizontal, -1], ArrowRight: [horizontal, 1], ArrowDown: [vertical, -1], ArrowUp: [vertical, 1] };
  const [axis, by] = moves[event.key] ?? [null, 0];
  if (axis === null) return;
  event.preventDefault();
  select({ [axis]: place[axis] + by });
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
