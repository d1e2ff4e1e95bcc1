"use strict";
// The run that the reader chooses: profile, motion of the probe, numbers. All data are in the page.
(() => {
  const study = JSON.parse(document.getElementById("data").textContent);
  const byId = (id) => document.getElementById(id);
  const form = byId("choice"), slider = byId("time"), play = byId("play");
  const INK = "#1b1d21", SOFT = "#5c636e", LINE = "#c9ced6", BAND = "#eef0f3", VERTICAL = "#011959", HORIZONTAL = "#c4622d", PLACE = "#8c2d04";
  const FONT = "12px system-ui, sans-serif";
  const LOST = -32768; // a position that is not a number or outside the range
  let chosen = null; // point, its run unpacked, time as text
  let timer = 0;

  // ---------------------------------------------------------------- data

  async function unpacked(text) {
    const bytes = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
    return new Response(new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"))).arrayBuffer();
  }

  // Frames from their differences; typed arrays wrap around as the packing did.
  function summed(values, width) {
    for (let i = width; i < values.length; i += 1) values[i] += values[i - width];
    return values;
  }

  async function loaded(run) {
    const scene = { ...study, ...run.own };
    const [positions, curve, ...parts] = await Promise.all([run.positions, run.curve, ...Object.values(run.shares)].map(unpacked));
    const n = run.particles, frames = run.times.length;
    const shares = Object.fromEntries(Object.keys(run.shares).map((name, i) => [name, summed(new Uint8Array(parts[i]), n)]));
    const places = summed(new Int16Array(positions), 2 * n), samples = new Float32Array(curve);
    const count = samples.length / 3;
    const moved = new Float32Array(frames * n).fill(NaN); // displacement since the first frame kept, the end of the gravity stage
    for (let f = 0; f < frames; f += 1) {
      for (let i = 0; i < n; i += 1) {
        const x = places[2 * n * f + i], y = places[2 * n * f + n + i];
        if (x !== LOST && places[i] !== LOST) moved[n * f + i] = scene.quantum * Math.hypot(x - places[i], y - places[n + i]);
      }
    }
    return {
      n, scene, times: run.times, places, moved, shares,
      t: samples.subarray(0, count), u: samples.subarray(count, 2 * count), v: samples.subarray(2 * count),
    };
  }

  const largest = (values) => values.reduce((most, value) => (value > most ? value : most), 0);

  // ---------------------------------------------------------------- drawing

  // Canvas of a height in CSS pixels, cleared, at twice the resolution at least: it is printed, too.
  function pen(canvas, height) {
    const width = canvas.parentElement.clientWidth, scale = Math.max(2, window.devicePixelRatio);
    canvas.width = Math.round(width * scale);
    canvas.height = Math.round(height * scale);
    const ink = canvas.getContext("2d");
    ink.scale(scale, scale);
    ink.fillStyle = "#fff";
    ink.fillRect(0, 0, width, height + 1); // the last row of pixels is whole
    ink.font = FONT;
    return ink;
  }

  // Round numbers from low to high, some `count` of them.
  function ticks(low, high, count) {
    const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
    const step = power * [1, 2, 5, 10].find((part) => part * power >= rough * 0.999);
    const found = [];
    for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i += 1) found.push(Number((i * step).toPrecision(12)));
    return found;
  }

  const label = (value) => String(value).replace("-", "−");

  function write(ink, text, x, y, align = "center", baseline = "alphabetic", colour = INK) {
    Object.assign(ink, { textAlign: align, textBaseline: baseline, fillStyle: colour });
    ink.fillText(text, x, y);
  }

  // Axes around a box in pixels; returns the mappings from data to pixels.
  function axes(ink, box, [left, right], [low, high], names, grid) {
    const X = (x) => box.x + ((x - left) / (right - left)) * box.w;
    const Y = (y) => box.y + box.h - ((y - low) / (high - low)) * box.h;
    ink.lineWidth = 1;
    ink.strokeStyle = LINE;
    ink.beginPath();
    for (const x of ticks(left, right, box.w / 75)) {
      ink.moveTo(X(x), box.y + box.h);
      ink.lineTo(X(x), box.y + box.h + 4);
      write(ink, label(x), X(x), box.y + box.h + 7, "center", "top", SOFT);
    }
    for (const y of ticks(low, high, Math.max(2, box.h / 45))) {
      ink.moveTo(box.x - 4, Y(y));
      ink.lineTo(grid ? box.x + box.w : box.x, Y(y));
      write(ink, label(y), box.x - 7, Y(y), "right", "middle", SOFT);
    }
    ink.moveTo(box.x, box.y);
    ink.lineTo(box.x, box.y + box.h);
    ink.lineTo(box.x + box.w, box.y + box.h);
    ink.stroke();
    write(ink, names[0], box.x + box.w / 2, box.y + box.h + 24, "center", "top");
    ink.save();
    ink.translate(13, box.y + box.h / 2);
    ink.rotate(-Math.PI / 2);
    write(ink, names[1], 0, 0, "center", "middle");
    ink.restore();
    return [X, Y];
  }

  // What colours the soil: value of a particle in the frame, end of the scale, its name.
  function colouring(frame) {
    const { n, moved, shares } = chosen.run, wanted = form.elements.colour.value;
    if (wanted in study.shares) { // a run that does not have it has none of it
      return { of: (i) => (shares[wanted] ? shares[wanted][n * frame + i] / 255 : 0), end: 1, name: study.shares[wanted] };
    }
    const own = largest(moved), end = wanted === "common" ? study.largest : own;
    return { of: (i) => moved[n * frame + i], end: Math.max(end, 0.1), name: "displacement (m)" };
  }

  function circles(ink, centres, radius, stroke, fill) {
    ink.beginPath();
    for (const [x, y] of centres) {
      ink.moveTo(x + radius, y);
      ink.arc(x, y, radius, 0, 2 * Math.PI);
    }
    if (fill) {
      ink.fillStyle = fill;
      ink.fill();
    }
    ink.strokeStyle = stroke;
    ink.stroke();
  }

  function drawProfile(frame) {
    const canvas = byId("profile"), width = canvas.parentElement.clientWidth;
    const { n, places, scene: own } = chosen.run;
    const box = { x: 58, y: 22, w: width - 70, h: 0 }; // room for the name of a probe at the top
    const scaleOf = box.w / (study.right - study.left);
    for (const [name, , y] of own.places) box.y = Math.max(box.y, 24 + 8 * name.length - scaleOf * (study.upper - y)); // and for places
    box.h = scaleOf * (study.upper - study.lower); // equal aspect
    const ink = pen(canvas, box.y + box.h + 104);
    const bins = study.colours.map(() => []);
    // The axes are those of the survey; a slope that falls to the right does so.
    const along = (x) => own.origin[0] + own.direction * x, ends = [along(study.left), along(study.right)].sort((one, other) => one - other);
    const heights = [study.lower, study.upper].map((y) => y + own.origin[1]);
    const [atX, atY] = axes(ink, box, ends, heights, ["horizontal position (m)", own.upwards], false);
    const X = (x) => atX(along(x)), Y = (y) => atY(y + own.origin[1]);
    const radius = (0.5 * own.spacing * box.w) / (study.right - study.left), scale = colouring(frame);
    let lost = 0;
    for (let i = 0; i < n; i += 1) {
      const x = places[2 * n * frame + i], y = places[2 * n * frame + n + i], value = scale.of(i);
      if (x === LOST || Number.isNaN(value)) lost += 1;
      else {
        const bin = Math.min(bins.length - 1, Math.floor((value / scale.end) * bins.length));
        bins[bin].push([X(own.middle[0] + own.quantum * x), Y(own.middle[1] + own.quantum * y)]);
      }
    }
    ink.save();
    ink.beginPath();
    ink.rect(box.x, 0, box.w, box.y + box.h);
    ink.clip();
    ink.lineWidth = 0.6;
    circles(ink, own.box[0].map((x, i) => [X(x), Y(own.box[1][i])]), radius, SOFT, "#fff");
    ink.lineWidth = 0.25;
    bins.forEach((centres, bin) => circles(ink, centres, radius * Math.sqrt(study.stride), INK, study.colours[bin]));
    ink.lineWidth = 1.2;
    ink.strokeStyle = INK;
    ink.beginPath();
    own.surface[0].forEach((x, i) => ink.lineTo(X(x), Y(own.surface[1][i])));
    ink.stroke();
    ink.lineWidth = 0.8;
    ink.strokeStyle = SOFT;
    ink.setLineDash([2, 2]);
    for (const [xs, ys] of own.layers) {
      ink.beginPath();
      xs.forEach((x, i) => ink.lineTo(X(x), Y(ys[i])));
      ink.closePath();
      ink.stroke();
    }
    ink.setLineDash([]);
    for (const [name, x, y] of own.places) { // a post on the initial ground, with the name upright above it
      ink.lineWidth = 1.6;
      ink.strokeStyle = PLACE;
      ink.beginPath();
      ink.moveTo(X(x), Y(y));
      ink.lineTo(X(x), Y(y) - 14);
      ink.stroke();
      ink.save();
      ink.translate(X(x), Y(y) - 17);
      ink.rotate(-Math.PI / 2);
      ink.font = `bold ${FONT}`;
      ink.lineWidth = 3;
      ink.strokeStyle = "#fff";
      Object.assign(ink, { textAlign: "left", textBaseline: "middle" });
      ink.strokeText(name, 0, 0);
      write(ink, name, 0, 0, "left", "middle", PLACE);
      ink.restore();
    }
    const [x, y] = [places[2 * n * frame], places[2 * n * frame + n]];
    if (x !== LOST) {
      const at = [X(own.middle[0] + own.quantum * x), Y(own.middle[1] + own.quantum * y)];
      ink.lineWidth = 1.6;
      circles(ink, [at], 4.5, INK, "#fff");
      ink.font = `bold ${FONT}`;
      ink.lineWidth = 3;
      ink.strokeStyle = "#fff";
      const [side, align] = own.direction < 0 ? [5, "left"] : [-5, "right"]; // where the air is
      Object.assign(ink, { textAlign: align, textBaseline: "bottom" });
      ink.strokeText(study.probe, at[0] + side, at[1] - 4);
      write(ink, study.probe, at[0] + side, at[1] - 4, align, "bottom");
    }
    ink.restore();
    drawBar(ink, { x: box.x, y: box.y + box.h + 52, w: Math.min(box.w, 420), h: 10 }, scale);
    canvas.setAttribute("aria-label", `Profile at ${chosen.run.times[frame]} s, ${chosen.title}, colour: ${scale.name} from 0 to ${scale.end.toPrecision(3)}`);
    byId("frame-note").textContent = lost ? `${lost} of ${n} particles are not drawn: their position is not a number or far outside.` : "";
  }

  function drawBar(ink, bar, scale) {
    study.colours.forEach((colour, i) => {
      ink.fillStyle = colour;
      ink.fillRect(bar.x + (i * bar.w) / study.colours.length, bar.y, bar.w / study.colours.length + 0.5, bar.h);
    });
    for (const value of ticks(0, scale.end, 5)) write(ink, label(value), bar.x + (value / scale.end) * bar.w, bar.y + bar.h + 4, "center", "top", SOFT);
    write(ink, scale.name, bar.x, bar.y + bar.h + 20, "left", "top");
  }

  function drawCurve(frame) {
    const canvas = byId("curve"), { t, v, times, scene: own } = chosen.run, u = chosen.run.u.map((value) => own.direction * value);
    const box = { x: 58, y: 26, w: canvas.parentElement.clientWidth - 70, h: 190 };
    const ink = pen(canvas, box.y + box.h + 44);
    const finite = [0, ...u, ...v].filter(Number.isFinite);
    let [low, high] = [Math.min(...finite), Math.max(...finite)];
    const pad = Math.max(0.06 * (high - low), 0.01);
    [low, high] = [low - pad, high + pad];
    const X = (x) => box.x + ((x - study.start) / (study.end - study.start)) * box.w;
    if (own.shaking) {
      ink.fillStyle = BAND;
      ink.fillRect(X(own.shaking[0]), box.y, X(own.shaking[1]) - X(own.shaking[0]), box.h);
    }
    const [, Y] = axes(ink, box, [study.start, study.end], [low, high], ["time (s)", `displacement of ${study.probe} (m)`], true);
    ink.strokeStyle = SOFT;
    ink.beginPath();
    ink.moveTo(X(times[frame]), box.y);
    ink.lineTo(X(times[frame]), box.y + box.h);
    ink.stroke();
    ink.lineWidth = 2;
    let key = box.x;
    const named = (name) => {
      write(ink, name, key + 34, 11, "left", "middle");
      key += 48 + ink.measureText(name).width;
    };
    [["vertical", v, VERTICAL, []], ["horizontal", u, HORIZONTAL, [7, 4]]].forEach(([name, values, colour, dashes]) => {
      ink.setLineDash(dashes);
      ink.strokeStyle = colour;
      ink.beginPath();
      for (let i = 0; i < t.length; i += 1) if (Number.isFinite(values[i])) ink.lineTo(X(t[i]), Y(values[i]));
      ink.moveTo(key, 11);
      ink.lineTo(key + 28, 11);
      ink.stroke();
      named(name);
    });
    ink.setLineDash([]);
    if (own.shaking) {
      ink.fillStyle = BAND;
      ink.fillRect(key, 4, 28, 14);
      named("shaking");
    }
    const last = (values) => values[values.length - 1].toFixed(2);
    canvas.setAttribute("aria-label", `Displacement of ${study.probe} over time, ${chosen.title}: at the end ${last(v)} m vertical, ${last(u)} m horizontal`);
  }

  // ---------------------------------------------------------------- the reader's choice

  function draw() {
    const frame = Number(slider.value);
    if (!chosen || !chosen.run) return;
    const { times } = chosen.run;
    byId("now").textContent = `${times[frame].toFixed(2)} of ${times[times.length - 1].toFixed(2)} s`;
    slider.setAttribute("aria-valuetext", byId("now").textContent);
    drawProfile(frame);
    drawCurve(frame);
  }

  function list(id, rows, tag) {
    byId(id).replaceChildren(...rows.map(([name, value]) => {
      const row = document.createElement("div");
      row.classList.toggle("whole", name === "liquefaction"); // a sentence
      row.appendChild(document.createElement("dt")).textContent = name;
      row.appendChild(document.createElement("dd")).appendChild(document.createElement(tag)).textContent = value;
      return row;
    }));
  }

  function describe({ facts, status, file, run }, title) {
    const named = Object.fromEntries(study.columns.map((column, i) => [column, facts[i]]));
    const diverged = status === "diverged", unshaken = status === "failed_unshaken", path = `${study.folder}/${file}`;
    const numbers = study.numbers.map((name) => [name, named[name]]);
    byId("title").textContent = title;
    byId("class").textContent = named.class;
    if (run) numbers.push(...run.liquefied.map((told) => ["liquefaction", told]));
    if (unshaken) numbers.unshift(["without shaking", `soil fails and softens before the shaking${run ? `: ${run.reason}` : ""}`]);
    byId("result").className = diverged || unshaken ? "bad" : "";
    list("numbers", diverged ? [["diverged", `The guard stopped this run${run ? ` (${run.reason})` : ""}; it has no results. The drawing shows what was stored until then.`]] : numbers, "span");
    byId("link").href = `#run=${nameOf(file)}`;
    const own = [["file", path], ["repeat it", `sph run ${path} --out again.nc`]];
    list("facts", [["status", named.status], ...(study.client ? [] : own)], "code");
  }

  // ---------------------------------------------------------------- links and files

  const nameOf = (file) => file.replace(/^runs\/|\.nc$/g, ""); // of a run, as in its file

  // Open the run that the address names, if it names one of the page's.
  function follow() {
    const wanted = decodeURIComponent(location.hash).match(/^#run=(.+)$/);
    const found = wanted && Object.entries(study.points).find(([, point]) => nameOf(point.file) === wanted[1]);
    if (!found) return;
    if (study.axes[0] === "run") {
      if (find) { find.value = ""; narrow(); }
      form.elements.run.value = found[0];
    } else found[0].split("|").forEach((value, i) => { form.elements[study.axes[i]].value = value; });
    choose();
    byId("explorer").scrollIntoView();
  }

  function keep(name, href) {
    Object.assign(document.createElement("a"), { href, download: name.replace(/[/\\:]/g, "-") }).click();
  }

  const text = (words) => URL.createObjectURL(new Blob([words], { type: "text/csv" }));
  const csv = (rows) => rows.map((row) => row.map((cell) => (/[",\n]/.test(cell) ? `"${cell.replaceAll('"', '""')}"` : cell)).join(",")).join("\n") + "\n";

  const SAVES = {
    profile: () => keep(`${nameOf(chosen.point.file)}-profile.png`, byId("profile").toDataURL()),
    curve: () => keep(`${nameOf(chosen.point.file)}-displacement.png`, byId("curve").toDataURL()),
    history: () => {
      const { t, u, v, scene: own } = chosen.run, rows = [["time (s)", "horizontal (m)", "vertical (m)"]];
      t.forEach((time, i) => rows.push([time, own.direction * u[i], v[i]].map((value) => String(Number(value.toPrecision(7))))));
      keep(`${nameOf(chosen.point.file)}-displacement.csv`, text(csv(rows)));
    },
    picture: (button) => keep(button.dataset.name, button.closest("figure").querySelector("img").src),
    table: (button) => {
      const rows = [...button.previousElementSibling.querySelectorAll("tr")];
      keep(button.dataset.name, text(csv(rows.map((row) => [...row.cells].map((cell) => cell.textContent)))));
    },
    study: async (button) => keep(button.dataset.name, text(new TextDecoder().decode(await unpacked(study.table)))),
  };

  async function choose() {
    const point = study.points[study.axes.map((name) => form.elements[name].value).join("|")];
    if (!point) return undefined; // nothing found
    if (chosen && chosen.point === point) return draw();
    const before = chosen && chosen.run ? chosen.run.times[Number(slider.value)] : Infinity;
    const next = { point, run: null, title: point.title };
    chosen = next;
    describe(point, next.title);
    byId("drawings").hidden = !point.run;
    const run = point.run && (await loaded(point.run));
    if (chosen !== next || !run) return undefined; // another one was chosen meanwhile, or the page holds no drawings
    chosen.run = run;
    slider.max = run.times.length - 1;
    const wasAtEnd = before === Infinity || Number(slider.dataset.end) <= before;
    slider.dataset.end = run.times[run.times.length - 1];
    slider.value = wasAtEnd ? slider.max : run.times.filter((time) => time <= before).length - 1;
    return draw();
  }

  for (const [name, words] of Object.entries(study.shares)) form.elements.colour.add(new Option(words, name));

  // Only the runs of a list whose words hold all those wanted.
  const find = byId("find"), all = find ? [...form.elements.run.options] : [];
  function narrow() {
    const wanted = find.value.toLowerCase().split(/\s+/), select = form.elements.run;
    const selected = select.value;
    select.replaceChildren(...all.filter((option) => wanted.every((word) => option.text.toLowerCase().includes(word))));
    if (study.points[selected] && [...select.options].some((option) => option.value === selected)) select.value = selected;
    choose();
  }

  function stop() {
    clearInterval(timer);
    timer = 0;
    play.textContent = "▶";
    play.setAttribute("aria-label", "Play");
  }

  play.addEventListener("click", () => {
    if (timer) return stop();
    if (slider.value === slider.max) slider.value = 0;
    play.textContent = "⏸";
    play.setAttribute("aria-label", "Pause");
    timer = setInterval(() => {
      slider.value = Number(slider.value) + 1;
      draw();
      if (slider.value === slider.max) stop();
    }, 120);
    return undefined;
  });
  slider.addEventListener("input", () => { stop(); draw(); });
  form.addEventListener("submit", (event) => event.preventDefault());
  if (find) find.addEventListener("input", () => { stop(); narrow(); });
  form.addEventListener("change", () => {
    stop();
    choose();
    if (chosen) history.replaceState(null, "", `#run=${nameOf(chosen.point.file)}`);
  });
  for (const button of document.querySelectorAll("button.save")) {
    button.hidden = false;
    button.addEventListener("click", () => SAVES[button.dataset.save](button));
  }
  window.addEventListener("hashchange", follow);
  window.addEventListener("beforeprint", () => document.querySelectorAll("details:not(#scene details, .long)").forEach((rest) => { rest.open = true; }));
  byId("detail").textContent = `This page holds ${study.detail} of every run, positions to ${(1000 * study.quantum).toPrecision(2)} mm; the run's file holds the rest.`;
  new ResizeObserver(() => draw()).observe(byId("profile").parentElement);
  choose();
  follow();
})();
