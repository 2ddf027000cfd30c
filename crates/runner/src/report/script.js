"use strict";
// The runs: axes slowest first, and one number for each cell in every column.
const { runs, comparisons } = JSON.parse(document.getElementById("data").textContent);
const element = (id) => document.getElementById(id);
const details = (of) => document.querySelector(`details[data-table="${of}"]`);

// What the map can show: the probability of a run, or how much that of a run differs from the first.
const views = [
  ...runs.map((run) => ({ run, label: `P of ${run.path}` })),
  ...comparisons.map((comparison) => ({
    run: runs[0], comparison, label: `P of ${runs[comparison.run].path} minus P of ${runs[0].path}`,
  })),
];
let view = views[0];
// The point that is selected first: the one that is asked about, or the middle.
const start = (run) => run.at ?? run.axes.map((axis) => Math.floor((axis.values.length - 1) / 2));
let place = start(view.run);

function cellAt(run, at) {
  return at.reduce((cell, position, i) => cell * run.axes[i].values.length + position, 0);
}
const cellWith = (run, changes) => cellAt(run, place.map((position, i) => (i in changes ? changes[i] : position)));
const sameAxes = (a, b) => JSON.stringify(a.axes) === JSON.stringify(b.axes);
const number = (value) => (value === null ? "unknown" : Number(value.toPrecision(5)).toString());
// Symbols of one letter have subscripts, by the tags that Plotly knows or as elements.
const SYMBOL = /(?<![\p{L}\p{N}_.])(\p{L})_([\p{L}\p{N}]{1,2})(?![\p{L}\p{N}_])/gu;
const inPlot = (text) => text.replace(SYMBOL, "$1<sub>$2</sub>");
function write(target, text) {
  const subscript = (of) => Object.assign(document.createElement("sub"), { textContent: of });
  target.replaceChildren(...text.split(SYMBOL).map((part, i) => (i % 3 === 2 ? subscript(part) : part)));
}
const named = (axis, i) => `${axis.title} = ${number(axis.values[i])}${axis.unit ? " " + axis.unit : ""}`;
const heading = (axis) => (axis.unit ? `${axis.title} (${axis.unit})` : axis.title);
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const isMap = () => view.run.vertical !== null && view.run.horizontal !== null;
const config = { responsive: true, displaylogo: false, modeBarButtonsToRemove: ["select2d", "lasso2d"] };
const LINES = ["#3c6eb4", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"];

// What the view knows of a cell: a value with its interval, in words too.
const value = (cell) => (view.comparison ? view.comparison.value[cell] : view.run.p[cell]);
const tabled = (cell) => (view.run.verdicts && !view.comparison ? described(cell) : number(value(cell)));
function described(cell) {
  const of = view.comparison ?? view.run;
  const interval = `${number(of.low[cell])} to ${number(of.high[cell])}`;
  if (view.comparison) {
    if (of.low[cell] === null) return "not a cell of both runs";
    if (value(cell) === null) return "difference unknown: a cell has no probability";
    const both = `P = ${number(of.second[cell])} and ${number(of.first[cell])}`;
    return `difference = ${number(value(cell))} (${of.interval_name}: ${interval}); ${both}`;
  }
  const run = view.run;
  if (run.verdicts) return run.verdicts.names[run.verdicts.of_cells[cell]];
  const drawn = run.unstable ? `${run.unstable[cell]} of ${run.samples[cell]} samples unstable` : `${run.samples[cell]} samples`;
  const counts = run.samples[cell] > 0 ? `; ${drawn}` : "";
  return `P = ${number(run.p[cell])} (${run.interval_name}: ${interval})${counts}${apart(cell)}`;
}

// What is said of a cell in lines that fit in a narrow window.
const inLines = (text) => text.replace(" (", "<br>(").replaceAll("; ", ";<br>");

// A title in lines of few letters.
function inShortLines(title) {
  return title.split(" ").reduce((text, word) => {
    const last = text.slice(text.lastIndexOf(">") + 1);
    return text + (last.length + word.length < 14 ? " " : "<br>") + word;
  });
}

// The shares of the samples of a cell that lie outside the model or have no verdict.
function apart(cell) {
  const { apart: shares } = view.run;
  if (!shares) return "";
  const said = (share, what) => (share > 0 ? `; ${number(100 * share)} % ${what}` : "");
  return said(shares.outside[cell], "outside the model") + said(shares.open[cell], "undecided or failed");
}

// What the model with exactly the expected values of a cell does.
function aboutModel(cell) {
  if (view.comparison) return "Strokes: the interval contains 0.";
  const { expected, recorded } = view.run;
  const sentences = [];
  const marks = view.run.apart && isMap()
    ? [`Crosses: ${100 * MANY} % of the samples or more lie outside the model, or are undecided or failed.`] : [];
  if (expected) {
    const rate = expected.growth_rate[cell];
    const [rateOn, cycleOn] = expected.on;
    const size = expected.amplitude_mm[cell];
    const stick = expected.stick[cell];
    sentences.push(
      rate === null ? "no growth rate is known"
        : `small motions about steady sliding ${rate > 0 ? "grow" : "decay"} at ${number(Math.abs(rate))} 1/s${rateOn}`,
      size === null ? `no limit cycle${cycleOn}`
        : `limit cycle${cycleOn}: amplitude ${number(size)} mm, ${number(expected.frequency_hz[cell])} Hz, ` +
          (stick === 0 ? "without sticking" : `${number(100 * stick)} % of the period in stick`),
    );
  }
  const lines = !sentences.length ? marks : [...marks, `With exactly these values: ${sentences.join("; ")}.`];
  for (const { name, samples, scale, unit, median, low, high } of recorded) {
    if (median[cell] === null) continue;
    const shown = (column) => `${number(column[cell] * scale)} ${unit}`.trim();
    lines.push(`${name[0].toUpperCase()}${name.slice(1)} of the ${samples}: median ${shown(median)}, ` +
      `5 to 95 %: ${shown(low)} to ${shown(high)}.`);
  }
  return lines.join(" ");
}

function layout(x, y, extra) {
  const line = colour("--line"), text = colour("--text");
  const axis = (of) => ({
    title: { text: inPlot(of) }, gridcolor: line, linecolor: line, zeroline: false, automargin: true,
    exponentformat: "power",
  });
  return {
    paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)", font: { color: text, size: 12 },
    // Above a plot is its tool bar, below it its legend.
    margin: { l: 60, r: 20, t: 34, b: 50 }, showlegend: false, hovermode: "closest",
    legend: { orientation: "h", x: 0, y: -0.35, yanchor: "top" },
    xaxis: axis(x), yaxis: axis(y), ...extra,
  };
}

const marker = () => ({ size: 13, symbol: "circle-open", color: colour("--mark"), line: { width: 3 } });

// Colours of probabilities are those of the bands between the levels, all of one width, since small probabilities
// matter too.
function probabilityTraces(x, y, cells, text) {
  const run = view.run, bands = run.colours.length;
  const band = (p) => (p === null ? null : run.levels.filter((level) => level <= p).length + 0.5);
  const z = cells.map((row) => row.map((cell) => run.p[cell]));
  const first = cellWith(run, { [run.vertical]: 0, [run.horizontal]: 0 });
  const taken = [];
  const lines = run.lines.filter((line) => line.first === first).map((line) => {
    const ink = line.is_limit ? "#e01030" : line.level > 0.6 ? "#fff" : "#000";
    const labelled = labelPlace(line, taken);
    return {
      type: "scatter", mode: "lines+text", x: line.x, y: line.y, hoverinfo: "skip",
      line: { color: ink, width: line.is_wide ? 2.5 : 1 }, textposition: "top left", textfont: { size: 10, color: ink },
      text: line.x.map((_, at) => (at === labelled ? line.name : "")),
    };
  });
  return [{
    type: "heatmap", x, y, z: z.map((row) => row.map(band)), text, hovertemplate: "%{text}<extra></extra>",
    zmin: 0, zmax: bands,
    colorscale: run.colours.flatMap((fill, i) => [[i / bands, fill], [(i + 1) / bands, fill]]),
    colorbar: {
      title: { text: "P" }, tickvals: run.levels.map((_, i) => i + 1), ticktext: run.level_names, tickfont: { size: 10 },
    },
  }, ...lines, ...crosses(x, y, cells)];
}

// Where along a line its label stands: near its middle, but apart from the labels that are `taken`, in shares of the map.
const APART = 0.2;
function labelPlace(line, taken) {
  const { run } = view;
  const shares = (axis, values) => {
    const { type, range: [from, to] } = ends(axis);
    return values.map((at) => ((type === "log" ? Math.log10(at) : at) - from) / (to - from));
  };
  const x = shares(run.axes[run.horizontal], line.x), y = shares(run.axes[run.vertical], line.y);
  const room = x.map((_, i) => taken.reduce((least, [u, v]) => Math.min(least, Math.hypot(x[i] - u, y[i] - v)), APART));
  const offMiddle = (i) => Math.abs(i - (x.length - 1) / 2);
  const isBetter = (i, best) => room[i] > room[best] || (room[i] === room[best] && offMiddle(i) < offMiddle(best));
  const place = x.reduce((best, _, i) => (isBetter(i, best) ? i : best), 0);
  taken.push([x[place], y[place]]);
  return place;
}

// Crosses where many samples of a cell lie outside the model or have no verdict.
const MANY = 0.05;
function crosses(x, y, cells) {
  const { apart: shares } = view.run;
  if (!shares) return [];
  const has = (cell) => shares.outside[cell] >= MANY || shares.open[cell] >= MANY;
  const marked = cells.flatMap((row, i) => row.flatMap((cell, j) => (has(cell) ? [[x[j], y[i]]] : [])));
  return [{
    type: "scatter", mode: "markers", x: marked.map(([at]) => at), y: marked.map(([, at]) => at), hoverinfo: "skip",
    marker: { symbol: "x-thin-open", size: 6, color: "#333" },
  }];
}

// Verdicts, where nothing scatters: the colours of those that some cell has.
function verdictTraces(x, y, cells, text) {
  const { of_cells, names: all, colours: inks } = view.run.verdicts;
  const here = all.map((_, kind) => kind).filter((kind) => of_cells.includes(kind)), kinds = here.length;
  const names = here.map((kind) => all[kind]), colours = here.map((kind) => inks[kind]);
  return [{
    type: "heatmap", x, y, z: cells.map((row) => row.map((cell) => here.indexOf(of_cells[cell]))), text, zmin: -0.5, zmax: kinds - 0.5,
    hovertemplate: "%{text}<extra></extra>",
    colorscale: colours.flatMap((fill, i) => [[i / kinds, fill], [(i + 1) / kinds, fill]]),
    colorbar: { tickvals: names.map((_, i) => i), ticktext: names, tickfont: { size: 10 } },
  }];
}

// Differences: blue below, red above; a stroke where the interval contains 0.
function differenceTraces(x, y, cells, text) {
  const { low, high, value: all } = view.comparison;
  const largest = all.reduce((most, of) => (of === null ? most : Math.max(most, Math.abs(of))), 1e-12);
  const open = cells.flatMap((row, i) => row.flatMap((cell, j) =>
    (all[cell] !== null && low[cell] <= 0 && high[cell] >= 0 ? [[x[j], y[i]]] : [])));
  return [{
    type: "heatmap", x, y, z: cells.map((row) => row.map((cell) => all[cell])), text,
    hovertemplate: "%{text}<extra></extra>", zmin: -largest, zmax: largest,
    colorscale: view.comparison.colours, colorbar: { title: { text: "ΔP" }, tickfont: { size: 10 } },
  }, {
    type: "scatter", mode: "markers", x: open.map(([at]) => at), y: open.map(([, at]) => at), hoverinfo: "skip",
    marker: { symbol: "line-ne-open", size: 6, color: "#555" },
  }];
}

function cellsOfMap() {
  const { run } = view;
  return run.axes[run.vertical].values.map((_, row) => run.axes[run.horizontal].values.map((_, column) =>
    cellWith(run, { [run.vertical]: row, [run.horizontal]: column })));
}

// An axis from the outer edge of its first tile to that of its last.
function ends({ values, logarithmic }) {
  const at = values.map((of) => (logarithmic ? Math.log10(of) : of)), last = at.length - 1;
  const range = [at[0] - (at[1] - at[0]) / 2, at[last] + (at[last] - at[last - 1]) / 2];
  return { type: logarithmic ? "log" : "linear", range };
}

function drawMap() {
  const { run } = view;
  const across = run.axes[run.horizontal], up = run.axes[run.vertical];
  const cells = cellsOfMap();
  const describedAt = (cell, i, j) =>
    `${inPlot(named(up, i))}<br>${inPlot(named(across, j))}<br>${inLines(described(cell))}`;
  const text = cells.map((row, i) => row.map((cell, j) => describedAt(cell, i, j)));
  const drawn = view.comparison ? differenceTraces : run.verdicts ? verdictTraces : probabilityTraces;
  const traces = drawn(across.values, up.values, cells, text);
  traces.push({
    type: "scatter", mode: "markers", x: [across.values[place[run.horizontal]]], y: [up.values[place[run.vertical]]],
    marker: marker(), hoverinfo: "skip",
  });
  const sides = layout(heading(across), heading(up));
  Object.assign(sides.xaxis, ends(across));
  Object.assign(sides.yaxis, ends(up));
  Plotly.react("map", traces, sides, config);
}

// The numbers of the pictures as rows, the first of them the head.
const tables = {
  map() {
    const { run } = view;
    if (!isMap()) return sectionTable(run.horizontal);
    const across = run.axes[run.horizontal], up = run.axes[run.vertical];
    const rows = cellsOfMap().map((row, i) => [number(up.values[i]), ...row.map(tabled)]);
    return [[`${up.title} \\ ${across.title}`, ...across.values.map(number)], ...rows.reverse()];
  },
  horizontal: () => sectionTable(view.run.horizontal),
  vertical: () => sectionTable(view.run.vertical),
  sensitivity() {
    const cell = cellAt(view.run, place), columns = ["first_order", "first_order_error", "total", "total_error"];
    return view.run.sensitivity.flatMap(({ of, inputs }) => [
      [`Of the ${of}`, "First order", "standard error", "Total", "standard error"],
      ...inputs.map((input) => [input.input, ...columns.map((name) => number(input[name][cell]))]),
    ]);
  },
};

function sectionTable(index) {
  const axis = view.run.axes[index], of = view.comparison ?? view.run;
  const rows = axis.values.map((at, i) => {
    const cell = cellWith(view.run, { [index]: i });
    return [at, value(cell), of.low[cell], of.high[cell]].map(number);
  });
  return [[heading(axis), view.comparison ? "Difference" : "P", "from", "to"], ...rows];
}

// Tables are made when they are looked at: a large one takes seconds.
function fillTable(of) {
  const table = details(of).querySelector("table");
  table.replaceChildren();
  tables[of]().forEach((contents, i) => {
    const row = table.insertRow();
    contents.forEach((content, j) => {
      const cell = document.createElement(i === 0 || j === 0 ? "th" : "td");
      write(cell, content);
      row.append(cell);
    });
  });
}

// The value along an axis through the selected point with its band, and that of the other runs.
function drawSection(target, index) {
  const { run } = view, axis = run.axes[index], of = view.comparison ?? run;
  const cells = axis.values.map((_, i) => cellWith(run, { [index]: i }));
  const pick = (column) => cells.map((cell) => (value(cell) === null ? null : column[cell]));
  const shade = "rgba(60, 110, 180, 0.3)";
  const others = view.comparison ? [] : runs.filter((other) => other !== run && sameAxes(other, run));
  const traces = [
    { x: axis.values, y: pick(of.low), mode: "lines", line: { width: 0 }, hoverinfo: "skip", showlegend: false },
    { x: axis.values, y: pick(of.high), mode: "lines", line: { width: 0 }, fill: "tonexty", fillcolor: shade,
      hoverinfo: "skip", showlegend: false },
    ...others.map((other, i) => ({
      x: axis.values, y: cells.map((cell) => other.p[cell]), mode: "lines", name: other.path,
      line: { color: LINES[1 + i % (LINES.length - 1)], width: 1.5, dash: "dash" },
      text: cells.map((cell, i) => `${other.path}<br>${inPlot(named(axis, i))}<br>P = ${number(other.p[cell])}`),
      hovertemplate: "%{text}<extra></extra>",
    })),
    { x: axis.values, y: cells.map(value), mode: "lines+markers", line: { color: LINES[0], width: 2 },
      marker: { size: 5 }, name: run.path,
      text: cells.map((cell, i) => `${inPlot(named(axis, i))}<br>${inLines(described(cell))}`),
      hovertemplate: "%{text}<extra></extra>" },
    { x: [axis.values[place[index]]], y: [value(cellAt(run, place))], mode: "markers", hoverinfo: "skip",
      marker: marker(), showlegend: false },
  ];
  const sides = layout(heading(axis), view.comparison ? "Difference of P" : "Probability of instability P");
  if (axis.logarithmic) sides.xaxis.type = "log";
  sides.yaxis.rangemode = "tozero";
  sides.showlegend = others.length > 0;
  if (run.target && !view.comparison) {
    traces.unshift({
      x: [Math.min(...axis.values), Math.max(...axis.values)], y: [run.target.value, run.target.value], mode: "lines+text",
      line: { color: colour("--text"), width: 1, dash: "dash" }, text: ["", run.target.name], textposition: "top left",
      textfont: { size: 10, color: colour("--text") }, hoverinfo: "skip", showlegend: false,
    });
  }
  Plotly.react(target, traces, sides, config);
}

function drawSensitivity() {
  const { sensitivity } = view.run, cell = cellAt(view.run, place), target = element("sensitivity");
  element("sensitivity-section").hidden = !sensitivity.length || Boolean(view.comparison);
  if (element("sensitivity-section").hidden) return;
  if (target.childElementCount !== sensitivity.length) {
    target.replaceChildren(...sensitivity.map(() => Object.assign(document.createElement("div"), { className: "plot" })));
  }
  sensitivity.forEach(({ of, inputs }, i) => {
    const bars = (name, column, fill) => ({
      type: "bar", name, x: inputs.map(({ input }) => input), y: inputs.map((input) => input[column][cell]),
      error_y: { type: "data", array: inputs.map((input) => 1.96 * input[`${column}_error`][cell]), color: colour("--text") },
      marker: { color: fill }, hovertemplate: "%{x}: %{y:.4g}<extra></extra>",
    });
    const sides = layout("", `Sobol index of the ${of}`, { showlegend: true, barmode: "group" });
    const names = inputs.map(({ input }) => input);
    Object.assign(sides.xaxis, { tickvals: names, ticktext: names.map((of) => inPlot(inShortLines(of))) });
    sides.yaxis.rangemode = "tozero";
    const shown = [bars("first order", "first_order", LINES[0]), bars("total", "total", LINES[4])];
    Plotly.react(target.children[i], shown, sides, config);
  });
  if (details("sensitivity").open) fillTable("sensitivity");
}

function draw() {
  const { run } = view, cell = cellAt(run, place);
  const long = run.axes.map((axis, i) => [axis, i]).filter(([axis]) => axis.values.length > 1);
  write(element("selected"), [...long.map(([axis, i]) => named(axis, place[i])), described(cell)].join(", "));
  element("expected").textContent = aboutModel(cell);
  element("interval").textContent = (view.comparison ?? run).interval_name;
  element("sections").hidden = !isMap() || Boolean(run.verdicts && !view.comparison);
  details("map").hidden = run.horizontal === null;
  element("map").style.display = run.horizontal === null ? "none" : "";
  if (isMap()) {
    drawMap();
    drawSection("along-horizontal", run.horizontal);
    drawSection("along-vertical", run.vertical);
  } else if (run.horizontal !== null) {
    drawSection("map", run.horizontal);
  }
  ["map", "horizontal", "vertical"].filter((of) => details(of).open).forEach(fillTable);
  drawSensitivity();
}

function select(changes) {
  for (const [axis, position] of Object.entries(changes)) {
    place[axis] = Math.min(Math.max(position, 0), view.run.axes[axis].values.length - 1);
  }
  draw();
}

// Radio buttons for the views, and a slider for each long axis that the map does not show.
function addControls() {
  element("controls").replaceChildren();
  if (views.length > 1) {
    const group = document.createElement("fieldset");
    group.append(Object.assign(document.createElement("legend"), { textContent: "Shown" }));
    views.forEach((of, i) => {
      const label = document.createElement("label");
      const button = Object.assign(document.createElement("input"), {
        type: "radio", name: "view", value: i, checked: of === view,
      });
      button.addEventListener("change", () => show(of));
      label.append(button, ` ${of.label}`);
      group.append(label);
    });
    element("controls").append(group);
  }
  const { axes, vertical, horizontal } = view.run;
  axes.forEach((axis, i) => {
    if (axis.values.length < 2 || i === vertical || i === horizontal) return;
    const label = document.createElement("label");
    const output = document.createElement("output");
    const slider = Object.assign(document.createElement("input"), {
      type: "range", min: 0, max: axis.values.length - 1, step: 1, value: place[i], id: `axis-${i}`,
    });
    const update = () => write(output, named(axis, place[i]));
    slider.addEventListener("input", () => { select({ [i]: Number(slider.value) }); update(); });
    update();
    label.append(output, slider);
    element("controls").append(label);
  });
}

function show(wanted) {
  if (!sameAxes(wanted.run, view.run)) {
    place = start(wanted.run);
    ["map", "along-horizontal", "along-vertical"].forEach((id) => Plotly.purge(id));
    view = wanted;
    addControls();
    element("controls").querySelector("input:checked").focus();
  }
  view = wanted;
  draw();
  listen();
}

const nearest = (values, wanted) =>
  values.reduce((best, at, i) => (Math.abs(at - wanted) < Math.abs(values[best] - wanted) ? i : best), 0);

function listen() {
  const map = element("map");
  if (!map.on) return;
  map.removeAllListeners("plotly_click");
  map.on("plotly_click", (event) => {
    const { x, y } = event.points[0], { axes, horizontal, vertical } = view.run;
    const changes = horizontal === null ? {} : { [horizontal]: nearest(axes[horizontal].values, x) };
    if (isMap()) changes[vertical] = nearest(axes[vertical].values, y);
    select(changes);
  });
}

Object.keys(tables).forEach((of) => details(of).addEventListener("toggle", () => details(of).open && fillTable(of)));
element("map").addEventListener("keydown", (event) => {
  const { horizontal, vertical } = view.run;
  const moves = { ArrowLeft: [horizontal, -1], ArrowRight: [horizontal, 1], ArrowDown: [vertical, -1], ArrowUp: [vertical, 1] };
  const [axis, by] = moves[event.key] ?? [null, 0];
  if (axis === null) return;
  event.preventDefault();
  select({ [axis]: place[axis] + by });
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);

// On paper plots are as wide as the page, and in the light colours of the style for print.
const PAPER = 640;
const plots = () => document.querySelectorAll(".plot.js-plotly-plot");
function onPaper(isPrinted) {
  document.querySelectorAll("details.printed").forEach((of) => { of.open = isPrinted; });
  draw();
  plots().forEach((plot) => {
    const isHalf = plot.parentElement.classList.contains("pair");
    Plotly.relayout(plot, isPrinted ? { width: isHalf ? PAPER / 2 : PAPER, autosize: false } : { width: null, autosize: true });
  });
}
addEventListener("beforeprint", () => onPaper(true));
addEventListener("afterprint", () => onPaper(false));
addControls();
draw();
listen();
