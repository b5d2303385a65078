"use strict";
// Choices, filters and the chosen cell live in the part of the address behind #, so a link shows the same again.

const $ = (id) => document.getElementById(id);
const form = $("controls");
const control = (name) => form.elements[name];
const parameters = new Map(DATA.parameters.map((each) => [each.name, each]));
const numbers = new Map(DATA.numbers.map((each) => [each.name, each.values]));
const curves = new Map(DATA.curves.map((each) => [each.name, { ...each, values: unpacked(each.values) }]));
const COUNT = DATA.runs.ids.length;
const SETTINGS = ["view", "rows", "cols", "x", "value", "curve", "of", "scale"];
// Lines that can be told apart, runs that are listed, and points above which the processor for graphics draws.
const MOST_LINES = 12, MOST_LISTED = 50, MANY_POINTS = 3000;
// Shades of the lines of parallel coordinates, and pixels that the number of a cell needs.
const SHADES = 24, NUMBER_WIDTH = 44;
// Colours of the scale Cividis at its beginning, middle and end.
const STOPS = [[253, 231, 55], [124, 123, 120], [0, 34, 78]];
const LAYOUT = { margin: { l: 20, r: 20, t: 20, b: 40 }, font: { family: "system-ui, sans-serif", size: 13 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff", hoverlabel: { align: "left" } };
const CONFIG = { responsive: true, displaylogo: false, plotlyServerURL: "", modeBarButtonsToRemove: ["select2d", "lasso2d", "sendChartToCloud"] };
const COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#7a5200", "#555555", "#5e3c99", "#1b7837", "#b2182b", "#2166ac"];
const LINES = DATA.look.lines.length ? DATA.look.lines : COLOURS;
const CELLS = DATA.look.cells.length ? { colorscale: DATA.look.cells.map((colour, at, all) => [at / (all.length - 1), `rgb(${colour.join()})`]) } : { colorscale: "Cividis", reversescale: true };
const SHADES_OF = DATA.look.cells.length ? DATA.look.cells : STOPS;
const DASHES = ["solid", "dash", "dot", "dashdot"];

let defaults = {};
// The runs of the chosen cell, line or point: a key, and a name for it.
let chosen = null;
let groupsShown = new Map();
// How the keys of groups read.
let spokenKeys = new Map();

// How names and values read. Keys, and the address, hold the names themselves.
const word = (name) => DATA.look.labels[name] ?? name;
const valueWord = (name, value) => DATA.look.labels[`${name}=${value}`] ?? value;
const JOIN = Object.keys(DATA.look.labels).length ? ", " : " ";
const spoken = (name, value) => (parameters.has(name) ? DATA.look.labels[`${name}=${value}`] ?? `${word(name)}=${value}` : value);

function unpacked(text) {
  const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  return new Float32Array(bytes.buffer);
}

function shown(value) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  return Math.abs(value) >= 1000 ? Math.round(value).toLocaleString("en") : String(Number(value.toPrecision(3)));
}

function statistic(values, of) {
  const known = values.filter((value) => value !== null && !Number.isNaN(value));
  if (!known.length) return null;
  if (of === "min") return Math.min(...known);
  if (of === "max") return Math.max(...known);
  if (of === "mean") return known.reduce((sum, value) => sum + value, 0) / known.length;
  known.sort((a, b) => a - b);
  const middle = known.length >> 1;
  return known.length % 2 ? known[middle] : (known[middle - 1] + known[middle]) / 2;
}

function element(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

// ---- Choices

function options(select, names) {
  select.replaceChildren(...names.map((name) => element("option", { value: name, textContent: word(name) })));
}

function prepare() {
  const names = [...parameters.keys()];
  options(control("rows"), [...names, "(all)"]);
  options(control("cols"), [...names, "(all)"]);
  options(control("x"), [...numbers.keys(), ...names]);
  options(control("value"), [...numbers.keys()]);
  options(control("curve"), [...curves.keys()]);
  const rows = names.find((name) => !name.includes(".")) ?? names[0] ?? "(all)";
  const others = names.filter((name) => name !== rows && name !== "seed");
  const most = others.reduce((best, name) => (parameters.get(name).values.length > parameters.get(best).values.length ? name : best), others[0]);
  control("rows").value = rows;
  control("cols").value = most ?? "(all)";
  control("x").value = most ?? control("x").value;
  for (const [name, value] of Object.entries(DATA.fixed)) {
    $("fixed").append(element("dt", { textContent: word(name) }), element("dd", { textContent: valueWord(name, value) }));
  }
  for (const parameter of parameters.values()) {
    const group = element("fieldset", {}, element("legend", { textContent: word(parameter.name) }));
    parameter.values.forEach((value, place) => {
      const box = element("input", { type: "checkbox", checked: true });
      Object.assign(box.dataset, { parameter: parameter.name, place });
      group.append(element("label", {}, box, valueWord(parameter.name, value)));
    });
    $("filter-list").append(group);
  }
  if (DATA.look.scale) control("scale").value = DATA.look.scale;
  defaults = Object.fromEntries(SETTINGS.map((name) => [name, control(name).value]));
}

function boxes(name) {
  return [...document.querySelectorAll("#filter-list input")].filter((box) => box.dataset.parameter === name);
}

function allowed() {
  const filters = [];
  for (const [name, { index }] of parameters) {
    const all = boxes(name);
    if (all.some((box) => !box.checked)) filters.push({ index, set: all.map((box) => box.checked) });
  }
  const runs = [];
  for (let run = 0; run < COUNT; run++) if (filters.every(({ index, set }) => set[index[run]])) runs.push(run);
  return runs;
}

function toAddress() {
  const state = new URLSearchParams();
  for (const name of SETTINGS) if (control(name).value !== defaults[name]) state.set(name, control(name).value);
  for (const [name, { values }] of parameters) {
    const all = boxes(name);
    if (all.some((box) => !box.checked)) {
      state.set(`only.${name}`, values.filter((_, place) => all[place].checked).join("|"));
    }
  }
  if (chosen !== null) state.set("chosen", chosen);
  history.replaceState(null, "", `#${state}`);
}

function fromAddress() {
  const state = new URLSearchParams(location.hash.slice(1));
  for (const name of SETTINGS) {
    const wanted = state.get(name) ?? defaults[name];
    if ([...control(name).options].some((option) => option.value === wanted)) control(name).value = wanted;
  }
  for (const [name, { values }] of parameters) {
    const only = state.get(`only.${name}`)?.split("|");
    boxes(name).forEach((box, place) => { box.checked = !only || only.includes(values[place]); });
  }
  chosen = state.get("chosen");
}

// ---- Groups of runs

function valueOf(name, run) {
  const parameter = parameters.get(name);
  return parameter ? parameter.values[parameter.index[run]] : "all runs";
}

function placesOf(name, runs) {
  const parameter = parameters.get(name);
  if (!parameter) return ["all runs"];
  const there = new Set(runs.map((run) => parameter.index[run]));
  return parameter.values.filter((_, place) => there.has(place));
}

function grouped(runs, keyOf) {
  const groups = new Map();
  for (const run of runs) {
    const key = keyOf(run);
    if (!groups.has(key)) groups.set(key, []);
    groups.get(key).push(run);
  }
  return groups;
}

function named(name, value) {
  return parameters.has(name) ? `${name}=${value}` : value;
}

// ---- Views: each draws, fills the table, and returns a heading and a line of text

function heatmap(runs) {
  const [rows, cols, value, of, scale] = ["rows", "cols", "value", "of", "scale"].map((name) => control(name).value);
  const down = placesOf(rows, runs), across = placesOf(cols, runs);
  const key = (row, column) => (rows === cols ? named(rows, row) : `${named(rows, row)} ${named(cols, column)}`);
  groupsShown = grouped(runs, (run) => key(valueOf(rows, run), valueOf(cols, run)));
  const column = numbers.get(value);
  const cells = down.map((row) => across.map((each) => {
    const group = rows === cols && row !== each ? undefined : groupsShown.get(key(row, each));
    spokenKeys.set(key(row, each), rows === cols ? spoken(rows, row) : `${spoken(rows, row)}${JOIN}${spoken(cols, each)}`);
    return { key: key(row, each), count: group?.length ?? 0, value: group ? statistic(group.map((run) => column[run]), of) : null };
  }));
  const log = scale === "log";
  const z = cells.map((row) => row.map((cell) => (cell.value === null || (log && cell.value <= 0) ? null : log ? Math.log10(cell.value) : cell.value)));
  const all = z.flat().filter((each) => each !== null);
  const ticks = log && all.length ? logTicks(Math.min(...all), Math.max(...all)) : {};
  draw([{
    type: "heatmap", x: across.map((each) => valueWord(cols, each)), y: down.map((each) => valueWord(rows, each)), z, ...CELLS, xgap: 2, ygap: 2,
    text: cells.map((row) => row.map((cell) => (cell.count ? shown(cell.value) : ""))), texttemplate: $("chart").clientWidth / (across.length + 3) >= NUMBER_WIDTH ? "%{text}" : "",
    customdata: cells.map((row) => row.map((cell) => `${spokenKeys.get(cell.key)}<br>${word(value)}: ${shown(cell.value)} (${cell.count} runs)`)),
    hovertemplate: "%{customdata}<extra></extra>", colorbar: { title: { text: word(value), side: "right" }, thickness: 14, ...ticks },
  }], {
    xaxis: { title: { text: word(cols) }, type: "category", automargin: true }, yaxis: { title: { text: word(rows) }, type: "category", autorange: "reversed", automargin: true },
    height: Math.max(320, 110 + 34 * down.length),
  }, (point) => cells[point.pointIndex[0]][point.pointIndex[1]].key);
  const head = element("tr", {}, element("th", { scope: "col", textContent: `${word(rows)} ╲ ${word(cols)}` }), ...across.map((each) => element("th", { scope: "col", textContent: valueWord(cols, each) })));
  fillTable(head, down.map((row, at) => element("tr", {}, element("th", { scope: "row", textContent: valueWord(rows, row) }), ...cells[at].map((cell) => element("td", {}, cell.count ? chooser(cell.key, shown(cell.value)) : "")))));
  return [`${word(value)} by ${word(rows)} and ${word(cols)}`, `${groupsShown.size} cells with runs, ${of} of the runs of a cell`];
}

function logTicks(low, high) {
  const values = [];
  for (let decade = Math.floor(low); decade <= Math.ceil(high); decade++) for (const digit of [1, 2, 5]) values.push(digit * 10 ** decade);
  const within = values.filter((value) => Math.log10(value) >= low - 0.05 && Math.log10(value) <= high + 0.05);
  return within.length ? { tickvals: within.map(Math.log10), ticktext: within.map(shown) } : {};
}

function mean(name, group, of) {
  const { trials, values } = curves.get(name);
  return Array.from({ length: trials }, (_, trial) => statistic(group.map((run) => values[run * trials + trial]), of));
}

function curveView(runs) {
  const [rows, curve, of, scale] = ["rows", "curve", "of", "scale"].map((name) => control(name).value);
  groupsShown = grouped(runs, (run) => named(rows, valueOf(rows, run)));
  const keys = placesOf(rows, runs).map((value) => {
    spokenKeys.set(named(rows, value), spoken(rows, value));
    return named(rows, value);
  });
  const drawn = keys.slice(0, MOST_LINES).map((key) => ({ key, y: mean(curve, groupsShown.get(key), of) }));
  draw(drawn.map(({ key, y }, at) => ({
    type: "scatter", mode: "lines", y, name: spokenKeys.get(key), line: { color: LINES[at], dash: DASHES[at % DASHES.length], width: 2 }, hovertemplate: `trial %{x}: %{y:.4g}<extra>${spokenKeys.get(key)}</extra>`,
  })), { xaxis: { title: { text: "trial" }, automargin: true }, yaxis: { title: { text: word(curve) }, type: scale, automargin: true }, hovermode: "closest", showlegend: true, legend: { orientation: "h", y: -0.2 }, height: 480 }, (point) => drawn[point.curveNumber].key);
  const places = [0, 9, 29, 49, 99].filter((trial) => trial < curves.get(curve).trials);
  const head = element("tr", {}, ...["line", "runs", ...places.map((trial) => `trial ${trial}`)].map((each) => element("th", { scope: "col", textContent: each })));
  fillTable(head, drawn.map(({ key, y }) => element("tr", {}, element("th", { scope: "row" }, chooser(key, spokenKeys.get(key))), element("td", { textContent: groupsShown.get(key).length }), ...places.map((trial) => element("td", { textContent: shown(y[trial]) })))));
  const more = keys.length > MOST_LINES ? `; the first ${MOST_LINES} of ${keys.length} lines, choose with filters` : "";
  return [`${word(curve)} by ${word(rows)}`, `${drawn.length} lines, ${of} of the runs of a line${more}`];
}

function scatter(runs) {
  const [rows, x, value, scale] = ["rows", "x", "value", "scale"].map((name) => control(name).value);
  const column = numbers.get(value), isNumber = numbers.has(x);
  const at = (run) => (isNumber ? numbers.get(x)[run] : valueWord(x, valueOf(x, run)));
  groupsShown = new Map(runs.map((run) => [DATA.runs.ids[run], [run]]));
  const lines = placesOf(rows, runs).map((row) => ({ row, runs: runs.filter((run) => valueOf(rows, run) === row) }));
  draw(lines.map((line, place) => ({
    type: runs.length > MANY_POINTS ? "scattergl" : "scatter", mode: "markers", name: spoken(rows, line.row), x: line.runs.map(at), y: line.runs.map((run) => column[run]),
    marker: { color: LINES[place % LINES.length], size: 8, opacity: 0.75, symbol: place % 8 }, text: line.runs.map((run) => DATA.runs.commands[run]), hovertemplate: "%{text}<br>%{x}: %{y:.5g}<extra></extra>",
  })), {
    xaxis: { title: { text: word(x) }, automargin: true, type: isNumber ? scale : "category", ...(isNumber ? {} : { categoryorder: "array", categoryarray: placesOf(x, runs).map((each) => valueWord(x, each)) }) },
    yaxis: { title: { text: word(value) }, type: scale, automargin: true }, hovermode: "closest", showlegend: lines.length > 1, legend: { orientation: "h", y: -0.2 }, height: 480,
  }, (point) => DATA.runs.ids[lines[point.curveNumber].runs[point.pointNumber]]);
  listRuns(runs, value);
  return [`${word(value)} by ${word(x)}`, "A point for each run"];
}

// Lines of one shade are one trace: thousands of lines are drawn at once, and without a processor for graphics.
function parallel(runs) {
  const [value, scale] = ["value", "scale"].map((name) => control(name).value);
  const log = scale === "log", column = numbers.get(value);
  groupsShown = new Map(runs.map((run) => [DATA.runs.ids[run], [run]]));
  const there = runs.filter((run) => column[run] !== null && (!log || column[run] > 0));
  const level = (run) => (log ? Math.log10(column[run]) : column[run]);
  let low = Infinity, high = -Infinity;
  for (const run of there) { low = Math.min(low, level(run)); high = Math.max(high, level(run)); }
  const share = (run) => (high > low ? (level(run) - low) / (high - low) : 0.5);
  const names = [...parameters.keys()], axes = [...names, value];
  const places = names.map((name) => placesOf(name, there));
  const heights = names.map((name, at) => {
    const height = new Map(places[at].map((each, number) => [each, places[at].length > 1 ? number / (places[at].length - 1) : 0.5]));
    return parameters.get(name).values.map((each) => height.get(each));
  });
  const bins = Array.from({ length: SHADES }, () => ({ x: [], y: [], runs: [] }));
  // Shades by rank: a few great values would leave only the lightest for all others.
  const ranked = [...there].sort((a, b) => level(a) - level(b));
  for (const [rank, run] of ranked.entries()) {
    const bin = bins[Math.floor((rank * SHADES) / ranked.length)];
    names.forEach((name, at) => { bin.x.push(at); bin.y.push(heights[at][parameters.get(name).index[run]]); bin.runs.push(run); });
    bin.x.push(names.length, null); bin.y.push(share(run), null); bin.runs.push(run, null);
  }
  const shade = (at) => {
    const part = ((SHADES_OF.length - 1) * at) / (SHADES - 1), first = Math.min(SHADES_OF.length - 2, Math.floor(part));
    return `rgb(${SHADES_OF[first].map((from, each) => Math.round(from + (part - first) * (SHADES_OF[first + 1][each] - from))).join()})`;
  };
  // The greatest first, so that the least lie above.
  const drawn = bins.map((bin, at) => ({ bin, at })).filter(({ bin }) => bin.runs.length).reverse();
  const strength = Math.max(0.15, Math.min(0.8, 60 / Math.sqrt(there.length + 1)));
  const labels = names.flatMap((name, at) => places[at].map((each, number) => ({ x: at, y: places[at].length > 1 ? number / (places[at].length - 1) : 0.5, text: valueWord(name, each) })));
  const ends = [0, 0.25, 0.5, 0.75, 1].map((part) => ({ x: names.length, y: part, text: shown(log ? 10 ** (low + part * (high - low)) : low + part * (high - low)) }));
  const step = (at) => (places[at]?.length > 24 ? Math.ceil(places[at].length / 24) : 1);
  draw(drawn.map(({ bin, at }) => ({ type: "scatter", mode: "lines", x: bin.x, y: bin.y, line: { color: shade(at), width: 1.5 }, opacity: strength, hoverinfo: "none" })), {
    xaxis: { tickvals: axes.map((_, at) => at), ticktext: axes.map(word), side: "top", range: [-0.6, axes.length - 0.4], zeroline: false, automargin: true, fixedrange: true },
    yaxis: { visible: false, range: [-0.08, 1.06], fixedrange: true }, showlegend: false, hovermode: "closest", height: 520,
    annotations: [...labels.filter(({ x, y }) => Math.round(y * (places[x].length - 1)) % step(x) === 0), ...ends].map((each) => ({ ...each, showarrow: false, xanchor: "right", font: { size: 11 }, bgcolor: "rgba(255,255,255,0.8)" })),
  }, (point) => DATA.runs.ids[drawn[point.curveNumber].bin.runs[point.pointNumber]]);
  listRuns(there, value);
  return [`${word(value)}, all parameters`, `A line for each run, dark where ${word(value)} is great`];
}

const VIEWS = { heatmap, curves: curveView, scatter, parallel };

// ---- Picture, table, and what was chosen

function draw(traces, layout, keyOf) {
  const chart = $("chart");
  Plotly.react(chart, traces, { ...LAYOUT, ...layout }, CONFIG).then(() => {
    quieten(chart);
    chart.removeAllListeners("plotly_click");
    chart.on("plotly_click", (event) => { const key = keyOf(event.points[0]); if (key !== null) choose(key); });
  });
}

// Of a picture, the buttons above it are read aloud; its numbers are in the table.
function quieten(chart) {
  for (const drawn of chart.querySelectorAll("svg")) drawn.setAttribute("aria-hidden", "true");
}

function chooser(key, label) {
  const button = element("button", { type: "button", textContent: label, onclick: () => choose(key) });
  button.setAttribute("aria-label", `${spokenKeys.get(key) ?? key}: ${label}, show its runs`);
  button.dataset.key = key;
  return button;
}

function fillTable(head, rows) {
  const table = element("table", {}, element("thead", {}, head), element("tbody", {}, ...rows));
  table.setAttribute("aria-labelledby", "chart-heading");
  $("table").replaceChildren(table);
}

function listRuns(runs, value) {
  const column = numbers.get(value);
  const sorted = [...runs].sort((a, b) => (column[a] ?? Infinity) - (column[b] ?? Infinity)).slice(0, MOST_LISTED);
  const names = [...parameters.keys()];
  const head = element("tr", {}, ...[value, ...names].map((each) => element("th", { scope: "col", textContent: word(each) })));
  fillTable(head, sorted.map((run) => element("tr", {}, element("td", {}, chooser(DATA.runs.ids[run], shown(column[run]))), ...names.map((name) => element("td", { textContent: valueWord(name, valueOf(name, run)) })))));
}

function choose(key) {
  chosen = key;
  showChosen();
  toAddress();
  $("chosen-heading").focus({ preventScroll: true });
  $("chosen").scrollIntoView({ block: "nearest" });
}

function showChosen() {
  const group = chosen === null ? undefined : groupsShown.get(chosen);
  for (const button of document.querySelectorAll("#table button")) button.setAttribute("aria-pressed", button.dataset.key === chosen);
  $("chosen").hidden = !group;
  if (!group) { chosen = null; return; }
  $("chosen-heading").textContent = `${spokenKeys.get(chosen) ?? chosen}: ${group.length} run${group.length === 1 ? "" : "s"}`;
  const value = control("value").value, curve = control("curve").value;
  $("chosen-runs").replaceChildren(...group.slice(0, MOST_LISTED).map((run) => {
    const command = DATA.runs.commands[run];
    const copy = element("button", { type: "button", textContent: "Copy", ariaLabel: `Copy: ${command}`, onclick: () => navigator.clipboard?.writeText(command).then(() => { $("status").textContent = "Copied the command"; }) });
    const link = element("a", { href: DATA.address.replace("RUN_ID", DATA.runs.ids[run]), target: "_blank", rel: "noopener", textContent: "MLflow run", ariaLabel: `MLflow run ${DATA.runs.ids[run].slice(0, 8)}` });
    return element("li", {}, `${word(value)}: ${shown(numbers.get(value)[run])} · `, link, " ", copy, element("br", {}), element("code", { textContent: command }));
  }));
  if (group.length > MOST_LISTED) $("chosen-runs").append(element("li", { textContent: `and ${group.length - MOST_LISTED} more` }));
  if (!curves.size) return;
  const scale = control("scale").value;
  Plotly.react($("chosen-chart"), group.slice(0, MOST_LINES).map((run, at) => ({ type: "scatter", mode: "lines", y: mean(curve, [run], "mean"), name: DATA.runs.ids[run].slice(0, 8), line: { color: LINES[at % LINES.length], width: 1.5 } })),
    { ...LAYOUT, xaxis: { title: { text: "trial" }, automargin: true }, yaxis: { title: { text: word(curve) }, type: scale, automargin: true }, height: 300, showlegend: false }, CONFIG).then(() => quieten($("chosen-chart")));
}

function update() {
  const view = control("view").value;
  for (const label of form.querySelectorAll("[data-for]")) label.hidden = !label.dataset.for.split(" ").includes(view);
  $("rows-label").textContent = { heatmap: "Rows", curves: "Lines", scatter: "Colours" }[view] ?? "Rows";
  const runs = allowed();
  $("filtered").textContent = runs.length < COUNT ? `(${runs.length.toLocaleString("en")} of ${COUNT.toLocaleString("en")} runs)` : "";
  if (!runs.length) {
    $("chart-heading").textContent = "No run is left";
    $("status").textContent = "The filters leave out all runs";
    groupsShown = new Map();
    Plotly.purge($("chart"));
    $("table").replaceChildren();
  } else {
    const [heading, status] = VIEWS[view](runs);
    $("chart-heading").textContent = heading;
    $("status").textContent = `${status}, ${runs.length.toLocaleString("en")} of ${COUNT.toLocaleString("en")} runs`;
  }
  showChosen();
  toAddress();
}

form.addEventListener("change", update);
form.addEventListener("submit", (event) => event.preventDefault());
$("filter-list").addEventListener("change", update);
$("reset").addEventListener("click", () => { history.replaceState(null, "", "#"); fromAddress(); update(); });
addEventListener("hashchange", () => { fromAddress(); update(); });
prepare();
fromAddress();
update();
