// The view of a report in three dimensions, copy buttons, and light or dark. No dependency; nothing is ever fetched.
"use strict";
(() => {
  const all = (selector) => [...document.querySelectorAll(selector)];
  const root = document.documentElement;
  for (const element of all("[hidden]")) element.hidden = false;
  root.classList.add("live");

  // ---- light or dark

  const isDark = () =>
    root.dataset.scheme ? root.dataset.scheme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  document.getElementById("scheme").addEventListener("click", () => {
    root.dataset.scheme = isDark() ? "light" : "dark";
    draw();
  });

  // ---- copy

  for (const button of all("button.copy")) {
    const text = button.parentElement.querySelector("pre");
    button.addEventListener("click", async () => {
      let copied = true;
      try {
        await navigator.clipboard.writeText(text.textContent);
      } catch {
        getSelection().selectAllChildren(text);
        copied = document.execCommand("copy");
      }
      button.textContent = copied ? "copied" : "press Ctrl+C";
      setTimeout(() => (button.textContent = "copy"), 2000);
    });
  }

  // ---- the view

  const data = document.getElementById("scene");
  let draw = () => {};
  if (!data) return;
  const scene = JSON.parse(data.textContent);
  const canvas = document.getElementById("view");
  const told = document.getElementById("told");
  const paint = canvas.getContext("2d");
  const layers = Object.fromEntries(all("[data-layer]").map((box) => [box.dataset.layer, box]));
  const shown = (name) => !layers[name] || layers[name].checked;

  // Vectors are arrays of three numbers, the scene's radius being one.
  const unit = (v) => v.map((x) => x / scene.parts);
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const add = (a, b, times = 1) => [a[0] + times * b[0], a[1] + times * b[1], a[2] + times * b[2]];
  const normalLength = scene.normal / scene.parts;
  const tipRadius = scene.tip_radius / scene.parts;
  const origin = unit(scene.origin);
  const axes = scene.axes.map(unit);
  const patches = scene.patches.map((patch) => ({
    ...patch,
    vertices: patch.vertices.map(unit),
    normals: patch.normals.map(unit),
  }));
  const touches = scene.touches.map((touch) => ({
    ...touch,
    foot: unit(touch.foot),
    tip: unit(touch.tip),
    normal: unit(touch.normal),
    residual: touch.residual / scene.parts,
  }));
  const ellipsoids = scene.ellipsoids.map((one) => ({ at: unit(one.at), half: one.half_axes.map(unit) }));
  const ghosts = scene.ghosts.map((ghost) => {
    const [at, turn] = [unit(ghost.origin), ghost.turn.map(unit)];
    const placed = (point) => {
      const from = add(point, origin, -1);
      return add(at, turn.map((row) => dot(row, from)));
    };
    const rims = patches.flatMap((patch) =>
      patch.edges.filter((edge) => edge[4]).map((edge) => [patch.vertices[edge[0]], patch.vertices[edge[1]]].map(placed)));
    return { lines: [...rims, ...axes.map((axis) => [placed(origin), placed(add(origin, axis))])] };
  });

  const first = { azimuth: scene.view[0], elevation: scene.view[1], zoom: 1 };
  let view = { ...first };
  let chosen = -1;
  let [right, up, toward] = [[], [], []];
  let [width, height, scale] = [0, 0, 1];
  let middle = [0, 0];
  let marks = [];

  const turned = () => {
    const [s, c] = [Math.sin(view.azimuth), Math.cos(view.azimuth)];
    const [h, l] = [Math.sin(view.elevation), Math.cos(view.elevation)];
    right = [-s, c, 0];
    up = [-h * c, -h * s, l];
    toward = [l * c, l * s, h];
  };
  const at = (point) => [
    width / 2 + (dot(right, point) - middle[0]) * scale,
    height / 2 - (dot(up, point) - middle[1]) * scale,
  ];

  // What is drawn fills the first view.
  const points = [...patches.flatMap((patch) => patch.vertices), ...axes.map((axis) => add(origin, axis)),
    ...touches.map((touch) => add(touch.foot, touch.normal, normalLength))];
  const fit = () => {
    const free = 30;
    const bounds = [right, up].map((axis) => {
      const along = points.map((point) => dot(axis, point));
      return [Math.min(...along), Math.max(...along)];
    });
    middle = bounds.map(([low, high]) => (low + high) / 2);
    return Math.min(...bounds.map(([low, high], k) => ([width, height][k] - 2 * free) / (high - low)));
  };

  const colours = () => {
    // Resolved colours stand on elements only: light-dark() is nothing that a canvas knows.
    const probe = document.createElement("i");
    canvas.after(probe);
    const colour = (name) => {
      probe.className = `colour-${name}`;
      return getComputedStyle(probe).color;
    };
    const names = ["ink", "faint", "lit", "unlit", "back", "edge", "residual", "ellipsoid", "bad", "paper", "x", "y", "z", "chosen"];
    const found = Object.fromEntries(names.map((name) => [name, colour(name)]));
    probe.remove();
    return found;
  };
  const mixed = (from, to, part) => {
    const [a, b] = [from, to].map((colour) => colour.match(/[\d.]+/g).map(Number));
    return `rgb(${[0, 1, 2].map((k) => Math.round(a[k] + (b[k] - a[k]) * part)).join()})`;
  };

  const path = (corners, close) => {
    paint.beginPath();
    corners.forEach((corner, k) => (k ? paint.lineTo(...at(corner)) : paint.moveTo(...at(corner))));
    if (close) paint.closePath();
  };
  const stroke = (colour, wide) => {
    paint.strokeStyle = colour;
    paint.lineWidth = wide;
    paint.stroke();
  };
  const word = (text, x, y, colour, paper, font = "13px system-ui, sans-serif") => {
    paint.font = font;
    paint.textAlign = "center";
    paint.textBaseline = "middle";
    paint.lineJoin = "round";
    paint.strokeStyle = paper;
    paint.lineWidth = 3;
    paint.strokeText(text, x, y);
    paint.fillStyle = colour;
    paint.fillText(text, x, y);
  };

  // Surfaces from the back to the front; those that lie on one side of a plane by that, whatever their depths.
  const ordered = () => {
    const facing = patches.map((patch) => patch.normals.length > 0 && dot(patch.normals[0], toward) > 0);
    const hides = (one, other) => {
      const [above, below] = [patches[one].above[other], patches[other].above[one]];
      return above !== null ? above === facing[other] : below !== null ? below !== facing[one] : false;
    };
    const depths = patches.map(({ vertices }) => vertices.reduce((sum, v) => sum + dot(toward, v), 0) / (vertices.length || 1));
    const left = patches.map((_, index) => index).sort((a, b) => depths[a] - depths[b]);
    const found = [];
    while (left.length) {
      // Where each hides another one, the farthest.
      const free = left.findIndex((one) => left.every((other) => other === one || !hides(one, other)));
      found.push(patches[left.splice(Math.max(0, free), 1)[0]]);
    }
    return found;
  };

  const drawSurfaces = (colour) => {
    const light = add(add(add([0, 0, 0], toward, 0.8), up, 0.5), right, -0.33);
    for (const patch of ordered()) {
      const items = [];
      const seen = patch.normals.map((normal) => dot(normal, toward) > 0);
      const depth = (corners) => corners.reduce((sum, k) => sum + dot(toward, patch.vertices[k]), 0) / corners.length;
      patch.faces.forEach((face, index) => {
        if (!seen[index] && patch.solid) return;
        const fill = seen[index] ? mixed(colour.unlit, colour.lit, Math.max(0, dot(patch.normals[index], light))) : colour.back;
        items.push([depth(face), () => {
          path(face.map((k) => patch.vertices[k]), true);
          paint.fillStyle = fill;
          paint.fill();
          stroke(fill, 1);
        }]);
      });
      for (const [from, to, one, other, rim] of patch.edges) {
        const outline = other !== null && seen[one] !== seen[other];
        const inSight = seen[one] || (other !== null && seen[other]) || !patch.solid;
        if (!inSight || !(rim || outline)) continue;
        items.push([depth([from, to]) + 0.03, () => {
          path([patch.vertices[from], patch.vertices[to]]);
          stroke(colour.edge, 1);
        }]);
      }
      items.sort((a, b) => a[0] - b[0]).forEach(([, item]) => item());
    }
  };

  const drawEllipsoid = ({ at: place, half }, colour) => {
    const [x, y] = at(place);
    const [r, u] = [right, up].map((axis) => half.map((h) => dot(axis, h) * scale));
    const [a, b, c] = [dot(r, r), -dot(r, u), dot(u, u)];
    const mean = (a + c) / 2;
    const off = Math.hypot((a - c) / 2, b);
    paint.beginPath();
    paint.ellipse(x, y, Math.sqrt(mean + off), Math.sqrt(Math.max(0, mean - off)), Math.atan2(2 * b, a - c) / 2, 0, 2 * Math.PI);
    paint.globalAlpha = 0.14;
    paint.fillStyle = colour.ellipsoid;
    paint.fill();
    paint.globalAlpha = 1;
    stroke(colour.ellipsoid, 1.2);
  };

  const drawTouch = (touch, index, colour) => {
    const ink = touch.excluded ? colour.bad : colour.ink;
    const foot = at(touch.foot);
    const end = at(add(touch.foot, touch.normal, normalLength));
    marks.push(foot);
    paint.globalAlpha = dot(touch.normal, toward) > 0 || index === chosen ? 1 : 0.45;
    if (shown("normals")) {
      path([touch.foot, add(touch.foot, touch.normal, normalLength)]);
      stroke(ink, 1);
      if (tipRadius * scale > 4) {
        paint.beginPath();
        paint.arc(...at(touch.tip), tipRadius * scale, 0, 2 * Math.PI);
        stroke(colour.faint, 0.8);
      }
    }
    if (shown("residuals") && !touch.excluded) {
      paint.lineCap = "round";
      path([touch.foot, add(touch.foot, touch.normal, touch.residual)]);
      stroke(colour.residual, 4);
      paint.lineCap = "butt";
    }
    paint.beginPath();
    paint.arc(...foot, index === chosen ? 6 : 3.6, 0, 2 * Math.PI);
    paint.fillStyle = touch.excluded ? colour.paper : index === chosen ? colour.chosen : ink;
    paint.fill();
    stroke(ink, index === chosen ? 2 : 1);
    if (shown("numbers") && (touches.length <= 24 || index === chosen)) {
      const [dx, dy] = [end[0] - foot[0], end[1] - foot[1]];
      const far = Math.hypot(dx, dy);
      const [ux, uy] = far > 1 ? [dx / far, dy / far] : [0.6, -0.8];
      word(String(index), end[0] + 9 * ux, end[1] + 9 * uy, ink, colour.paper, "12px system-ui, sans-serif");
    }
    paint.globalAlpha = 1;
  };

  const drawParent = (colour) => {
    const from = [46, height - 50];
    ["x", "y", "z"].forEach((name, k) => {
      const [dx, dy] = [right[k], -up[k]];
      paint.beginPath();
      paint.moveTo(...from);
      paint.lineTo(from[0] + 28 * dx, from[1] + 28 * dy);
      stroke(colour.faint, 1.2);
      word(name, from[0] + 37 * dx, from[1] + 37 * dy, colour.faint, colour.paper, "12px system-ui, sans-serif");
    });
    word("parent", 46, height - 8, colour.faint, colour.paper, "11px system-ui, sans-serif");
  };

  draw = () => {
    const dense = window.devicePixelRatio || 1;
    [width, height] = [canvas.clientWidth, canvas.clientHeight];
    if (!width) return;
    canvas.width = Math.round(width * dense);
    canvas.height = Math.round(height * dense);
    paint.setTransform(dense, 0, 0, dense, 0, 0);
    const now = { ...view };
    Object.assign(view, first);
    turned();
    const filling = fit();
    Object.assign(view, now);
    turned();
    // Turned, the scene turns about its middle.
    scale = filling * view.zoom;
    const colour = colours();
    paint.clearRect(0, 0, width, height);
    marks = [];
    if (shown("ghosts")) {
      paint.setLineDash([3, 3]);
      for (const ghost of ghosts) for (const line of ghost.lines) { path(line); stroke(colour.faint, 1); }
      paint.setLineDash([]);
    }
    if (shown("surfaces")) drawSurfaces(colour);
    // Where surfaces end behind others.
    paint.setLineDash([2, 3]);
    for (const patch of patches) {
      for (const [one, other, , , rim] of patch.edges) {
        if (rim) { path([patch.vertices[one], patch.vertices[other]]); stroke(colour.edge, 0.8); }
      }
    }
    paint.setLineDash([]);
    axes.forEach((axis, k) => {
      const ink = colour["xyz"[k]];
      path([origin, add(origin, axis)]);
      stroke(ink, 2);
      const [from, to] = [at(origin), at(add(origin, axis))];
      const far = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
      word("XYZ"[k], to[0] + (10 * (to[0] - from[0])) / far, to[1] + (10 * (to[1] - from[1])) / far, ink, colour.paper, "600 13px system-ui, sans-serif");
    });
    if (shown("ellipsoids")) for (const ellipsoid of ellipsoids) drawEllipsoid(ellipsoid, colour);
    touches.forEach((touch, index) => drawTouch(touch, index, colour));
    drawParent(colour);
  };

  const choose = (index) => {
    if (index === chosen) return;
    chosen = index;
    told.textContent = index < 0 ? "" : touches[index].text;
    draw();
  };
  const step = (by) => choose((chosen + by + touches.length + (chosen < 0 && by < 0 ? 1 : 0)) % touches.length);
  const turn = (azimuth, elevation) => {
    view.azimuth += azimuth;
    view.elevation = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, view.elevation + elevation));
    draw();
  };
  const zoom = (by) => {
    view.zoom = Math.max(0.2, Math.min(50, view.zoom * by));
    draw();
  };
  const from = (azimuth, elevation) => {
    Object.assign(view, { azimuth, elevation });
    draw();
  };
  const actions = {
    in: () => zoom(1.25),
    out: () => zoom(0.8),
    reset: () => { view = { ...first }; choose(-1); draw(); },
    x: () => from(0, 0),
    y: () => from(Math.PI / 2, 0),
    z: () => from(-Math.PI / 2, Math.PI / 2),
    next: () => step(1),
    previous: () => step(-1),
  };
  const keys = {
    ArrowLeft: () => turn(-0.1, 0),
    ArrowRight: () => turn(0.1, 0),
    ArrowUp: () => turn(0, 0.1),
    ArrowDown: () => turn(0, -0.1),
    "+": actions.in, "=": actions.in, "-": actions.out,
    "]": actions.next, n: actions.next, "[": actions.previous, p: actions.previous,
    0: actions.reset, Home: actions.reset,
    Escape: () => choose(-1),
  };
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !Object.hasOwn(keys, event.key)) return;
    event.preventDefault();
    keys[event.key]();
  });
  for (const button of all("[data-do]")) button.addEventListener("click", actions[button.dataset.do]);
  for (const box of Object.values(layers)) box.addEventListener("change", () => draw());

  // ---- pointer: drag to turn, point at a touch

  let held = null;
  canvas.addEventListener("pointerdown", (event) => {
    held = [event.clientX, event.clientY];
    canvas.setPointerCapture(event.pointerId);
    canvas.focus({ preventScroll: true });
  });
  const release = () => (held = null);
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("pointermove", (event) => {
    if (held) {
      const [dx, dy] = [event.clientX - held[0], event.clientY - held[1]];
      held = [event.clientX, event.clientY];
      turn(-dx * 0.01, dy * 0.01);
      return;
    }
    const box = canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const far = marks.map((mark) => Math.hypot(mark[0] - x, mark[1] - y));
    const nearest = far.indexOf(Math.min(...far));
    if (far[nearest] < 14) choose(nearest);
  });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY * 0.0015));
  }, { passive: false });

  new ResizeObserver(() => draw()).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw());
  draw();
})();
