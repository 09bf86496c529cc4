"use strict";
// Which pages hold all words that are looked for; the pages' words are PAGES, a list of {address, title, text}.
(() => {
  const box = document.getElementById("search");
  const found = document.getElementById("found");
  const said = document.getElementById("said");
  const cards = [...document.querySelectorAll(".cards li")];
  const claims = [...document.querySelectorAll(".claims tbody tr")];
  const simple = (text) => text.toLowerCase().normalize("NFKD").replace(/[\u0300-\u036f]/g, "");
  const texts = new Map(PAGES.map((page) => [page.address, simple(page.title + " " + page.text)]));
  const rows = claims.map((row) => simple(row.textContent));
  const has = (text, words) => words.every((word) => text.includes(word));
  // Some words before and after the first place where one of them stands.
  const part = (page, words) => {
    const text = simple(page.text);
    const places = words.map((word) => text.indexOf(word)).filter((place) => place >= 0);
    const start = Math.max(0, Math.min(...(places.length ? places : [0])) - 60);
    return (start ? "… " : "") + page.text.slice(start, start + 200).trim() + " …";
  };
  const look = () => {
    const words = simple(box.value).split(/\s+/).filter(Boolean);
    const pages = words.length ? PAGES.filter((page) => has(texts.get(page.address), words)) : [];
    const places = new Set(pages.map((page) => page.address));
    cards.forEach((card) => {
      card.hidden = words.length > 0 && !places.has(card.querySelector("a").getAttribute("href"));
    });
    let fits = 0;
    claims.forEach((row, k) => {
      row.hidden = words.length > 0 && !has(rows[k], words);
      fits += row.hidden ? 0 : 1;
    });
    found.replaceChildren(...pages.map((page) => {
      const item = document.createElement("li");
      const link = document.createElement("a");
      link.href = page.address;
      link.textContent = page.title;
      const text = document.createElement("p");
      text.textContent = part(page, words);
      item.append(link, text);
      return item;
    }));
    const count = (number, word) => `${number} ${word}${number === 1 ? "" : "s"}`;
    said.textContent = words.length ? `${count(pages.length, "page")}, ${count(fits, "claim")}` : "";
  };
  box.addEventListener("input", look);
  box.closest("form").addEventListener("submit", (event) => event.preventDefault());
  box.closest("form").hidden = false;
  look();
})();
