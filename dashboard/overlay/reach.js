(function () {
  // What reaches everybody: cells of tables and titles of folders by the keyboard, a name for every control, and no right
  // panel in a narrow window. viser's client does not name its sliders and icons, and opens folders by the mouse alone.
  const {modules, ends, tables} = window.__echelonParts;
  const FOLDED_BELOW = 1024, NAME_MS = 1000, STEPS = tables.cells;
  const ICONS = {"list-search": "All commands", "adjustments": "Settings of the viewer", "arrow-back": "Back to the controls"};
  const TITLES = ".mantine-Paper-root:has(> svg.tabler-icon-chevron-up), .mantine-Paper-root:has(> svg.tabler-icon-chevron-down)";
  const SHEET = 'div[style*="max-height: 60%"] div[style*="height: 3.5em"][style*="cursor: pointer"]';
  let kept = null;  // the cell that has the focus: its table may be replaced at any time

  // ---- cells
  function cells(one) { return [...one.closest("[onpointerdown]").querySelectorAll("[data-click]")]; }
  function key(event) {
    const title = event.target.dataset && event.target.dataset.title !== undefined;
    if (title && STEPS[event.key] === 0) {
      event.target.click();
      event.preventDefault();
      event.stopImmediatePropagation();
      return;
    }
    const cell = event.target.closest && event.target.closest("[data-click]");
    if (!cell || !(event.key in STEPS) || event.ctrlKey || event.metaKey || event.altKey) return;
    const all = cells(cell), step = STEPS[event.key], next = all[all.indexOf(cell) + step];
    if (step && next) next.focus();
    if (!step && !event.repeat) {
      const name = cell.dataset.cell;
      cell.dispatchEvent(new PointerEvent("pointerdown", {bubbles: true}));
      kept = name;  // a press with the mouse would leave it
    }
    event.preventDefault();
    event.stopImmediatePropagation();
  }
  function refocus() {
    if (!kept || (document.activeElement && document.activeElement !== document.body)) return;
    const again = document.querySelector(`[data-cell="${kept}"]`);
    if (again) again.focus({preventScroll: true});
  }
  function leave() { kept = null; }
  function enter(event) {
    const cell = event.target.closest("[data-cell]");
    kept = cell ? cell.dataset.cell : null;
  }
  window.addEventListener("keydown", key, true);
  window.addEventListener("pointerdown", leave, true);
  document.addEventListener("focusin", enter);
  const watcher = new MutationObserver(refocus);
  watcher.observe(document.body, {childList: true, subtree: true});

  // ---- names
  function named(label) {
    const row = label.closest(":has(input, button, [role=slider])");
    if (!row || row.querySelectorAll("label[for]").length > 1) return;
    for (const one of row.querySelectorAll("input, [role=slider]"))
      if (!one.getAttribute("aria-label")) one.setAttribute("aria-label", label.textContent.trim());
  }
  function title(one) {
    one.dataset.title = "";
    one.tabIndex = 0;
    one.setAttribute("role", "button");
    if (one.matches(TITLES)) one.setAttribute("aria-expanded", Boolean(one.querySelector(".tabler-icon-chevron-up")));
  }
  function names() {
    document.querySelectorAll("label[for]").forEach(named);
    for (const [icon, name] of Object.entries(ICONS))
      document.querySelectorAll(`button:has(> * > .tabler-icon-${icon}), button:has(> .tabler-icon-${icon})`)
        .forEach(one => one.setAttribute("aria-label", name));
    document.querySelectorAll(TITLES + ", " + SHEET).forEach(title);
  }

  // ---- a narrow window
  let folded = false, named_at = 0;
  function fold() {
    if (folded || window.innerWidth >= FOLDED_BELOW) return;
    const area = document.querySelector('[data-dock-region-collapse="right"]');
    if (!area) return;
    folded = true;
    area.click();
  }
  modules.push({take() {
    if (performance.now() - named_at < NAME_MS) return;
    named_at = performance.now();
    names();
    fold();
  }});
  ends.push(() => {
    watcher.disconnect();
    window.removeEventListener("keydown", key, true);
    window.removeEventListener("pointerdown", leave, true);
    document.removeEventListener("focusin", enter);
  });
})();
