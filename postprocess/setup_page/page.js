// SPDX-License-Identifier: BSD-3-Clause
// State, entries and checks of the page, and the text of video.toml that follows from them.
(function () {
  "use strict";

  const find = (id) => document.getElementById(id);
  const setup = JSON.parse(find("setup").textContent);
  const {checks: rules, detected} = setup;
  const FIRST_ROOT = 1.8751; // of the frequency equation of a clamped beam
  const DECIMALS = 10; // handles stop at tenths of a pixel
  const DEFAULT_SHAPE = 2 / 3; // mass per length of a chain of spheres, over density times area
  const DIRECTIONS = {decreasing_row: "upward", increasing_row: "downward",
    decreasing_column: "to the left", increasing_column: "to the right"};
  const WANTED = {length_mm: "the length from the clamp to the tip", diameter_mm: "the diameter of the stem",
    density_kg_m3: "the density of the stem", fps: "the frame rate of the camera",
    line_mm: "the length of the orange line", mm_per_px: "the scale at the stem"};

  const middle = 0.5 * (setup.frame_width - 1), bottom = setup.frame_height - 1;
  const state = {
    up: detected ? detected.up : "decreasing_row", stem: "auto", channel: "auto", scale: "stem",
    release: null, frame: firstShown(),
    points: {clamp: pointOf(detected && detected.clamp, [middle, bottom]),
      tip: pointOf(detected && detected.tip, [middle, 0]),
      "scale-a": besideStem(0.2), "scale-b": besideStem(0.8)},
    touched: new Set(), // handles that the user moved, and entries that the user left
  };

  function pointOf(pair, otherwise) {
    const [x, y] = pair || otherwise;
    return {x, y};
  }

  // An end of the line of known length: first the line lies parallel to the stem, near a side.
  function besideStem(part) {
    const isUpright = !detected || detected.up.endsWith("row"), aside = 0.85;
    return {x: Math.round((isUpright ? aside : part) * setup.frame_width),
      y: Math.round((isUpright ? part : aside) * setup.frame_height)};
  }

  // The picture whose axis ends nearest to the tip at rest.
  function firstShown() {
    const distances = setup.frames.map(({axis}) => !detected || !axis || !axis.length ? Infinity
      : Math.min(...[axis[0], axis[axis.length - 1]].map(([x, y]) =>
        Math.hypot(x - detected.tip[0], y - detected.tip[1]))));
    return Math.max(0, distances.indexOf(Math.min(...distances)));
  }

  // Numbers as text ------------------------------------------------------------------------------

  // Shortest text with at most `digits` significant digits.
  const short = (number, digits = 4) => String(Number(number.toPrecision(digits)));
  // A limit of the allowed range: 100000 is 1e5.
  const bound = (number) => Math.abs(number) >= 1e5
    ? number.toExponential().replace("e+", "e") : String(number);
  function tomlNumber(number) {
    const text = short(number, 6);
    return /[.e]/.test(text) ? text : text + ".0";
  }
  const tomlText = (text) => JSON.stringify(text).replace(/\x7f/g, "\\u007F");

  function modulusText(pascal) {
    const [number, unit] = pascal >= 1e8 ? [1e-9 * pascal, "GPa"] : [1e-6 * pascal, "MPa"];
    return `${number < 10 ? number.toPrecision(2) : short(number, 2)} ${unit}`;
  }

  // Entries --------------------------------------------------------------------------------------

  function allowed(limits) {
    if (limits.from === undefined) return `at most ${bound(limits.to)}`;
    return `${limits.open ? "larger than" : "at least"} ${bound(limits.from)} and at most ${bound(limits.to)}`;
  }

  // Why a number is not allowed, or "".
  function outOf(name, number, limits) {
    if (!limits) return "";
    const isLow = limits.open ? number <= limits.from : number < limits.from;
    if (!isLow && !(number > limits.to)) return "";
    return `${name} = ${short(number, 6)} is not allowed: it must be ${allowed(limits)}`;
  }

  // The number of an entry, or null with a fault if it is no allowed number.
  function entered(id, faults, isOptional = false) {
    const text = find(id).value.trim();
    const refuse = (fault) => { faults.push({id, text: fault, isMissing: text === ""}); return null; };
    if (text === "") return isOptional ? null : refuse(`${id} is missing: enter ${WANTED[id]}`);
    if (text.includes(",")) return refuse(`${id} = ${text} is not a number: write a decimal point, no comma`);
    if (!/^[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?$/i.test(text)) return refuse(`${id} = ${text} is not a number`);
    const fault = outOf(id, Number(text), setup.limits[id] || (id === "line_mm" && setup.limits.length_mm));
    return fault ? refuse(fault) : Number(text);
  }

  function enteredName(faults) {
    const name = find("stem_id").value.trim();
    if (name === "")
      faults.push({id: "stem_id", text: "id is missing: enter a name for the specimen", isMissing: true});
    else if (!/^[A-Za-z0-9._-]+$/.test(name))
      faults.push({id: "stem_id", text: `id = ${name} is not allowed: use letters, digits, ".", "_" and "-"`});
    return name;
  }

  // Geometry -------------------------------------------------------------------------------------

  const isSideways = (up) => up.endsWith("column");
  const alongAxis = () => isSideways(state.up) ? "x" : "y";
  const acrossAxis = () => isSideways(state.up) ? "y" : "x";

  // Pixels from clamp to tip in the direction of the stem; across it, without a sign.
  function visible() {
    const {clamp, tip} = state.points, sign = state.up.startsWith("decreasing") ? -1 : 1;
    return {along: sign * (tip[alongAxis()] - clamp[alongAxis()]),
      across: Math.abs(tip[acrossAxis()] - clamp[acrossAxis()])};
  }

  // The place of the stem at its clamp is stated only if it is not the detected one.
  function statesAxis() {
    if (!detected || isSideways(state.up) !== isSideways(detected.up)) return true;
    return Math.abs(state.points.clamp[acrossAxis()] - detected.clamp[isSideways(state.up) ? 1 : 0]) > 0.01;
  }

  function scaleOf(values) {
    if (state.scale === "number") return values.mm_per_px;
    const {"scale-a": a, "scale-b": b} = state.points;
    const [millimetres, pixels] = state.scale === "line"
      ? [values.line_mm, Math.hypot(b.x - a.x, b.y - a.y)] : [values.length_mm, visible().along];
    return millimetres !== null && pixels > 0 ? millimetres / pixels : null;
  }

  // Checks ---------------------------------------------------------------------------------------

  function collect() {
    const faults = [], notes = [], facts = [], values = {};
    values.id = enteredName(faults);
    for (const id of ["length_mm", "diameter_mm", "density_kg_m3"]) values[id] = entered(id, faults);
    values.fps = entered("fps", faults, setup.rate_is_the_cameras);
    values.exposure_ms = entered("exposure_ms", faults, true);
    for (const [kind, id] of [["line", "line_mm"], ["number", "mm_per_px"]])
      values[id] = state.scale === kind ? entered(id, faults) : null;
    values.scale = scaleOf(values);
    const found = {values, faults, notes, facts};
    checkHandles(found);
    checkLength(found);
    checkWidth(found);
    tellMass(found);
    checkSwing(found);
    if (values.exposure_ms && values.fps && values.exposure_ms * values.fps > 1000)
      notes.push("The exposure is longer than the time from frame to frame: check exposure_ms and fps.");
    return found;
  }

  function checkHandles({values, faults}) {
    const {along, across} = visible(), {clamp} = state.points;
    const isPlaced = (id) => detected || state.touched.has(id);
    if (!isPlaced("clamp"))
      faults.push({id: "clamp", text: "The clamp was not detected: move the red handle to it."});
    if (!isPlaced("tip") && state.scale === "stem")
      faults.push({id: "tip", text: "The tip was not detected: move the blue handle to it."});
    if (along <= across)
      faults.push({id: "up", text: `The direction "${DIRECTIONS[state.up]}" does not agree with the handles: `
        + "the tip does not lie in this direction from the clamp."});
    for (const [axis, name] of [["y", "row"], ["x", "column"]]) {
      const fault = outOf(`clamp_${name}`, clamp[axis], setup.limits.clamp);
      if (fault) faults.push({id: "clamp", text: fault});
    }
    const release = state.release !== null
      && outOf("release_frame", state.release, setup.limits.release_frame);
    if (release) faults.push({id: "release_frame", text: release});
    if (state.scale === "number") return;
    if (state.scale === "line" && values.line_mm !== null && values.scale === null)
      faults.push({id: "line_mm", text: "The ends of the orange line coincide: move them apart."});
    const fault = values.scale !== null && outOf("mm_per_px", values.scale, setup.limits.mm_per_px);
    if (fault) faults.push({id: state.scale === "line" ? "line_mm" : "length_mm", text: fault});
  }

  function checkLength({values, faults, notes, facts}) {
    const {scale, length_mm: length} = values, {along} = visible();
    const isKnown = scale !== null && length !== null && along > 0 && (detected || state.touched.has("tip"));
    if (!isKnown || state.scale === "stem") return;
    const seen = along * scale, slack = rules.pixels_of_length * scale;
    const text = `The visible stem is ${short(seen)} mm long from clamp to tip; length_mm is ${short(length)}.`;
    const advice = " Check the clamp, the tip, the scale and length_mm.";
    if (Math.abs(seen - length) > rules.length_refusal * length + slack)
      faults.push({id: "length_mm", text: text + advice});
    else if (Math.abs(seen - length) > rules.length_note * length + slack) notes.push(text + advice);
    else facts.push(text);
  }

  function checkWidth({values, notes, facts}) {
    const {scale, diameter_mm: diameter} = values;
    if (!detected || !detected.width_px || scale === null || diameter === null) return;
    const width = detected.width_px, expected = diameter / scale;
    const text = `The stem appears ${short(width, 3)} pixels wide; diameter_mm and the scale give `
      + `${short(expected, 3)} pixels.`;
    const isFar = width > rules.width_largest * expected + rules.width_pixels
      || width < rules.width_smallest * expected - rules.width_pixels;
    (isFar ? notes : facts).push(isFar ? text + " Check the scale and diameter_mm." : text);
  }

  // Mass per length, kg/m, of a chain of spheres of the density.
  function linearDensity(values) {
    const shape = rules.mass_per_length_over_density_area || DEFAULT_SHAPE;
    return shape * values.density_kg_m3 * Math.PI * (1e-3 * values.diameter_mm) ** 2 / 4;
  }

  function tellMass({values, facts}) {
    if ([values.length_mm, values.diameter_mm, values.density_kg_m3].includes(null)) return;
    const spheres = 1e3 * linearDensity(values);
    facts.push(`The stem has ${short(spheres, 3)} g/m, ${short(spheres * values.length_mm, 3)} mg in all. If the density is `
      + `that of a solid rod's material, it has ${short(spheres / (rules.mass_per_length_over_density_area || DEFAULT_SHAPE), 3)} g/m: then write material_density_kg_m3 in `
      + "video.toml (or mass_mg or linear_density_kg_m).");
  }

  // Young's modulus (Pa) that a plain beam needs for this frequency (Hz).
  function modulusFor(frequency, values) {
    const length = 1e-3 * values.length_mm, diameter = 1e-3 * values.diameter_mm;
    const mass = linearDensity(values);
    const inertia = Math.PI * diameter ** 4 / 64;
    return (2 * Math.PI * frequency * length ** 2 / FIRST_ROOT ** 2) ** 2 * mass / inertia;
  }

  function checkSwing({values, notes, facts}) {
    const cycles = detected && detected.cycles_per_frame;
    if (!cycles) return;
    if (cycles > rules.cycles_per_frame_largest)
      notes.push(`The recording has only ${short(1 / cycles, 2)} frames per swing: the camera was slow.`);
    const rate = setup.rate_is_the_cameras ? setup.stated_fps : values.fps;
    if (!rate) return;
    const text = `The stem swings at ${short(cycles * rate, 3)} Hz`;
    if ([values.length_mm, values.diameter_mm, values.density_kg_m3].includes(null))
      return void facts.push(text + ".");
    const modulus = modulusFor(cycles * rate, values);
    const isUsual = modulus >= rules.modulus_smallest && modulus <= rules.modulus_largest;
    const whole = `${text}; a plain beam would need E = ${modulusText(modulus)}.`;
    if (isUsual) facts.push(whole);
    else notes.push(`${whole} Plant stems have ${modulusText(rules.modulus_smallest)} to `
      + `${modulusText(rules.modulus_largest)}: check fps, the scale, length, diameter and density.`);
  }

  // video.toml -----------------------------------------------------------------------------------

  function tomlOf(values) {
    const lines = [`# written with \`culm setup\`, ${setup.program.replace(/[\x00-\x1f\x7f]/g, " ")}`];
    const number = (key, value) => {
      lines.push(value === null ? `# ${key} is missing` : `${key} = ${tomlNumber(value)}`);
    };
    const text = (key, value) => lines.push(`${key} = ${tomlText(value)}`);
    lines.push("[video]");
    text("frames", setup.frames_key);
    if (!setup.rate_is_the_cameras) number("fps", values.fps);
    number("mm_per_px", values.scale);
    text("up", state.up);
    const [along, across] = isSideways(state.up) ? ["column", "row"] : ["row", "column"];
    number("clamp_" + along, state.points.clamp[alongAxis()]);
    if (statesAxis()) number("axis_" + across, state.points.clamp[acrossAxis()]);
    if (state.stem !== "auto") text("stem", state.stem);
    if (setup.bands === 3 && state.channel !== "auto") text("best_channel", state.channel);
    if (state.release !== null) lines.push(`release_frame = ${state.release}`);
    lines.push("[stem]");
    text("id", values.id);
    for (const key of ["length_mm", "diameter_mm", "density_kg_m3"]) number(key, values[key]);
    if (values.exposure_ms !== null) {
      lines.push("[camera]");
      number("exposure_ms", values.exposure_ms);
    }
    return lines.join("\n") + "\n";
  }

  // What the page shows --------------------------------------------------------------------------

  function showFaults(faults) {
    for (const place of document.querySelectorAll("p.fault")) {
      const id = place.id.replace(/-fault$/, ""), entry = find(id);
      const fault = faults.find((one) => one.id === id && (!one.isMissing || state.touched.has(id)));
      place.hidden = !fault;
      place.textContent = fault ? fault.text : "";
      if (entry) entry.setAttribute("aria-invalid", fault ? "true" : "false");
    }
  }

  // A list that is read aloud changes only if its text does.
  function showChecks({faults, notes, facts}) {
    const items = [...faults.map(({text}) => ["fault", "Error: " + text]),
      ...notes.map((text) => ["doubt", "Note: " + text]), ...facts.map((text) => ["good", text])];
    if (faults.length === 0) items.unshift(["good", "There are no errors."]);
    const list = find("checks"), shown = JSON.stringify(items);
    if (list.shown === shown) return;
    list.shown = shown;
    list.replaceChildren(...items.map(([kind, text]) => {
      const item = document.createElement("li");
      item.className = kind;
      item.textContent = text;
      return item;
    }));
  }

  function showText(id, text) {
    if (find(id).textContent !== text) find(id).textContent = text;
  }

  function showRelease() {
    const frame = detected ? detected.release_frame : null;
    const found = typeof frame === "number" ? `frame ${frame} was detected` : "none was detected";
    const pull = detected && detected.pull_side && typeof detected.pull_px === "number"
      ? ` The stem is pulled to the ${detected.pull_side} by ${short(detected.pull_px, 3)} pixels.` : "";
    showText("release-facts", "The last frame in which the stem is held: " + (state.release === null
      ? found + "." : `frame ${state.release}, set by you (${found}).`) + pull);
    find("release-auto").disabled = state.release === null;
    find("release-use-shown").disabled = setup.frames.length === 0;
  }

  function showScale({values}) {
    for (const part of document.querySelectorAll("[data-scale]")) part.hidden = part.dataset.scale !== state.scale;
    showText("scale-facts", values.scale === null ? "not known yet" : short(values.scale, 6) + " mm/px");
  }

  function showFrame() {
    const frame = setup.frames[state.frame], slider = find("frame");
    const text = frame ? `Frame ${frame.number}: ${frame.caption}` : "The page contains no pictures.";
    slider.value = state.frame;
    slider.setAttribute("aria-valuetext", text);
    showText("frame-facts", text);
    find("frame-previous").disabled = state.frame <= 0;
    find("frame-next").disabled = state.frame >= setup.frames.length - 1;
    return view.drawImage();
  }

  function update() {
    const found = collect(), {faults} = found, {clamp, tip} = state.points;
    view.draw();
    showFaults(faults);
    showChecks(found);
    showRelease();
    showScale(found);
    showText("handle-facts", `Clamp: ${Picture.described(clamp)}. Tip: ${Picture.described(tip)}. `
      + `Distance: ${short(visible().along)} pixels.`);
    showText("toml", tomlOf(found.values));
    find("save").disabled = find("copy").disabled = faults.length > 0;
    showText("save-facts", faults.length === 0 ? "" : faults.length === 1
      ? `One error must be corrected first: ${faults[0].text}`
      : `${faults.length} errors must be corrected first; see Checks.`);
  }

  // What the user does ---------------------------------------------------------------------------

  // Near the detected axis the pointer keeps to it: a drag along the stem does not change axis_column.
  function moveHandle(id, point, isExact) {
    const next = {x: Math.round(DECIMALS * point.x) / DECIMALS, y: Math.round(DECIMALS * point.y) / DECIMALS};
    const across = acrossAxis();
    if (id === "clamp" && detected && !isExact && isSideways(state.up) === isSideways(detected.up)) {
      const axis = detected.clamp[across === "x" ? 0 : 1];
      if (Math.abs(next[across] - axis) <= 0.5 * (detected.width_px || 0)) next[across] = axis;
    }
    // Only coordinates that changed are rounded: the detected ones keep their fractions.
    for (const axis of ["x", "y"])
      if (Math.abs(point[axis] - state.points[id][axis]) < 1e-9) next[axis] = state.points[id][axis];
    state.points[id] = next;
    state.touched.add(id);
    update();
  }

  function chooseFrame(frame) {
    state.frame = Math.min(Math.max(frame, 0), setup.frames.length - 1);
    showFrame();
    view.draw();
  }

  function save() {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([find("toml").textContent], {type: "text/plain"}));
    link.download = "video.toml";
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    showText("save-facts", "Your browser saves the file.");
  }

  async function copy() {
    try {
      await navigator.clipboard.writeText(find("toml").textContent);
    } catch (refused) { // some browsers have no clipboard for file://
      window.getSelection().selectAllChildren(find("toml"));
      document.execCommand("copy");
    }
    showText("save-facts", "Copied.");
  }

  function startChoices(name, after = update) {
    for (const choice of document.querySelectorAll(`input[name="${name}"]`))
      choice.addEventListener("change", () => { state[name] = choice.value; after(); });
  }

  function startEntries() {
    const name = setup.folder.replace(/[\\/]+$/, "").split(/[\\/]/).pop();
    find("stem_id").value = name.replace(/[^A-Za-z0-9._-]+/g, "_").replace(/^[_.-]+|[_.-]+$/g, "") || "stem";
    find("density-note").textContent = "culm models the stem as a chain of touching spheres of this density.";
    find("up").value = state.up;
    if (detected && detected.stem) find("stem-auto-name").textContent = `automatic (${detected.stem})`;
    if (detected && detected.channel) find("channel-auto-name").textContent = `automatic (${detected.channel})`;
    find("channel").hidden = setup.bands !== 3;
    for (const text of setup.assumed || []) {
      const entry = document.createElement("li");
      entry.textContent = text;
      find("assumed-list").append(entry);
      find("assumed").hidden = false;
    }
    const stated = setup.stated_fps;
    if (setup.rate_is_the_cameras) {
      find("fps").readOnly = true;
      find("fps").value = stated === null ? "" : String(stated);
      find("fps-note").textContent = "The rate was read from the camera's header.";
    } else if (setup.proposed_fps) {
      find("fps").value = String(Number(setup.proposed_fps.toPrecision(6)));
      find("fps-note").textContent = setup.remarks.join("; ");
    } else if (stated !== null) {
      find("fps-note").textContent = `The file states ${short(stated)} frames/s. This is usually the rate of `
        + "playback; enter the rate of the camera.";
    }
    find("entries").addEventListener("submit", (event) => event.preventDefault());
    find("entries").addEventListener("input", update);
    find("entries").addEventListener("focusout", (event) => {
      if (!event.target.matches("input:not([type])")) return;
      state.touched.add(event.target.id);
      showFaults(collect().faults);
    });
    find("up").addEventListener("change", () => { state.up = find("up").value; update(); });
    ["stem", "scale"].forEach((name) => startChoices(name));
    startChoices("channel", () => { showFrame(); update(); });
  }

  function startButtons() {
    const onClick = (id, action) => find(id).addEventListener("click", action);
    find("frame").max = Math.max(0, setup.frames.length - 1);
    find("frame").addEventListener("input", () => chooseFrame(Number(find("frame").value)));
    onClick("frame-previous", () => chooseFrame(state.frame - 1));
    onClick("frame-next", () => chooseFrame(state.frame + 1));
    onClick("zoom-in", () => view.zoom(1));
    onClick("zoom-out", () => view.zoom(-1));
    onClick("zoom-reset", () => { view.reset(); view.draw(); });
    onClick("release-use-shown", () => { state.release = setup.frames[state.frame].number; update(); });
    onClick("release-auto", () => { state.release = null; update(); });
    onClick("save", save);
    onClick("copy", copy);
  }

  function startTexts() {
    document.title = `culm setup: ${setup.video}`;
    showText("video", setup.video);
    showText("remark", setup.remark);
    find("remark").hidden = setup.remark === "";
    showText("program", setup.program);
    showText("target", setup.folder.replace(/\/+$/, "") + "/video.toml");
    showText("command", setup.command);
  }

  const view = new Picture.View(find("picture"), setup, state, moveHandle);
  view.zoomed = (zoom) => showText("zoom-facts", `${short(zoom, 2)}×`);
  startTexts();
  startEntries();
  startButtons();
  update();
  new ResizeObserver(() => view.draw()).observe(find("picture").parentElement);
  window.addEventListener("resize", () => view.draw());
  showFrame().then(() => {
    document.documentElement.dataset.ready = "true";
    performance.mark("culm-ready");
  });
}());
