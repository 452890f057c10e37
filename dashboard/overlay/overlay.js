(function () {
  // Elements over the canvas of this page. What they show comes from the hidden elements [data-part]; where robots are,
  // and the camera, from viser's client. They are placed right after a frame is drawn, from what was drawn: the newest
  // message may be a frame ahead. Nothing is placed while nothing has changed.
  if (window.__echelonOverlay) window.__echelonOverlay();
  const LEAST = 26, LEAST_OF_CROWD = 8, LARGEST = 16, CROWD = 128, LEAST_DIGIT = 11, MOST_DIGIT = 34, NOTICE_MS = 8000, SOFTWARE_MS = 10000, TELL_MS = 200;
  const SCALED = ["/bodies", "/outlines", "/believed", "/heads", "/slots", "/ghosts", "/told"];
  const root = document.createElement("div");
  root.id = "e-overlay";
  root.innerHTML = '<div class="e-frame"></div><div class="e-things"></div><div class="e-status" role="status"></div>';
  document.body.appendChild(root);
  const [frame, things, status] = root.children;
  const sources = {}, shown = {}, numbers = [], chips = new Map();
  let dirty = true, config = {length: 0.055, digit: 0.024};
  let notice = {number: 0, until: 0, html: ""}, told = 0, toldAt = 0;
  const born = performance.now();

  // ---- what the server shows, and what this page tells it
  function source(name) {
    return sources[name] && sources[name].isConnected ? sources[name] : null;
  }
  function changed(name) {  // the element, if it is another than at the last call
    const found = source(name);
    if (!found || found === shown[name]) return null;
    shown[name] = found;
    return found;
  }
  function value(element) {
    try { return JSON.parse(element.dataset.value); } catch (error) { return null; }
  }
  function tell(words) {
    const label = document.querySelector("LABEL"), box = label && label.closest(":has(input)");
    const input = box && box.querySelector("input");
    if (!input) return false;
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, words + "," + (++told));
    input.dispatchEvent(new Event("input", {bubbles: true}));
    toldAt = performance.now();
    return true;
  }
  const modules = [], ends = [];  // of the parts below: {take()} now and then, and what is done when the script is replaced
  const tables = "TABLES";  // of keys and signs, and the help: the script is sent with them in this place
  window.__echelonParts = {root, changed, value, tell, modules, ends, tables, redraw: () => { dirty = true; }};

  // ---- status line
  function statusLine(now) {
    const found = changed("notice");
    if (found && Number(found.dataset.number) > notice.number)
      notice = {number: Number(found.dataset.number), until: now + NOTICE_MS, html: found.innerHTML};
    const line = source("status");
    let html = now < notice.until ? notice.html : line ? line.innerHTML : "";
    if (line && now >= notice.until && now - born < SOFTWARE_MS && document.getElementById("webgl-software-rendering"))
      html = html.replace(/<span class="e-keys">.*?<.span>/, "") + ' <span class="e-keys">Drawn without a graphics card.</span>';
    if (status.innerHTML !== html && shown.line !== html) { shown.line = html; status.innerHTML = html; }
  }

  // ---- from the scene to the page
  function apply(m, x, y, z, w) {
    return [0, 1, 2, 3].map(r => m[r] * x + m[r + 4] * y + m[r + 8] * z + m[r + 12] * w);
  }
  function projection(viewer, area) {
    const camera = viewer.camera, known = {};
    return function (name, index) {
      const node = name in known ? known[name] : known[name] = drawn(viewer, name);
      const at = node && node.place(index);
      if (!at) return null;
      const seen = apply(camera.matrixWorldInverse.elements, at[0], at[1], at[2], 1);
      const clip = apply(camera.projectionMatrix.elements, seen[0], seen[1], seen[2], 1);
      if (!(clip[3] > 0)) return null;
      return {x: (clip[0] / clip[3] + 1) / 2 * area.width, y: (1 - clip[1] / clip[3]) / 2 * area.height,
        perMetre: area.height / 2 * camera.projectionMatrix.elements[5] / clip[3]};
    };
  }
  function drawn(viewer, name) {  // a node of many meshes, as it was drawn last
    const ref = viewer.nodeRefFromName[name], group = ref && (ref.current || ref);
    let mesh = null;
    if (group) group.traverse(one => { if (!mesh && one.isInstancedMesh2) mesh = one; });
    if (!mesh) return null;
    return {count: mesh._instancesCount, place: index => {
      if (index >= mesh._instancesCount) return null;
      const m = mesh.matricesTexture._data, at = 16 * index;
      return apply(mesh.matrixWorld.elements, m[at + 12], m[at + 13], m[at + 14], 1);
    }};
  }
  function rescale(viewer, tree, perMetre, count) {
    const wanted = count > CROWD ? LEAST_OF_CROWD : LEAST;
    const least = Math.min(LARGEST, Math.max(1, wanted / Math.max(1e-6, config.length * perMetre)));
    const scale = Math.exp(Math.round(Math.log(least) * 40) / 40);
    for (const name of SCALED) {
      const node = tree[name];
      if (!node) continue;
      const now = node.message.props.batched_scales;
      if (Math.abs((now ? now[0] : 1) - scale) < 1e-3 * scale) continue;
      viewer.messageQueue.push({type: "SceneNodeUpdateMessage", name, owner: node.message.owner || "",
        updates: {batched_scales: new Float32Array([scale])}});
      viewer.requestRender();
    }
    return scale;
  }

  // ---- numbers and chips
  function number(index) {
    if (!numbers[index]) {
      const made = numbers[index] = document.createElement("span");
      made.className = "e-over-number";
      made.textContent = index + 1;
      things.appendChild(made);
    }
    return numbers[index];
  }
  function takeChips() {
    const found = changed("chips");
    if (!found) return;
    const left = new Set(chips.keys());
    for (const chip of found.children) {
      const name = chip.dataset.key;
      left.delete(name);
      let made = chips.get(name);
      if (!made) {
        made = {element: document.createElement("div"), side: 0, html: ""};
        made.element.className = "e-over-chip";
        made.element.dataset.key = name;
        chips.set(name, made);
        things.appendChild(made.element);
      }
      made.node = chip.dataset.node;
      made.index = Number(chip.dataset.index);
      if (made.html !== chip.innerHTML) {
        made.html = made.element.innerHTML = chip.innerHTML;
        made.width = made.element.offsetWidth + 1;
        made.height = made.element.offsetHeight + 1;
      }
    }
    for (const name of left) { chips.get(name).element.remove(); chips.delete(name); }
    dirty = true;
  }
  const SIDES = [[1, 0], [1, -1], [1, 1], [-1, 0], [-1, -1], [-1, 1], [0, -1], [0, 1]];
  function overlap(a, b) {
    return Math.max(0, Math.min(a.x + a.w, b.x + b.w) - Math.max(a.x, b.x)) *
      Math.max(0, Math.min(a.y + a.h, b.y + b.h) - Math.max(a.y, b.y));
  }
  function box(chip, at, side, away) {
    const [sx, sy] = SIDES[side], w = chip.width, h = chip.height, far = sx && sy ? 0.75 * away : away;
    return {x: at.x + sx * far - (sx > 0 ? 0 : sx < 0 ? w : w / 2), y: at.y + sy * far - (sy > 0 ? 0 : sy < 0 ? h : h / 2),
      w, h};
  }
  function placeChips(project, area, taken) {
    const floor = area.height - 100, told = chips.has("told") && project("/told", 1);
    if (told) taken.push({x: told.x - 12, y: told.y - 12, w: 24, h: 24});
    for (const chip of chips.values()) {
      const at = project(chip.node, chip.index);
      chip.element.style.visibility = at ? "visible" : "hidden";
      if (!at) continue;
      const away = chip.node === "/told" ? 18 : Math.max(LEAST, config.length * at.perMetre) * 0.62 + 12;
      const cost = side => {
        const b = box(chip, at, side, away);
        const out = Math.max(0, 4 - b.x) + Math.max(0, b.x + b.w + 4 - area.width) + Math.max(0, 34 - b.y) +
          Math.max(0, b.y + b.h - floor);
        return taken.reduce((sum, other) => sum + overlap(b, other), 40 * out);
      };
      if (cost(chip.side) > 0) {
        let best = chip.side, least = cost(chip.side) * 0.8;
        for (let side = 0; side < SIDES.length; side++) if (cost(side) < least) { best = side; least = cost(side); }
        chip.side = best;
      }
      const b = box(chip, at, chip.side, away);  // at the rim, if its robot is out of sight
      b.x = Math.min(Math.max(b.x, 4), area.width - b.w - 4);
      b.y = Math.min(Math.max(b.y, 34), floor - b.h);
      taken.push(b);
      chip.element.style.transform = `translate(${b.x.toFixed(1)}px,${b.y.toFixed(1)}px)`;
    }
  }
  function placeNumbers(count, project, area) {
    const taken = [], first = count > CROWD ? project("/bodies", 0) : null;
    const near = first && config.length * first.perMetre > LEAST;  // else they would lie on one another
    for (let i = 0; i < Math.max(count, numbers.length); i++) {
      const at = i < count && (count <= CROWD || near) ? project("/bodies", i) : null;
      const inside = at && at.x > -20 && at.y > -20 && at.x < area.width + 20 && at.y < area.height + 20;
      if (!inside && !numbers[i]) continue;  // of a crowd a page makes what it shows
      const made = number(i);
      if (made.shown !== inside) made.style.visibility = (made.shown = inside) ? "visible" : "hidden";
      if (!inside) continue;
      const digit = Math.min(MOST_DIGIT, Math.max(LEAST_DIGIT, config.digit * at.perMetre)) * (i < 9 ? 1 : 0.8);
      const size = Math.max(LEAST, config.length * at.perMetre) * 0.55;
      made.style.transform = `translate(${at.x.toFixed(1)}px,${at.y.toFixed(1)}px) translate(-50%,-50%)`;
      if (made.size !== digit.toFixed(0)) made.style.fontSize = (made.size = digit.toFixed(0)) + "px";
      taken.push({x: at.x - size, y: at.y - size, w: 2 * size, h: 2 * size});
    }
    return taken;
  }

  // ---- every frame
  function place(canvas) {
    const at = canvas.getBoundingClientRect();
    const found = [at.left, at.top, at.width, at.height].map(n => Math.round(n) + "px").join(" ");
    if (found === shown.area) return;
    shown.area = found;
    [root.style.left, root.style.top, root.style.width, root.style.height] = found.split(" ");
    root.classList.toggle("e-narrow", window.innerWidth < 1400);
    dirty = true;
  }
  function keepTold(name, value, now) {  // not right after other words, as viser sends the last of some only
    if (value !== shown[name] && now - toldAt > TELL_MS && tell(name + "," + value)) shown[name] = value;
  }
  function look(now) {
    for (const name of ["config", "status", "notice", "chips", "line", "marks", "rewound", "drive"])
      if (!source(name)) sources[name] = document.querySelector(`[data-part="${name}"]`);
    const found = changed("config");
    if (found) { config = value(found) || config; dirty = true; }
    takeChips();
    statusLine(now);
    for (const module of modules) module.take();
    const open = [...document.querySelectorAll('[role="tab"][aria-selected="true"]')].map(tab => tab.textContent.trim());
    keepTold("width", window.innerWidth, now);
    keepTold("tabs", open.join(), now);
  }
  function draw() {  // after a frame
    const viewer = window.__viserMutable, tree = window.__viserSceneTree.getState(), bodies = drawn(viewer, "/bodies");
    place(viewer.canvas);  // a window may have changed since
    const area = {width: root.clientWidth, height: root.clientHeight};
    if (!bodies || area.height < 50) return;  // a window that is being laid out
    const project = projection(viewer, area), first = project("/bodies", 0);
    if (first) rescale(viewer, tree, first.perMetre, bodies.count);
    placeChips(project, area, placeNumbers(bodies.count, project, area));
    dirty = false;
  }
  function guarded(what) {
    try { what(); } catch (error) { console.warn("overlay: " + error); }
  }
  let hooked = null;
  const timer = setInterval(() => guarded(() => {
    const viewer = window.__viserMutable;
    if (!viewer || !viewer.camera || !viewer.canvas || !viewer.scene) return;
    if (hooked !== viewer.scene) {
      hooked = viewer.scene;
      hooked.onAfterRender = (renderer, scene, camera) => { if (camera === viewer.camera) guarded(draw); };
    }
    look(performance.now());
    place(viewer.canvas);
    if (dirty) guarded(draw);
  }), 90);
  window.__echelonOverlay = function () {
    clearInterval(timer);
    if (hooked) hooked.onAfterRender = () => {};
    ends.forEach(end => end());
    root.remove();
    window.__echelonOverlay = null;
  };
})();
