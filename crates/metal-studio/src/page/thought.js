// What the mind was told and what it expected: looks with their price ticking up, supports, nulls, values.

const number = (value, digits = 2) => value.toFixed(digits).replace('-', '−');
const element = (tag, name, text) => {
  const made = document.createElement(tag);
  if (name) made.className = name;
  if (text !== undefined) made.textContent = text;
  return made;
};

/** The looks in their order, as far as they are revealed, and what they cost together. */
export function drawLooks(list, world, lane, count) {
  let sum = 0;
  const items = lane.asked.slice(0, count).map((member, i) => {
    sum += lane.prices[i];
    const item = element('li');
    item.append(element('b', '', i + 1), `${world.members[member].name} ${number(lane.prices[i], 1)}`);
    return item;
  });
  if (!lane.asked.length) items.push(element('li', 'sum', 'no look'));
  else items.push(element('li', 'sum', `price ${number(Math.min(sum, lane.look_price || 0), 1)}`));
  list.replaceChildren(...items);
}

/** One row per tiny agent; whoever else was asked gets a row, too. */
export function drawSupports(table, world, lane, count) {
  const asked = lane.asked.slice(0, count);
  const tiny = world.members.map((m, i) => [m, i]).filter(([m, i]) => m.sensors.length === 1 || lane.asked.includes(i));
  const head = element('tr');
  head.append(element('th'));
  const decided = count >= lane.asked.length;
  world.actions.forEach((action, a) => head.append(element('th', decided && a === lane.action ? 'chosen' : '', (decided && a === lane.action ? '▸ ' : '') + action)));
  const rows = tiny.map(([member, i]) => {
    const order = asked.indexOf(i);
    const row = element('tr', order < 0 ? 'null' : '');
    const name = element('th');
    name.scope = 'row';
    name.append(order < 0 ? element('span', 'none') : element('span', 'badge', order + 1), member.name);
    row.append(name);
    const support = order < 0 ? null : lane.opinions[i]?.support;
    const best = support ? support.indexOf(Math.max(...support)) : -1;
    world.actions.forEach((_, a) => row.append(supportCell(support, a, a === best)));
    return row;
  });
  const thead = element('thead'), tbody = element('tbody');
  thead.append(head);
  tbody.append(...rows);
  table.replaceChildren(table.caption, thead, tbody);
}

function supportCell(support, action, best) {
  const cell = element('td', best ? 'best' : '');
  if (!support) {
    cell.textContent = '∅';
    cell.setAttribute('aria-label', 'null');
    return cell;
  }
  const bar = element('i');
  bar.style.width = `${100 * support[action]}%`;
  cell.append(bar, element('span', '', support[action].toFixed(2)));
  return cell;
}

/** Values of acting against values of looking, before the look or the move that comes now. */
export function drawValues(box, note, world, lane, count) {
  const values = lane.values[Math.min(count, lane.values.length - 1)];
  if (values?.length === 0) {
    note.textContent = '';
    box.replaceChildren(element('p', 'note', 'Nothing is weighed here: this choice was left to chance, or everything is looked at.'));
    return;
  }
  if (!values) {
    note.textContent = '';
    box.replaceChildren(element('p', 'note', 'This driver weighs no looks: only attention control has values of looking and acting.'));
    return;
  }
  const looks = lookMembers(world, values.length - world.actions.length);
  const last = count >= lane.asked.length;
  note.textContent = last ? 'before the move' : `before look ${count + 1}`;
  const taken = last ? lane.action : world.actions.length + looks.indexOf(lane.asked[count]);
  const open = i => i < world.actions.length || !lane.asked.slice(0, count).includes(looks[i - world.actions.length]);
  const range = [Math.min(...values), Math.max(...values)];
  const row = (name, i) => valueRow(name, values[i], { range, taken: i === taken, shut: !open(i) });
  box.replaceChildren(
    valueColumn('Act …', 'act', world.actions.map((name, i) => row(name, i))),
    valueColumn('Look at …', 'look', looks.map((m, i) => row(world.members[m].name, world.actions.length + i))),
  );
}

/** Attention control looks at tiny agents, in the order of the experiment. */
function lookMembers(world, count) {
  const tiny = world.members.map((m, i) => [m, i]).filter(([m]) => m.sensors.length === 1).map(([, i]) => i);
  return tiny.slice(0, count);
}

function valueColumn(title, name, rows) {
  const column = element('div', name), list = element('ol');
  list.append(...rows);
  column.append(element('h3', '', title), list);
  return column;
}

function valueRow(name, value, { range: [low, high], taken, shut }) {
  const row = element('li', `${taken ? 'taken' : ''} ${shut ? 'shut' : ''}`);
  const bar = element('span', 'bar'), fill = element('i');
  fill.style.width = `${high > low ? 4 + 96 * (value - low) / (high - low) : 50}%`;
  bar.append(fill);
  row.append(element('span', '', taken ? '▸' : ''), element('span', '', name), bar, element('span', 'number', number(value, 1)));
  if (shut) row.firstChild.textContent = '✓';
  if (shut) row.title = 'was asked already';
  return row;
}
