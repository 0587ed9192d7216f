"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const drawn = [];
const night = matchMedia("(prefers-color-scheme: dark)");

function look(layout) {
  const style = getComputedStyle(document.documentElement);
  const ink = style.getPropertyValue("--ink").trim(), line = style.getPropertyValue("--line").trim();
  const changes = {"font.color": ink, paper_bgcolor: "rgba(0,0,0,0)", plot_bgcolor: "rgba(0,0,0,0)"};
  for (const axis of Object.keys(layout).filter((name) => /^[xy]axis\d*$/.test(name))) {
    Object.assign(changes, {[axis + ".gridcolor"]: line, [axis + ".linecolor"]: line, [axis + ".zerolinecolor"]: line});
  }
  return changes;
}

function scale(trace) {
  return trace.meta ? trace.meta[night.matches ? "night" : "day"] : trace.colorscale;
}

function draw(name, figure) {
  for (const trace of figure.data.filter((one) => one.meta)) trace.colorscale = scale(trace);
  if (matchMedia("(pointer: coarse)").matches) figure.layout.dragmode = false; // a finger scrolls the page
  const place = document.getElementById(name);
  const ready = Plotly.newPlot(place, figure.data, figure.layout, {displayModeBar: false, responsive: true});
  drawn.push(place);
  return ready.then(() => Plotly.relayout(place, look(figure.layout)));
}

night.addEventListener("change", () => {
  for (const place of drawn) {
    place.data.forEach((trace, index) => { if (trace.meta) Plotly.restyle(place, {colorscale: [scale(trace)]}, index); });
    Plotly.relayout(place, look(place.layout));
  }
});

function inOrder(one, other) {
  if (one === "" || other === "") return (one === "") - (other === "");
  return one - other || one.localeCompare(other);
}

function sort(heading) {
  const turned = heading.getAttribute("aria-sort") === "ascending" ? -1 : 1;
  for (const other of heading.parentElement.cells) other.removeAttribute("aria-sort");
  heading.setAttribute("aria-sort", turned > 0 ? "ascending" : "descending");
  const body = heading.closest("table").tBodies[0], cell = (row) => row.cells[heading.cellIndex].textContent;
  body.append(...Array.from(body.rows).sort((one, other) => turned * inOrder(cell(one), cell(other))));
}

for (const button of document.querySelectorAll("thead button")) {
  button.addEventListener("click", () => sort(button.parentElement));
}

function choose(select, picture) {
  const seen = new Set(picture.choices[select.value]);
  Plotly.restyle(picture.name, {visible: picture.data.map((_, index) => seen.has(index))});
}

const waiting = data.pictures.map((picture) => draw(picture.name, picture));
for (const select of document.querySelectorAll("select[data-picture]")) {
  const picture = data.pictures.find((one) => one.name === select.dataset.picture);
  select.addEventListener("change", () => choose(select, picture));
}

function move({t, places, profile, map}) {
  const bytes = Uint8Array.from(atob(document.getElementById("field").textContent), (sign) => sign.charCodeAt(0));
  const numbers = new Float32Array(bytes.buffer);
  const rows = places.map(({start, points}) => t.map((_, i) => numbers.subarray(start + i * points, start + (i + 1) * points)));
  const slider = document.getElementById("time"), button = document.getElementById("play"), now = document.getElementById("now");
  profile.data.forEach((trace, index) => { trace.y = rows[index][0]; });
  map.data[0].z = rows[0];
  let timer = null;

  function show(frame) {
    const told = "t = " + Number(t[frame].toPrecision(6));
    slider.value = frame;
    slider.setAttribute("aria-valuetext", told);
    now.textContent = told;
    Plotly.restyle("profile", {y: rows.map((series) => series[frame])});
    // A whole shape moves alone; with a part of one, plotly draws the map again, which takes a hundred times as long.
    Plotly.relayout("map", {shapes: [{...map.layout.shapes[0], y0: t[frame], y1: t[frame]}]});
  }

  function stop() {
    clearInterval(timer);
    timer = null;
    button.textContent = "Play";
    button.setAttribute("aria-label", "Play the run");
  }

  function play() {
    if (Number(slider.value) === t.length - 1) show(0);
    timer = setInterval(() => (Number(slider.value) < t.length - 1 ? show(Number(slider.value) + 1) : stop()), 40);
    button.textContent = "Pause";
    button.setAttribute("aria-label", "Pause the run");
  }

  button.addEventListener("click", () => (timer === null ? play() : stop()));
  slider.addEventListener("input", () => { if (timer !== null) stop(); show(Number(slider.value)); });
  return Promise.all([draw("profile", profile), draw("map", map)]).then(() => {
    document.getElementById("map").on("plotly_click", (event) => { if (timer !== null) stop(); show(event.points[0].pointIndex[0]); });
    show(0);
  });
}

if (data.moving) waiting.push(move(data.moving));
Promise.all(waiting).then(() => { document.body.dataset.ready = "yes"; });
