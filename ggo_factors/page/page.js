"use strict";
(() => {
  const numbers = JSON.parse(document.getElementById("numbers").textContent);
  const { motion, steps, legs, source } = numbers;
  const { time_s: times, joints_m: joints } = motion;
  const last = times.length - 1;
  const find = (id) => document.getElementById(id);
  const stage = find("stage"), slider = find("slider"), play = find("play"), pace = find("pace");
  const reach = source.model.thigh_m + source.model.shank_m;
  document.documentElement.classList.add("scripted");

  // The view goes with the hip, and climbs with the ground, but does not bob.
  const hip = (at) => [joints[at][4], joints[at][5]];
  const [firstX, firstY] = hip(0), [lastX, lastY] = hip(last);
  const climbs = Math.abs(lastX - firstX) > 0.1 ? (lastY - firstY) / (lastX - firstX) : 0;

  function view(at) {
    const height = 1.55 * reach;
    const width = stage.clientHeight ? height * stage.clientWidth / stage.clientHeight : height;
    const x = hip(at)[0], top = firstY + climbs * (x - firstX) + 0.25 * reach;
    stage.setAttribute("viewBox", [x - width / 2, -top, width, height].map((m) => (1000 * m).toFixed(1)).join(" "));
  }

  function leg(name, at) {
    const points = (name === "left" ? [2, 1, 0] : [2, 3, 4])
      .map((k) => [1000 * joints[at][2 * k], -1000 * joints[at][2 * k + 1]]);
    const text = (list) => list.map((point) => point.map((value) => value.toFixed(1)).join(",")).join(" ");
    stage.querySelector(".leg." + name).setAttribute("points", text(points));
    stage.querySelectorAll(".joint." + name).forEach((mark, k) => {
      const [x, y] = points[k + 1];
      const [across, up, shift] = name === "left" ? ["cx", "cy", 0] : ["x", "y", 15];
      mark.setAttribute(across, (x - shift).toFixed(1));
      mark.setAttribute(up, (y - shift).toFixed(1));
    });
    const foot = stage.querySelector(".foot." + name);
    if (foot) {
      const [x, y] = points[2], { ankle_m: ankle, heel_m: heel, toe_m: toe } = source.model;
      const tilt = motion.tilt_rad[at][name === "left" ? 0 : 1];
      const along = 1000 * Math.cos(tilt), down = 1000 * Math.sin(tilt);
      const under = [x + ankle * down, y + ankle * along];
      const ends = [-heel, toe].map((length) => [under[0] + length * along, under[1] - length * down]);
      foot.setAttribute("points", text([...ends, [x, y]]));
    }
  }

  const millimetres = (value) => value.toFixed(1).replace("-", "\u2212") + " mm";

  function show(at) {
    const number = motion.step[at], clear = motion.clearance_mm[at], least = steps[number - 1].clearance_mm;
    leg("left", at);
    leg("right", at);
    view(at);
    const time = times[at].toFixed(2) + " s";
    const none = "none in this step";
    const over = clear !== null ? millimetres(clear) : least === null ? none : "not over one";
    find("time").textContent = time;
    find("step").textContent = number + " of " + steps.length;
    find("swings").textContent = numbers.kind === "gait" ? "not said" : legs[steps[number - 1].swings];
    find("clearance").textContent = over;
    find("least").textContent = least === null ? none : millimetres(least);
    slider.setAttribute("aria-valuetext", time + ", step " + number + ", foot over obstacle or stair edge: " + over);
    for (const line of document.querySelectorAll(".now")) {
      const { first, last: end } = line.dataset;
      const x = Number(first) + (Number(end) - Number(first)) * (times[at] - times[0]) / (times[last] - times[0]);
      line.setAttribute("x1", x.toFixed(1));
      line.setAttribute("x2", x.toFixed(1));
    }
  }

  let playing = false, begun = 0, from = 0;

  function goOn(now) {
    if (!playing) return;
    const time = from + (now - begun) / 1000 * Number(pace.value);
    let at = Number(slider.value);
    while (at < last && times[at + 1] <= time) at += 1;
    slider.value = at;
    show(at);
    if (at === last) turn(false);
    else requestAnimationFrame(goOn);
  }

  function turn(on) {
    playing = on;
    play.textContent = on ? "Pause" : "Play";
    if (!on) return;
    if (Number(slider.value) === last) slider.value = 0;
    anchor();
    requestAnimationFrame(goOn);
  }

  // Time goes on from where the slider is.
  function anchor() {
    begun = performance.now();
    from = times[Number(slider.value)];
  }

  slider.addEventListener("input", () => { anchor(); show(Number(slider.value)); });
  slider.addEventListener("keydown", (event) => {
    if (event.key !== " " && event.key !== "Enter") return;
    event.preventDefault();
    turn(!playing);
  });
  pace.addEventListener("change", anchor);
  play.addEventListener("click", () => turn(!playing));
  addEventListener("resize", () => view(Number(slider.value)));
  show(Number(slider.value));
})();
