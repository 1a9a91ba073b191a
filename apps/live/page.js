'use strict';
const at = id => document.getElementById(id);
const say = (id, text, kind = '') => {
  const element = at(id);
  if (element.textContent !== text) element.textContent = text;
  element.className = (element.className.match(/pill|verdict/) || [''])[0] + ' ' + kind;
};
const list = (id, texts) => at(id).replaceChildren(...texts.map(text => {
  const item = document.createElement('li');
  item.textContent = text;
  return item;
}));
let state = null, tick = null, ended = false;

// Numbers
const digits = sigma => Math.min(8, Math.max(0, 1 - Math.floor(Math.log10(sigma))));
const number = (value, sigma) => sigma > 0 && isFinite(sigma)
  ? `${value.toFixed(digits(sigma))} \u00b1 ${sigma.toFixed(digits(sigma))}` : value.toPrecision(4);
function numbers(theta) {
  const degrees = 180 / Math.PI, rows = [];
  const three = (name, values, sigmas, unit, scale = 1) => values.forEach((v, i) =>
    rows.push([i ? '' : name, 'xyz'[i], number(scale * v, scale * sigmas[i]), unit]));
  theta.magnetometers.forEach((m, i) => three(theta.magnetometers.length > 1
    ? `Hard iron, ${m.name}` : 'Hard iron', m.bias, m.bias_sigma, '\u00b5T'));
  rows.push(['Field strength', '', number(theta.field.strength_uT, theta.field.strength_uT_sigma), '\u00b5T']);
  rows.push(['Field dip', '', number(theta.field.dip_deg, theta.field.dip_deg_sigma), '\u00b0']);
  three('Gyroscope bias', theta.gyroscope.bias, theta.gyroscope.bias_sigma, '\u00b0/s', degrees);
  three('Accelerometer bias', theta.accelerometer.bias, theta.accelerometer.bias_sigma, 'm/s\u00b2');
  at('numbers').replaceChildren(...rows.map(row => {
    const line = document.createElement('tr');
    row.forEach((text, i) => {
      const cell = line.insertCell();
      cell.textContent = text;
      if (i === 2) cell.className = 'n';
    });
    return line;
  }));
}
function targets(all) {
  at('targets').replaceChildren(...all.map(t => {
    const known = t.sigma !== null, met = known && t.sigma <= t.limit;
    const box = document.createElement('div'), text = document.createElement('div');
    const name = document.createElement('span'), value = document.createElement('span');
    box.className = 'target';
    name.textContent = t.name;
    value.textContent = known
      ? `\u00b1 ${t.sigma.toPrecision(2)} ${t.unit} (wanted: ${t.limit} ${t.unit})` : `wanted: \u00b1 ${t.limit} ${t.unit}`;
    text.append(name, value);
    const bar = document.createElement('div'), fill = document.createElement('i');
    bar.className = 'bar';
    fill.className = met ? 'met' : '';
    // A hundred times the limit is nothing, the limit all.
    const share = known ? 1 - Math.log(Math.max(1, t.sigma / t.limit)) / Math.log(100) : 0;
    fill.style.width = `${100 * Math.min(1, Math.max(0, share))}%`;
    bar.append(fill);
    box.append(text, bar);
    return box;
  }));
}

// The state of a window
const kPhases = {collecting: 'collecting', calibrating: 'calibrating', converged: 'good enough'};
function verdict(trust, end) {
  const words = {yes: 'may be used', limited: 'may be used with care', no: 'do not use'};
  const kinds = {yes: 'good', limited: 'caution', no: 'bad'};
  const file = end && end.file ? ` Written to ${end.file}.` : '';
  say('verdict', `${end ? 'Finished: ' : 'So far: '}${words[trust.verdict]}.${file}`, kinds[trust.verdict]);
  list('reasons', trust.reasons);
}
function showState() {
  const line = state.line, end = state.end;
  at('source').textContent = state.source || '';
  if (state.recent.length) list('events', state.recent.slice().reverse());
  if (line) {
    targets(line.target);
    const bad = line.flagged_windows.length;
    say('disturbances', bad ? `${bad} second${bad > 1 ? 's' : ''} did not fit the rest and ${bad > 1 ? 'are' : 'is'} left out (a phone or iron came near).`
      : 'Nothing so far.', bad ? 'caution' : '');
    list('issues', line.issues.map(i => `${i.problem}; ${i.remedy}.`));
    at('counts').textContent = `${line.samples} samples, ${state.rate_hz.toFixed(0)} a second` +
      (line.malformed ? `, ${line.malformed} lines not understood` : '') +
      (line.lost_bytes ? `, ${line.lost_bytes} bytes lost` : '');
    if (line.theta) {
      if (!end) verdict(line.theta.trust, null);
      numbers(line.theta);
    }
  }
  if (end) {
    ended = true;
    verdict(end, end);
    if (end.magnetometers) numbers(end);
  }
  prepareSphere();
  showWords();
}

// What to do, several times a second
function showWords() {
  const line = state && state.line, end = state && state.end;
  if (end) {
    say('phase', 'finished', end.verdict === 'no' ? 'bad' : 'good');
    say('headline', end.verdict === 'no' ? 'Not usable' : 'Done', end.verdict === 'no' ? 'bad' : 'good');
    say('guidance', end.verdict === 'no' ? (end.reasons[0] || '') : 'The sensor may be put down.');
    say('turning', '');
  } else {
    const fatal = tick && tick.fatal, good = line && line.phase === 'converged' && !fatal;
    const headline = (tick && tick.headline) || (line && line.headline) || 'Waiting';
    say('phase', line ? kPhases[line.phase] : 'waiting', fatal ? 'bad' : good ? 'good' : '');
    say('headline', headline, fatal ? 'bad' : good ? 'good' : '');
    say('guidance', (tick && tick.guidance) || (line && line.guidance) || 'for the first samples.');
    if (tick && tick.silent_s !== null) {
      say('turning', `Nothing has come from the sensor for ${tick.silent_s.toFixed(0)} s.`, 'bad');
    } else if (tick && tick.turning && !fatal) {
      const now = tick.turning.toUpperCase(), wanted = state && state.axis && state.axis.toUpperCase();
      const right = !wanted || now === wanted;
      say('turning', `You are turning it about ${now}` + (!wanted ? '.' : right ? ': go on.' : `, not ${wanted}.`),
        right ? 'good' : 'caution');
    } else {
      say('turning', '');
    }
  }
  document.title = `magimu: ${at('headline').textContent.toLowerCase()}`;
}

// The sphere
const canvas = at('sphere'), pen = canvas.getContext('2d');
const kTiles = 240, tiles = [];
for (let k = 0; k < kTiles; ++k) {  // evenly, on a spiral
  const z = 1 - (2 * k + 1) / kTiles, r = Math.sqrt(1 - z * z), a = k * Math.PI * (3 - Math.sqrt(5));
  tiles.push({at: [r * Math.cos(a), r * Math.sin(a), z], seen: false});
}
const kReach = Math.cos(0.17);  // rad: a tile counts as seen from within its own circle or so
let dots = [], toSphere = p => p, yaw = 0.6, pitch = 0.35, drag = null, touched = 0;
const minus = (a, b) => a.map((x, i) => x - b[i]);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const norm = a => Math.sqrt(dot(a, a));
function inverse(m) {
  const [a, b, c] = m;
  const cross = (u, v) => [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
  const rows = [cross(b, c), cross(c, a), cross(a, b)], det = dot(a, rows[0]);
  return [0, 1, 2].map(i => rows.map(r => r[i] / det));
}
function prepareSphere() {
  const raw = state.points, theta = (state.end && state.end.magnetometers) ? state.end : state.line && state.line.theta;
  if (theta) {
    const m = theta.magnetometers[0], inv = inverse(m.distortion);
    toSphere = p => { const d = minus(p, m.bias); return inv.map(row => dot(row, d)); };
  } else if (raw.length) {  // until then: between the extremes
    const low = [0, 1, 2].map(i => Math.min(...raw.map(p => p[i])));
    const high = [0, 1, 2].map(i => Math.max(...raw.map(p => p[i])));
    const middle = low.map((x, i) => (x + high[i]) / 2);
    const radius = Math.max(10, ...low.map((x, i) => (high[i] - x) / 2));
    toSphere = p => minus(p, middle).map(x => x / radius);
  }
  dots = raw.map(toSphere);
  const unit = dots.map(d => d.map(x => x / (norm(d) || 1)));
  let seen = 0;
  for (const tile of tiles) {
    tile.seen = unit.some(u => dot(u, tile.at) > kReach);
    seen += tile.seen;
  }
  at('coverage').textContent = dots.length ? `${Math.round(100 * seen / kTiles)} % of all directions seen` : 'nothing seen yet';
  // Half of the dots: a magnet that was near for a while is told elsewhere.
  const off = dots.map(d => Math.abs(norm(d) - 1)).sort((a, b) => a - b), half = off[off.length >> 1];
  at('roundness').textContent = theta && off.length ? `half of the dots are within ${(100 * half).toFixed(half < 0.01 ? 2 : 1)} % of the sphere` : '';
}
function look(p) {
  const x = Math.cos(yaw) * p[0] - Math.sin(yaw) * p[1], y = Math.sin(yaw) * p[0] + Math.cos(yaw) * p[1];
  return [x, -(Math.cos(pitch) * p[2] - Math.sin(pitch) * y), Math.cos(pitch) * y + Math.sin(pitch) * p[2]];
}
function draw() {
  const size = canvas.clientWidth, dense = window.devicePixelRatio || 1;
  if (canvas.width !== Math.round(size * dense)) canvas.width = canvas.height = Math.round(size * dense);
  pen.setTransform(dense, 0, 0, dense, 0, 0);
  pen.clearRect(0, 0, size, size);
  const style = getComputedStyle(document.documentElement), colour = name => style.getPropertyValue('--' + name);
  const middle = size / 2, radius = 0.39 * size;
  const place = p => { const q = look(p); return [middle + radius * q[0], middle + radius * q[1], -q[2]]; };
  const disc = (x, y, r) => { pen.beginPath(); pen.arc(x, y, r, 0, 2 * Math.PI); };
  pen.lineWidth = 1.5;
  pen.strokeStyle = colour('line');
  disc(middle, middle, radius);
  pen.stroke();
  const axes = (front) => ['x', 'y', 'z'].forEach((name, i) => [1, -1].forEach(sign => {
    const tip = [0, 0, 0];
    tip[i] = 1.14 * sign;
    const [x, y, near] = place(tip);
    if ((near > 0) !== front) return;
    const wanted = state && !state.end && state.axis === name;
    const from = place(tip.map(v => v / 1.14));
    pen.strokeStyle = pen.fillStyle = colour(name);
    pen.lineWidth = wanted ? 6 : 2;
    pen.beginPath();
    pen.moveTo(from[0], from[1]);
    pen.lineTo(x, y);
    pen.stroke();
    if (sign < 0) return;
    pen.font = `600 ${wanted ? 26 : 17}px system-ui, sans-serif`;
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    const out = place(tip.map(v => v * 1.1));
    pen.fillText(name.toUpperCase(), out[0], out[1]);
  }));
  axes(false);
  const shown = dots.map(place);
  pen.fillStyle = colour('back');
  for (const [x, y, near] of shown) if (near <= 0) { disc(x, y, 2); pen.fill(); }
  pen.strokeStyle = colour('gap');
  pen.lineWidth = 1;
  for (const tile of tiles) {
    const [x, y, near] = place(tile.at);
    if (tile.seen || near < 0.05) continue;
    pen.globalAlpha = 0.35 + 0.5 * near;
    disc(x, y, 2 + 0.022 * size * near);
    pen.stroke();
  }
  pen.globalAlpha = 1;
  pen.fillStyle = colour('front');
  for (const [x, y, near] of shown) if (near > 0) { disc(x, y, 2 + 1.8 * near); pen.fill(); }
  axes(true);
  if (tick && tick.mag && dots.length && !ended) {  // where the field points now
    const [x, y, near] = place(toSphere(tick.mag));
    pen.globalAlpha = near > 0 ? 1 : 0.45;
    pen.lineWidth = 3;
    pen.strokeStyle = colour('text');
    disc(x, y, 9);
    pen.stroke();
    pen.globalAlpha = 1;
  }
}
const still = matchMedia('(prefers-reduced-motion: reduce)');
let before = 0;
function frame(now) {
  if (!drag && now - touched > 4000 && !still.matches) yaw += 0.00012 * Math.min(100, now - before);
  before = now;
  draw();
  requestAnimationFrame(frame);
}
canvas.addEventListener('pointerdown', e => { drag = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); });
canvas.addEventListener('pointermove', e => {
  if (!drag) return;
  yaw += (e.clientX - drag[0]) / 150;
  pitch = Math.min(1.5, Math.max(-1.5, pitch + (e.clientY - drag[1]) / 150));
  drag = [e.clientX, e.clientY];
});
for (const name of ['pointerup', 'pointercancel']) canvas.addEventListener(name, () => { drag = null; touched = performance.now(); });
requestAnimationFrame(frame);

// The connection
function connect() {
  const socket = new WebSocket(`ws://${location.host}/live`);
  socket.onmessage = message => {
    const told = JSON.parse(message.data);
    if (told.kind === 'state') {
      state = told;
      ended = false;
      showState();
    } else {
      tick = told;
      showWords();
    }
  };
  socket.onclose = () => {
    if (!ended) {
      say('phase', 'not connected', 'bad');
      say('turning', 'magimu has ended, or cannot be reached. What you see is the last that was known.', 'bad');
    }
    setTimeout(connect, 1000);
  };
}
connect();
