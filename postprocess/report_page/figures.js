// SPDX-License-Identifier: BSD-3-Clause
// A figure: axes, legend and colour bar around the marks of its traces; hovering, zooming, clicking.
// Drag to zoom into a rectangle, double-click to see everything; the buttons do the same.
const Figures = (function () {
  "use strict";

  const RESOLUTION = 2; // pixels of the canvas for one of the page, also for print
  const FONT = "12px system-ui, -apple-system, 'Segoe UI', 'DejaVu Sans', sans-serif";
  const PADDING = 0.05; // of the range, to either side
  const SMALLEST_DRAG = 5; // pixels
  const BAR_WIDTH = 12, BAR_SPACE = 72; // pixels of a colour bar, and with its ticks
  const ZOOM_STEP = 0.6;
  const BORDERS = {dash: "dashed", dot: "dotted"};
  const GLYPHS = {circle: "●", square: "■", "square-open": "□", diamond: "◆", "diamond-open": "◇",
    "triangle-up": "▲", "line-ew-open": "–", x: "×", "x-thin-open": "×"}; // text, which paper shows too

  const superscript = (exponent) => String(exponent).replace(/./g,
    (c) => c === "-" ? "⁻" : "⁰¹²³⁴⁵⁶⁷⁸⁹"[c]);

  // Four digits, a true minus sign, a power of ten where there are many zeros.
  function numberText(value) {
    if (value === null || value === undefined) return "–";
    if (typeof value !== "number") return String(value);
    const size = Math.abs(value);
    if (size !== 0 && (size < 1e-4 || size >= 1e6)) {
      const [mantissa, exponent] = value.toExponential(3).split("e");
      const digits = String(Number(mantissa)).replace("-", "−");
      const power = "10" + superscript(Number(exponent));
      return digits === "1" ? power : `${digits}·${power}`;
    }
    return String(size >= 1e4 ? Math.round(value) : Number(value.toPrecision(4))).replace("-", "−");
  }

  // With the decimals that distinguish neighbouring ticks.
  function tickText(value, step) {
    if (Math.abs(value) < 1e-9 * step) return "0";
    const decimals = Math.max(0, -Math.floor(Math.log10(step) + 1e-9));
    const isPlain = Math.abs(value) < 1e6 && decimals < 5;
    return isPlain ? value.toFixed(decimals).replace("-", "−") : numberText(value);
  }

  // The values of a trace's axis: numbers, or positions of named categories.
  class Axis {
    constructor(layout) {
      this.layout = layout;
      this.isLog = layout.type === "log";
      this.places = layout.type === "category" ? new Map() : null;
      this.view = this.full = null; // [start, end]: what is shown, what there is
    }

    number(value) {
      if (value === null || value === undefined) return null;
      if (typeof value === "string" && !this.places) this.places = new Map();
      if (this.places) {
        if (!this.places.has(String(value))) this.places.set(String(value), this.places.size);
        return this.places.get(String(value));
      }
      return this.isLog && value <= 0 ? null : value;
    }

    frame(values, isFilled) {
      let [low, high] = d3.extent(values);
      if (low === undefined) [low, high] = [0, 1];
      if (this.places && !isFilled) [low, high] = [-0.5, this.places.size - 0.5];
      else if (this.isLog) {
        const by = low === high ? 2 : (high / low) ** PADDING;
        [low, high] = [low / by, high * by];
      }
      else if (!isFilled) {
        const pad = PADDING * (high - low) || 0.5 * Math.abs(high) || 0.5;
        const starts = low === 0 && values.startsAtZero;
        [low, high] = [starts ? 0 : low - pad, high + pad];
      }
      if (this.layout.rangemode === "tozero") low = 0;
      if (this.layout.autorange === "reversed") [low, high] = [high, low];
      if (this.layout.range) [low, high] = this.isLog ? this.layout.range.map((end) => 10 ** end) : this.layout.range;
      const isWhole = !this.view || String(this.view) === String(this.full);
      this.full = [low, high];
      if (isWhole) this.view = this.full;
    }

    scale(from, to) {
      return (this.isLog ? d3.scale.log() : d3.scale.linear()).domain(this.view).range([from, to]);
    }

    // [{at, text}] of ticks for so many pixels
    ticks(pixels, spacing) {
      const isShown = (value) => (value - this.view[0]) * (value - this.view[1]) <= 0;
      if (this.places)
        return Array.from(this.places, ([text, at]) => ({at, text})).filter((tick) => isShown(tick.at));
      const given = (this.layout.tickvals || []).map((at, k) => ({at, text: this.layout.ticktext[k]}))
        .filter((tick) => isShown(tick.at));
      if (given.length > 1) return given;
      const scale = d3.scale.linear().domain(d3.extent(this.view));
      const all = scale.ticks(Math.max(3, Math.floor(pixels / spacing)));
      const values = this.layout.whole ? all.filter((value) => value % 1 === 0) : all;
      return values.filter(isShown).map((at) => ({at, text: tickText(at, values[1] - values[0] || 1)}));
    }

    zoom(ends) {
      if (!this.layout.fixedrange) this.view = ends;
    }

    zoomBy(factor) {
      const to = this.isLog ? Math.log : (v) => v, from = this.isLog ? Math.exp : (v) => v;
      const [a, b] = this.view.map(to), middle = 0.5 * (a + b), half = 0.5 * factor * (b - a);
      this.zoom([from(middle - half), from(middle + half)]);
    }
  }

  class Figure {
    constructor(element, {data, layout}) {
      this.element = element;
      this.data = data;
      this.layout = layout;
      this.x = new Axis(layout.xaxis);
      this.panels = ["yaxis", "yaxis2"].filter((name) => layout[name])
        .map((name) => ({name, y: new Axis(layout[name]), domain: layout[name].domain || [0, 1]}));
      this.clicked = () => {};
      this.prepare();
      this.build();
      this.draw();
    }

    panelOf(trace) {
      return this.panels[trace.yaxis === "y2" ? 1 : 0];
    }

    prepare() {
      const hidden = (this.marks || []).map((mark) => mark.hidden);
      const bars = this.data.filter((trace) => trace.type === "bar" && !trace.width);
      this.marks = this.data.map((trace, k) => Object.assign(Marks.prepared(trace,
        {x: this.x, y: this.panelOf(trace).y}, bars.indexOf(trace), bars.length),
      {hidden: hidden[k] || false}));
      this.frame();
    }

    frame() {
      const valuesOf = (marks, direction) => {
        const values = [].concat(...marks.map((mark) => mark.values[direction]));
        values.startsAtZero = marks.some((mark) => mark.rectangles);
        return values;
      };
      const isFilled = (marks) => marks.some((mark) => mark.fills);
      this.x.frame(valuesOf(this.marks, "x"), isFilled(this.marks));
      for (const panel of this.panels) {
        const marks = this.marks.filter((mark) => this.panelOf(mark.trace) === panel);
        panel.y.frame(valuesOf(marks, "y"), isFilled(marks));
      }
    }

    build() {
      const root = d3.select(this.element);
      if (this.layout.showlegend) this.buildLegend(root.append("ul").attr("class", "traces"));
      this.box = root.append("div").attr("class", "box");
      this.canvas = this.box.append("canvas").node();
      this.svg = this.box.append("svg").attr({"aria-hidden": "true", preserveAspectRatio: "none"});
      this.hint = this.box.append("div").attr("class", "hint").style("display", "none");
      const tools = this.box.append("div").attr("class", "tools");
      for (const [text, label, act] of [["+", "zoom in", () => this.zoomBy(ZOOM_STEP)],
        ["−", "zoom out", () => this.zoomBy(1 / ZOOM_STEP)], ["⤢", "show everything", () => this.reset()]])
        tools.append("button").attr({type: "button", "aria-label": label, title: label}).text(text).on("click", act);
      this.listen();
    }

    buildLegend(list) {
      this.data.forEach((trace, k) => {
        const marker = trace.marker || {};
        if (!trace.name || trace.showlegend === false || Array.isArray(marker.color)) return;
        const button = list.append("li").append("button").attr({type: "button", "aria-pressed": "true",
          title: "show or hide"});
        const line = trace.line && trace.mode !== "markers";
        const colour = line ? trace.line.color : marker.color;
        if (line) button.append("span").attr("class", "line")
          .style("border-top", `2px ${BORDERS[trace.line.dash] || "solid"} ${colour}`);
        if (!line || trace.mode.includes("markers")) button.append("span").style("color", colour)
          .text(trace.type === "bar" ? "■" : GLYPHS[marker.symbol] || "●");
        button.append("b").text(trace.name);
        button.on("click", () => {
          this.marks[k].hidden = !this.marks[k].hidden;
          button.attr("aria-pressed", String(!this.marks[k].hidden));
          this.draw();
        });
      });
    }

    // Sizes in pixels of everything around the panels.
    measure() {
      const node = this.box.node();
      this.width = node.clientWidth;
      this.height = node.clientHeight;
      const pen = this.canvas.getContext("2d");
      pen.font = FONT;
      const widest = (ticks) => d3.max(ticks, (tick) => pen.measureText(tick.text).width) || 0;
      this.coloured = this.marks.find((mark) => mark.colours);
      this.right = this.width - (this.coloured ? BAR_SPACE : 14);
      this.top = this.coloured && this.coloured.colours.title ? 24 : 10;
      const perTick = this.width / Math.max(1, this.x.places ? this.x.places.size : 1);
      const names = this.x.places ? widest(this.x.ticks(1, 1)) : 0;
      this.areTurned = names > 0.8 * perTick;
      this.bottom = this.height - (this.areTurned ? 10 + 0.6 * names : 22) - (this.x.layout.title ? 22 : 4);
      let left = 0;
      for (const panel of this.panels) {
        const span = this.bottom - this.top;
        panel.low = this.bottom - panel.domain[0] * span;
        panel.high = this.bottom - panel.domain[1] * span;
        panel.ticks = panel.y.ticks(panel.low - panel.high, 28);
        left = Math.max(left, widest(panel.ticks));
      }
      const hasTitle = this.panels.some((panel) => panel.y.layout.title);
      this.left = Math.min(left + (hasTitle ? 34 : 14), 0.5 * this.width);
      this.sx = this.x.scale(this.left, this.right);
      for (const panel of this.panels) panel.scale = panel.y.scale(panel.low, panel.high);
    }

    draw() {
      this.measure();
      const {canvas, width, height} = this;
      canvas.width = RESOLUTION * width;
      canvas.height = RESOLUTION * height;
      const pen = canvas.getContext("2d");
      pen.setTransform(RESOLUTION, 0, 0, RESOLUTION, 0, 0);
      pen.font = FONT;
      this.svg.attr("viewBox", `0 0 ${width} ${height}`).selectAll("*").remove();
      const ticks = this.x.ticks(this.right - this.left, 74);
      for (const panel of this.panels) {
        this.drawGrid(pen, panel, ticks);
        pen.save();
        pen.beginPath();
        pen.rect(this.left, panel.high, this.right - this.left, panel.low - panel.high);
        pen.clip();
        this.marks.filter((mark) => !mark.hidden && this.panelOf(mark.trace) === panel)
          .forEach((mark) => Marks.draw(pen, mark, this.sx, panel.scale));
        pen.restore();
        this.drawVertical(panel);
      }
      this.drawHorizontal(ticks);
      this.drawLevels();
      if (this.coloured) this.drawColourBar();
    }

    drawGrid(pen, panel, ticks) {
      if (this.marks.some((mark) => mark.fills)) return;
      const lineOf = (colour, x, y) => {
        pen.strokeStyle = colour;
        pen.beginPath(); pen.moveTo(x[0], y[0]); pen.lineTo(x[1], y[1]); pen.stroke();
      };
      pen.lineWidth = 1;
      for (const tick of this.x.places ? [] : ticks)
        lineOf("#e6e6e6", [this.sx(tick.at), this.sx(tick.at)], [panel.low, panel.high]);
      for (const tick of panel.y.places ? [] : panel.ticks)
        lineOf(tick.at === 0 && panel.y.layout.zeroline ? "#777777" : "#e6e6e6", [this.left, this.right],
          [panel.scale(tick.at), panel.scale(tick.at)]);
    }

    line(x, y, colour = "#666666", width = 1, dash = "") {
      this.svg.append("line").attr({x1: x[0], x2: x[1], y1: y[0], y2: y[1], stroke: colour,
        "stroke-width": width, "stroke-dasharray": dash});
    }

    text(x, y, text, anchor = "middle", turn = 0) {
      return this.svg.append("text").attr({x, y, "text-anchor": anchor,
        transform: turn ? `rotate(${turn} ${x} ${y})` : null}).text(text);
    }

    drawVertical(panel) {
      this.line([this.left, this.left], [panel.low, panel.high]);
      for (const tick of panel.ticks) {
        const y = panel.scale(tick.at);
        this.line([this.left - 4, this.left], [y, y]);
        this.text(this.left - 7, y + 4, tick.text, "end");
      }
      this.text(13, 0.5 * (panel.low + panel.high), panel.y.layout.title, "middle", -90);
    }

    drawHorizontal(ticks) {
      const low = d3.max(this.panels, (panel) => panel.low);
      this.line([this.left, this.right], [low, low]);
      for (const tick of ticks) {
        const x = this.sx(tick.at);
        this.line([x, x], [low, low + 4]);
        this.text(x, low + 17, tick.text, this.areTurned ? "end" : "middle", this.areTurned ? -35 : 0);
      }
      this.text(0.5 * (this.left + this.right), this.height - 6, this.x.layout.title);
    }

    // Lines across the whole drawing.
    drawLevels() {
      const first = this.panels[0];
      for (const {along, at, colour, dash} of this.layout.levels || []) {
        const pixel = along === "x" ? this.sx(at) : first.scale(at);
        const dashes = dash === "dash" ? "6 4" : "";
        const ends = along === "x" ? [this.left, this.right] : [first.high, first.low];
        if (pixel < ends[0] || pixel > ends[1]) continue;
        if (along === "x") this.line([pixel, pixel], [first.low, first.high], colour, 1, dashes);
        else this.line([this.left, this.right], [pixel, pixel], colour, 1, dashes);
      }
    }

    drawColourBar() {
      const {low, high, of, title} = this.coloured.colours;
      const x = this.right + 12, [start, end] = [this.panels[0].low, this.panels[0].high];
      const scale = d3.scale.linear().domain([low, low === high ? low + 1 : high]).range([start, end]);
      for (let y = end; y < start; ++y)
        this.svg.append("rect").attr({x, y, width: BAR_WIDTH, height: 1.5, fill: of(scale.invert(y))});
      for (const tick of low === high ? [low] : scale.ticks(5)) {
        this.line([x + BAR_WIDTH, x + BAR_WIDTH + 3], [scale(tick), scale(tick)]);
        this.text(x + BAR_WIDTH + 5, scale(tick) + 4, tickText(tick, (high - low) / 5 || 1), "start");
      }
      this.text(this.width - 4, 14, title, "end");
    }

    // The mark under a pixel: {curve, index, at}, the nearest of all traces.
    at(px, py) {
      let best = null;
      this.marks.forEach((mark, curve) => {
        if (mark.hidden || mark.trace.hoverinfo === "skip") return;
        const panel = this.panelOf(mark.trace);
        if (px < this.left || px > this.right || py > panel.low || py < panel.high) return;
        const found = Marks.find(mark, px, py, this.sx, panel.scale);
        if (found && (!best || found.distance < best.distance)) best = {curve, ...found};
      });
      return best;
    }

    // What is said of a mark: the members that `hoverinfo` names.
    textOf({curve, index}) {
      const trace = this.data[curve], y = this.panelOf(trace).y;
      const [row, column] = Array.isArray(index) ? index : [index, index];
      const label = (axis, value) => `${axis.layout.title || "value"}: ${numberText(value)}`;
      const lines = trace.name && this.data.length > 1 ? [trace.name] : [];
      const parts = {x: () => label(this.x, trace.x[column]), y: () => label(y, trace.y[row]),
        z: () => `${trace.colorbar || "value"}: ${numberText(trace.z[row][column])}`, text: () => trace.text[row]};
      for (const part of (trace.hoverinfo || "x+y").split("+")) lines.push(parts[part]());
      return lines.join("\n");
    }

    // Page coordinates of a point, for programs that click on it.
    pixelOf(curve, index) {
      const {left, top} = this.box.node().getBoundingClientRect();
      const mark = this.marks[curve], point = mark.points[index];
      return [left + this.sx(point.x), top + this.panelOf(mark.trace).scale(point.y)];
    }

    hover(position) {
      this.svg.selectAll(".ring").remove();
      const found = position && this.at(...position);
      this.hint.style("display", found ? "block" : "none");
      if (!found) return;
      const [x, y] = found.at || position;
      if (found.at) this.svg.append("circle").attr({class: "ring", cx: x, cy: y, r: 7});
      this.hint.text(this.textOf(found));
      const {offsetWidth, offsetHeight} = this.hint.node();
      this.hint.style({left: Math.min(x + 12, Math.max(0, this.width - offsetWidth)) + "px",
        top: Math.max(0, y - offsetHeight - 10) + "px"});
    }

    listen() {
      const node = this.svg.node();
      let start = null;
      const move = () => {
        const here = d3.mouse(node);
        if (!start) return this.hover(here);
        this.hover(null);
        const [x, y] = [0, 1].map((k) => Math.min(start[k], here[k]));
        this.svg.selectAll(".zoom").remove();
        this.svg.append("rect").attr({class: "zoom", x, y, width: Math.abs(here[0] - start[0]),
          height: Math.abs(here[1] - start[1])});
      };
      this.svg.on("mousemove", move).on("mouseleave", () => { if (!start) this.hover(null); })
        .on("dblclick", () => this.reset());
      this.svg.on("mousedown", () => {
        start = d3.mouse(node);
        d3.event.preventDefault();
        d3.select(window).on("mousemove.zoom", move).on("mouseup.zoom", () => {
          const end = d3.mouse(node), from = start;
          start = null;
          d3.select(window).on("mousemove.zoom", null).on("mouseup.zoom", null);
          this.svg.selectAll(".zoom").remove();
          if (Math.hypot(end[0] - from[0], end[1] - from[1]) > SMALLEST_DRAG) return this.zoomTo(from, end);
          const found = this.at(...end);
          if (found) this.clicked(found);
        });
      });
    }

    // A drag along one direction zooms along this one only.
    zoomTo(from, to) {
      const panel = this.panels.find((part) => from[1] <= part.low && from[1] >= part.high) || this.panels[0];
      const order = (ends, view) => (view[0] < view[1]) === (ends[0] < ends[1]) ? ends : ends.reverse();
      if (Math.abs(to[0] - from[0]) > SMALLEST_DRAG)
        this.x.zoom(order([this.sx.invert(from[0]), this.sx.invert(to[0])], this.x.view));
      if (Math.abs(to[1] - from[1]) > SMALLEST_DRAG)
        panel.y.zoom(order([panel.scale.invert(from[1]), panel.scale.invert(to[1])], panel.y.view));
      this.draw();
    }

    zoomBy(factor) {
      [this.x, ...this.panels.map((panel) => panel.y)].forEach((axis) => axis.zoomBy(factor));
      this.draw();
    }

    reset() {
      for (const axis of [this.x, ...this.panels.map((panel) => panel.y)]) axis.view = axis.full;
      this.draw();
    }

    // Other values of some traces: {curve: {x, y}}.
    update(changes) {
      for (const [curve, {x, y}] of Object.entries(changes)) Object.assign(this.data[curve], {x, y});
      this.prepare();
      this.draw();
    }
  }

  return {Figure};
}());
