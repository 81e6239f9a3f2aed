// SPDX-License-Identifier: BSD-3-Clause
// The marks of a trace: prepared in the units of its axes, drawn on a canvas, found under the pointer.
// A trace is a dictionary of drawing.py; scales and line shapes are D3's.
const Marks = (function () {
  "use strict";

  const DASHES = {solid: [], dash: [7, 4], dot: [2, 3]};
  const INTERPOLATION = {linear: "linear", hv: "step-after", spline: "cardinal"};
  const REACH = 25; // pixels between the pointer and a point that it hovers
  const BAR_SHARE = 0.8; // of the distance between two categories

  // stops: [[0, colour], …, [1, colour]]
  function colourScale(stops, low, high) {
    const span = high - low || 1;
    return d3.scale.linear().domain(stops.map((stop) => low + stop[0] * span))
      .range(stops.map((stop) => stop[1])).clamp(true);
  }

  // The limits of cells about their centres; of categories half a place to either side.
  function edgesOf(values, axis) {
    const at = values.map((value) => axis.number(value));
    if (at.length === 1) return [at[0] - 0.5, at[0] + 0.5];
    const inner = at.slice(1).map((value, k) => 0.5 * (value + at[k]));
    const last = at.length - 1;
    return [2 * at[0] - inner[0], ...inner, 2 * at[last] - inner[inner.length - 1]];
  }

  // Bars as rectangles; slot of slots: bars of several traces stand next to each other.
  function rectanglesOf(trace, axes, slot, slots) {
    const lies = trace.orientation === "h";
    const along = lies ? axes.x : axes.y, across = lies ? axes.y : axes.x;
    const lengths = lies ? trace.x : trace.y, positions = lies ? trace.y : trace.x;
    return Array.from(lengths, (length, k) => {
      const middle = across.number(positions[k]);
      const width = trace.width ? trace.width[k] : BAR_SHARE / slots;
      const low = trace.width ? middle - 0.5 * width : middle - 0.5 * BAR_SHARE + slot * width;
      const ends = [Math.min(0, along.number(length)), Math.max(0, along.number(length))];
      return lies ? {x: ends, y: [low, low + width]} : {x: [low, low + width], y: ends};
    });
  }

  // Ends of the error bars of point k along "x" or "y", or null.
  function errorOf(trace, direction, k, value) {
    const error = trace["error_" + direction];
    if (!error || error.array[k] === null || value === null) return null;
    const below = error.arrayminus ? error.arrayminus[k] : error.array[k];
    return [value - below, value + error.array[k]];
  }

  // values: numbers that have to be on the axes; fills: the marks end at the edge of the drawing.
  function prepared(trace, axes, slot, slots) {
    const mark = {trace, axes, values: {x: [], y: []}, fills: false, hidden: false};
    if (trace.type === "heatmap") {
      mark.edges = {x: edgesOf(trace.x, axes.x), y: edgesOf(trace.y, axes.y)};
      mark.values = mark.edges;
      mark.fills = true;
    } else if (trace.type === "bar") {
      mark.rectangles = rectanglesOf(trace, axes, slot, slots);
      for (const direction of ["x", "y"])
        mark.rectangles.forEach((bar) => mark.values[direction].push(...bar[direction]));
    } else {
      mark.points = Array.from(trace.x, (x, k) => ({x: axes.x.number(x), y: axes.y.number(trace.y[k])}))
        .map((point) => point.x === null || point.y === null ? null : point);
      for (const direction of ["x", "y"])
        mark.values[direction] = mark.points.filter(Boolean).map((point) => point[direction]);
    }
    for (const direction of ["x", "y"]) {
      const lengths = trace[direction];
      if (!trace["error_" + direction]) continue;
      lengths.forEach((value, k) => mark.values[direction].push(
        ...(errorOf(trace, direction, k, axes[direction].number(value)) || [])));
    }
    mark.colours = coloursOf(mark);
    return mark;
  }

  // The scale of a trace whose marks are coloured by a value, with what its colour bar needs.
  function coloursOf(mark) {
    const {trace} = mark, marker = trace.marker || {};
    const isMap = trace.type === "heatmap";
    if (!isMap && !Array.isArray(marker.color)) return null;
    const values = (isMap ? d3.merge(trace.z) : marker.color).filter((value) => value !== null);
    const [low, high] = trace.zmin === undefined ? d3.extent(values) : [trace.zmin, trace.zmax];
    const stops = isMap ? trace.colorscale : marker.colorscale;
    return {low, high, of: colourScale(stops, low, high),
      title: (isMap ? trace : marker).colorbar || ""};
  }

  function drawSymbol(pen, symbol, x, y, size, colour, border) {
    const r = 0.5 * size, open = symbol.endsWith("-open");
    pen.beginPath();
    if (symbol.startsWith("circle")) pen.arc(x, y, r, 0, 2 * Math.PI);
    else if (symbol.startsWith("diamond"))
      [[0, -r], [r, 0], [0, r], [-r, 0]].forEach(([a, b]) => pen.lineTo(x + a, y + b));
    else if (symbol.startsWith("square")) pen.rect(x - r, y - r, size, size);
    else if (symbol.startsWith("line-ew")) { pen.moveTo(x - r, y); pen.lineTo(x + r, y); }
    else if (symbol.startsWith("triangle"))
      [[0, -r], [r, r], [-r, r]].forEach(([a, b]) => pen.lineTo(x + a, y + b));
    else { // crosses
      pen.moveTo(x - r, y - r); pen.lineTo(x + r, y + r);
      pen.moveTo(x - r, y + r); pen.lineTo(x + r, y - r);
    }
    if (symbol.startsWith("diamond")) pen.closePath();
    const isStroke = open || symbol.startsWith("x") || symbol.startsWith("line");
    if (!isStroke) { pen.fillStyle = colour; pen.fill(); }
    if (!isStroke && !border) return;
    pen.strokeStyle = isStroke ? colour : border.color;
    pen.lineWidth = border ? border.width : symbol === "x" ? 2.5 : 1.4;
    pen.stroke();
  }

  function drawErrors(pen, mark, sx, sy) {
    const {trace, points, rectangles} = mark;
    const middles = points || rectangles.map((bar) => trace.orientation === "h"
      ? {x: bar.x[0] < 0 ? bar.x[0] : bar.x[1], y: 0.5 * (bar.y[0] + bar.y[1])}
      : {x: 0.5 * (bar.x[0] + bar.x[1]), y: bar.y[0] < 0 ? bar.y[0] : bar.y[1]});
    pen.strokeStyle = (trace.error_x || trace.error_y).color || "#222222";
    pen.lineWidth = 1;
    pen.beginPath();
    middles.forEach((middle, k) => {
      if (!middle) return;
      const across = errorOf(trace, "x", k, middle.x), upright = errorOf(trace, "y", k, middle.y);
      if (across) { pen.moveTo(sx(across[0]), sy(middle.y)); pen.lineTo(sx(across[1]), sy(middle.y)); }
      if (upright) { pen.moveTo(sx(middle.x), sy(upright[0])); pen.lineTo(sx(middle.x), sy(upright[1])); }
    });
    pen.stroke();
  }

  function drawMap(pen, mark, sx, sy) {
    const xs = mark.edges.x.map(sx), ys = mark.edges.y.map(sy);
    mark.trace.z.forEach((row, r) => row.forEach((value, c) => {
      if (value === null) return;
      pen.fillStyle = mark.colours.of(value);
      // Half a pixel more, for the seams between cells.
      pen.fillRect(Math.min(xs[c], xs[c + 1]), Math.min(ys[r], ys[r + 1]),
        Math.abs(xs[c + 1] - xs[c]) + 0.5, Math.abs(ys[r + 1] - ys[r]) + 0.5);
    }));
  }

  function drawBars(pen, mark, sx, sy) {
    pen.fillStyle = mark.trace.marker.color;
    for (const bar of mark.rectangles) {
      const x = bar.x.map(sx), y = bar.y.map(sy);
      const gap = mark.trace.width && Math.abs(x[1] - x[0]) > 3 ? 1 : 0; // between touching bars
      pen.fillRect(Math.min(...x), Math.min(...y), Math.abs(x[1] - x[0]) - gap, Math.abs(y[1] - y[0]));
    }
  }

  function drawPoints(pen, mark, sx, sy) {
    const {trace, points} = mark, mode = trace.mode, marker = trace.marker || {};
    if (mode.includes("lines")) {
      const path = d3.svg.line().defined(Boolean).x((point) => sx(point.x)).y((point) => sy(point.y))
        .interpolate(INTERPOLATION[trace.line.shape || "linear"])(points);
      pen.strokeStyle = trace.line.color;
      pen.lineWidth = trace.line.width || 1.5;
      pen.setLineDash(DASHES[trace.line.dash || "solid"]);
      if (path) pen.stroke(new Path2D(path));
      pen.setLineDash([]);
    }
    points.forEach((point, k) => {
      if (!point) return;
      const colour = mark.colours ? mark.colours.of(marker.color[k]) : marker.color;
      if (mode.includes("markers"))
        drawSymbol(pen, marker.symbol || "circle", sx(point.x), sy(point.y), marker.size, colour, marker.line);
      if (!mode.includes("text")) return;
      pen.fillStyle = "#222222";
      pen.textAlign = "center";
      const half = 0.5 * pen.measureText(trace.text[k]).width, [left, right] = sx.range(); // it stays inside
      pen.fillText(trace.text[k], Math.max(left + half + 3, Math.min(right - half - 3, sx(point.x))),
        sy(point.y) - 0.5 * marker.size - 5);
    });
  }

  function draw(pen, mark, sx, sy) {
    if (mark.edges) drawMap(pen, mark, sx, sy);
    else if (mark.rectangles) drawBars(pen, mark, sx, sy);
    if (mark.trace.error_x || mark.trace.error_y) drawErrors(pen, mark, sx, sy);
    if (mark.points) drawPoints(pen, mark, sx, sy);
  }

  const isWithin = (ends, value) => value >= Math.min(...ends) && value <= Math.max(...ends);

  function cellAt(edges, value) {
    for (let k = 0; k + 1 < edges.length; ++k)
      if (isWithin([edges[k], edges[k + 1]], value)) return k;
    return -1;
  }

  // The mark nearest to a pixel: {index, distance, at} or null; of a map index is [row, column].
  function find(mark, px, py, sx, sy) {
    if (mark.edges) {
      const column = cellAt(mark.edges.x, sx.invert(px)), row = cellAt(mark.edges.y, sy.invert(py));
      return row < 0 || column < 0 || mark.trace.z[row][column] === null ? null
        : {index: [row, column], distance: REACH, at: null};
    }
    if (mark.rectangles) {
      const lies = mark.trace.orientation === "h";
      const k = mark.rectangles.findIndex((bar) => lies
        ? isWithin(bar.y.map(sy), py) : isWithin(bar.x.map(sx), px));
      return k < 0 ? null : {index: k, distance: REACH, at: null};
    }
    let best = null;
    mark.points.forEach((point, k) => {
      if (!point) return;
      const x = sx(point.x), y = sy(point.y), distance = Math.hypot(x - px, y - py);
      if (distance <= REACH && (!best || distance < best.distance)) best = {index: k, distance, at: [x, y]};
    });
    return best;
  }

  return {prepared, draw, find};
}());
