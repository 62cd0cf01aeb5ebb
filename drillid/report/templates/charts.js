"use strict";
// Draws the charts of a well, gives them the page's colours and units, and shows the spectra of a window.
const FOOT = 0.3048;
const parts = [];
let dressing = false;

// A document of charts in the page: its models by their identifiers, and those with a name
async function read(element) {
  const held = JSON.parse(document.getElementById(element).textContent);
  await Bokeh.embed.embed_items({ [element]: held.document }, []);
  const content = Bokeh.documents.at(-1);
  const models = new Map([...content.all_models].map((model) => [model.id, model]));
  const part = { content, models, looked_up: held.looked_up, units: "metric" };
  parts.push(part);
  dress(part);
  return part;
}

function named(name) {
  const part = parts.find(({ looked_up }) => name in looked_up.named);
  return part?.models.get(part.looked_up.named[name]);
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
    const times = factor(ratio);
    if (typeof data[column][0] === "number") data[column] = Float64Array.from(data[column], (value) => value * times);
    else for (const image of data[column]) image.forEach((value, index) => { image[index] = value * times; });
  }
  model.data = data;
}

// Tags of a model say what the page changes in it, see style.py
function dress(part) {
  const style = getComputedStyle(document.documentElement);
  const chosen = document.documentElement.dataset.units;
  const factor = (scale) => (chosen === part.units ? 1 : chosen === "oilfield" ? scale : 1 / scale);
  dressing = true;
  for (const model of part.models.values()) {
    const [tags] = model.tags ?? [];
    if (!tags) continue;
    const changes = { ...tags[chosen] };
    for (const [property, colour] of Object.entries(tags.colours ?? {})) {
      changes[property] = colour === "none" ? null : style.getPropertyValue(`--${colour}`).trim();
    }
    if (Object.keys(changes).length) model.setv(changes);
    if (tags.scale && chosen !== part.units) scaled(model, tags.scale, factor);
  }
  part.units = chosen;
  dressing = false;
}

function look() {
  for (const part of parts) dress(part);
  if (named("maps")) nameWindows();
}

function nameWindows() {
  const oilfield = document.documentElement.dataset.units === "oilfield";
  const select = document.getElementById("window");
  for (const { dataset: { before, depth, after }, index } of select.options) {
    const place = oilfield ? `${(depth / FOOT).toFixed(0)} ft` : `${Number(depth).toFixed(1)} m`;
    select.options[index].textContent = `${before}${place}${after}`;
  }
  document.getElementById("window-shown").textContent = select.selectedOptions[0].textContent;
  named("shown").location = named("maps").data.depth[Number(select.value)];
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
  document.getElementById("window").value = String(row);
  nameWindows();
}

function nearestRow(index) {
  const number = named("windows").data.window[index];
  const numbers = [...named("maps").data.window];
  const distance = numbers.map((other) => Math.abs(other - number));
  return distance.indexOf(Math.min(...distance));
}

function zoom(top, bottom) {
  named("depths").setv({ start: bottom, end: top });
}

function step(factor) {
  const { start, end } = named("depths");
  const [middle, half] = [(start + end) / 2, (Math.abs(start - end) / 2) * factor];
  zoom(middle - half, middle + half);
}

// The log plot and the maps are documents of their own: what one of them shows, the other does
function link(one, other) {
  for (const [from, to] of [[one, other], [other, one]]) {
    from.change.connect(() => {
      const { start, end } = from;
      if (!dressing && (to.start !== start || to.end !== end)) to.setv({ start, end });
    });
  }
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

// Roots of a document that is shown without any, each to be put into its element
async function unrooted({ content, models, looked_up }) {
  const charts = Object.entries(looked_up.roots).map(([element, root]) => ({ place: document.getElementById(element), root: models.get(root) }));
  for (const { root } of charts) content.remove_root(root);
  const elements = [];
  const views = await Bokeh.embed.add_document_standalone(content, document.body, elements);
  return { charts, views, put: ({ place, root }) => { elements.push(place); content.add_root(root); } };
}

// The log plot first; the other charts one by one as soon as the page has nothing else to do, the nearest to what is seen first
async function draw() {
  document.addEventListener("drillid-look", look);
  const log = await read("log-chart");
  const first = await unrooted(log);
  first.put(first.charts[0]);
  await finished(first.views, first.charts[0].root);
  document.documentElement.dataset.drawn = "true";
  await idle();
  const others = await unrooted(await read("charts"));
  showWindow(Number(document.getElementById("window").value));
  link(named("depths"), named("map_depths"));
  listen();
  for (const left = [...others.charts]; left.length;) {
    await idle();
    left.sort((one, other) => away(other) - away(one));
    others.put(left.pop());
  }
  for (const { root } of others.charts) await finished(others.views, root);
  document.documentElement.dataset.complete = "true";
}

// Pixels between a chart's place and what is seen of the page
function away({ place }) {
  const { top, bottom } = place.getBoundingClientRect();
  return Math.max(top - innerHeight, -bottom, 0);
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
