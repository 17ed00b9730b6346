// Learning: control of the run, and curves that the studio draws. No chart is made here.
import { ask } from './link.js';
import { download } from './keep.js';

const $ = id => document.getElementById(id);
const CHARTS = ['cost', 'looks', 'accidents', 'histogram', 'belief', 'sizes'];
const REFRESH_MS = 1500;
let world = null, chosen = '', status = null, busy = false;

export function begin(w) {
  world = w;
  $('train').onclick = () => ask('train', { demonstrations: $('from-person').checked });
  $('hold').onclick = () => ask(status?.training?.state === 'paused' ? 'resume_training' : 'pause_training');
  $('stop').onclick = () => ask('stop_training');
  $('view-training').onclick = () => ask('view_training', { on: status?.view !== 'training' });
  $('pace').onchange = () => ask('pace', { steps_per_sec: Number($('pace').value) });
  $('phase').add(new Option('the one that learns now', ''));
  for (const phase of world.phases) $('phase').add(new Option(phase.name.replaceAll('_', ' '), phase.name));
  $('phase').onchange = () => { chosen = $('phase').value; refresh(); };
  $('charts').append(...CHARTS.map(card));
  setInterval(refresh, REFRESH_MS);
}

function card(name) {
  const made = document.createElement('section');
  made.className = 'card';
  made.innerHTML = `<div class="chart-of" id="chart-${name}"><p class="note">${name}: nothing to draw yet; press Train.</p></div><button class="take" title="Save this chart">SVG</button>`;
  made.querySelector('.take').onclick = () => download(address(name, true), `metal-${name}.svg`);
  if (name === 'belief') made.prepend(beliefChoice());
  return made;
}

function beliefChoice() {
  const row = document.createElement('div');
  row.className = 'row';
  const select = (id, label) => `<label>${label} <select id="belief-${id}"></select></label>`;
  row.innerHTML = select('member', 'Tiny agent') + select('x', 'across') + select('y', 'up');
  const tiny = world.members.map((m, i) => [m, i]).filter(([m]) => m.sensors.length === 1);
  const [member, x, y] = row.querySelectorAll('select');
  tiny.forEach(([m, i]) => member.add(new Option(m.name, i)));
  member.onchange = () => {
    const { features } = world.sensors[world.members[member.value].sensors[0]];
    for (const axis of [x, y]) axis.replaceChildren(...features.map((name, i) => new Option(name, i)));
    [x.value, y.value] = ['0', '2'];
    refresh();
  };
  for (const axis of [x, y]) axis.onchange = refresh;
  queueMicrotask(() => member.onchange());
  return row;
}

function address(name, file) {
  const wishes = new URLSearchParams(chosen ? { phase: chosen } : {});
  if (name === 'belief') for (const key of ['member', 'x', 'y']) wishes.set(key, $(`belief-${key}`).value);
  if (file) wishes.set('file', '1');
  return `draw/${name}?${wishes}`;
}

/** Asks for every chart again while the view is open. */
export async function refresh() {
  if (busy || $('curves').hidden || !status?.training) return;
  busy = true;
  try {
    for (const name of CHARTS) {
      const answer = await fetch(address(name, false));
      if (answer.ok) $(`chart-${name}`).innerHTML = await answer.text();
    }
  } catch { /* The connection is lost; the banner says so. */ } finally { busy = false; }
}

export function show(news) {
  status = news;
  const state = news.training?.state, alive = state === 'running' || state === 'paused';
  $('train').disabled = alive;
  $('train').textContent = news.training && !alive ? 'Train again' : 'Train';
  $('hold').disabled = $('stop').disabled = $('view-training').disabled = !alive;
  $('hold').textContent = state === 'paused' ? 'Resume' : 'Pause';
  $('view-training').setAttribute('aria-pressed', String(news.view === 'training'));
  $('from-person').disabled = !news.saved || alive;
  if (!news.training) return;
  const { phase, phases, episode, error } = news.training.progress;
  $('training-note').textContent = error ?? `${state}: ${phase.replaceAll('_', ' ')}, episode ${episode}`;
  $('phases').replaceChildren(...phases.map(([name, share]) => {
    const item = document.createElement('li');
    item.className = name === phase && alive ? 'now' : '';
    item.innerHTML = '<span></span><span class="bar"><i></i></span>';
    item.firstChild.textContent = `${name.replaceAll('_', ' ')} ${Math.round(100 * share)} %`;
    item.querySelector('i').style.width = `${100 * share}%`;
    return item;
  }));
}
