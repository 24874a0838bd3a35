// The interactive plots of a page. Each .plot holds an SVG and the same plot as JSON. A chart made
// from the JSON replaces the SVG. Chart.js draws it; this file adds the legend, the zoom and the
// tooltips.
'use strict';

(() => {
  const clickRange = 5;  // [pixels]: a drag that stays within it is a click
  const shapes = {disc: 'circle', square: 'rect', diamond: 'rectRot', ring: 'circle',
                  triangle: 'triangle'};

  /** The contents of a tooltip: rows of label and text, by the point's name. */
  const facts = JSON.parse(document.getElementById('facts')?.textContent ?? '{}');

  /** A new element; `properties` are set on it, `children` are elements or text. */
  function element(name, properties = {}, ...children) {
    const made = Object.assign(document.createElement(name), properties);
    made.append(...children);
    return made;
  }

  // --- axes --------------------------------------------------------------------------------------

  /** 0.5, 200, 1e-3, 2.5e-6. */
  function numberText(value) {
    const rounded = Number(value.toPrecision(3));
    if (rounded >= 0.01 && rounded < 1e4) return String(rounded);
    return rounded.toExponential().replace('e+', 'e');
  }

  /** Grid lines at every digit of a decade, or at round steps if the axis is much shorter. */
  function logTicks(min, max) {
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

  function logAxis(title, range) {
    return {
      type: 'logarithmic',
      ...range,
      // a longer title would be squeezed
      title: {display: true, text: title, font: ({chart}) => ({size: chart.width < 480 ? 11 : 14})},
      afterBuildTicks: scale => { scale.ticks = logTicks(scale.min, scale.max); },
      ticks: {
        autoSkip: false,
        maxRotation: 0,
        callback: (value, i, ticks) => ticks[i].labelled ? numberText(value) : ''
      },
      grid: {color: context => context.tick?.labelled ? '#c8c8c8' : '#ececec'}
    };
  }

  // --- curves ------------------------------------------------------------------------------------

  function datasetOf(series) {
    return {
      entries: series.entries,
      color: series.color,
      data: series.points.map(([x, y, name, lower, upper]) => ({x, y, name, lower, upper})),
      showLine: true,
      stepped: series.front ? 'before' : false,
      borderColor: series.color,
      borderWidth: series.front ? 1.2 : 1.7,
      borderDash: series.dashed ? [5, 4] : [],
      pointStyle: shapes[series.shape],
      pointBackgroundColor: series.shape === 'ring' ? '#0000' : series.color,
      pointBorderColor: series.color,
      pointBorderWidth: series.shape === 'ring' ? 1.7 : 0,
      pointRadius: series.front ? 9 : series.shape === 'disc' ? 4 : 5,
      pointHoverRadius: series.front ? 9 : 7,
      pointHitRadius: 6
    };
  }

  /** Joins the quartiles of each point of the curves that are shown. */
  const quartiles = {
    id: 'quartiles',
    afterDatasetsDraw(chart) {
      const {ctx, scales: {x, y}, chartArea: {left, top, width, height}} = chart;
      ctx.save();
      ctx.beginPath();
      ctx.rect(left, top, width, height);
      ctx.clip();
      for (const {index} of chart.getSortedVisibleDatasetMetas()) {
        const {data, borderColor} = chart.data.datasets[index];
        ctx.strokeStyle = borderColor;
        ctx.beginPath();
        for (const point of data.filter(({lower}) => lower > 0)) {
          ctx.moveTo(x.getPixelForValue(point.lower), y.getPixelForValue(point.y));
          ctx.lineTo(x.getPixelForValue(point.upper), y.getPixelForValue(point.y));
        }
        ctx.stroke();
      }
      ctx.restore();
    }
  };

  /** Pales all curves except those of the legend's entry `focus`; null pales none. */
  function paintFocus(chart, focus) {
    for (const dataset of chart.data.datasets) {
      const color = focus && !dataset.entries.includes(focus) ? dataset.color + '20' : dataset.color;
      dataset.borderColor = dataset.pointBorderColor = color;
      if (dataset.pointBackgroundColor !== '#0000') dataset.pointBackgroundColor = color;
    }
    chart.update('none');
  }

  // --- tooltip -----------------------------------------------------------------------------------

  const tip = element('div', {className: 'tip', hidden: true});
  let zooming = false;  // a drag shows no tooltips
  document.body.append(tip);

  /** A point's name, its numbers and its pictures, which are copies of the page's. */
  function cardOf(item, plot) {
    const {x, y, name} = item.raw;
    const rows = facts[name] ?? [[plot.x, numberText(x)], [plot.y, numberText(y)]];
    const table = element('table');
    for (const [label, text] of rows)
      table.insertRow().append(element('td', {}, label), element('td', {}, text));
    const pictures = element('div', {className: 'pictures'});
    for (const figure of document.querySelectorAll('figure[data-variant]'))
      if (figure.dataset.variant === name) pictures.append(figure.cloneNode(true));
    const card = element('div', {className: 'card'}, element('h4', {}, name), table, pictures);
    card.style.borderColor = item.dataset.color;
    return card;
  }

  function showTip({chart, tooltip}, plot) {
    tip.hidden = zooming || tooltip.opacity === 0 || !tooltip.dataPoints?.length;
    if (tip.hidden) return;
    const shown = tooltip.dataPoints.slice(0, 3), more = tooltip.dataPoints.slice(3);
    tip.replaceChildren(...shown.map(item => cardOf(item, plot)));
    if (more.length)
      tip.append(element('p', {}, `at the same place: ${more.map(item => item.raw.name).join(', ')}`));

    const canvas = chart.canvas.getBoundingClientRect(), gap = 18;
    const x = canvas.left + tooltip.caretX, y = canvas.top + tooltip.caretY;
    tip.style.left = tip.style.top = '0';
    const {width, height} = tip.getBoundingClientRect();
    const fits = x + gap + width <= document.documentElement.clientWidth;
    const left = fits ? x + gap : Math.max(x - gap - width, 0);
    const top = Math.min(Math.max(y - height / 2, 4), window.innerHeight - height - 4);
    tip.style.left = `${left + window.scrollX}px`;
    tip.style.top = `${top + window.scrollY}px`;
  }

  // --- legend ------------------------------------------------------------------------------------

  function swatchOf(entry) {
    const mark = {
      disc: '<circle cx="17" cy="8" r="4"/>',
      square: '<rect x="13" y="4" width="8" height="8"/>',
      diamond: '<path d="M17 3l5 5-5 5-5-5z"/>',
      ring: '<circle cx="17" cy="8" r="5" fill="none" stroke-width="1.7"/>',
      triangle: '<path d="M17 3l5 9h-10z"/>'
    }[entry.shape];
    const line = entry.joined
      ? `<path d="M2 8h30" stroke-width="1.7" stroke-dasharray="${entry.dashed ? '5 4' : 'none'}"/>`
      : '';
    const box = document.createElement('span');
    box.innerHTML = `<svg width="34" height="16" fill="${entry.color}" stroke="${entry.color}" ` +
      `stroke-width="0">${line}${mark}</svg>`;
    return box.firstChild;
  }

  /** A button for each entry: a click hides its curves, a double click shows them alone. */
  function legendOf(chart, entries) {
    const hidden = new Set();
    let alone = null;
    const shows = entry => dataset =>
      dataset.entries.includes(entry) && !dataset.entries.some(other => hidden.has(other)) &&
      (alone === null || dataset.entries.includes(alone));
    const buttons = entries.map(entry =>
      element('button', {type: 'button'}, swatchOf(entry), entry.text));
    const update = () => {
      const {datasets} = chart.data;
      datasets.forEach((dataset, i) =>
        chart.setDatasetVisibility(i, dataset.entries.some(entry => shows(entry)(dataset))));
      entries.forEach(({text}, i) => {
        const on = !hidden.has(text) && (alone === null || datasets.some(shows(text)));
        buttons[i].setAttribute('aria-pressed', on);
      });
      chart.update('none');
    };
    buttons.forEach((button, i) => {
      const {text} = entries[i];
      button.onclick = () => {
        if (!hidden.delete(text)) hidden.add(text);
        update();
      };
      button.ondblclick = () => {
        alone = alone === text ? null : text;
        update();
      };
      button.onmouseenter = () => paintFocus(chart, text);
      button.onmouseleave = () => paintFocus(chart, null);
    });
    const showAll = () => {
      hidden.clear();
      alone = null;
      update();
    };
    update();
    return {box: element('div', {className: 'legend'}, ...buttons), showAll};
  }

  // --- zoom --------------------------------------------------------------------------------------

  /** The axes of a chart in pixels of its canvas; `whole` has their first ranges. */
  function axesOf(chart, whole) {
    const valuesAt = (axis, from, to) => {
      const values = [from, to].map(pixel => chart.scales[axis].getValueForPixel(pixel));
      return {min: Math.min(...values), max: Math.max(...values)};
    };
    const set = ranges => {
      Object.assign(chart.options.scales.x, ranges.x);
      Object.assign(chart.options.scales.y, ranges.y);
      chart.update('none');
    };
    return {
      inside: ({x, y}) => ({
        x: Math.min(Math.max(x, chart.chartArea.left), chart.chartArea.right),
        y: Math.min(Math.max(y, chart.chartArea.top), chart.chartArea.bottom)
      }),
      /** The box between two corners fills the chart. A box along one axis zooms that axis alone. */
      fill: (a, b) => set({x: Math.abs(b.x - a.x) > clickRange ? valuesAt('x', a.x, b.x) : {},
                           y: Math.abs(b.y - a.y) > clickRange ? valuesAt('y', a.y, b.y) : {}}),
      move: (dx, dy) => {
        const {left, right, top, bottom} = chart.chartArea;
        set({x: valuesAt('x', left - dx, right - dx), y: valuesAt('y', top - dy, bottom - dy)});
      },
      /** Zooms to the box around the point, `scale` times as wide and high as the chart. */
      scale: ({x, y}, scale) => {
        const {left, right, top, bottom} = chart.chartArea;
        set({x: valuesAt('x', x + (left - x) * scale, x + (right - x) * scale),
             y: valuesAt('y', y + (top - y) * scale, y + (bottom - y) * scale)});
      },
      reset: () => set(whole)
    };
  }

  /** Drag: zoom into a box. Shift and drag: move. Ctrl and wheel: zoom. Double click: reset. */
  function addZoom(canvas, frame, axes) {
    const place = event => {
      const box = canvas.getBoundingClientRect();
      return {x: event.clientX - box.left, y: event.clientY - box.top};
    };
    let drag = null;  // `at`: where it began, or where a move has come to; `box`: none for a move
    const end = () => {
      drag?.box?.remove();
      drag = null;
      zooming = false;
    };
    canvas.addEventListener('pointerdown', event => {
      if (event.button !== 0 || event.pointerType === 'touch') return;
      canvas.setPointerCapture(event.pointerId);
      zooming = tip.hidden = true;
      drag = {at: event.shiftKey ? place(event) : axes.inside(place(event))};
      if (event.shiftKey) return;
      drag.box = element('div', {className: 'zoom-box', hidden: true});
      frame.append(drag.box);
    });
    canvas.addEventListener('pointermove', event => {
      if (!drag) return;
      const {at, box} = drag, to = box ? axes.inside(place(event)) : place(event);
      if (!box) {
        axes.move(to.x - at.x, to.y - at.y);
        drag.at = to;
        return;
      }
      box.hidden = Math.hypot(to.x - at.x, to.y - at.y) <= clickRange;
      Object.assign(box.style, {
        left: `${Math.min(at.x, to.x)}px`, width: `${Math.abs(to.x - at.x)}px`,
        top: `${Math.min(at.y, to.y)}px`, height: `${Math.abs(to.y - at.y)}px`
      });
    });
    canvas.addEventListener('pointerup', event => {
      if (drag?.box && !drag.box.hidden) axes.fill(drag.at, axes.inside(place(event)));
      end();
    });
    canvas.addEventListener('pointercancel', end);
    canvas.addEventListener('wheel', event => {
      if (!event.ctrlKey) return;
      event.preventDefault();
      axes.scale(place(event), Math.exp(event.deltaY * 0.002));
    }, {passive: false});
    canvas.addEventListener('dblclick', axes.reset);
  }

  // --- a plot ------------------------------------------------------------------------------------

  function show(section) {
    const plot = JSON.parse(section.querySelector('script').textContent);
    const points = plot.series.flatMap(series => series.points);
    const whole = {x: logRange(points.map(p => p[0])), y: logRange(points.map(p => p[1]))};
    const canvas = element('canvas');
    canvas.setAttribute('role', 'img');
    canvas.setAttribute('aria-label', plot.title);
    const frame = element('div', {className: 'frame'}, canvas);
    const area = element('div', {className: 'chart'}, frame);
    section.querySelector('svg').replaceWith(area);

    const chart = new Chart(canvas, {
      type: 'scatter',
      data: {datasets: plot.series.map(datasetOf)},
      plugins: [quartiles],
      options: {
        animation: false,
        maintainAspectRatio: false,
        interaction: {mode: 'nearest', intersect: true},
        scales: {x: logAxis(plot.x, whole.x), y: logAxis(plot.y, whole.y)},
        plugins: {
          legend: {display: false},
          tooltip: {
            enabled: false,
            external: context => showTip(context, plot),
            filter: item => Boolean(item.raw.name)
          }
        }
      }
    });
    const legend = legendOf(chart, plot.legend);
    const axes = axesOf(chart, whole);
    addZoom(canvas, frame, axes);
    area.append(legend.box);
    section.querySelector('header').append(
      element('button', {type: 'button', onclick: axes.reset}, 'Reset zoom'),
      element('button', {type: 'button', onclick: legend.showAll}, 'Show all'));
  }

  Object.assign(Chart.defaults.font, {family: 'system-ui, sans-serif', size: 13});
  Chart.defaults.color = '#222';
  const plots = document.querySelectorAll('.plot');
  plots.forEach(show);
  plots[0]?.before(element('p', {className: 'hint'},
    'Point at a mark to see what it stands for. Click a name in the legend to hide its ' +
    'curves; double-click it to show them alone. Drag to zoom into a box, Shift+drag to move, ' +
    'Ctrl+wheel to zoom, double-click to reset.'));
})();
