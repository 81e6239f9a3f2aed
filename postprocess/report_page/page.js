// SPDX-License-Identifier: BSD-3-Clause
// Draws the figures of the page and runs its controls; every number is in the page already.
(function () {
  "use strict";

  const MISSING = -32768;
  function content(element, kind) {
    return JSON.parse(element.querySelector("script." + kind).textContent);
  }

  function unpacked(packed) {
    const bytes = Uint8Array.from(atob(packed.values), (c) => c.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Array.from({length: bytes.length / 2}, (_, k) => {
      const value = view.getInt16(2 * k, true);
      return value === MISSING ? null : value * packed.scale;
    });
  }

  function drawAll(done) {
    const waiting = Array.from(document.querySelectorAll(".drawing"));
    const next = () => {
      const element = waiting.shift();
      if (!element) return done();
      element.figure = new Figures.Figure(element, content(element.parentElement, "plot-data"));
      setTimeout(next, 0); // the reader may scroll meanwhile
    };
    next();
  }

  function startPicker(picker) {
    const data = content(picker, "picker-data");
    const design = document.getElementById(data.design).figure;
    const history = document.getElementById(data.history).figure;
    const select = picker.querySelector("select");
    const facts = picker.querySelector(".facts");
    const points = Object.keys(data.histories);
    const time = unpacked(data.time);
    const positions = new Map(); // point -> where the design shows it
    data.ids.forEach((ids, curve) => {
      const {x, y} = design.data[curve];
      ids.forEach((id, k) => Array.isArray(id)
        ? id.forEach((cell, column) => positions.set(String(cell), [x[column], y[k]]))
        : positions.set(String(id), [x[k], y[k]]));
    });
    const spans = [0, 1].map((axis) => {
      const values = Array.from(positions.values(), (position) => position[axis]);
      return values.reduce((a, b) => Math.max(a, b)) - values.reduce((a, b) => Math.min(a, b)) || 1;
    });
    for (const point of points) select.add(new Option(point, point));

    function show(point) {
      const kept = data.histories[point];
      const fitted = time.map((t) => t < 0 || t > data.window_ms ? null
        : kept.b0 * Math.exp(1e-3 * kept.b1 * t) * Math.cos(2e-3 * Math.PI * kept.b2 * t));
      select.value = point;
      facts.textContent = data.facts[point];
      history.update({0: {x: time, y: unpacked(kept)}, 1: {x: time, y: fitted}});
      const position = positions.get(point);
      design.update({[design.data.length - 1]: position
        ? {x: [position[0]], y: [position[1]]} : {x: [], y: []}});
    }

    function step(by) {
      const at = (points.indexOf(select.value) + by + points.length) % points.length;
      show(points[at]);
    }

    select.addEventListener("change", () => show(select.value));
    picker.querySelector(".previous").addEventListener("click", () => step(-1));
    picker.querySelector(".next").addEventListener("click", () => step(1));
    design.clicked = ({curve, index}) => {
      const id = [].concat(index).reduce((part, k) => part === undefined ? part : part[k],
        data.ids[curve]); // of a map: row and column
      if (id === undefined || id < 0) return;
      const position = positions.get(String(id));
      const distance = (point) => [0, 1].reduce((sum, axis) =>
        sum + ((positions.get(point)[axis] - position[axis]) / spans[axis]) ** 2, 0);
      show(points.filter((point) => positions.has(point))
        .reduce((best, point) => distance(point) < distance(best) ? point : best));
    };
    show(points[0]);
  }

  function startAnimation(part) {
    const data = content(part, "animation-data");
    const plot = document.getElementById(data.plot).figure;
    const play = part.querySelector(".play");
    const moment = part.querySelector(".moment");
    const speed = part.querySelector(".speed");
    const model = part.querySelector(".model");
    const facts = part.querySelector(".facts");
    const time = unpacked(data.time);
    const measured = unpacked(data.measured);
    const models = data.models.map(unpacked);
    const rows = data.heights.length;
    const heights = [0].concat(data.heights);
    let started = null; // when, and at which time of the record, it began to play

    function show(frame) {
      const row = (values) => values.slice(frame * rows, (frame + 1) * rows);
      moment.value = frame;
      facts.textContent = "t = " + time[frame].toFixed(1).replace("-", "−") + " ms";
      plot.update({0: {x: [0].concat(row(models[model.value])), y: heights},
        1: {x: row(measured), y: data.heights}});
    }

    function advance(now) {
      if (started === null) return;
      const wanted = started.time + (now - started.now) / Number(speed.value);
      let frame = Number(moment.value);
      while (frame + 1 < data.frames && time[frame + 1] <= wanted) frame += 1;
      if (frame !== Number(moment.value)) show(frame);
      if (frame + 1 >= data.frames) return stop();
      requestAnimationFrame(advance);
    }

    function stop() {
      started = null;
      play.textContent = "Play";
    }

    function start() {
      if (Number(moment.value) + 1 >= data.frames) show(0);
      started = {now: performance.now(), time: time[Number(moment.value)]};
      play.textContent = "Pause";
      requestAnimationFrame(advance);
    }

    play.addEventListener("click", () => started === null ? start() : stop());
    moment.addEventListener("input", () => { stop(); show(Number(moment.value)); });
    speed.addEventListener("change", () => { if (started !== null) start(); });
    model.addEventListener("change", () => show(Number(moment.value)));
    show(0);
  }

  function drawAgain() {
    document.querySelectorAll(".drawing").forEach((element) => element.figure.draw());
  }

  drawAll(() => {
    document.querySelectorAll(".picker").forEach(startPicker);
    document.querySelectorAll(".animation").forEach(startAnimation);
    window.addEventListener("resize", drawAgain);
    window.matchMedia("print").addEventListener("change", drawAgain); // other sizes on paper
    document.documentElement.dataset.ready = "true";
    performance.mark("culm-ready");
  });
}());
