// Who drives where, the situations of Table 1, failing sensors, and the timeline of past decisions.
import { ask } from './link.js';

const $ = id => document.getElementById(id);
const SCENARIOS = { mix: 'mix of all', free_road: 'free road', approaching: 'a car approaches', from_behind: 'nearing a car' };
const SHOWN = 240;
let drawn = '';

export function begin(world) {
  $('driver').onchange = () => ask('watch', { driver: Number($('driver').value) });
  $('rival').onchange = () => ask('compare', { driver: $('rival').value === '' ? null : Number($('rival').value) });
  $('scenario').onchange = () => ask('scenario', { name: $('scenario').value });
  world.sensors.forEach((sensor, i) => $('faults').append(faultChoice(sensor.name, i)));
  $('scrub').oninput = () => ask('recall', { decision: Number($('scrub').value) });
  $('now').onclick = () => dispatchEvent(new Event('now'));
}

function faultChoice(name, sensor) {
  const label = document.createElement('label'), select = document.createElement('select');
  for (const [value, text] of [['fine', 'fine'], ['off', 'off'], ['blind', 'blind'], ['noisy', 'noisy']]) select.add(new Option(text, value));
  select.onchange = () => ask('fault', { sensor, fault: select.value });
  label.append(name, select);
  return label;
}

/** Fills a list of choices, only when it changed: an open list must not jump. */
function fill(select, options, value) {
  const key = JSON.stringify(options);
  if (select.dataset.key !== key) {
    select.replaceChildren(...options.map(([text, v]) => new Option(text, v)));
    select.dataset.key = key;
  }
  if (document.activeElement !== select || select.value !== String(value)) select.value = value;
}

export function show(world, status) {
  const drivers = status.drivers.map((label, i) => [label, i]);
  fill($('driver'), drivers, status.at_the_wheel[0]);
  fill($('rival'), [['nobody', ''], ...drivers], status.at_the_wheel[1] ?? '');
  fill($('scenario'), status.scenarios.map(name => [SCENARIOS[name] ?? name, name]), status.scenario);
  status.faults.forEach((fault, i) => {
    const label = $('faults').children[i];
    label.querySelector('select').value = fault;
    label.classList.toggle('broken', fault !== 'fine');
  });
  showScenes(world, status);
}

function showScenes(world, status) {
  const key = JSON.stringify([status.situations, status.scene]);
  if (key === drawn) return;
  drawn = key;
  const focused = [...$('scenes').querySelectorAll('button')].indexOf(document.activeElement);
  $('scenes').replaceChildren(...status.situations.map((scene, index) => {
    const item = document.createElement('li'), button = document.createElement('button'), small = document.createElement('small');
    const ours = scene.ours.map(m => world.members[m].name).join(' ') || 'no look';
    small.append(`ours ${ours}`, document.createElement('br'), `paper ${scene.paper.join(' ')}`);
    button.append(scene.name, small);
    button.setAttribute('aria-pressed', String(status.scene === index));
    button.onclick = () => ask('scene', { index });
    item.append(button);
    return item;
  }));
  if (focused >= 0) $('scenes').querySelectorAll('button')[focused]?.focus();
}

/** Draws the strip again if there is something new. */
export class Timeline {
  constructor() { [this.last, this.busy] = [0, false]; }

  async refresh([first, last]) {
    const width = Math.round($('timeline').clientWidth);
    if (this.busy || !last || last === this.last && first === this.first && width === this.width) return;
    this.busy = true;
    try {
      const answer = await fetch(`draw/timeline?width=${width}`);
      if (answer.ok) $('timeline').innerHTML = await answer.text();
      [this.first, this.last, this.width] = [first, last, width];
    } finally { this.busy = false; }
    const scrub = $('scrub'), from = Math.max(first, last - SHOWN + 1);
    // The slider lies over a strip of fixed pitch, however few decisions there are yet.
    [scrub.min, scrub.max] = [from, from + SHOWN - 1];
    if (!scrub.dataset.past) scrub.value = last;
  }
}
