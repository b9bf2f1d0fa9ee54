// The tabs, the colour theme and printing.

const DRAW = { errors: drawErrors, shapes: drawShapes, mac: drawMac, frf: drawFrf, poles: drawPoles, circles: drawCircles, energies: drawEnergies, update: drawUpdate, speed: drawSpeed, maps: drawMaps, precision: drawPrecision };

/** Whether the page has been painted; figures come after it. */
let painted = false;

/** Draws the figures of a part of the page, once. */
function drawIn(part) {
  readData();
  for (const host of part.querySelectorAll('[data-draw]')) {
    const draw = DRAW[host.dataset.draw];
    delete host.dataset.draw;
    host.removeAttribute('data-draw');
    if (draw) draw(host);
  }
}

const sections = [...document.querySelectorAll('main > section')];
const tabs = [...document.querySelectorAll('nav [role=tab]')];

/** Scrolls the row of tabs only if the tab is not fully visible. */
function reveal(tab) {
  const row = tab.parentNode;
  const seen = tab.offsetLeft >= row.scrollLeft && tab.offsetLeft + tab.offsetWidth <= row.scrollLeft + row.clientWidth;
  if (!seen) row.scrollLeft = Math.max(0, tab.offsetLeft - 60);
}

function showTab(id, focus = false) {
  const wanted = sections.find((section) => section.id === id) || sections[0];
  for (const section of sections) section.hidden = section !== wanted;
  for (const tab of tabs) {
    const on = tab.hash === `#${wanted.id}`;
    tab.setAttribute('aria-selected', String(on));
    tab.tabIndex = on ? 0 : -1;
    if (on && focus) tab.focus();
    if (on) reveal(tab);
  }
  tip.hide();
  if (painted) drawIn(wanted);
}

function setTheme(name) {
  document.documentElement.dataset.theme = name;
  palette = PALETTES[name];
  redrawAll();
}

function start() {
  document.documentElement.classList.add('js');
  const dark = matchMedia('(prefers-color-scheme: dark)');
  setTheme(dark.matches ? 'dark' : 'light');
  dark.addEventListener('change', () => setTheme(dark.matches ? 'dark' : 'light'));
  document.getElementById('theme').addEventListener('click', () => setTheme(palette === PALETTES.dark ? 'light' : 'dark'));
  for (const tab of tabs) {
    tab.addEventListener('click', (event) => {
      event.preventDefault();
      history.replaceState(null, '', tab.hash);
      showTab(tab.hash.slice(1));
    });
    tab.addEventListener('keydown', (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
      if (!step) return;
      event.preventDefault();
      const next = tabs[(tabs.indexOf(tab) + step + tabs.length) % tabs.length];
      showTab(next.hash.slice(1), true);
    });
  }
  addEventListener('hashchange', () => showTab(location.hash.slice(1)));
  let waiting = null;
  addEventListener('resize', () => {
    clearTimeout(waiting);
    waiting = setTimeout(redrawAll, 120);
  });
  let before = null;
  let opened = [];
  addEventListener('beforeprint', () => {
    before = palette === PALETTES.dark ? 'dark' : 'light';
    document.documentElement.classList.add('printing');
    for (const section of sections) section.hidden = false;
    opened = [...document.querySelectorAll('details.notes:not([open]), .codes details:not([open])')];
    for (const element of opened) element.open = true;
    sections.forEach(drawIn);
    setTheme('light');
  });
  addEventListener('afterprint', () => {
    document.documentElement.classList.remove('printing');
    setTheme(before || 'light');
    for (const element of opened) element.open = false;
    showTab(location.hash.slice(1));
  });
  showTab(location.hash.slice(1));
  requestAnimationFrame(() => setTimeout(() => {
    painted = true;
    showTab(location.hash.slice(1));
  }));
}

start();
