"use strict";
// The questionnaire. Nothing leaves this page but by the participant's own download.
const data = JSON.parse(document.getElementById("data").textContent);
const main = document.getElementById("main");
const STORE = "doro-study-" + data.study.digest;
const ANSWERS = { schema: "doro.study.answers", version: 1 };
const SCALES = {
  informative: {
    question: "How informative is what the robot says?",
    hint: "Does it tell you what you need to know to answer, no less and nothing wrong?",
    ends: ["not informative at all", "fully informative"],
  },
  natural: {
    question: "How natural is what the robot says?",
    hint: "Would a person say it like this? Only how it is said, not whether it is right.",
    ends: ["not natural at all", "fully natural"],
  },
};

// ---- order: the same for the same participant and study, another for everybody else
function hash(text) { // FNV-1a, 32 bits
  let value = 0x811c9dc5;
  for (const byte of new TextEncoder().encode(text)) value = Math.imul(value ^ byte, 0x01000193);
  return value >>> 0;
}
function random(seed) { // mulberry32
  return () => {
    seed = (seed + 0x6d2b79f5) | 0;
    let t = Math.imul(seed ^ (seed >>> 15), 1 | seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    return ((t ^ (t >>> 14)) >>> 0) / 4294967296;
  };
}
function shuffled(list, next) {
  const out = list.slice();
  for (let i = out.length - 1; i > 0; i--) {
    const j = Math.floor(next() * (i + 1));
    [out[i], out[j]] = [out[j], out[i]];
  }
  return out;
}
function planOf(participant) {
  const seed = hash(data.study.digest + "|" + participant);
  const next = random(seed);
  let pages = [];
  if (data.design === "one") {
    // The texts of a scene stand in turns: every participant rates every system equally often.
    data.items.forEach((item) => pages.push({ item, unit: item.units[seed % item.units.length] }));
    pages = shuffled(pages, next);
  } else {
    // A round for each text of a scene: texts of one scene are never close together.
    const rounds = Math.max(...data.items.map((item) => item.units.length));
    const orders = data.items.map((item) => shuffled(item.units, next));
    for (let r = 0; r < rounds; r++) {
      const round = data.items.map((item, k) => ({ item, unit: orders[k][r] })).filter((page) => page.unit);
      pages.push(...shuffled(round, next));
    }
  }
  // Checks stand at even distances inside, never first.
  const total = pages.length;
  data.checks.forEach((check, k) => {
    pages.splice(Math.ceil((total * (k + 1)) / (data.checks.length + 1)) + k, 0, { check });
  });
  return pages;
}
const keyOf = (page) => (page.check ? page.check.id : page.unit.id);

// ---- what is kept in the browser
let state = { participant: "", consent: false, started: "", finished: null, at: -1, given: {} };
let keeps = true;
function save() {
  try { localStorage.setItem(STORE, JSON.stringify(state)); } catch (error) { keeps = false; }
}
function load() {
  try {
    const kept = JSON.parse(localStorage.getItem(STORE));
    if (kept && kept.given && kept.participant) state = kept;
  } catch (error) { keeps = false; }
}

// ---- small helpers; text is always set as text
function make(tag, properties = {}, ...children) {
  const node = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in node) node[name] = value; else node.setAttribute(name, value);
  }
  node.append(...children);
  return node;
}
function show(title, ...children) {
  const heading = make("h1", { tabIndex: -1 }, title);
  main.replaceChildren(heading, ...children);
  window.scrollTo(0, 0);
  heading.focus({ preventScroll: true });
  document.title = title + " – What a robot asks";
}
const say = (text) => { document.getElementById("status").textContent = text; };
const errorLine = () => make("p", { className: "error", role: "alert" });
function button(text, action, isMain = false) {
  return make("button", { type: "button", className: isMain ? "main" : "", onclick: action }, text);
}
function letters(list) {
  const nodes = [];
  list.forEach((letter, k) => {
    if (k > 0) nodes.push(k === list.length - 1 ? " or " : ", ");
    nodes.push(make("span", { className: "letter" }, letter));
  });
  return nodes;
}

// ---- pages
function welcome() {
  document.getElementById("progress").hidden = true;
  const fresh = "p-" + [...crypto.getRandomValues(new Uint8Array(4))].map((b) => b.toString(16).padStart(2, "0")).join("");
  const wanted = new URLSearchParams(location.search).get("p");
  const name = make("input", { type: "text", id: "participant", maxLength: 40, autocomplete: "off", value: state.participant || wanted || fresh });
  const tick = make("input", { type: "checkbox", id: "consent", checked: state.consent });
  const error = errorLine();
  const count = planOf("count").length;
  const start = () => {
    if (!name.value.trim()) { error.textContent = "Please give an id, for example the one that was proposed."; name.focus(); return; }
    if (!tick.checked) { error.textContent = "Please tick the box if you agree to take part."; tick.focus(); return; }
    if (state.participant !== name.value.trim()) state = { participant: name.value.trim(), given: {}, at: 0, finished: null, started: new Date().toISOString() };
    state.consent = true;
    state.at = Math.max(0, state.at);
    save();
    next();
  };
  show("Thank you for helping",
    make("p", {}, `A person asks a robot for a thing in a room. The robot has looked around and says something back: it asks, or it confirms. In ${count} short pages you tell us how good that is.`),
    make("p", {}, "On each page you see pictures of the room. Things that may be meant have letters, and yellow is the one that you want. The letters are for you alone: the robot does not know them, so please do not use them when you answer."),
    make("p", {}, "It takes about a minute a page. You can stop at any time; this browser keeps your place."),
    make("div", { className: "field" }, make("label", { htmlFor: "participant" }, "Your id"),
      make("p", { className: "hint" }, "No name, please. It only keeps your answers together."), name),
    make("label", { className: "tick", htmlFor: "consent" }, tick,
      make("span", {}, "I take part of my own will and am 18 or older. My ratings and answers, under this id and with the time they took, may be evaluated and published. Nothing is sent from this page: at the end I download a file and pass it on myself, or not.")),
    error, make("div", { className: "bar" }, button("Start", start, true)));
}

function scale(kind, value) {
  const about = SCALES[kind];
  const hint = `${kind}-hint`;
  const row = make("div", { className: "scale" });
  for (let number = 1; number <= 5; number++) {
    const input = make("input", { type: "radio", name: kind, value: String(number), checked: value === number });
    const end = number === 1 ? about.ends[0] : number === 5 ? about.ends[1] : "";
    if (end) input.setAttribute("aria-label", `${number}, ${end}`);
    row.append(make("label", {}, input, String(number)));
  }
  const set = make("fieldset", {}, make("legend", {}, about.question), make("p", { className: "hint", id: hint }, about.hint), row,
    make("p", { className: "ends", "aria-hidden": "true" }, make("span", {}, "1: " + about.ends[0]), make("span", {}, "5: " + about.ends[1])));
  set.setAttribute("aria-describedby", hint);
  return set;
}
function chosen(kind) {
  const input = main.querySelector(`input[name="${kind}"]:checked`);
  return input ? Number(input.value) : 0;
}
function pictures(item) {
  const list = make("ul", { className: "pictures" });
  item.pictures.forEach((picture, k) => {
    const marked = picture.letters.length ? ": " + picture.letters.join(", ") : "";
    const text = picture.plan ? "From above" + marked : `View ${k + 1}` + marked;
    const image = make("img", { src: picture.source, alt: (picture.plan ? "Plan of the room from above" : `View ${k + 1} of the room`) + (marked ? ", marked" + marked : ""), width: 480, height: 480 });
    const open = () => {
      const large = document.getElementById("large-image");
      large.src = picture.source;
      large.alt = image.alt;
      document.getElementById("large").showModal();
    };
    list.append(make("li", {}, make("button", { type: "button", onclick: open, title: "Enlarge" }, image, make("span", {}, text))));
  });
  return list;
}
function wish(item) {
  if (!item.letters.length) return make("p", { className: "wish" }, "These pictures show most of the room. See for yourself whether there is what the person wants.");
  const line = make("p", { className: "wish" });
  if (item.wanted.length) {
    line.append("You want ", ...letters(item.wanted), item.wanted.length > 1 ? " (either is fine)." : ".");
    const others = item.letters.filter((letter) => !item.wanted.includes(letter));
    if (others.length) line.append(` Also there: ${others.join(", ")}.`);
  }
  return line;
}

function scenePage(page, entry, began) {
  const { item, unit } = page;
  const reply = make("input", { type: "text", id: "reply", maxLength: 300, autocomplete: "off", value: entry.reply || "" });
  const lost = make("input", { type: "checkbox", id: "lost", checked: Boolean(entry.cannot_tell) });
  const read = () => ({
    item: item.id, unit: unit.id, informative: chosen("informative"), natural: chosen("natural"),
    reply: reply.value.trim(), cannot_tell: lost.checked && !reply.value.trim(),
    seconds: Math.round(((entry.seconds || 0) + (Date.now() - began) / 1000) * 10) / 10,
  });
  const check = () => (item.wanted.length && !reply.value.trim() && !lost.checked ? ["Please write what you would answer, or tick the box below it.", reply] : null);
  const hint = item.wanted.length ? "In your own words, without the letters, so that you get what you want." : "In your own words; you may leave it empty.";
  const rest = [scale("informative", entry.informative), scale("natural", entry.natural),
    make("div", { className: "field" }, make("label", { htmlFor: "reply" }, "What would you answer?"), make("p", { className: "hint" }, hint), reply,
      ...(item.wanted.length ? [make("label", { className: "tick", htmlFor: "lost" }, lost, make("span", {}, "I cannot tell what to answer"))] : []))];
  const said = (who, name, text) => make("div", { className: "talk" }, make("p", { className: who }, make("b", {}, name), "“" + text + "”"));
  const body = [said("person", "You say", item.instruction), wish(item), pictures(item), said("robot", "The robot says", unit.text), ...rest];
  return { title: `Page ${state.at + 1}`, body, read, check };
}
function checkPage(page, entry) {
  const text = `This page shows that somebody is reading. Please choose ${page.check.informative} for informative and ${page.check.natural} for natural.`;
  const read = () => ({ id: page.check.id, informative: chosen("informative"), natural: chosen("natural") });
  return { title: `Page ${state.at + 1}`, body: [make("p", { className: "wish" }, text), scale("informative", entry.informative), scale("natural", entry.natural)], read, check: () => null };
}

function next() {
  const pages = planOf(state.participant);
  if (state.at >= pages.length) { end(pages); return; }
  const page = pages[state.at];
  const key = keyOf(page);
  const view = (page.check ? checkPage : scenePage)(page, state.given[key] || {}, Date.now());
  const error = errorLine();
  const keep = () => { state.given[key] = view.read(); save(); };
  const go = () => {
    const missing = ["informative", "natural"].find((kind) => !chosen(kind));
    const problem = missing ? [`Please rate how ${missing} it is.`, main.querySelector(`input[name="${missing}"]`)] : view.check();
    if (problem) { error.textContent = problem[0]; problem[1].focus(); return; }
    keep();
    state.at += 1;
    save();
    next();
  };
  const back = () => { keep(); state.at -= 1; save(); next(); };
  document.getElementById("progress").hidden = false;
  document.getElementById("progress-text").textContent = `${state.at + 1} of ${pages.length}`;
  const bar = document.getElementById("bar");
  bar.max = pages.length;
  bar.value = state.at;
  const buttons = [button(state.at + 1 === pages.length ? "Finish" : "Next", go, true)];
  if (state.at > 0) buttons.push(button("Back", back));
  const form = make("form", { onsubmit: (event) => { event.preventDefault(); go(); } }, ...view.body, error, make("div", { className: "bar" }, ...buttons));
  form.addEventListener("input", () => { state.given[key] = view.read(); save(); });
  show(view.title, form);
  say(`Page ${state.at + 1} of ${pages.length}`);
}

function answersOf(pages) {
  const rated = pages.filter((page) => page.unit);
  return {
    ...ANSWERS, study: data.study, participant: state.participant, consent: state.consent,
    started: state.started, finished: state.finished,
    answers: rated.map((page, position) => ({ ...state.given[page.unit.id], position })),
    checks: pages.filter((page) => page.check).map((page) => state.given[page.check.id]),
  };
}
function end(pages) {
  if (!state.finished) { state.finished = new Date().toISOString(); save(); }
  document.getElementById("bar").value = pages.length;
  document.getElementById("progress-text").textContent = "done";
  const text = JSON.stringify(answersOf(pages), null, 1);
  const file = `${data.study.id}-${state.participant.replace(/[^A-Za-z0-9_-]+/g, "_")}.json`;
  const download = () => {
    const link = make("a", { href: URL.createObjectURL(new Blob([text], { type: "application/json" })), download: file });
    document.body.append(link);
    link.click();
    link.remove();
    said.textContent = `${file} is in your downloads. Please send it to whoever gave you this questionnaire.`;
  };
  const said = make("p", { role: "status" });
  const back = () => { state.at = pages.length - 1; state.finished = null; save(); next(); };
  show("That was all, thank you",
    make("p", {}, "Download your answers and send the file to whoever gave you this questionnaire. Nothing was sent from this page."),
    ...(keeps ? [] : [make("p", { className: "error" }, "This browser keeps nothing for this page: please download before you close it.")]),
    make("div", { className: "bar" }, button("Download my answers", download, true), button("Back", back)), said);
  say("Finished");
}

document.getElementById("close").onclick = () => document.getElementById("large").close();
load();
// "next" looks for the page where the participant was; a new one begins with the consent.
if (state.consent && state.at >= 0) next(); else welcome();
