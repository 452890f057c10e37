(function () {
  // The time line along the foot of the scene. The server sends what is on it (episodes with their error, marks) and the
  // moment that is shown; a drag is told to the server as "go,episode,stamp", and shown here at once.
  const {root, changed, value, tell, modules, tables} = window.__echelonParts;
  const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20], GAP = 14, TOP = 24, BASE = 58, SETTLE_MS = 600, TELL_MS = 70;
  const FORMS = tables.signs, KEYS = tables.handle;
  const shortcut = name => tables.shortcuts["Time line: " + name];
  const strip = document.createElement("div");
  strip.className = "e-strip";
  strip.innerHTML = '<div class="e-strip-left"><button data-do="play" class="e-round"></button>' +
    `<button data-do="mark,back" aria-label="Event before" title="Event before (${shortcut("event before")})">⇤</button>` +
    `<button data-do="mark,next" aria-label="Next event" title="Next event (${shortcut("next event")})">⇥</button></div>` +
    '<div class="e-track"><svg aria-hidden="true"></svg><div class="e-handle" role="slider" tabindex="0" aria-label="Time"' +
    '><span></span></div></div>' +
    '<div class="e-strip-right"><button data-do="live" class="e-live"></button><button data-do="loop" aria-label="Loop" ' +
    'title="Begin again at the end">↻</button><span class="e-clock"></span></div>';
  root.appendChild(strip);
  const frame = root.querySelector(".e-frame");
  const track = strip.querySelector(".e-track"), svg = strip.querySelector("svg"), handle = strip.querySelector(".e-handle");
  const pill = strip.querySelector(".e-live"), clock = strip.querySelector(".e-clock"), play = strip.querySelector(".e-round");
  const loop = strip.querySelector('[data-do="loop"]');
  let line = null, marks = [], mine = null, dragged = false, until = 0, told = 0, width = 0, drawn = "", before = "";

  // ---- places and pixels
  function scale() {
    const gaps = GAP * (line.episodes.length - 1), seconds = line.episodes.reduce((sum, e) => sum + e[2] - e[1], 0);
    return (width - gaps) / Math.max(seconds, 1e-3);
  }
  function x(episode, stamp) {
    let at = 0;
    for (const [number, begins, ends] of line.episodes) {
      if (number === episode) return at + (Math.min(Math.max(stamp, begins), ends) - begins) * scale();
      at += (ends - begins) * scale() + GAP;
    }
    return null;
  }
  function placeAt(pixel) {
    let at = 0, found = null;
    for (const [number, begins, ends] of line.episodes) {
      if (pixel >= at - GAP / 2 || !found)
        found = [number, Math.min(Math.max(begins + (pixel - at) / scale(), begins), ends)];
      at += (ends - begins) * scale() + GAP;
    }
    return found;
  }
  function newest() { const e = line.episodes[line.episodes.length - 1]; return [e[0], e[2]]; }
  function here() { return mine || line.at || newest(); }
  function past() { return Boolean(mine || line.at); }

  // ---- drawing
  function escaped(text) { return text.replace(/[&<>"]/g, c => "&#" + c.charCodeAt(0) + ";"); }
  function step(seconds) {
    const least = seconds * 64 / Math.max(width, 64);
    for (const nice of [0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600]) if (nice >= least) return nice;
    return 1200;
  }
  function picture() {
    const parts = [], per = scale(), seconds = line.episodes.reduce((sum, e) => sum + e[2] - e[1], 0), every = step(seconds);
    const top = Math.max(2 * line.limit, ...line.episodes.map(e => Math.max(0, ...e[3].map(p => p[1]))));
    const y = error => BASE - (BASE - TOP - 6) * Math.min(1, error / top);
    for (const [number, kind, begins, ends] of marks) {
      const from = x(number, begins);
      if (from === null || (kind === "push" && ends === null)) continue;
      const to = x(number, ends === null ? Infinity : ends);
      parts.push(`<rect x="${from.toFixed(1)}" y="${TOP}" width="${Math.max(1, to - from).toFixed(1)}" height="${BASE - TOP}" ` +
        `style="fill:var(--${FORMS[kind][1]})" opacity=".22"/>`);
    }
    for (const [number, begins, ends, trace] of line.episodes) {
      const from = x(number, begins), to = from + (ends - begins) * per;
      const points = trace.map(([t, e]) => `${x(number, t).toFixed(1)},${y(e).toFixed(1)}`);
      if (points.length > 1)
        parts.push(`<polygon class="e-trace" points="${from.toFixed(1)},${BASE} ${points.join(" ")} ${to.toFixed(1)},${BASE}"/>`);
      parts.push(`<path class="e-limit" d="M${from.toFixed(1)} ${y(line.limit).toFixed(1)}H${to.toFixed(1)}"/>`,
        `<path class="e-axis" d="M${from.toFixed(1)} ${BASE}H${to.toFixed(1)}"/>`);
      for (let t = Math.ceil(begins / every - 1e-6) * every; t <= ends; t += every)
        parts.push(`<text class="e-tick" x="${x(number, t).toFixed(1)}" y="${BASE + 15}">${+t.toFixed(1)}</text>`);
      if (number !== line.episodes[line.episodes.length - 1][0])
        parts.push(`<path class="e-reset" d="M${(to + GAP / 2).toFixed(1)} ${TOP - 6}V${BASE + 4}"/>`);
    }
    let free = -1;
    for (const [number, kind, begins, ends, label] of marks) {
      const at = x(number, begins), [form, colour] = FORMS[kind];
      if (at === null || (line.episodes.find(e => e[0] === number) || [0, 0])[1] > begins + 0.2) continue;
      const room = at >= free && at + 6.3 * label.length + 12 < width + 60;
      if (room) free = at + 6.3 * label.length + 20;
      parts.push(`<path d="M${at.toFixed(1)} ${TOP - 6}V${BASE}" style="stroke:var(--${colour})" opacity=".7"/>` +
        `<text class="e-mark" x="${(at - 4).toFixed(1)}" y="13" style="fill:var(--${colour})">${form}` +
        (room ? ` <tspan>${escaped(label)}</tspan>` : "") + `<title>${escaped(label)}</title></text>`);
      if (ends !== null) parts.push(`<circle cx="${x(number, ends).toFixed(1)}" cy="${BASE}" r="3" style="fill:var(--${FORMS.over[1]})"/>`);
    }
    return parts.join("");
  }
  function showHandle() {
    const at = here(), now = newest(), left = x(at[0], at[1]), rewound = past() && line.live;
    if (left === null) return;
    handle.style.transform = `translateX(${left.toFixed(1)}px)`;
    const away = at[0] === now[0] ? now[1] - at[1] : null;
    handle.firstChild.textContent = !past() ? "" : !line.live ? at[1].toFixed(1) + " s" : away === null ?
      at[1].toFixed(1) + " s" : "−" + away.toFixed(1) + " s";
    handle.setAttribute("aria-valuemin", line.episodes[0][1]);
    handle.setAttribute("aria-valuemax", now[1]);
    handle.setAttribute("aria-valuenow", at[1].toFixed(1));
    handle.setAttribute("aria-valuetext", at[1].toFixed(1) + " s" + (rewound ? ", in the past" : ""));
    svg.style.setProperty("--here", left.toFixed(1) + "px");
    svg.querySelectorAll(".e-done").forEach(e => e.remove());
    svg.insertAdjacentHTML("beforeend", `<path class="e-done" d="M0 ${BASE}H${left.toFixed(1)}"/>`);
    strip.classList.toggle("e-past", rewound);
    pill.textContent = line.live ? (past() ? "LIVE ›" : "● LIVE") : line.speed + " ×";
    pill.title = line.live ? `Show the run as it is (${shortcut("the run as it is")})` : "Speed";
    loop.style.display = line.live ? "none" : "";
    loop.setAttribute("aria-pressed", line.loop);
    clock.textContent = line.live ? now[1].toFixed(1) + (past() ? " s now" : " s") : "of " + now[1].toFixed(1) + " s";
    const held = past() && !line.playing;
    play.textContent = held ? "▶" : "❙❙";
    play.setAttribute("aria-label", held ? "Play from here" : past() ? "Stop here" : "Hold this moment; the run goes on");
    play.title = play.getAttribute("aria-label");
  }
  function take() {
    const lines = changed("line"), given = changed("marks"), rewound = changed("rewound");
    if (lines) line = value(lines) || line;
    if (given) marks = value(given) || marks;
    if (rewound) banner(value(rewound));
    if (!line || !line.episodes.length) { strip.style.visibility = "hidden"; return; }
    strip.style.visibility = "visible";
    if (mine && !dragged && performance.now() > until) mine = null;
    const found = track.clientWidth;
    if (!lines && !given && found === width && !mine) return;
    width = found;
    const html = picture();
    if (html !== drawn) { drawn = html; svg.innerHTML = html; }
    showHandle();
  }
  function banner(shown) {
    frame.classList.toggle("e-rewound", Boolean(shown));
    const html = shown ? `<div class="e-banner"><b>Looking at t = ${escaped(shown.at)} s</b> · ${escaped(shown.rest)}</div>` : "";
    if (html !== before) { before = html; frame.innerHTML = html; }
  }

  // ---- what users do
  function go(place, last) {
    mine = place;
    until = performance.now() + SETTLE_MS;
    if (last || performance.now() - told > TELL_MS) {
      told = performance.now();
      tell(`go,${place[0]},${place[1].toFixed(2)}`);
    }
    showHandle();
  }
  function pixel(event) { return event.clientX - track.getBoundingClientRect().left; }
  track.addEventListener("pointerdown", event => {
    if (!line) return;
    dragged = true;
    track.setPointerCapture(event.pointerId);
    go(placeAt(pixel(event)));
    handle.focus();
    event.preventDefault();
  });
  track.addEventListener("pointermove", event => { if (dragged) go(placeAt(pixel(event))); });
  const released = event => {
    if (!dragged) return;
    dragged = false;
    setTimeout(() => mine && go(mine, true), TELL_MS);
  };
  track.addEventListener("pointerup", released);
  track.addEventListener("pointercancel", released);
  function doIt(what) {
    mine = null;
    if (what === "live" && !line.live)
      what = "speed," + SPEEDS[(SPEEDS.indexOf(line.speed) + 1) % SPEEDS.length];
    tell(what);
  }
  strip.addEventListener("click", event => {
    const button = event.target.closest("[data-do]");
    if (button) doIt(button.dataset.do);
  });
  handle.addEventListener("keydown", event => {
    const words = KEYS[event.key], [what, seconds] = (words || "").split(",");
    if (!words || !line) return;
    if (what === "step" && event.shiftKey) doIt(`step,${Math.sign(seconds) * 0.1}`);
    else doIt(what === "begin" ? `go,${line.episodes[0][0]},0` : words);
    event.preventDefault();
    event.stopPropagation();
  });
  modules.push({take});
})();
