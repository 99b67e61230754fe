"use strict";
// Draws the charts of a page: every <figure data-chart="name"> gets the chart of that name in the page's data.
const DATA = JSON.parse(document.getElementById("data").textContent);

const Charts = (() => {
  const HEIGHT = 210, KEPT = 1e-3, ZOOM = 0.8;
  const drawn = [];

  const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();

  // A number with as many digits as are needed to tell it from its neighbours on the axis.
  function shown(value, digits = 5) {
    if (value === null || value === undefined) return "–";
    const size = Math.abs(value);
    const text = size !== 0 && (size >= 1e6 || size < 1e-4) ? Number(value.toPrecision(3)).toExponential().replace("e+", "e") : String(Number(value.toPrecision(digits)));
    return text.replace("-", "−");
  }

  // A place on the x axis: a number, or the name of what stands there.
  const named = (chart, v) => !chart.x.names ? shown(v) : v === null || v === undefined ? "–" : chart.x.names[v] ?? "";

  function seriesOf(own) {
    const stroke = () => colour(own.colour);
    const base = { label: own.label, stroke, value: (u, v) => shown(v), spanGaps: false, points: { show: false } };
    if (own.kind === "points")
      return { ...base, paths: () => null, points: { show: true, size: 5, stroke, fill: () => colour("paper") } };
    if (own.kind === "steps")
      return { ...base, width: 1.5, paths: uPlot.paths.stepped({ align: 1 }) };
    if (own.kind === "marked")
      return { ...base, width: 1.5, points: { show: true, size: 6, stroke, fill: stroke } };
    return { ...base, width: 2 };
  }

  // An axis spans at least a thousandth of the size of what is on it: rounding is not magnified.
  function range(chart) {
    return (u, low, high) => {
      if (low === null || !isFinite(low)) return [0, 1];
      for (const bound of chart.bounds) { low = Math.min(low, bound.value); high = Math.max(high, bound.value); }
      const least = Math.max(KEPT * Math.max(Math.abs(low), Math.abs(high)), 1e-9);
      const middle = (low + high) / 2, half = Math.max(high - low, least) / 2 * 1.08;
      return [middle - half, middle + half];
    };
  }

  // Bounds as dashed lines, phases by name, segment edges as strokes on the axis.
  function behind(chart) {
    return (u) => {
      const c = u.ctx, box = u.bbox, at = (x) => u.valToPos(x, "x", true);
      c.save();
      c.beginPath(); c.rect(box.left, box.top, box.width, box.height); c.clip();
      c.strokeStyle = colour(chart.markColour || "quiet"); c.lineWidth = devicePixelRatio * (chart.markColour ? 2 : 1);
      c.beginPath();
      for (const mark of chart.marks) {
        c.moveTo(at(mark), box.top + box.height);
        c.lineTo(at(mark), box.top + box.height - 5 * devicePixelRatio);
      }
      c.stroke();
      c.strokeStyle = colour("quiet"); c.lineWidth = devicePixelRatio;
      c.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
      for (const bound of chart.bounds) {
        const y = u.valToPos(bound.value, "y", true);
        c.beginPath(); c.moveTo(at(bound.from), y); c.lineTo(at(bound.to), y); c.stroke();
      }
      c.setLineDash([]);
      c.fillStyle = colour("quiet"); c.textBaseline = "top"; c.textAlign = "left";
      c.font = 11 * devicePixelRatio + "px system-ui, sans-serif";
      for (const phase of chart.phases) {
        c.beginPath(); c.moveTo(at(phase.to), box.top); c.lineTo(at(phase.to), box.top + box.height); c.stroke();
        const room = at(phase.to) - at(phase.from);
        if (c.measureText(phase.name).width < room) c.fillText(phase.name, at(phase.from) + 3 * devicePixelRatio, box.top + 2);
      }
      c.restore();
    };
  }

  // Of a logarithmic axis: the decades, or each second or third of them where there are many.
  function decades(u, splits) {
    const powers = splits.map((v) => v === null ? null : Math.log10(v)), whole = powers.filter((p) => p !== null && Math.abs(p - Math.round(p)) < 1e-9);
    const step = Math.max(Math.ceil(whole.length / 6), 1);
    return splits.map((v, i) => powers[i] !== null && Math.abs(powers[i] - Math.round(powers[i])) < 1e-9 && Math.round(powers[i]) % step === 0 ? v : null);
  }

  function options(chart, width) {
    const axis = { stroke: () => colour("ink"), grid: { stroke: () => colour("grid"), width: 1 }, ticks: { stroke: () => colour("line"), width: 1 },
                   font: "12px system-ui, sans-serif", labelFont: "12px system-ui, sans-serif" };
    const overTime = chart.x.sync === "time";
    return {
      width, height: HEIGHT,
      scales: { x: { time: false }, y: chart.log ? { distr: 3 } : { range: range(chart) } },
      axes: [{ ...axis, label: chart.x.label, labelSize: 18, size: 34, values: (u, all) => all.map((v) => named(chart, v)) },
             { ...axis, ...(chart.log ? { filter: decades, grid: { ...axis.grid, filter: decades }, ticks: { ...axis.ticks, filter: decades } } : {}), size: 62, values: (u, all) => all.map((v) => v === null ? "" : shown(v)) }],
      series: [{ label: chart.x.label, value: (u, v) => named(chart, v) }, ...chart.series.map(seriesOf)],
      cursor: { drag: { x: true, y: false }, sync: overTime ? { key: "time" } : undefined, points: { size: 8 } },
      legend: { live: true },
      hooks: { draw: [behind(chart)], setScale: [(u, name) => name === "x" && overTime && follow(u)] },
    };
  }

  // A zoom of one chart over time is one of all.
  let following = false;
  function follow(one) {
    if (following) return;
    following = true;
    const { min, max } = one.scales.x;
    for (const { plot, chart } of drawn)
      if (plot !== one && chart.x.sync === "time") plot.setScale("x", { min, max });
    following = false;
  }

  const ends = (plot) => { const x = plot.data[0].filter((v) => v !== null); return [x[0], x[x.length - 1]]; };
  function whole(plot) { const [min, max] = ends(plot); plot.setScale("x", { min, max }); }

  function zoom(plot, factor) {
    const { min, max } = plot.scales.x, [first, last] = ends(plot);
    const index = plot.cursor.idx, middle = index === null || index === undefined ? (min + max) / 2 : plot.data[0][index];
    plot.setScale("x", { min: Math.max(first, middle - (middle - min) * factor), max: Math.min(last, middle + (max - middle) * factor) });
  }

  function move(plot, step) {
    const x = plot.data[0], { min, max } = plot.scales.x;
    const from = plot.cursor.idx === null || plot.cursor.idx === undefined ? x.findIndex((v) => v >= min) - step : plot.cursor.idx;
    let to = from + step;
    while (to > 0 && to < x.length - 1 && plot.data[1][to] === null) to += Math.sign(step);
    to = Math.min(Math.max(to, 0), x.length - 1);
    if (x[to] < min || x[to] > max) return;
    const y = plot.data[1][to];
    plot.setCursor({ left: plot.valToPos(x[to], "x"), top: y === null || y === undefined ? 10 : plot.valToPos(y, "y") });
  }

  function keys(plot, event) {
    const big = event.shiftKey ? 10 : 1;
    const actions = { ArrowRight: () => move(plot, big), ArrowLeft: () => move(plot, -big), "+": () => zoom(plot, ZOOM),
                      "=": () => zoom(plot, ZOOM), "-": () => zoom(plot, 1 / ZOOM), "0": () => whole(plot), Escape: () => whole(plot) };
    if (!(event.key in actions) || event.ctrlKey || event.metaKey || event.target.closest("button, .u-legend")) return;
    event.preventDefault();
    actions[event.key]();
  }

  function extremes(chart) {
    const lines = chart.series.filter((s) => s.kind === chart.series[0].kind);
    const values = lines.flatMap((s) => s.values).filter((v) => v !== null);
    const said = chart.series.map((s) => s.label).join(", ");
    if (!values.length) return `${chart.title}: no values`;
    const least = values.reduce((a, b) => Math.min(a, b)), most = values.reduce((a, b) => Math.max(a, b));
    return `${chart.title} over ${chart.x.label}: ${said}; from ${shown(values[0])} to ${shown(values[values.length - 1])}, least ${shown(least)}, largest ${shown(most)}`;
  }

  // The legend hides and shows curves by keyboard, too.
  function reachable(plot) {
    for (const row of plot.root.querySelectorAll(".u-series > th")) {
      if (row.parentElement === row.parentElement.parentElement.firstElementChild) continue;
      row.tabIndex = 0;
      row.setAttribute("role", "button");
      row.addEventListener("keydown", (event) => {
        if (event.key === "Enter" || event.key === " ") { event.preventDefault(); row.click(); }
      });
    }
  }

  function clean(chart) {
    const values = chart.series.map((s) => chart.log ? s.values.map((v) => v > 0 ? v : null) : s.values);
    return [chart.x.values, ...values];
  }

  function draw(figure, chart) {
    const data = clean(chart);
    const empty = chart.log && data.slice(1).every((values) => values.every((v) => v === null));
    if (empty) {
      const note = document.createElement("p");
      note.className = "quiet"; note.textContent = "zero everywhere, or not known";
      figure.append(note);
      return null;
    }
    const plot = new uPlot(options(chart, figure.clientWidth), data, figure);
    figure.tabIndex = 0;
    figure.setAttribute("role", "group");
    figure.setAttribute("aria-label", extremes(chart));
    figure.addEventListener("keydown", (event) => keys(plot, event));
    const reset = document.createElement("button");
    reset.type = "button"; reset.className = "reset"; reset.textContent = "whole"; reset.setAttribute("aria-label", `Show all of ${chart.title}`);
    reset.addEventListener("click", () => whole(plot));
    figure.querySelector("figcaption").append(reset);
    reachable(plot);
    const entry = { plot, figure, chart };
    drawn.push(entry);
    sized.observe(figure);
    return entry;
  }

  function remove(entry) {
    drawn.splice(drawn.indexOf(entry), 1);
    sized.unobserve(entry.figure);
    entry.plot.destroy();
    entry.figure.remove();
  }

  const sized = new ResizeObserver((entries) => {
    for (const { target, contentRect } of entries) {
      const found = drawn.find(({ figure }) => figure === target);
      if (found && Math.round(contentRect.width) !== found.plot.width)
        found.plot.setSize({ width: Math.max(Math.round(contentRect.width), 120), height: HEIGHT });
    }
  });

  // Charts are drawn when they come near the window: a page of a hundred is there at once.
  const near = new IntersectionObserver((entries) => {
    for (const { target, isIntersecting } of entries) {
      if (!isIntersecting) continue;
      near.unobserve(target);
      draw(target, DATA.charts[target.dataset.chart]);
    }
  }, { rootMargin: "800px" });

  for (const figure of document.querySelectorAll("figure[data-chart]")) near.observe(figure);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => drawn.forEach(({ plot }) => plot.redraw(false, true)));
  return { draw, remove, shown, colour, drawn };
})();
