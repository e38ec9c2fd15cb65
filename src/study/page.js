"use strict";
// The pictures stand once in the gallery; the viewer shows any two of them under a curtain.
(function () {
  const slider = document.getElementById("slider");
  if (!slider) return;
  const over = document.getElementById("over");
  const edge = document.getElementById("edge");
  function draw() {
    over.style.clipPath = "inset(0 " + (100 - slider.value) + "% 0 0)";
    edge.style.left = slider.value + "%";
  }
  function choose(select, image) {
    const show = () => { image.src = document.getElementById(select.value).src; };
    select.addEventListener("change", show);
    show();
  }
  slider.addEventListener("input", draw);
  choose(document.getElementById("left"), over);
  choose(document.getElementById("right"), document.getElementById("under"));
  draw();
})();
