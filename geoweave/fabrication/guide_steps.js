// The steps of the assembly and the sentences that say them. This part knows the pattern and no page.
"use strict";

function planned(content) {
  const strips = content.strips.map(([label, family, closed, length]) => ({ label, family, closed, length }));
  const crossings = content.crossings.map(([a, b, s, t, angle, over, mark, round]) => ({
    strips: [a, b], at: [s, t], angle, over, mark, again: round ? `/${round + 1}` : "",
  }));
  const passages = strips.map(() => []);
  crossings.forEach((each, x) => [0, 1].forEach((side) => passages[each.strips[side]].push({
    crossing: x, side, strip: each.strips[side], partner: each.strips[1 - side], at: each.at[side],
    away: each.at[1 - side], over: each.over === side, mark: each.mark,
    angle: within(side ? -each.angle : each.angle),
    label: strips[each.strips[1 - side]].label + each.again,
    name: strips[each.strips[side]].label + each.again,
  })));
  passages.forEach((each) => each.sort((one, two) => one.at - two.at || one.crossing - two.crossing));
  const steps = [{ kind: "start", number: 0 }];
  const firstOf = strips.map(() => 0), numberOf = strips.map(() => 0);
  const zones = [];
  content.order.forEach(([strip, backbone, fixed, zone], number) => {
    (zones[zone] = zones[zone] || []).push(strip);
    const now = new Set(fixed), last = new Map();
    // A strip that crosses itself can be woven there only when its later place is reached.
    passages[strip].forEach((each) => now.has(each.crossing) && last.set(each.crossing, each));
    const met = [...last.values()].sort((one, two) => one.at - two.at);
    const common = { strip, number, zone, backbone: backbone === 1, met };
    firstOf[strip] = steps.length;
    numberOf[strip] = number;
    steps.push({ kind: "take", ...common });
    met.forEach((passage, k) => steps.push({ kind: "cross", passage, k, ...common }));
    if (strips[strip].closed) steps.push({ kind: "join", ...common });
  });
  steps.push({ kind: "done", number: strips.length });
  const fasten = new Set(content.fasten);
  return { strips, crossings, passages, steps, fasten, firstOf, numberOf, zones, order: content.order.map(([strip]) => strip) };
}

function within(degrees) {
  return 180 - (((180 - degrees) % 360) + 360) % 360;
}

function millimetres(value) {
  return `${value.toLocaleString("en", { maximumFractionDigits: value < 100 ? 1 : 0 })} mm`;
}

function many(count, one) {
  return count === 1 ? `one ${one}` : `${count.toLocaleString("en")} ${one}s`;
}

// What a step says: its place, a sentence as parts of text and tags, and facts as pairs [strip, text].
function worded(step, plan, content) {
  const strip = plan.strips[step.strip];
  const name = (r) => ({ strip: r });
  if (step.kind === "start") {
    return {
      where: "Before you start",
      sentence: ["Cut out the strips and sort them by colour."],
      facts: [
        [null, `${many(content.strips.length, "strip")}, ${millimetres(content.width)} wide. ` +
          "This page gives them to you one at a time, and every crossing as it comes."],
        [null, "You need something to fasten crossings with: clips, tape or glue."],
        ...(plan.zones.length > 1 ? [[null, `It grows in ${plan.zones.length} zones, one beside the other: the map shows them.`]] : []),
      ],
    };
  }
  if (step.kind === "done") {
    return { where: "The end", sentence: ["It is woven."], facts: [
      [null, `${many(plan.strips.length, "strip")}, ${many(plan.crossings.length, "crossing")}.`],
    ] };
  }
  const zone = plan.zones.length > 1 ? `, zone ${step.zone + 1} of ${plan.zones.length}` : "";
  const where = `Strip ${step.number + 1} of ${plan.strips.length}${step.backbone ? ", backbone" : ""}${zone}`;
  if (step.kind === "take") {
    const later = plan.passages[step.strip].length - step.met.length;
    const partners = new Set(step.met.map((each) => each.partner));
    const facts = [[step.strip, `${millimetres(strip.length)} ${strip.closed ? "round" : "long"}, ` +
      "marked side out. Its arrow points the way you follow it."]];
    if (plan.zones.length > 1 && plan.zones[step.zone][0] === step.strip) {
      facts.push([null, `Here begins zone ${step.zone + 1}, of ${many(plan.zones[step.zone].length, "strip")}: see the map.`]);
    }
    if (content.found[step.strip]) facts.push([null, `It is on ${content.found[step.strip]}.`]);
    if (step.met.length) {
      facts.push([null, `It crosses ${many(partners.size, "strip")} that ${partners.size === 1 ? "is" : "are"} ` +
        `there already, at ${many(step.met.length, "place")}.` +
        (later ? ` ${later === 1 ? "One mark is" : `${later} marks are`} for strips that come later.` : "")]);
    } else if (step.number) {
      facts.push([null, "It meets nothing that is there yet: hold it ready, the next strips fasten it."]);
    } else {
      facts.push([null, "It is the first one: lay it down, the others are woven to it."]);
    }
    return { where, sentence: ["Take strip ", name(step.strip), "."], facts };
  }
  if (step.kind === "join") {
    const text = `${strip.label}=1`;
    return { where, sentence: ["Join the ends of ", name(step.strip), "."], facts: [
      [null, `Lay its start over the last ${millimetres(content.overlap)}, ${text} on ${text}, and fasten it there.`],
    ] };
  }
  const each = step.passage, own = each.partner === each.strip, mark = content.marks[each.mark].name;
  const side = each.angle > 0 ? "left" : "right", wide = Math.round(Math.abs(each.angle));
  const facts = [
    [each.strip, `${each.over ? "hollow" : "solid"} ${mark} with ${each.label}, at ${millimetres(each.at)}`],
    [each.partner, `${each.over ? "solid" : "hollow"} ${mark} with ${each.name}, at ${millimetres(each.away)}`],
    [null, `Along ${strip.label}, ${own ? "its other part" : plan.strips[each.partner].label} points to the ${side}, ${wide}°. ` +
      "Mark on mark, edges on the guides, fasten."],
  ];
  if (plan.fasten.has(each.crossing)) facts.push([null, "Glue or rivet it: friction alone does not hold this crossing."]);
  if (wide < 25 || wide > 155) facts.push([null, "A shallow crossing: the marks alone do not fix it, mind the angle."]);
  return {
    where: `${where}, crossing ${step.k + 1} of ${step.met.length}`,
    sentence: [each.over ? "Lay " : "Slide ", name(each.strip), { word: each.over ? "over" : "under" },
      own ? "itself" : name(each.partner), "at", { mark: each.mark, solid: !each.over, family: plan.strips[each.partner].family }],
    facts,
  };
}
