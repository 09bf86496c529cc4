// The page: it shows one step at a time, and remembers where the maker was.
"use strict";

(function guide() {
  const $ = (id) => document.getElementById(id);
  const content = JSON.parse($("content").textContent), plan = planned(content), steps = plan.steps;
  const colour = (family) => content.families[family % content.families.length];
  let index = 0, memory = "storage", space = null, drawn = null, map = null;

  // ---- words and marks

  function tagOf(strip) {
    const tag = document.createElement("b");
    tag.className = "tag";
    tag.style.setProperty("--family", colour(plan.strips[strip].family));
    tag.textContent = plan.strips[strip].label;
    return tag;
  }

  function markOf(mark, solid, family) {
    const box = svg("svg", { viewBox: "-1.25 -1.25 2.5 2.5", class: "mark", role: "img" });
    const title = svg("title", {}, box);
    title.textContent = `${solid ? "solid" : "hollow"} ${content.marks[mark].name}`;
    const path = svg("path", { d: `M${content.marks[mark].outline.map(([x, y]) => `${x},${-y}`).join("L")}Z` }, box);
    path.setAttribute("class", solid ? "solid" : "hollow");
    box.style.setProperty("--family", colour(family));
    return box;
  }

  function sentenceOf(parts) {
    return parts.flatMap((part) => {
      if (typeof part === "string") return [part === "itself" || part === "at" ? `${part} ` : part];
      if ("strip" in part) return [tagOf(part.strip), " "];
      if ("mark" in part) return [markOf(part.mark, part.solid, part.family), ` ${content.marks[part.mark].name}.`];
      const word = document.createElement("strong");
      word.className = part.word;
      word.textContent = part.word.toUpperCase();
      return [word, " "];
    });
  }

  function said(step) {
    const words = worded(step, plan, content);
    $("where").textContent = words.where;
    const parts = sentenceOf(words.sentence);
    const last = parts.length - 1;
    if (parts[last] === "." && parts[last - 1] === " ") parts.splice(last - 1, 1);
    $("sentence").replaceChildren(...parts);
    $("facts").replaceChildren(...words.facts.map(([strip, text]) => {
      const line = document.createElement("p");
      if (strip !== null) line.append(tagOf(strip), " ");
      line.append(text);
      return line;
    }), ...(step.kind === "start" ? legend() : []));
  }

  function chips(step) {
    const box = $("chips");
    if (!step.met) { box.replaceChildren(); return; }
    const first = plan.firstOf[step.strip] + 1;
    const made = step.met.map((each, k) => {
      const chip = document.createElement("button");
      chip.type = "button";
      chip.className = `chip ${each.over ? "over" : "under"}`;
      chip.append(markOf(each.mark, !each.over, plan.strips[each.partner].family), each.label);
      chip.title = `${each.over ? "over" : "under"} ${each.label} at ${millimetres(each.at)}`;
      chip.style.setProperty("--family", colour(plan.strips[each.partner].family));
      if (first + k < index) chip.classList.add("done");
      if (first + k === index) chip.setAttribute("aria-current", "step");
      chip.addEventListener("click", () => go(first + k));
      return chip;
    });
    box.replaceChildren(...made);
    const now = box.querySelector("[aria-current]");
    if (now) box.scrollTop = now.offsetTop - box.offsetTop - box.clientHeight / 2;
  }

  // ---- strips in hand

  const own = new Belt($("own"), content, plan, pick), other = new Belt($("other"), content, plan, pick);

  function pick(crossing) {
    const step = steps[index];
    const k = step.met ? step.met.findIndex((each) => each.crossing === crossing) : -1;
    if (k >= 0) go(plan.firstOf[step.strip] + 1 + k);
  }

  function belts(step) {
    const strip = step.strip === undefined ? (step.kind === "start" ? plan.order[0] : plan.order[plan.order.length - 1]) : step.strip;
    const there = new Set(plan.order.slice(0, step.number));
    if (step.kind === "done") plan.order.forEach((each) => there.add(each));
    // Crossings that are fastened already: those of earlier strips, and those of this strip up to this step.
    const fixed = (r) => new Set(plan.passages[r].filter((each) => each.partner !== r || there.has(r))
      .filter((each) => there.has(each.partner) && there.has(r)).map((each) => each.crossing));
    const done = fixed(strip), now = new Set();
    if (step.met) {
      const before = step.kind === "cross" ? step.k : step.kind === "join" ? step.met.length : 0;
      step.met.forEach((each, k) => (k < before ? done : now).add(each.crossing));
    }
    if (step.kind === "start") plan.passages[strip].forEach((each) => now.add(each.crossing));
    const passage = step.kind === "cross" ? step.passage : null;
    $("strips").hidden = step.kind === "done";
    own.show(strip, passage, done, now);
    const length = plan.strips[strip].length;
    own.caption.replaceChildren(tagOf(strip), ` ${step.kind === "start" ? "the first strip" : "in hand"}, ${millimetres(length)}`);
    const second = passage !== null;
    $("other").hidden = !second;
    if (second) {
      const back = { ...passage, strip: passage.partner, partner: passage.strip, at: passage.away, angle: within(-passage.angle) };
      const behind = fixed(passage.partner);
      done.forEach((each) => behind.add(each));
      const only = new Set([passage.crossing]);
      behind.delete(passage.crossing);
      other.show(passage.partner, back, behind, only);
      const text = passage.partner === strip ? "its other place" : passage.over ? "goes below" : "lies above";
      other.caption.replaceChildren(tagOf(passage.partner), ` ${text}`);
    }
  }

  // ---- the order of strips

  const segments = plan.order.map((strip) => {
    const segment = document.createElement("button");
    const step = steps[plan.firstOf[strip]];
    segment.type = "button";
    segment.style.flexGrow = 1 + step.met.length;
    segment.style.setProperty("--family", colour(plan.strips[strip].family));
    segment.title = plan.strips[strip].label;
    segment.setAttribute("aria-label", `strip ${plan.strips[strip].label}`);
    segment.tabIndex = -1;
    segment.addEventListener("click", () => go(plan.firstOf[strip]));
    return segment;
  });
  $("progress").replaceChildren(...segments);
  const listed = plan.order.map((strip) => {
    const item = document.createElement("button");
    item.type = "button";
    item.append(tagOf(strip));
    item.addEventListener("click", () => go(plan.firstOf[strip]));
    return item;
  });
  $("list").replaceChildren(...listed);
  if (plan.zones.length > 1) {
    plan.zones.forEach((strips, zone) => {
      const name = document.createElement("span");
      name.className = "zone";
      name.textContent = `Zone ${zone + 1}`;
      listed[plan.numberOf[strips[0]]].before(name);
    });
  }

  function progress(step) {
    const number = step.kind === "start" ? -1 : step.number;
    [segments, listed].forEach((items) => items.forEach((item, k) => {
      item.className = k < number ? "done" : k === number ? "now" : "";
      if (k === number) item.setAttribute("aria-current", "step");
      else item.removeAttribute("aria-current");
    }));
    const share = number >= 0 && number < segments.length ? (index - plan.firstOf[step.strip] + 1) / (step.met.length + 2) : 0;
    if (segments[number]) segments[number].style.setProperty("--share", `${Math.round(100 * share)}%`);
    $("count").textContent = `${index} of ${steps.length - 1}`;
    $("back").disabled = index === 0;
    $("next").disabled = index === steps.length - 1;
    const next = steps[index + 1];
    $("next").textContent = !next ? "Next" : index === 0 ? "Begin" : next.kind === "take" ? "Next strip" : "Next";
  }

  function legend() {
    const line = (parts) => { const p = document.createElement("p"); p.append(...parts); return p; };
    return [
      line([markOf(3, false, 0), " A hollow mark and dashed guides: this strip lies over the other one."]),
      line([markOf(3, true, 0), " A solid mark, double guides and the other one's colour: this strip goes under."]),
      line(["The name beside a mark is that of the strip that crosses there. The same mark is on that strip too, beside the name of this one."]),
      line(["Guides are where the edges of the other strip lie; the small arrow at the edge is where it goes."]),
      line(["Each strip has its name and an arrow at both ends. The marked side is the outside of the weave, the plain side the inside."]),
    ];
  }

  // ---- memory

  const KEY = `geoweave-guide-${content.key}`;

  function remembered() {
    const asked = /^#step-(\d+)$/.exec(location.hash);
    if (asked) return Number(asked[1]);
    try {
      const stored = JSON.parse(localStorage.getItem(KEY) || "{}");
      if (space && Number.isInteger(stored.side) && stored.up === content.up) { space.tip(stored.side); space.whole(); }
      return Number.isInteger(stored.step) ? stored.step : 0;
    } catch (error) {
      return 0;
    }
  }

  function remember() {
    try {
      localStorage.setItem(KEY, JSON.stringify({ step: index, side: space ? space.side : 0, up: content.up }));
      memory = "storage";
      if (location.hash.startsWith("#step-")) history.replaceState(null, "", location.pathname + location.search);
    } catch (error) {
      memory = "address";
      try { history.replaceState(null, "", `#step-${index}`); } catch (refused) { location.hash = `step-${index}`; }
    }
    $("memory").textContent = memory === "storage"
      ? "This page remembers where you are: close it and come back."
      : "This browser keeps nothing for this page. Its address holds the step: bookmark it to come back here.";
  }

  // ---- one step

  function go(to) {
    index = Math.min(Math.max(Math.round(to) || 0, 0), steps.length - 1);
    const step = steps[index];
    said(step);
    chips(step);
    belts(step);
    progress(step);
    $("lens").hidden = step.kind !== "cross" || !space;
    $("zones").hidden = step.kind === "cross" || step.kind === "done" || !map;
    if (map) map.show(step);
    if (space) space.show(step);
    document.body.dataset.kind = step.kind;
    document.body.dataset.step = index;
    remember();
  }

  function strip(way) {
    const step = steps[index], first = step.strip === undefined ? index : plan.firstOf[step.strip];
    if (way < 0 && index > first) { go(first); return; }
    const number = step.kind === "start" ? (way > 0 ? 0 : -1) : step.kind === "done" ? (way > 0 ? plan.order.length : plan.order.length - 1) : step.number + way;
    go(number < 0 ? 0 : number >= plan.order.length ? steps.length - 1 : plan.firstOf[plan.order[number]]);
  }

  function labels() {
    const box = $("tags");
    box.replaceChildren(...space.tags.map((tag) => {
      const { x, y, front } = space.seen(tag.point);
      const name = document.createElement("i");
      name.className = tag.kind;
      name.textContent = tag.text;
      const out = tag.up ? tag.up.clone().multiplyScalar(content.width * 0.9).add(tag.point) : tag.point;
      const end = tag.kind === "asked" ? { x, y: y - 18 } : space.seen(out);
      const centre = space.mark && tag.kind !== "asked" ? space.seen(space.mark.point) : null;
      if (centre) {
        // The name stands clear of the ring that marks the crossing.
        const dx = end.x - centre.x || 1, dy = end.y - centre.y, far = Math.hypot(dx, dy), wanted = Math.max(far, 44);
        end.x = centre.x + dx / far * wanted;
        end.y = centre.y + dy / far * wanted;
      }
      name.style.left = `${end.x}px`;
      name.style.top = `${end.y}px`;
      name.hidden = !front;
      return name;
    }));
  }

  function start() {
    $("title").textContent = content.title;
    const metres = plan.strips.reduce((sum, each) => sum + each.length, 0) / 1000;
    $("size").textContent = `${many(plan.strips.length, "strip")}, ${many(plan.crossings.length, "crossing")}, ` +
      `${metres.toLocaleString("en", { maximumFractionDigits: 1 })} m of strip`;
    $("legend").replaceChildren(...legend());
    if (plan.zones.length > 1) map = new ZoneMap($("zones"), content, plan);
    try {
      space = new Space($("canvas"), content, plan);
      space.lens = () => {
        const lens = $("lens"), size = lens.clientWidth;
        return [lens.offsetLeft + lens.clientLeft, lens.offsetTop + lens.clientTop, size];
      };
      space.aside = () => Math.max($("lens").offsetWidth, $("zones").offsetWidth);
      space.onDraw = labels;
    } catch (error) {
      $("trouble").hidden = false;
      $("trouble").textContent = "This browser does not show pictures in space (WebGL is off or missing). The steps and the strips work without.";
      $("tools").hidden = true;
      $("canvas").hidden = true;
    }
    $("back").addEventListener("click", () => go(index - 1));
    $("next").addEventListener("click", () => go(index + 1));
    $("print").addEventListener("click", () => window.print());
    if (space) {
      $("closer").addEventListener("click", () => space.zoom(0.8));
      $("farther").addEventListener("click", () => space.zoom(1.25));
      $("whole").addEventListener("click", () => space.back());
      const toggle = (id, name) => $(id).addEventListener("click", () => {
        space[name] = !space[name];
        $(id).setAttribute("aria-pressed", String(space[name]));
        space.show(steps[index]);
      });
      toggle("follow", "following");
      toggle("later", "later");
      $("tip").addEventListener("click", () => { space.tip(space.side + 1); $("whole").click(); remember(); });
    }
    window.addEventListener("keydown", keys);
    window.addEventListener("resize", () => { [own, other].forEach((belt) => { belt.resize(); if (belt.strip >= 0) belt.reach(true); }); });
    window.addEventListener("hashchange", () => { const asked = /^#step-(\d+)$/.exec(location.hash); if (asked && Number(asked[1]) !== index) go(Number(asked[1])); });
    window.addEventListener("beforeprint", sheet);
    go(remembered());
  }

  function keys(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    const { key } = event;
    if (event.shiftKey && space && key.startsWith("Arrow")) {
      space.turn({ ArrowLeft: -0.15, ArrowRight: 0.15 }[key] || 0, { ArrowUp: 0.12, ArrowDown: -0.12 }[key] || 0);
    } else if (key === "ArrowRight" || key === "PageDown") go(index + 1);
    else if (key === "ArrowLeft" || key === "PageUp") go(index - 1);
    else if (key === "ArrowDown") strip(1);
    else if (key === "ArrowUp") strip(-1);
    else if (key === "Home") go(0);
    else if (key === "End") go(steps.length - 1);
    else if (space && (key === "+" || key === "=")) space.zoom(0.8);
    else if (space && (key === "-" || key === "_")) space.zoom(1.25);
    else if (space && key === "0") $("whole").click();
    else return;
    event.preventDefault();
  }

  // ---- everything on paper

  function sheet() {
    const box = $("sheet");
    if (drawn) return;
    drawn = true;
    const make = (kind, ...parts) => { const element = document.createElement(kind); element.append(...parts); return element; };
    const parts = [make("h1", content.title), make("p", $("size").textContent)];
    if (space) {
      const picture = document.createElement("img");
      picture.src = space.picture();
      picture.alt = "the weave";
      parts.push(picture);
    }
    if (map) {
      const both = make("div", ...map.views.map((view) => view.parentElement.cloneNode(true)));
      both.className = "zones";
      both.querySelectorAll("[data-zone]").forEach((each) => each.setAttribute("class", "all"));
      both.querySelectorAll(".own").forEach((each) => each.classList.remove("own"));
      parts.push(both);
    }
    plan.order.forEach((r, number) => {
      if (map && plan.zones[steps[plan.firstOf[r]].zone][0] === r) parts.push(make("h3", `Zone ${steps[plan.firstOf[r]].zone + 1}`));
      const step = steps[plan.firstOf[r]], strip = plan.strips[r];
      const head = make("h2", `${number + 1}. Strip `, tagOf(r), ` ${millimetres(strip.length)}${step.backbone ? ", backbone" : ""}`);
      const rows = step.met.map((each) => make("tr", make("td", "☐"), make("td", markOf(each.mark, !each.over, plan.strips[each.partner].family)),
        make("td", each.over ? "over" : "under"), make("td", each.partner === r ? "itself" : each.label),
        make("td", millimetres(each.at)), make("td", millimetres(each.away)), make("td", `${Math.round(Math.abs(each.angle))}° ${each.angle > 0 ? "left" : "right"}`)));
      const names = make("tr", ...["", "mark", "", "strip", `on ${strip.label}`, "on the other", "angle"].map((text) => make("th", text)));
      const table = make("table", make("thead", names), make("tbody", ...rows));
      const block = make("section", head, ...(rows.length ? [table] : [make("p", number ? "Meets nothing that is there yet." : "The first one: lay it down.")]));
      if (strip.closed) block.append(make("p", `☐ Join its ends: the start over the last ${millimetres(content.overlap)}.`));
      parts.push(block);
    });
    box.replaceChildren(...parts);
  }

  start();

  // For tests, and for whoever wants to drive the page.
  window.guide = {
    go, plan, content,
    get index() { return index; },
    get step() { return steps[index]; },
    get memory() { return memory; },
    // What is marked in space, where that is on the canvas, and the angle at which the ribbons cross there.
    marked() {
      if (!space || !space.mark) return null;
      const point = space.ring.position, { passage } = steps[index], { up } = space.mark;
      const one = space.spot(passage.strip, passage.at).ahead, two = space.spot(passage.partner, passage.away).ahead;
      [one, two].forEach((way) => way.addScaledVector(up, -way.dot(up)));
      const angle = Math.atan2(up.dot(one.clone().cross(two)), one.dot(two)) * 180 / Math.PI;
      return { crossing: space.mark.crossing, point: point.toArray(), seen: space.seen(point), shown: space.ring.visible, angle };
    },
    shown() { return space ? space.meshes.filter((mesh) => mesh.visible).map((mesh) => mesh.userData.strip) : []; },
    still() { return !space || (!space.flight && !space.dirty); },
  };
})();
