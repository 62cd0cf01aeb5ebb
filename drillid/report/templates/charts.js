"use strict";
// Draws the charts of a well, gives them the page's colours and units, and shows the spectra of a window.
const held = JSON.parse(document.getElementById("charts").textContent);
const models = new Map();
let drawn = null;
let units = "metric";

function named(name) {
  return models.get(held.looked_up.named[name]);
}

function scaled(model, scale, factor) {
  if (typeof scale === "number") {
    const ends = { start: model.start * factor(scale), end: model.end * factor(scale) };
    const reset = { reset_start: ends.start, reset_end: ends.end };
    const { bounds } = model;
    // bounds in the other unit would clamp the ends
    model.bounds = null;
    model.setv({ ...ends, ...reset });
    model.bounds = Array.isArray(bounds) ? bounds.map((bound) => bound * factor(scale)) : bounds;
    return;
  }
  const data = { ...model.data };
  for (const [column, ratio] of Object.entries(scale)) {
    data[column] = Float64Array.from(data[column], (value) => value * factor(ratio));
  }
  model.data = data;
}

// Tags of a model say what the page changes in it, see style.py
function look() {
  const style = getComputedStyle(document.documentElement);
  const chosen = document.documentElement.dataset.units;
  const factor = (scale) => (chosen === units ? 1 : chosen === "oilfield" ? scale : 1 / scale);
  for (const model of models.values()) {
    const [tags] = model.tags ?? [];
    if (!tags) continue;
    const changes = { ...tags[chosen] };
    for (const [property, colour] of Object.entries(tags.colours ?? {})) {
      changes[property] = colour === "none" ? null : style.getPropertyValue(`--${colour}`).trim();
    }
    if (Object.keys(changes).length) model.setv(changes);
    if (tags.scale && chosen !== units) scaled(model, tags.scale, factor);
  }
  units = chosen;
}

function showWindow(row) {
  const rows = named("maps");
  for (const name of ["spectra", "steps"]) {
    const target = named(name);
    const data = { ...target.data };
    for (const column of Object.keys(data)) {
      if (column in rows.data) data[column] = Float32Array.from(rows.data[column][row]);
    }
    target.data = data;
  }
  const select = document.getElementById("window");
  select.value = String(row);
  const words = select.selectedOptions[0].textContent.trim();
  document.getElementById("window-shown").textContent = words;
  named("shown").data = { depth: Float64Array.of(rows.data.depth[row]) };
}

function nearestRow(index) {
  const number = named("windows").data.window[index];
  const numbers = [...named("maps").data.window];
  const distance = numbers.map((other) => Math.abs(other - number));
  return distance.indexOf(Math.min(...distance));
}

function zoom(top, bottom) {
  const depths = named("depths");
  depths.setv({ start: bottom, end: top });
}

function step(factor) {
  const { start, end } = named("depths");
  const [middle, half] = [(start + end) / 2, (Math.abs(start - end) / 2) * factor];
  zoom(middle - half, middle + half);
}

function listen() {
  const select = document.getElementById("window");
  select.addEventListener("change", () => showWindow(Number(select.value)));
  for (const button of document.querySelectorAll("button[data-move]")) {
    button.addEventListener("click", () => {
      const row = Number(select.value) + Number(button.dataset.move);
      if (row >= 0 && row < select.options.length) showWindow(row);
    });
  }
  for (const button of document.querySelectorAll("button[data-zoom]")) {
    button.addEventListener("click", () => {
      if (button.dataset.zoom === "all") zoom(named("depths").reset_end, named("depths").reset_start);
      else step(Number(button.dataset.zoom));
    });
  }
  const { selected } = named("windows");
  selected.change.connect(() => {
    const [index] = selected.indices;
    if (index === undefined) return;
    selected.indices = [];
    showWindow(nearestRow(index));
  });
}

// The log plot first; the other charts one by one as soon as the page has nothing else to do
async function draw() {
  await Bokeh.embed.embed_items({ well: held.document }, []);
  [drawn] = Bokeh.documents;
  for (const model of drawn.all_models) models.set(model.id, model);
  look();
  showWindow(Number(document.getElementById("window").value));
  const charts = Object.entries(held.looked_up.roots).map(([element, root]) => [document.getElementById(element), models.get(root)]);
  for (const [, root] of charts) drawn.remove_root(root);
  const elements = [];
  const views = await Bokeh.embed.add_document_standalone(drawn, document.body, elements);
  for (const [element, root] of charts) {
    elements.push(element);
    drawn.add_root(root);
    if (root === charts[0][1]) {
      await finished(views, root);
      listen();
      document.addEventListener("drillid-look", look);
      document.documentElement.dataset.drawn = "true";
    }
    await idle();
  }
  for (const [, root] of charts) await finished(views, root);
  document.documentElement.dataset.complete = "true";
}

function idle() {
  return new Promise((done) => { requestIdleCallback(done, { timeout: 200 }); });
}

function finished(views, root) {
  return new Promise((done) => {
    const ask = () => { if (views.get(root)?.has_finished()) done(); else setTimeout(ask, 20); };
    ask();
  });
}

draw();
