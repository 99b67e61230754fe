"use strict";
// Draws the shapes of a moment as SVG, and plays them in real time. Nothing moves until somebody asks for it.
(() => {
  const film = DATA.film, SVG = "http://www.w3.org/2000/svg", MARGIN = 0.08;
  const COLOURS = { cart: "state", pole: "ink", tip: "control", ground: "output", black: "ink", orange: "output", sky: "path",
                    green: "algebraic", blue: "state", vermilion: "control", purple: "costate" };
  const picture = document.querySelector("#film svg"), slider = document.getElementById("moment");
  const clock = document.getElementById("clock"), button = document.getElementById("play");
  const [[left, bottom], [right, top]] = film.box;
  const margin = MARGIN * Math.max(right - left, top - bottom) || 0.5;
  const width = right - left + 2 * margin, height = top - bottom + 2 * margin, thin = Math.max(width, height) / 150;
  picture.setAttribute("viewBox", `${left - margin} ${-top - margin} ${width} ${height}`);

  function element(kind, attributes) {
    const made = document.createElementNS(SVG, kind);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    return made;
  }
  const joined = (points) => points.map(([x, y]) => `${x},${-y}`).join(" ");

  function drawn(shape) {
    const colour = `var(--${COLOURS[shape.colour] || "quiet"})`;
    if (shape.kind === "line")
      return element("polyline", { points: joined(shape.points), fill: "none", style: `stroke: ${colour}`, "stroke-width": thin, "stroke-linecap": "round", "stroke-linejoin": "round",
                                     "stroke-dasharray": shape.dashed ? `${2 * thin} ${2 * thin}` : "none" });
    if (shape.kind === "box") {
      const [x, y] = shape.centre, [w, h] = shape.size;
      return element("rect", { x: x - w / 2, y: -y - h / 2, width: w, height: h, style: `fill: ${colour}` });
    }
    if (shape.kind === "disc")
      return element("circle", { cx: shape.centre[0], cy: -shape.centre[1], r: shape.radius, style: `fill: ${colour}` });
    return element("line", { x1: left - margin, x2: right + margin, y1: -shape.height, y2: -shape.height, style: `stroke: ${colour}`, "stroke-width": thin * 0.7 });
  }

  function show(index) {
    const traces = film.traces.map((points) => element("polyline", { points: joined(points), fill: "none", style: "stroke: var(--quiet)", "stroke-width": thin / 3 }));
    picture.replaceChildren(...traces, ...film.frames[index].map(drawn));
    slider.value = index;
    const told = `${Charts.shown(film.times[index], 4)} ${film.unit}`;
    clock.textContent = told;
    slider.setAttribute("aria-valuetext", told);
  }

  let began = null;
  const last = film.frames.length - 1, seconds = Math.min(Math.max(film.times[last] - film.times[0], 2), 10);
  function stop() { began = null; button.textContent = "Play"; }
  function step(now) {
    if (began === null) return;
    const index = Math.min(Math.floor((now - began) / 1000 / seconds * last), last);
    show(index);
    if (index < last) requestAnimationFrame(step); else stop();
  }
  button.addEventListener("click", () => {
    if (began !== null) { stop(); return; }
    const from = Number(slider.value) < last ? Number(slider.value) : 0;
    button.textContent = "Pause";
    requestAnimationFrame((now) => { began = now - from / last * seconds * 1000; step(now); });
    began = performance.now();
  });
  slider.addEventListener("input", () => { stop(); show(Number(slider.value)); });
  show(0);
})();
