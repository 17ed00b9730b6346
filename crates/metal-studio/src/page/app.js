// The page: takes in what the studio tells and lets every part draw itself.
import { ask, connect, on, stats } from './link.js';
import { Road } from './road.js';
import { Eye } from './eye.js';
import { drawLooks, drawSupports, drawValues } from './thought.js';
import * as wheel from './wheel.js';
import * as explore from './explore.js';
import * as curves from './curves.js';
import * as keep from './keep.js';

const $ = id => document.getElementById(id);
const still = matchMedia('(prefers-reduced-motion: reduce)');
/** Share of a motor step in which its looks are shown one after the other. */
const THINKING = 0.6;
/** Steps shorter than this show all their looks at once. */
const BRIEF_SECS = 0.12;

const world = await (await fetch('world.json')).json();
const timeline = new explore.Timeline();
let me = 0, status = null, frame = null, began = 0, drawn = '', past = false, said = 0;
let lanes = [];

$('title').textContent = world.title;
wheel.begin(world);
explore.begin(world);
curves.begin(world);
keep.begin(complain);

/** Says something to the person for a while. */
function complain(text) {
  $('notice').hidden = !text;
  $('notice').textContent = text ?? '';
  clearTimeout(said);
  said = setTimeout(() => { $('notice').hidden = true; }, 6000);
}

const kilo = bytes => `${(bytes / 1000).toFixed(1)} kB`;

function build(count) {
  if (lanes.length === count) return;
  lanes = Array.from({ length: count }, (_, i) => ({ road: new Road(world, i), eye: new Eye(world) }));
  $('lanes').replaceChildren(...lanes.map(lane => lane.road.figure));
  $('lanes').dataset.count = count;
  $('eyes').replaceChildren(...lanes.map(lane => lane.eye.figure));
}

function take(news) {
  build(news.lanes.length);
  [frame, began, drawn] = [news, performance.now(), ''];
  lanes.forEach(lane => lane.road.show(news, news.past ? 0 : Math.min(news.secs, 2)));
  const [lane] = news.lanes, action = world.actions[lane.action];
  const cost = value => value.toFixed(2).replace('-', '−');
  const advice = lane.advice !== null && lane.advice !== lane.action ? ` (expert: ${world.actions[lane.advice]})` : '';
  $('facts').textContent = news.done ? `step ${news.step + 1} · ${action}${advice} · motor ${cost(lane.motor)}`
    : `would: ${action}`;
  if (lane.link) $('facts').textContent += ` · link ${kilo(lane.link.bytes)}, saved ${kilo(lane.link.saved_bytes)}`;
}

/** How many looks of the decision are shown by now. */
function revealed() {
  const all = frame.lanes[0].asked.length;
  if (still.matches || frame.past || !frame.done || frame.secs < BRIEF_SECS || frame.source === 'demonstration') return all;
  const share = (performance.now() - began) / (1000 * frame.secs * THINKING);
  return Math.min(all, Math.floor(share * (all + 1)));
}

function paint() {
  requestAnimationFrame(paint);
  if (!frame || $('stage').hidden) return;
  lanes.forEach(lane => lane.road.draw());
  const count = revealed(), unseen = $('unseen').checked;
  const key = `${count} ${unseen} ${$('eyes').clientWidth} ${document.documentElement.dataset.theme} ${status?.faults}`;
  if (key === drawn) return;
  drawn = key;
  const faults = status?.faults ?? [];
  lanes.forEach((lane, i) => lane.eye.draw(frame.lanes[i], { count: i ? Infinity : count, unseen, faults, named: lanes.length > 1 }));
  drawLooks($('looks'), world, frame.lanes[0], count);
  drawSupports($('supports'), world, frame.lanes[0], count);
  drawValues($('values'), $('moment'), world, frame.lanes[0], count);
  stats.drawn += 1;
}

function toNow() {
  past = false;
  delete $('scrub').dataset.past;
  $('now').hidden = true;
  $('where').textContent = 'every decision; slide to see one again';
  if (status) $('scrub').value = status.span[1];
}

on('hello', news => { me = news.you; });
on('frame', news => { if (!past) take(news); });
on('past', news => {
  if (!news) return;
  past = true;
  $('scrub').dataset.past = '1';
  $('now').hidden = false;
  $('where').textContent = `decision ${news.n}, ${news.lanes[0].driver}`;
  take({ ...news, past: true });
});
on('refused', complain);
on('link', up => {
  $('connection').dataset.state = up ? 'live' : 'waiting';
  $('connection').textContent = up ? 'live' : 'waiting';
  $('lost').hidden = up;
});
on('status', news => {
  status = news;
  drawn = '';
  document.body.dataset.view = news.view;
  const mine = news.wheel === me;
  const others = news.pages - 1;
  $('wheel').textContent = mine ? 'You hold the wheel' : news.wheel ? 'Watching' : 'Take the wheel of the page';
  $('wheel').title = `${others} other page${others === 1 ? '' : 's'} open; click to ${mine ? 'let go' : 'take the wheel'}`;
  $('wheel').onclick = () => ask(mine ? 'release_wheel' : 'take_wheel');
  if (news.notice) complain(news.notice);
  wheel.show(news, mine);
  explore.show(world, news);
  curves.show(news);
});
setInterval(() => { if (status && !$('stage').hidden) timeline.refresh(status.span).catch(() => {}); }, 600);
addEventListener('now', toNow);
addEventListener('resize', () => { drawn = ''; });

const tabs = [$('tab-stage'), $('tab-curves')];
function open(tab) {
  for (const other of tabs) {
    const chosen = other === tab;
    other.setAttribute('aria-selected', String(chosen));
    other.tabIndex = chosen ? 0 : -1;
    $(other.getAttribute('aria-controls')).hidden = !chosen;
  }
  curves.refresh();
}
tabs.forEach((tab, i) => {
  tab.onclick = () => open(tab);
  tab.onkeydown = event => {
    if (event.key !== 'ArrowRight' && event.key !== 'ArrowLeft') return;
    tabs[1 - i].focus();
    open(tabs[1 - i]);
  };
});
$('theme').onclick = () => {
  const root = document.documentElement;
  const dark = root.dataset.theme ? root.dataset.theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
  root.dataset.theme = dark ? 'light' : 'dark';
  drawn = '';
};
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { drawn = ''; });
// For tests and the curious: where a car is on the screen.
window.studio.where = body => lanes[0].road.where(body);
window.studio.status = () => status;
window.studio.frame = () => frame;
connect();
requestAnimationFrame(paint);
