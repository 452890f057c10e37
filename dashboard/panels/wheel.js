(function () {
  if (window.__echelonWheel) window.__echelonWheel();
  var ways = "WAYS";  // signs of v and omega by key; the script is sent with them in this place
  var held = {}, moving = false;
  function field() {
    var label = document.querySelector("LABEL"), box = label && label.closest(":has(input)");
    return box && box.querySelector("input");
  }
  function say() {
    var input = field(), v = 0, omega = 0;
    if (!input) { off(); return; }
    for (var code in held) { v += ways[code][0]; omega += ways[code][1]; }
    if (!v && !omega && !moving) return;
    moving = Boolean(v || omega);
    var text = [Math.sign(v), Math.sign(omega), Date.now()].join(",");
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, text);
    input.dispatchEvent(new Event("input", {bubbles: true}));
  }
  function typing(element) {
    return element && (element.isContentEditable || element.tagName === "TEXTAREA" ||
      (element.tagName === "INPUT" && !/^(checkbox|radio|button|range)$/.test(element.type)));
  }
  function key(event) {
    if (!ways[event.code] || event.ctrlKey || event.metaKey || event.altKey || typing(event.target)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
    var before = Boolean(held[event.code]);
    if (event.type === "keydown") held[event.code] = true; else delete held[event.code];
    if (before !== Boolean(held[event.code])) setTimeout(say, 0);
  }
  function blur() { held = {}; say(); }
  function off() {
    clearInterval(timer);
    window.removeEventListener("keydown", key, true);
    window.removeEventListener("keyup", key, true);
    window.removeEventListener("blur", blur);
    window.__echelonWheel = null;
  }
  window.addEventListener("keydown", key, true);
  window.addEventListener("keyup", key, true);
  window.addEventListener("blur", blur);
  var timer = setInterval(say, 100);
  window.__echelonWheel = off;
})();
