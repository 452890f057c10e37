(function () {
  // The help: a dialog over the whole page. Its key and a small button open it; the key, Escape and a click beside it close it.
  const {root, tables} = window.__echelonParts;
  const dialog = document.createElement("dialog"), button = document.createElement("button");
  dialog.className = "e-help";
  dialog.innerHTML = tables.help;
  dialog.setAttribute("aria-label", "Keys, colours and marks");
  button.className = "e-help-button";
  button.type = "button";
  button.textContent = tables.helpKey;
  button.title = `Keys, colours and marks (${tables.helpKey})`;
  button.setAttribute("aria-label", "Help");
  root.append(button, dialog);
  function toggle() { if (dialog.open) dialog.close(); else dialog.showModal(); }
  function typing(element) {
    return element && (element.isContentEditable || element.tagName === "TEXTAREA" ||
      (element.tagName === "INPUT" && !/^(checkbox|radio|button|range)$/.test(element.type)));
  }
  function key(event) {
    if (!root.isConnected) { window.removeEventListener("keydown", key, true); return; }
    if (event.key !== tables.helpKey || event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    event.preventDefault();
    event.stopPropagation();
    toggle();
  }
  button.addEventListener("click", toggle);
  dialog.addEventListener("click", event => {
    if (event.target === dialog || event.target.closest("[data-close]")) dialog.close();
  });
  window.addEventListener("keydown", key, true);
})();
