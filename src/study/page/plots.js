// Plots with two logarithmic axes, drawn as SVG. A legend hides curves, a drag zooms, and a pointer
// shows what a mark stands for.
'use strict';

/** A new element; `properties` are set on it, `children` are elements or text. */
function element(name, properties = {}, ...children) {
  const made = Object.assign(document.createElement(name), properties);
  made.append(...children);
  return made;
}

/** A new element of an SVG with these attributes. */
function shapeOf(name, attributes = {}, ...children) {
  const made = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  made.append(...children);
  return made;
}

/** 0.5, 200, 1e-3, 2.5e-6. */
function numberText(value) {
  const rounded = Number(value.toPrecision(3));
  if (rounded >= 0.01 && rounded < 1e4) return String(rounded);
  return rounded.toExponential().replace('e+', 'e');
}

/** Grid lines at every digit of a decade, or at round steps if the axis is much shorter. */
function logTicks({min, max}) {
  const decades = Math.log10(max / min);
  const ticks = [];
  if (decades < 0.7) {
    const exact = (max - min) / 6, power = 10 ** Math.floor(Math.log10(exact));
    const step = power * [1, 2, 5, 10].find(digit => digit * power >= exact);
    for (let i = Math.ceil(min / step); i * step <= max; ++i)
      ticks.push({value: i * step, labelled: true});
    return ticks;
  }
  const stride = Math.max(1, Math.ceil(decades / 10));
  const named = decades < 1.3 ? [1, 2, 3, 4, 5, 7] : decades < 2.5 ? [1, 2, 5] : [1];
  for (let power = Math.floor(Math.log10(min)); power <= Math.log10(max); ++power)
    for (let digit = 1; digit < 10; ++digit) {
      const value = Number(`${digit}e${power}`);
      if (value < min || value > max) continue;
      ticks.push({value, labelled: named.includes(digit) && power % stride === 0});
    }
  return ticks;
}

/** The range of the values with a margin. */
function logRange(values) {
  if (values.length === 0) return {min: 0.1, max: 10};
  const least = Math.min(...values), greatest = Math.max(...values);
  const margin = 10 ** Math.max(0.05 * Math.log10(greatest / least), 0.1);
  return {min: least / margin, max: greatest * margin};
}

/** An axis: the range's ends are at `from` and `to` [pixels]. */
function axisOf(range, from, to) {
  const rate = (to - from) / Math.log(range.max / range.min);
  return {
    from, to,
    at: value => from + rate * Math.log(value / range.min),
    value: pixel => range.min * Math.exp((pixel - from) / rate),
    ticks: () => logTicks(range)
  };
}

function markOf({shape, color}, x, y, r) {
  const d = {
    square: `M${x - r} ${y - r}h${2 * r}v${2 * r}h${-2 * r}z`,
    diamond: `M${x} ${y - r}l${r} ${r} ${-r} ${r} ${-r} ${-r}z`,
    triangle: `M${x} ${y - r}l${r} ${2 * r}h${-2 * r}z`
  }[shape] ?? `M${x - r} ${y}a${r} ${r} 0 1 0 ${2 * r} 0a${r} ${r} 0 1 0 ${-2 * r} 0z`;
  return shapeOf('path', shape === 'ring' ? {d, fill: 'none', stroke: color, 'stroke-width': 1.6}
                                          : {d, fill: color});
}

function lineOf({color, dashed}, d, width = 1.6) {
  return shapeOf('path', {d, fill: 'none', stroke: color, 'stroke-width': width,
                          'stroke-dasharray': dashed ? '5 4' : 'none'});
}

/** The legend's mark of an entry, with its middle at (x, y). */
function swatchOf(entry, x, y) {
  return [entry.joined ? lineOf(entry, `M${x - 15} ${y}h30`) : '', markOf(entry, x, y, 4.5)];
}

/** The curve of a series; `places` takes its marks. */
function curveOf(series, x, y, places) {
  const points = series.points.map(p => ({...p, series, at: [x.at(p.x), y.at(p.y)]}));
  places.push(...points.filter(p => p.name));
  const line = points.map(({at}, i) =>
    i === 0 ? `M${at}` : series.front ? `H${at[0]}V${at[1]}` : `L${at}`).join('');
  const marks = points.map(({at, name}) => {
    const mark = markOf(series, ...at, series.front ? 8 : 4.5);
    mark.setAttribute('class', 'mark');
    mark.setAttribute('data-name', name);
    return mark;
  });
  const quartiles = points.filter(p => p.lower > 0).map(p =>
    lineOf({color: series.color}, `M${x.at(p.lower)} ${p.at[1]}H${x.at(p.upper)}`, 1));
  return shapeOf('g', {'data-entries': series.entries.join('\n')},
                 lineOf(series, line || 'M0 0', series.front ? 1.2 : 1.6), ...marks, ...quartiles);
}

/** The plot's picture: {svg, x, y, places of marks}. `legend`: within the picture, for a file. */
function pictureOf(plot, ranges, series, width, height, legend = false) {
  const x = axisOf(ranges.x, 76, width - 14), y = axisOf(ranges.y, height - 52, 12);
  const places = [], side = legend ? 300 : 0;
  const text = (words, at, anchor, more = {}) =>
    shapeOf('text', {x: at[0], y: at[1], 'text-anchor': anchor, fill: '#222', ...more}, words);
  const svg = shapeOf('svg', {width: width + side, height, viewBox: `0 0 ${width + side} ${height}`,
                              'font-family': 'system-ui, sans-serif', 'font-size': 13, role: 'img',
                              'aria-label': plot.title});
  for (const {value, labelled} of x.ticks()) {
    svg.append(lineOf({color: labelled ? '#c8c8c8' : '#ececec'},
                      `M${x.at(value)} ${y.from}V${y.to}`, 1));
    if (labelled) svg.append(text(numberText(value), [x.at(value), y.from + 18], 'middle'));
  }
  for (const {value, labelled} of y.ticks()) {
    svg.append(lineOf({color: labelled ? '#c8c8c8' : '#ececec'},
                      `M${x.from} ${y.at(value)}H${x.to}`, 1));
    if (labelled) svg.append(text(numberText(value), [x.from - 7, y.at(value) + 4], 'end'));
  }
  const middle = (y.from + y.to) / 2, size = {'font-size': width < 480 ? 11 : 14};
  svg.append(text(plot.x, [(x.from + x.to) / 2, height - 10], 'middle', size),
             text(plot.y, [18, middle], 'middle', {...size, transform: `rotate(-90 18 ${middle})`}));
  const curves = shapeOf('svg', {x: x.from, y: y.to, width: x.to - x.from, height: y.from - y.to,
                                 viewBox: `${x.from} ${y.to} ${x.to - x.from} ${y.from - y.to}`});
  curves.append(...series.map(one => curveOf(one, x, y, places)));
  svg.append(curves);
  if (legend)
    plot.legend.forEach((entry, i) =>
      svg.append(...swatchOf(entry, width + 20, 22 + 20 * i),
                 text(entry.text, [width + 44, 26 + 20 * i], 'start')));
  return {svg, x, y, places};
}

/** The tooltip of all plots; `cardOf(point)` is what it shows of a point. */
const tip = element('div', {className: 'tip', hidden: true});

function showTip(points, cardOf, {clientX, clientY}) {
  tip.hidden = points.length === 0;
  if (tip.hidden) return;
  const more = points.slice(3).map(point => point.name).join(', ');
  tip.replaceChildren(...points.slice(0, 3).map(cardOf),
                      ...more ? [element('p', {}, `at the same place: ${more}`)] : []);
  tip.style.left = tip.style.top = '0';
  const {width, height} = tip.getBoundingClientRect(), gap = 18;
  const fits = clientX + gap + width <= document.documentElement.clientWidth;
  const left = fits ? clientX + gap : Math.max(clientX - gap - width, 0);
  const top = Math.min(Math.max(clientY - height / 2, 4), window.innerHeight - height - 4);
  tip.style.left = `${left + window.scrollX}px`;
  tip.style.top = `${top + window.scrollY}px`;
}

/**
 * The section of a plot: {name, title, x, y, legend, series}. A series has points {x, y, name, lower,
 * upper}, color, shape, dashed, entries of the legend, and `front` if it is a Pareto front.
 */
function plotOf(plot, cardOf) {
  plot.series.forEach(one => { one.points = one.points.filter(p => p.x > 0 && p.y > 0); });
  const points = plot.series.flatMap(one => one.points);
  const whole = {x: logRange(points.map(p => p.x)), y: logRange(points.map(p => p.y))};
  const frame = element('div', {className: 'frame'}), box = element('div', {className: 'zoom-box'});
  const hidden = new Set();
  let alone = null, ranges = whole, drawn = null;
  const shown = () => plot.series.filter(({entries}) =>
    !entries.some(entry => hidden.has(entry)) && (alone === null || entries.includes(alone)));
  const draw = () => {
    drawn = pictureOf(plot, ranges, shown(), Math.max(frame.clientWidth, 300), 540);
    frame.replaceChildren(drawn.svg);
    plot.legend.forEach(({text}, i) => buttons[i].setAttribute(
      'aria-pressed',
      alone === null ? !hidden.has(text) : shown().some(({entries}) => entries.includes(text))));
  };

  const pale = entry => frame.querySelectorAll('g[data-entries]').forEach(curve => {
    const own = curve.dataset.entries.split('\n').includes(entry);
    curve.setAttribute('opacity', entry === null || own ? 1 : 0.12);
  });
  const buttons = plot.legend.map(entry => {
    const swatch = shapeOf('svg', {width: 34, height: 16}, ...swatchOf(entry, 17, 8));
    return element('button', {
      type: 'button',
      onclick: () => { if (!hidden.delete(entry.text)) hidden.add(entry.text); draw(); },
      ondblclick: () => { alone = alone === entry.text ? null : entry.text; draw(); },
      onmouseenter: () => pale(entry.text),
      onmouseleave: () => pale(null)
    }, swatch, entry.text);
  });

  // drag: zoom into a box; Shift and drag: move; Ctrl and wheel: zoom; double click: reset
  const place = event => {
    const {left, top} = frame.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  const zoom = (a, b) => {  // to these pixels' box; along an axis that it hardly spans, not at all
    const range = (axis, from, to) => {
      const [min, max] = [axis.value(from), axis.value(to)].sort((m, n) => m - n);
      return {min, max};
    };
    ranges = {x: Math.abs(b[0] - a[0]) > 5 ? range(drawn.x, a[0], b[0]) : ranges.x,
              y: Math.abs(b[1] - a[1]) > 5 ? range(drawn.y, a[1], b[1]) : ranges.y};
    draw();
  };
  const corners = change => zoom(change([drawn.x.from, drawn.y.from]),
                                 change([drawn.x.to, drawn.y.to]));
  let drag = null;
  const end = () => { drag = null; box.remove(); };
  Object.assign(frame, {
    onpointerdown: event => {
      if (event.button !== 0 || event.pointerType === 'touch') return;
      frame.setPointerCapture(event.pointerId);
      drag = {at: place(event), move: event.shiftKey};
      tip.hidden = true;
    },
    onpointermove: event => {
      const [x, y] = place(event);
      if (!drag) {
        const far = drawn.places.map(({at}) => Math.hypot(at[0] - x, at[1] - y));
        const nearest = Math.min(8, ...far);
        const near = drawn.places.filter((_, i) => far[i] <= nearest + 0.5);
        return showTip(nearest < 8 ? near : [], cardOf, event);
      }
      const [dx, dy] = [x - drag.at[0], y - drag.at[1]];
      if (drag.move) {
        corners(([left, top]) => [left - dx, top - dy]);
        drag.at = [x, y];
      } else if (Math.hypot(dx, dy) > 5) {
        Object.assign(box.style, {left: `${Math.min(x, x - dx)}px`, width: `${Math.abs(dx)}px`,
                                  top: `${Math.min(y, y - dy)}px`, height: `${Math.abs(dy)}px`});
        frame.append(box);
      }
    },
    onpointerup: event => {
      if (drag && box.isConnected) zoom(drag.at, place(event));
      end();
    },
    onpointercancel: end,
    onpointerleave: () => { tip.hidden = true; },
    ondblclick: () => { ranges = whole; draw(); }
  });
  frame.addEventListener('wheel', event => {
    if (!event.ctrlKey) return;
    event.preventDefault();
    const at = place(event), scale = Math.exp(event.deltaY * 0.002);
    corners(corner => corner.map((pixel, i) => at[i] + (pixel - at[i]) * scale));
  }, {passive: false});

  new ResizeObserver(draw).observe(frame);
  const file = element('a', {download: `${plot.name}.svg`, href: '#', onclick: () => {
    const {svg} = pictureOf(plot, ranges, shown(), 760, 540, true);
    file.href = 'data:image/svg+xml,' +
      encodeURIComponent(new XMLSerializer().serializeToString(svg));
  }}, 'SVG');
  const button = (text, onclick) => element('button', {type: 'button', onclick}, text);
  return element('section', {className: 'plot', id: plot.name},
    element('header', {}, element('h3', {}, plot.title), file,
            button('Reset zoom', () => { ranges = whole; draw(); }),
            button('Show all', () => { hidden.clear(); alone = null; draw(); })),
    element('div', {className: 'chart'}, frame, element('div', {className: 'legend'}, ...buttons)));
}
