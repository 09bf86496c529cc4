// The page: what is looked at, what is selected, what is changed.
"use strict";

(function viewer() {
  const $ = (id) => document.getElementById(id);
  const content = JSON.parse($("content").textContent), edits = new Edits(content);
  const colourOf = (family) => content.families[family % content.families.length];
  const many = (count, one) => count === 1 ? `one ${one}` : `${count.toLocaleString("en")} ${one}s`;
  const unit = content.units === "mm" ? " mm" : "";
  const number = (value) => `${value.toLocaleString("en", { maximumSignificantDigits: value < 100 ? 3 : 4 })}${unit}`;
  const modes = { look: "Look", points: "Points", line: "Direction" };
  const colours = { family: "by family", bend: "by curvature, sideways", hard: "by hard place", force: "by force at the crossings" };
  let space = null, moving = false, hint = "";

  const make = (kind, attributes, ...parts) => {
    const element = document.createElement(kind);
    for (const key in attributes) {
      if (key.startsWith("on")) element.addEventListener(key.slice(2), attributes[key]);
      else if (key === "family") element.style.setProperty("--family", colourOf(attributes[key]));
      else element.setAttribute(key, attributes[key]);
    }
    element.append(...parts);
    return element;
  };
  const button = (text, act, attributes = {}) => make("button", { type: "button", onclick: act, ...attributes }, text);
  const tagOf = (r) => make("b", { class: "tag", family: content.strips[r][1] }, content.strips[r][0]);
  const label = (r) => content.strips[r][0];

  // A row of buttons of which one is chosen.
  function choice(box, names, chosen, act) {
    box.className = "choice";
    box.replaceChildren(...Object.entries(names).map(([key, text]) => button(text, () => act(key),
      { role: "radio", "aria-checked": String(key === String(chosen)), "data-key": key })));
  }

  // ---- the selected ribbon or crossing

  const words = (x) => {
    const { strips } = space.now.crossings[x], over = space.overAt(x);
    return [strips[over], strips[1 - over]];
  };

  function named(what) {
    if (what.kind === "ribbon") return label(what.strip);
    const [upper, lower] = words(what.crossing);
    return `${label(upper)} over ${label(lower)}`;
  }

  function here() {
    const what = space.selected, box = $("named"), deeds = $("deeds"), strip = what && what.kind === "ribbon" ? what.strip : -1;
    $("ribbon").value = strip >= 0 ? String(strip) : "";
    const barred = edits.steers;
    if (!what) {
      box.replaceChildren(make("p", {}, "Tap a ribbon or a crossing, or choose a ribbon by its name."));
      deeds.replaceChildren();
      $("chips").replaceChildren();
      return;
    }
    if (strip >= 0) {
      const [, , closed, length] = content.strips[strip], passages = space.now.passages[strip], gone = edits.dropped.has(strip);
      box.replaceChildren(make("p", { class: "name" }, tagOf(strip), gone ? " is dropped" : ""),
        make("p", {}, `${number(length)} ${closed ? "round, closed" : "long"}, ${many(passages.length, "crossing")}.`));
      const drop = button(gone ? "Bring back" : "Drop this ribbon", () => { edits.drop(strip); changed(); }, { id: "drop" });
      drop.disabled = barred;
      deeds.replaceChildren(button("Go there", () => go(what), { id: "go" }), drop);
      $("chips").replaceChildren(...passages.map((each) => {
        const over = space.overAt(each.crossing) === each.side, chip = button(`${over ? "over" : "under"} ${label(each.partner)}`,
          () => select({ kind: "crossing", crossing: each.crossing }, true), { class: "chip", family: content.strips[each.partner][1] });
        if (over !== (space.now.crossings[each.crossing].over === each.side)) chip.classList.add("changed");
        return chip;
      }));
      return;
    }
    const x = what.crossing, { angle, strips, designs } = space.now.crossings[x], [upper, lower] = words(x);
    const line = make("p", { class: "name" }, tagOf(upper), " over ", upper === lower ? "itself" : tagOf(lower));
    // Places in mm would be those of ribbons before their ends are trimmed.
    const counted = [0, 1].map((side) => {
      const met = space.now.passages[strips[side]], k = met.findIndex((each) => each.crossing === x && each.side === side);
      return `${k + 1} of ${met.length} on ${label(strips[side])}`;
    });
    const facts = [`Crossing ${counted.join(" and ")}.`];
    if (angle !== null) facts.push(`They cross at ${angle.toFixed(0)}°.`);
    const { force, fasten } = content.states[space.number];
    if (force && force[x] !== null) facts.push(`Force: ${Math.round(100 * force[x] / space.mostPulled)} % of the strongest.`);
    if (fasten.includes(x)) facts.push("Glue or rivet it: friction alone does not hold this crossing.");
    box.replaceChildren(line, make("p", {}, facts.join(" ")));
    const flip = button("Flip over and under", () => { edits.flip(designs); changed(); }, { id: "flip" });
    flip.disabled = barred || !designs.length;
    deeds.replaceChildren(button("Go there", () => go(what), { id: "go" }), flip,
      ...[...new Set(strips)].map((r) => button(label(r), () => select({ kind: "ribbon", strip: r }, false))));
    $("chips").replaceChildren();
  }

  function go(what) {
    const { point, up } = space.placeOf(what);
    space.flyTo(point.toArray(), up, what.kind === "crossing" ? 22 : 60);
  }

  function select(what, fly) {
    space.select(what);
    document.querySelectorAll("#places [aria-current]").forEach((each) => each.removeAttribute("aria-current"));
    here();
    if (fly && what) go(what);
  }

  // ---- colours

  function legend() {
    const box = $("legend"), swatch = (colour, text) => {
      const square = make("i", {});
      square.style.background = colour;
      return make("span", {}, square, text);
    };
    if (space.colour === "family") {
      const used = [...new Set(content.strips.map(([, family]) => family))].sort((a, b) => a - b);
      box.replaceChildren(...used.map((family) => swatch(colourOf(family), content.strips.find((each) => each[1] === family)[0].replace(/\d+$/, ""))));
    } else if (space.colour === "hard") {
      box.replaceChildren(swatch(`rgb(${HARD})`, "hard place"), swatch(`rgb(${PLAIN})`, "nothing to report"));
    } else {
      const bar = make("div", { class: "bar" });
      bar.style.background = `linear-gradient(to right, ${RAMP.map((each) => `rgb(${each})`).join(", ")})`;
      const most = space.colour === "force" ? "strongest" :
        `radius ${number(Number((content.width / (space.mostBent * content.states[space.number].bend.unit)).toPrecision(2)))} or less`;
      box.replaceChildren(bar, make("div", { class: "ends" }, make("span", {}, space.colour === "force" ? "no force" : "straight"), make("span", {}, most)));
    }
  }

  function colour(name) {
    space.colour = name;
    $("colour").value = name;
    space.coloured();
    space.dirty = true;
    legend();
  }

  function shape(k) {
    // What is edited in space is edited on the design.
    if (k !== 0 && space.mode !== "look") mode("look");
    space.shape(k);
    choice($("states"), Object.fromEntries(content.states.map((each, n) => [n, each.says])), k, (key) => shape(Number(key)));
    listColours();
    legend();
    here();
  }

  const available = () => Object.keys(colours).filter((each) => each === "force" ? Boolean(content.states[space.number].force) : each !== "hard" || content.places.length);

  function listColours() {
    $("colour").replaceChildren(...available().map((key) => make("option", { value: key }, colours[key])));
    $("colour").value = space.colour;
  }

  // ---- hard places

  function places() {
    $("hard").hidden = !content.places.length;
    $("hard").querySelector("summary").textContent = `Hard places (${content.places.length})`;
    const kinds = [...new Set(content.places.map((each) => each.kind))], parts = [];
    for (const kind of kinds) {
      const [what, measured] = (content.kinds[kind] || kind).split("; value: ");
      parts.push(make("h3", {}, what[0].toUpperCase() + what.slice(1)));
      content.places.forEach((place, k) => {
        if (place.kind !== kind) return;
        const names = [...new Set(place.ribbons)].map(label).join(", ");
        const said = [names, `${place.value.toLocaleString("en", { maximumSignificantDigits: 3 })}`].filter(Boolean).join(": ");
        parts.push(button(said, (event) => visit(k, event.currentTarget), { "data-place": k, title: measured || "" }));
      });
      if (measured) parts.push(make("p", {}, `The number is ${measured}.`));
    }
    $("places").replaceChildren(...parts);
  }

  function visit(k, item) {
    const place = content.places[k], point = new THREE.Vector3(...place.at[Math.min(space.number, place.at.length - 1)]);
    select(place.ribbons.length === 1 ? { kind: "ribbon", strip: place.ribbons[0] } : null, false);
    item.setAttribute("aria-current", "true");
    // Outwards as the nearest ribbon has it.
    let up = null, least = Infinity;
    space.now.ways.forEach((way) => way.centre.forEach((each, n) => {
      const far = each.distanceToSquared(point);
      if (far < least) { least = far; up = way.up[n]; }
    }));
    space.tags = [{ point, text: place.kind.replace(/_/g, " "), kind: "selected" }];
    space.flyTo(point.toArray(), up.clone(), 26);
  }

  // ---- branch points and direction

  function mode(name) {
    space.mode = name;
    moving = false;
    space.chosen = -1;
    if (name !== "look" && space.number !== 0) shape(0);
    choice($("modes"), Object.fromEntries(Object.entries(modes).filter(([key]) => key !== "points" || edits.points.length)), name, mode);
    steered();
  }

  function steered() {
    const box = $("chosen"), k = space.chosen;
    hint = "";
    if (space.mode === "look") box.replaceChildren();
    else if (edits.changes) {
      box.replaceChildren(make("p", {}, "Ribbons are dropped or crossings flipped. Save these edits first and apply them, or undo them."));
    } else if (space.mode === "points") {
      const rows = edits.points.map((each, n) => make("option", { value: n }, `${n + 1}: index ${each.index}/${content.symmetry}`));
      const list = make("select", { id: "point", "aria-label": "Branch point", onchange: (event) => pickPoint(Number(event.target.value)) },
        make("option", { value: -1 }, "Choose a branch point"), ...rows);
      list.value = String(k >= 0 ? k : -1);
      box.replaceChildren(list);
      if (k >= 0) {
        box.append(button(edits.points[k].pinned ? "Let go" : "Pin here", () => { edits.pin(k); changed(); }, { id: "pin" }),
          button(moving ? "Do not move" : "Move", () => { moving = !moving; steered(); }, { id: "move", "aria-pressed": String(moving) }));
      }
      hint = moving ? "Tap where it shall be" : "Tap a dark point";
      box.append(make("p", {}, "When one is pinned or moved, all others stay where they are too."));
    } else {
      const all = make("input", { type: "checkbox", id: "everywhere", onchange: (event) => { edits.follow(event.target.checked); changed(); } });
      all.checked = edits.everywhere;
      const again = button("Begin again", () => { edits.forget(); changed(); }, { id: "again" });
      again.disabled = !edits.line.length;
      box.replaceChildren(make("p", {}, edits.line.length < 2 ? "Tap two or more points on the weave; one family of ribbons then follows the line."
        : `A line of ${edits.line.length} points.`), make("label", {}, all, "The same direction everywhere"), again);
      hint = "Tap points of the line";
    }
    $("hint").textContent = hint;
    space.points();
    space.dirty = true;
  }

  function pickPoint(k) {
    space.chosen = k;
    moving = false;
    steered();
    if (k >= 0) space.flyTo(edits.points[k].point, null, 60);
  }

  function tapped(x, y, slack) {
    space.tags = [];
    if (space.mode === "look") {
      select(space.at(x, y, slack), false);
      return;
    }
    if (edits.changes) return;
    if (space.mode === "points" && !moving) {
      space.chosen = space.pointAt(x, y, slack);
      steered();
      return;
    }
    const point = space.surface(x, y);
    if (!point) return;
    if (space.mode === "line") edits.mark(point);
    else { edits.move(space.chosen, point); moving = false; }
    changed();
  }

  // ---- changes

  function changed() {
    space.refresh();
    here();
    steered();
    listed();
  }

  function listed() {
    const said = edits.said();
    $("list").replaceChildren(...(said.length ? said : ["None yet."]).map((text) => make("li", {}, text)));
    $("undo").disabled = !edits.before.length;
    $("save").disabled = !edits.any;
    $("how").replaceChildren(...(edits.any ? ["Then run ", make("code", {}, "geoweave edit DIR edits.json -o DIR2"), " with the folder of this weave."] : []));
    $("text").hidden = !edits.any;
    $("written").value = edits.any ? JSON.stringify(edits.document(), null, 1) : "";
  }

  function save() {
    const link = make("a", { download: "edits.json" });
    link.href = URL.createObjectURL(new Blob([`${JSON.stringify(edits.document(), null, 1)}\n`], { type: "application/json" }));
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  }

  function undo() { if (edits.undo()) changed(); }

  // ---- names beside what they name

  function tags() {
    const shown = [...space.tags];
    if (space.selected) {
      const at = space.placeOf(space.selected);
      shown.push({ point: space.selected.point || at.point, text: named(space.selected), kind: "selected" });
    }
    if (space.over) shown.push({ point: space.over.point, text: named(space.over), kind: "over" });
    $("tags").replaceChildren(...shown.map(({ point, text, kind }) => {
      const { x, y, front } = space.seen(point), name = make("i", { class: kind }, text);
      name.style.left = `${x}px`;
      name.style.top = `${y}px`;
      name.hidden = !front;
      return name;
    }));
  }

  function verdict() {
    const { verdict: found } = content, box = $("verdict");
    if (!found) return;
    box.hidden = false;
    box.textContent = found.reasons.length ? `${found.word[0].toUpperCase()}${found.word.slice(1)}: ${found.reasons.join("; ")}.` : `${found.word[0].toUpperCase()}${found.word.slice(1)}.`;
    box.classList.toggle("but", found.word.includes("but"));
    box.classList.toggle("not", found.word.includes("not"));
  }

  function keys(event) {
    if (event.ctrlKey || event.altKey || event.metaKey || event.defaultPrevented) return;
    const { key, target } = event, onCanvas = target === $("canvas") || target === document.body;
    if (/^(SELECT|INPUT|TEXTAREA)$/.test(target.tagName)) return;
    const next = (list, now) => list[(list.indexOf(now) + 1) % list.length];
    if (onCanvas && key.startsWith("Arrow")) space.turn({ ArrowLeft: -0.15, ArrowRight: 0.15 }[key] || 0, { ArrowUp: 0.12, ArrowDown: -0.12 }[key] || 0);
    else if (key === "+" || key === "=") space.zoom(0.8);
    else if (key === "-" || key === "_") space.zoom(1.25);
    else if (key === "0") space.back();
    else if (key === "s" || key === "S") shape(next([...content.states.keys()], space.number));
    else if (key === "c" || key === "C") colour(next(available(), space.colour));
    else if (key === "z" || key === "Z") undo();
    else if (key === "Escape") { space.tags = []; moving = false; select(null, false); steered(); }
    else if (target === $("canvas") && (key === "Enter" || key === " ")) {
      const box = target.getBoundingClientRect();
      tapped(box.left + box.width / 2, box.top + box.height / 2, 12);
    } else return;
    event.preventDefault();
  }

  function start() {
    $("title").textContent = content.title;
    const crossings = content.crossings.length;
    $("size").textContent = `${many(content.strips.length, "ribbon")}, ${many(crossings, "crossing")}, ${number(content.width)} wide`;
    try {
      space = new ViewSpace($("canvas"), content, edits);
    } catch (error) {
      $("trouble").hidden = false;
      $("trouble").textContent = "This browser does not show pictures in space (WebGL is off or missing).";
      ["tools", "panel", "canvas"].forEach((id) => { $(id).hidden = true; });
      return;
    }
    Object.assign(space, { tapped, onDraw: tags, onHover: tags });
    $("ribbon").replaceChildren(make("option", { value: "" }, "none"), ...content.strips.map(([name], r) => make("option", { value: r }, name)));
    $("ribbon").addEventListener("change", (event) => { const r = event.target.value; select(r === "" ? null : { kind: "ribbon", strip: Number(r) }, r !== ""); });
    $("colour").addEventListener("change", (event) => colour(event.target.value));
    $("closer").addEventListener("click", () => space.zoom(0.8));
    $("farther").addEventListener("click", () => space.zoom(1.25));
    $("whole").addEventListener("click", () => space.back());
    $("tip").addEventListener("click", () => { space.tip(space.side + 1); space.back(); });
    $("undo").addEventListener("click", undo);
    $("save").addEventListener("click", save);
    $("steer").addEventListener("toggle", () => { if (!$("steer").open) mode("look"); });
    window.addEventListener("keydown", keys);
    shape(content.states.length - 1);
    verdict();
    places();
    mode("look");
    listed();
    // The other shape is made ready while nothing else is to be done.
    if (content.states.length > 1) setTimeout(() => space.built(0), 300);
  }

  start();

  // For tests, and for whoever wants to drive the page.
  window.viewer = {
    content, edits, select, go, mode, colour, shape,
    get space() { return space; },
    still() { return !space || (!space.flight && !space.dirty); },
    // Where the middle of a crossing or of a ribbon is on the canvas.
    seen(what) { return space.seen(space.placeOf(what).point); },
  };
})();
