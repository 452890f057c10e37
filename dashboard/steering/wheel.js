(function () {
  // What drives on the page that has the wheel: keys that are held, the stick over the scene, and a gamepad.
  if (window.__echelonWheel) window.__echelonWheel.off();
  var ways = "WAYS";  // signs of v and omega by key; the script is sent with them in this place
  var DEAD = 0.15, UP = 12, DOWN = 13, LEFT = 14, RIGHT = 15;  // of a pad: its stick's dead share, and its cross's buttons
  var held = {}, moving = false, last = "", stick = [0, 0], count = 0;
  function field() {
    var label = document.querySelector("LABEL"), box = label && label.closest(":has(input)");
    return box && box.querySelector("input");
  }
  function beyond(share) {
    return Math.abs(share) < DEAD ? 0 : Math.sign(share) * (Math.abs(share) - DEAD) / (1 - DEAD);
  }
  function pads() {  // a browser has them after a button was pressed, on loopback or over https
    return Array.from(navigator.getGamepads ? navigator.getGamepads() : []).filter(function (one) { return one && one.connected; });
  }
  function pad() {
    for (var one of pads()) {
      var down = function (n) { return one.buttons[n] && one.buttons[n].pressed ? 1 : 0; };
      var v = down(UP) - down(DOWN) - beyond(one.axes[1] || 0), omega = down(LEFT) - down(RIGHT) - beyond(one.axes[0] || 0);
      if (v || omega) return [v, omega];
    }
    return [0, 0];
  }
  function asked() {
    var found = pad(), v = stick[0] + found[0], omega = stick[1] + found[1];
    for (var code in held) { v += ways[code][0]; omega += ways[code][1]; }
    return [v, omega].map(function (share) { return Math.max(-1, Math.min(1, share)); });
  }
  function say() {
    var input = field(), now = asked();
    if (!input) { off(); return; }
    if (!now[0] && !now[1] && !moving) return;
    moving = Boolean(now[0] || now[1]);
    last = now.join();
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set.call(input, now.concat(Date.now()).join(","));
    input.dispatchEvent(new Event("input", {bubbles: true}));
  }
  function look() {  // twenty times a second; what has not changed is said ten times
    count += 1;
    if (count % 2 === 0 || asked().join() !== last) say();
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
  function blur() { held = {}; stick = [0, 0]; say(); }
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
  var timer = setInterval(look, 50);
  window.__echelonWheel = {off: off, asked: asked, held: function () { return held; }, pads: pads,
    push: function (v, omega) { stick = [v, omega]; say(); }};
})();
