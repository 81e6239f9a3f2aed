// SPDX-License-Identifier: BSD-3-Clause
// The picture of the page: one frame, the axis of the stem, and handles moved by pointer or keys.
// Positions {x, y} are pixels of the original frame; whole numbers are pixel centres.
const Picture = (function () {
  "use strict";

  const SVG = "http://www.w3.org/2000/svg";
  const MARGIN = 0.05; // around the frame, in parts of its larger side: the clamp may lie outside
  const ZOOM_STEP = 1.6;
  const ZOOM_LARGEST = 60;
  const SHARP = 4; // screen pixels per frame pixel from which pixels are drawn as squares
  const BAR = 34; // half length of the clamp's bar, screen pixels
  const RING = 9; // radius of a handle, screen pixels
  const REACH = 20; // radius in which a handle is grabbed, screen pixels
  const CHANNELS = ["red", "green", "blue"];
  const ARROWS = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1]};
  const HANDLES = [
    {id: "clamp", name: "clamp", kind: "clamp"}, {id: "tip", name: "tip", kind: "tip"},
    {id: "scale-a", name: "start of the line", label: "Start", kind: "scale"},
    {id: "scale-b", name: "end of the line", label: "End", kind: "scale"}];

  function added(parent, tag, attributes) {
    const element = parent.appendChild(document.createElementNS(SVG, tag));
    for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
    return element;
  }

  const capital = (text) => text[0].toUpperCase() + text.slice(1);
  const pathOf = (points) => points.map(([x, y], k) => (k ? "L" : "M") + x + " " + y).join("");
  const described = (point) => `column ${point.x.toFixed(1)}, row ${point.y.toFixed(1)}`;

  // One colour channel of a picture as a grey picture.
  async function greyOf(url, channel) {
    const picture = new Image();
    picture.src = url;
    await picture.decode();
    const canvas = document.createElement("canvas");
    canvas.width = picture.naturalWidth;
    canvas.height = picture.naturalHeight;
    const pen = canvas.getContext("2d");
    pen.drawImage(picture, 0, 0);
    const pixels = pen.getImageData(0, 0, canvas.width, canvas.height);
    const kept = CHANNELS.indexOf(channel);
    for (let k = 0; k < pixels.data.length; k += 4)
      pixels.data.fill(pixels.data[k + kept], k, k + 3);
    pen.putImageData(pixels, 0, 0);
    return canvas.toDataURL("image/png");
  }

  class View {
    // state: {points, frame, up, channel, scale} of the page; moved(id, point, isExact): a handle moves
    constructor(svg, setup, state, moved) {
      Object.assign(this, {svg, setup, state, moved, greys: new Map(), last: "clamp", zoomed: () => {}});
      const {frame_width: width, frame_height: height} = setup;
      const margin = MARGIN * Math.max(width, height);
      this.whole = {x: 0.5 * (width - 1), y: 0.5 * (height - 1), zoom: 1,
        width: width + 2 * margin, height: height + 2 * margin};
      this.reset();
      this.scene = added(svg, "g", {});
      this.image = added(this.scene, "image",
        {x: -0.5, y: -0.5, width, height, preserveAspectRatio: "none"});
      for (const frame of setup.frames)
        added(this.scene, "path", {class: "swept", d: pathOf(frame.axis || [])});
      for (const name of ["rest-halo", "halo", "axis", "rest", "ruler-halo halo", "ruler"])
        this[name.split(" ")[0]] = added(this.scene, "path", {class: name});
      this.handles = HANDLES.map((handle) => this.startHandle(handle));
      this.startPanning();
    }

    reset() { this.view = {...this.whole}; }

    startHandle({id, name, label, kind}) {
      const group = added(this.svg, "g", {id, class: "handle " + kind, tabindex: 0, role: "slider"});
      const reach = added(group, "path", {class: "reach", style: "fill: transparent"});
      const under = added(group, "path", {class: "under"}), sign = added(group, "path", {class: "sign"});
      const text = added(group, "text", {"aria-hidden": "true"});
      text.textContent = label || capital(name);
      group.addEventListener("focus", () => { this.last = id; });
      group.addEventListener("keydown", (event) => this.keyed(id, event));
      this.dragged(group, (event) => {
        group.focus({preventScroll: true});
        const start = this.state.points[id], grip = this.frameOf(event);
        return (moving) => {
          const at = this.frameOf(moving), half = {x: 0.5 * this.whole.width, y: 0.5 * this.whole.height};
          const inside = (axis) => Math.min(Math.max(start[axis] + at[axis] - grip[axis],
            this.whole[axis] - half[axis]), this.whole[axis] + half[axis]);
          this.moved(id, {x: inside("x"), y: inside("y")}, false);
        };
      });
      return {id, name, kind, group, text, shapes: [reach, under, sign]};
    }

    // start(event) returns what to do while the pointer moves, or nothing.
    dragged(element, start) {
      let follow = null;
      element.addEventListener("pointerdown", (event) => {
        if (event.button !== 0) return;
        follow = start(event) || null;
        if (!follow) return;
        event.preventDefault();
        event.stopPropagation();
        element.setPointerCapture(event.pointerId);
      });
      element.addEventListener("pointermove", (event) => { if (follow) follow(event); });
      for (const end of ["pointerup", "pointercancel"])
        element.addEventListener(end, () => { follow = null; });
    }

    startPanning() {
      this.dragged(this.svg, (event) => {
        if (this.view.zoom === 1) return null;
        const {x, y} = this.view, scale = this.scale();
        return (moving) => {
          this.view.x = x - (moving.clientX - event.clientX) / scale;
          this.view.y = y - (moving.clientY - event.clientY) / scale;
          this.draw();
        };
      });
    }

    keyed(id, event) {
      const arrow = ARROWS[event.key];
      if (!arrow || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      const step = event.shiftKey ? 10 : event.altKey ? 0.1 : 1, point = this.state.points[id];
      const next = {x: point.x + step * arrow[0], y: point.y + step * arrow[1]};
      this.moved(id, next, true);
      const [x, y] = this.screenOf(this.state.points[id]), {width, height} = this.size;
      if (x >= 0 && y >= 0 && x <= width && y <= height) return;
      Object.assign(this.view, this.state.points[id]); // the handle left the view
      this.draw();
    }

    zoom(direction) {
      const zoom = Math.min(this.view.zoom * ZOOM_STEP ** direction, ZOOM_LARGEST);
      if (zoom < 1.01) this.reset();
      else Object.assign(this.view, {zoom, ...this.state.points[this.last]});
      this.draw();
    }

    // Screen pixels per frame pixel.
    scale() {
      const {width, height} = this.size;
      return this.view.zoom * Math.min(width / this.whole.width, height / this.whole.height);
    }

    screenOf({x, y}) {
      const scale = this.scale(), {width, height} = this.size;
      return [(x - this.view.x) * scale + 0.5 * width, (y - this.view.y) * scale + 0.5 * height];
    }

    frameOf(event) {
      const box = this.svg.getBoundingClientRect(), scale = this.scale();
      return {x: (event.clientX - box.left - 0.5 * box.width) / scale + this.view.x,
        y: (event.clientY - box.top - 0.5 * box.height) / scale + this.view.y};
    }

    // The height follows the width and the frame's shape, but leaves room for the controls below.
    resize() {
      const width = this.svg.clientWidth;
      const height = Math.min(width * this.whole.height / this.whole.width,
        Math.max(320, window.innerHeight - 300));
      this.svg.style.height = Math.round(height) + "px";
      this.size = {width, height: this.svg.clientHeight};
    }

    async drawImage() {
      const frame = this.setup.frames[this.state.frame], {channel} = this.state;
      if (!frame) return;
      let url = frame.image;
      if (this.setup.bands === 3 && channel !== "auto") {
        const key = channel + this.state.frame;
        if (!this.greys.has(key)) this.greys.set(key, await greyOf(frame.image, channel));
        url = this.greys.get(key);
      }
      const isShown = frame === this.setup.frames[this.state.frame] && channel === this.state.channel;
      if (isShown) this.image.setAttribute("href", url);
    }

    draw() {
      this.resize();
      const {points, frame} = this.state, scale = this.scale();
      const [left, top] = this.screenOf({x: 0, y: 0});
      this.scene.setAttribute("transform", `matrix(${scale} 0 0 ${scale} ${left} ${top})`);
      this.image.setAttribute("class", scale >= SHARP ? "sharp" : "");
      this.svg.classList.toggle("zoomed", this.view.zoom > 1);
      const axis = pathOf((this.setup.frames[frame] || {}).axis || []);
      const between = (a, b) => pathOf([points[a], points[b]].map(({x, y}) => [x, y]));
      const ruler = this.state.scale === "line" ? between("scale-a", "scale-b") : "";
      for (const [name, path] of [["halo", axis], ["axis", axis], ["rest-halo", between("clamp", "tip")],
        ["rest", between("clamp", "tip")], ["ruler-halo", ruler], ["ruler", ruler]])
        this[name].setAttribute("d", path);
      this.handles.forEach((handle) => this.drawHandle(handle));
      this.zoomed(this.view.zoom);
    }

    drawHandle({id, name, kind, group, text, shapes}) {
      const isHidden = kind === "scale" && this.state.scale !== "line";
      group.style.display = isHidden ? "none" : "";
      if (isHidden) return;
      const point = this.state.points[id], [x, y] = this.screenOf(point);
      const isSideways = this.state.up.endsWith("column");
      group.setAttribute("transform", `translate(${x} ${y})`);
      group.setAttribute("aria-label", `${capital(name)}: ${described(point)}`);
      group.setAttribute("aria-valuetext", described(point));
      group.setAttribute("aria-valuenow", (isSideways ? point.x : point.y).toFixed(1));
      // Hollow, so that the pixel below can be seen.
      const circle = (r) => `M${-r} 0a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0`;
      const bar = isSideways ? `M0 ${-BAR}V-3M0 3V${BAR}` : `M${-BAR} 0H-3M3 0H${BAR}`;
      const cross = `M${-RING - 5} 0H-3M3 0H${RING + 5}M0 ${-RING - 5}V-3M0 3V${RING + 5}`;
      const sign = kind === "clamp" ? bar : circle(RING) + cross;
      const reach = kind !== "clamp" ? circle(REACH) : circle(REACH) + (isSideways
        ? `M-10 ${-BAR}H10V${BAR}H-10z` : `M${-BAR} -10V10H${BAR}V-10z`);
      shapes.forEach((shape, k) => shape.setAttribute("d", k ? sign : reach));
      const isUpright = kind === "clamp" && isSideways;
      this.place(text, x, y, kind === "clamp" ? BAR + 6 : RING + 10,
        isUpright ? BAR : kind === "scale" ? RING + 5 : 0);
    }

    // A label beside its handle, on the side that has room; below or above it if `half` is not 0.
    place(text, x, y, distance, half) {
      const width = text.getComputedTextLength(), fits = x + distance + width < this.size.width - 4;
      const clearOfEdge = (at, length, size) => Math.min(Math.max(at, 4), size - length - 4);
      const below = y + half + 22 < this.size.height;
      text.setAttribute("x", half ? clearOfEdge(x - 0.5 * width, width, this.size.width) - x
        : fits ? distance : -distance - width);
      text.setAttribute("y", half ? (below ? half + 17 : -half - 8)
        : Math.min(Math.max(y + 5, 16), this.size.height - 6) - y);
    }
  }

  return {View, described};
}());
