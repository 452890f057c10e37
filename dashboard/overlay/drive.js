(function () {
  // Over the scene of a formation that is driven: what is ordered, by two gauges, and on the page that has the wheel its
  // keys and a stick for a finger or the mouse.
  const {root, changed, value, modules, tables} = window.__echelonParts;
  const SWEEP = 270, RADIUS = 34, STICK = 40;
  const gauges = document.createElement("div"), hand = document.createElement("div");
  gauges.className = "e-gauges";
  hand.className = "e-hand";
  hand.innerHTML = '<div class="e-hand-keys"><div>' +
    tables.driving.map(([sign, codes]) => `<kbd data-codes="${codes}">${sign}</kbd>`).join("") +
    `</div><small></small></div><div class="e-stick" role="img" aria-label="Stick: drag to drive"><i></i></div>`;
  root.append(gauges, hand);
  const pad = hand.querySelector(".e-stick"), knob = pad.firstChild, words = hand.querySelector("small");
  let shown = null, drawn = "", finger = null;

  function arc(from, to) {  // along the gauge: shares from 0 to 1
    const at = share => {
      const angle = (135 + SWEEP * share) * Math.PI / 180;
      return `${(45 + RADIUS * Math.cos(angle)).toFixed(1)} ${(45 + RADIUS * Math.sin(angle)).toFixed(1)}`;
    };
    const [low, high] = from < to ? [from, to] : [to, from];
    return `M${at(low)}A${RADIUS} ${RADIUS} 0 ${(high - low) * SWEEP > 180 ? 1 : 0} 1 ${at(high)}`;
  }
  function gauge(name, number, unit, begins, share) {
    return `<figure><svg viewBox="0 0 90 78"><path d="${arc(0, 1)}"/>` +
      (Math.abs(share - begins) > 0.004 ? `<path class="e-ordered" d="${arc(begins, share)}"/>` : "") +
      `<text class="e-big" x="45" y="48">${number}</text><text x="45" y="61">${unit}</text></svg><figcaption>${name}</figcaption></figure>`;
  }
  function picture() {
    const share = (now, most) => 0.5 + 0.5 * Math.max(-1, Math.min(1, now / most));
    const side = shown.omega > 0.005 ? " · left" : shown.omega < -0.005 ? " · right" : "";
    return gauge("speed", shown.v.toFixed(2), "m/s", 0.5, share(shown.v, shown.speed)) +
      gauge("turn", Math.abs(shown.omega).toFixed(2), "rad/s" + side, 0.5, share(-shown.omega, shown.turn));
  }
  function take() {
    const found = changed("drive");
    if (found) shown = value(found);
    const wheel = window.__echelonWheel;
    gauges.style.display = shown ? "" : "none";
    hand.style.display = shown && wheel ? "" : "none";
    root.classList.toggle("e-driven", Boolean(shown));
    if (!shown) return;
    const html = picture();
    if (html !== drawn) { drawn = html; gauges.innerHTML = html; }
    if (!wheel) return;
    const held = wheel.held(), [v, omega] = wheel.asked();
    for (const one of hand.querySelectorAll("kbd"))
      one.classList.toggle("e-held", one.dataset.codes.split(",").some(code => held[code]));
    const reach = STICK / Math.max(1, Math.hypot(v, omega));  // two keys at once push it to the rim, not beyond
    if (finger === null) knob.style.transform = `translate(${-omega * reach}px,${-v * reach}px)`;
    const pads = wheel.pads();
    const text = pads.length ? "gamepad: " + pads[0].id.slice(0, 24) : "or W A S D, a gamepad, the stick";
    if (words.textContent !== text) words.textContent = text;
  }

  // ---- the stick
  function push(event) {
    const box = pad.getBoundingClientRect(), wheel = window.__echelonWheel;
    let x = event.clientX - box.left - box.width / 2, y = event.clientY - box.top - box.height / 2;
    const far = Math.hypot(x, y), scale = far > STICK ? STICK / far : 1;
    x *= scale;
    y *= scale;
    knob.style.transform = `translate(${x}px,${y}px)`;
    if (wheel) wheel.push(-y / STICK, -x / STICK);
  }
  function release() {
    if (finger === null) return;
    finger = null;
    if (window.__echelonWheel) window.__echelonWheel.push(0, 0);
  }
  pad.addEventListener("pointerdown", event => {
    finger = event.pointerId;
    pad.setPointerCapture(finger);
    push(event);
    event.preventDefault();
  });
  pad.addEventListener("pointermove", event => { if (finger !== null) push(event); });
  pad.addEventListener("pointerup", release);
  pad.addEventListener("pointercancel", release);
  modules.push({take});
})();
