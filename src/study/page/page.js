// The page of a study, of a suite or of a sequence, from the JSON that it wrote. Names are text
// nodes, so that none becomes markup.
'use strict';

(() => {
  const data = JSON.parse(document.getElementById('data').textContent);
  const files = JSON.parse(document.getElementById('files').textContent);
  const usualRms = [1e-2, 1e-3, 1e-4, 1e-5];
  const main = document.querySelector('main');
  const none = '–';

  // --- numbers and texts -------------------------------------------------------------------------

  /** 1.3e-6; 2.0. */
  const twoDigits = value => value == null ? none : value === 0 ? '0' :
    value.toExponential(1).replace('e+0', '').replace('e+', 'e');
  const powerText = rms => `1e${Math.round(Math.log10(rms))}`;

  /** Median and quartiles. */
  function spreadOf(values) {
    const sorted = [...values].sort((a, b) => a - b);
    const at = part => {
      const place = part * (sorted.length - 1), i = Math.floor(place), low = sorted[i] ?? 0;
      return low + (place - i) * ((sorted[i + 1] ?? low) - low);
    };
    return {lower: at(0.25), median: at(0.5), upper: at(0.75)};
  }
  const timeOf = (point, clock) => spreadOf(point.times_ms.map(time => time[clock]));
  const spreadText = ({lower, median, upper}) => median > 0
    ? `${median.toFixed(1)} (${lower.toFixed(1)}–${upper.toFixed(1)})` : none;

  // --- parts of the page -------------------------------------------------------------------------

  const paragraph = (text, properties = {}) => element('p', properties, ...marked(text));
  /** What stands between backquotes is code, whose lines break between options. */
  function marked(text) {
    return text.split('`').flatMap((part, i) => i % 2 ? inElements('code', part) : [part]);
  }
  /** A command in elements, between which its lines break: between its options. */
  function inElements(name, command) {
    return command.split(/ (?=--)/).flatMap((words, i) => [...i ? [' '] : [], element(name, {}, words)]);
  }

  /** Rows of texts or elements, the first is the head. `words`: cells are left-aligned and wrap. */
  function tableOf(rows, words = false) {
    const table = element('table', {className: words ? 'words' : ''});
    rows.forEach((cells, i) => table.append(element('tr', {}, ...cells.map(cell =>
      element(i === 0 ? 'th' : 'td', {}, cell)))));
    return element('div', {className: 'wide'}, table);
  }

  /** The rows of a table from [row, column, text]; its first column is named `name`. */
  function rowsOf(name, cells) {
    const rows = [...new Set(cells.map(([row]) => row))];
    const columns = [...new Set(cells.map(([, column]) => column))];
    const texts = new Map(cells.map(([row, column, text]) => [`${row}\n${column}`, text]));
    return [[name, ...columns],
            ...rows.map(row => [row, ...columns.map(c => texts.get(`${row}\n${c}`) ?? none)])];
  }

  function section(title, ...parts) {
    main.append(element('h2', {}, title), ...parts);
  }
  function table(title, text, rows, words = false) {
    if (rows.length > 1) section(title, ...text ? [paragraph(text)] : [], tableOf(rows, words));
  }

  function figureOf(file, caption, alt = '') {
    const picture = files.pictures[file];
    const image = picture ? [element('img', {alt, src: `data:image/png;base64,${picture}`})] : [];
    return element('figure', {}, ...image, element('figcaption', {}, caption));
  }

  // --- rules and curves --------------------------------------------------------------------------

  const inks = ['#1f77b4', '#ff7f0e', '#2ca02c', '#d62728', '#9467bd', '#8c564b', '#e377c2',
                '#7f7f7f', '#bcbd22', '#17becf', '#000000', '#6e003c', '#78c878', '#aa6e28'];
  const foreignInks = ['#006e6e', '#964b00', '#5a00a0', '#5a5a5a'];
  const isChosen = point => point.tolerance !== undefined;

  /** The papers that the rules are from, and their DOIs; the others are from the first. */
  const papers = [
    ['Moreland and Angel 2004', '10.1109/SVVG.2004.2', []],
    ['Porter and Duff 1984', '10.1145/800031.808606', ['porter-duff']],
    ['Max 1995', '10.1109/2945.468400', ['midpoint', 'cell-exact']],
    ['Williams, Max and Stein 1998', '10.1109/2945.675650', ['psi-exact', 'linear-source']],
    ['Engel, Kraus and Ertl 2001', '10.1145/383507.383515', ['preintegrated', 'preintegrated-fast']]];

  function ruleList(points) {
    const used = new Set(points.filter(p => !isChosen(p)).map(p => p.rule));
    return element('ul', {}, ...data.rules.filter(({name}) => used.has(name)).map(({name, help}) => {
      const [paper, doi] = papers.find(([, , rules]) => rules.includes(name)) ?? papers[0];
      return element('li', {}, `${name}: ${help} (`,
        element('a', {href: `https://doi.org/${doi}`}, paper), ')');
    }));
  }

  /** The points by their curves, each from coarse to fine. */
  function curvesOf(points) {
    const curves = new Map();
    for (const point of points)
      curves.set(point.curve, [...curves.get(point.curve) ?? [], point]);
    for (const curve of curves.values())
      curve.sort((a, b) => (b.step ?? 0) - (a.step ?? 0) || (a.segments ?? 0) - (b.segments ?? 0) ||
                           (b.tolerance ?? 0) - (a.tolerance ?? 0));
    return curves;
  }

  /** What a curve takes for an RMS, linear in the logarithms between its points. */
  function needOf(curve, rms, costOf) {
    const fine = curve.findIndex(point => !(point.error.rms > rms));
    if (fine < 0) return null;
    const cost = costOf(curve[fine]), error = curve[fine].error.rms;
    if (fine === 0) return {cost, atMost: true};
    const before = curve[fine - 1], from = costOf(before);
    if (from <= 0 || cost <= 0 || error <= 0) return {cost};
    const part = Math.log(rms / before.error.rms) / Math.log(error / before.error.rms);
    return {cost: from * (cost / from) ** part};
  }
  const lookUps = point => point.samples_per_ray;
  const processorTime = point => timeOf(point, 'cpu').median;

  /** A plot of curves of psivox's points: [point of the curve, places]. */
  function plotOfCurves(curves) {
    const shapes = {cells: 'square', uniform: 'disc', template: 'diamond'};
    const legend = [];
    const add = entry => {
      if (!legend.some(({text}) => text === entry.text)) legend.push(entry);
      return entry.text;
    };
    const series = curves.map(([point, points]) => {
      const chosen = isChosen(point);
      const index = data.rules.findIndex(({name}) => name === point.rule);
      const color = chosen ? '#e63c8c' : inks[Math.max(index, 0) % inks.length];
      const shape = chosen ? 'ring' : shapes[point.sampling];
      return {points, color, shape, dashed: point.sampling === 'cells',
              entries: [add({text: point.rule, color, shape: chosen ? 'ring' : 'disc'})]};
    });
    for (const sampling of ['uniform', 'cells', 'template'])
      curves.forEach(([point], i) => {
        if (point.sampling !== sampling) return;
        series[i].entries.push(add({text: sampling, color: '#3c3c3c', shape: shapes[sampling],
                                    joined: true, dashed: sampling === 'cells'}));
      });
    return {series, legend, y: 'RMS over R G B A against the reference'};
  }

  /** Marks what no other point beats: an error counts as less from 1 % on. */
  function addFront(plot, points) {
    const front = [];
    for (const point of [...points].sort((a, b) => a.x - b.x || a.y - b.y))
      if (front.length === 0 || point.y < 0.99 * front.at(-1).y) front.push(point);
    const entry = {text: 'Pareto front', color: '#c80000', shape: 'ring'};
    plot.legend.push(entry);
    plot.series.push({...entry, points: front.map(({x, y, name}) => ({x, y, name})), dashed: true,
                      entries: [entry.text], front: true});
  }

  /** `costOf` gives a point's spread; points of a median of 0 are left out. */
  function costPlot(points, name, title, x, costOf, front = true) {
    const placed = ([point, ...rest]) => [point, [point, ...rest].map(p => {
      const {lower, median, upper} = costOf(p);
      return {x: median, y: p.error.rms, name: p.name, lower, upper};
    })];
    const curves = [...curvesOf(points.filter(p => costOf(p).median > 0)).values()].map(placed);
    if (curves.length === 0) return null;
    const plot = {...plotOfCurves(curves), name, title, x};
    if (front) addFront(plot, curves.flatMap(([, places]) => places));
    return plot;
  }

  // --- a study -----------------------------------------------------------------------------------

  const deviation = d => `${twoDigits(d.max)} at ${d.max_x},${d.max_y}`;
  const shownName = ({name}) => `${name} (foreign)`;
  const fileOf = name => name.replaceAll(' ', '_');
  const pairOf = (file, scale, name) => [
    figureOf(`pictures/${file}.png`, name), figureOf(`differences/${file}.png`,
      `less the reference; full colour at ±${twoDigits(scale)}`)];

  /** A point's row in the table of all numbers. */
  function factsOf(point) {
    const facts = [['RMS', twoDigits(point.error.rms)]];
    for (const channels of ['radiance', 'alpha']) {
      const d = point.error[channels];
      facts.push([`${channels} RMS`, twoDigits(d.rms)], [`${channels} max, pixel`, deviation(d)],
                 [`${channels} 99 %`, twoDigits(d.p99)], [`${channels} mean`, twoDigits(d.mean)]);
    }
    facts.push(['step error RMS', twoDigits(point.step_error?.rms)],
               ['arithmetic RMS', twoDigits(point.arithmetic_error?.rms)],
               ['look-ups per ray', point.samples_per_ray.toFixed(1)],
               ['segments per ray', point.steps_per_ray.toFixed(1)]);
    for (const [name, clock] of [['GPU', 'gpu'], ['wall', 'wall'], ['CPU', 'cpu']])
      facts.push([`${name} ms`, spreadText(timeOf(point, clock))]);
    return [...facts, ['atlas MiB', (point.atlas_bytes / 2 ** 20).toFixed(2)]];
  }

  function foreignFacts({rms, opaque, error, time_ms: time}) {
    return [['RMS', twoDigits(rms)], ['over', opaque ? 'R G B' : 'R G B A'],
            ['radiance max, pixel', deviation(error.radiance)],
            ['radiance 99 %', twoDigits(error.radiance.p99)],
            ['radiance mean', twoDigits(error.radiance.mean)],
            ['alpha RMS', opaque ? none : twoDigits(error.alpha.rms)],
            ['ms, as given', time > 0 ? time.toFixed(1) : none]];
  }

  const chosenText = ({chosen}) => chosen ? `: ${chosen.name}` : '';

  /** The card of a plot's point, by its name: what a tooltip shows. */
  function cards() {
    const brief = ['RMS', 'radiance max, pixel', 'look-ups per ray', 'CPU ms', 'wall ms', 'GPU ms'];
    const known = new Map();
    for (const point of data.points)
      known.set(point.name, {
        rows: [...point.chosen ? [['chosen', point.chosen.name]] : [],
               ...factsOf(point).filter(([label]) => brief.includes(label))],
        pictures: pairOf(fileOf(point.name), point.difference_scale, '')
      });
    for (const point of data.foreign)
      known.set(shownName(point), {
        rows: foreignFacts(point),
        pictures: pairOf(fileOf(`foreign_${point.name}`), point.difference_scale, '')
      });
    return known;
  }

  function cardOf(known, {name, x, y, series}) {
    const {rows, pictures} =
      known.get(name) ?? {rows: [['cost', numberText(x)], ['RMS', numberText(y)]], pictures: []};
    const table = element('table');
    for (const [label, text] of rows)
      table.insertRow().append(element('td', {}, label), element('td', {}, text));
    const card = element('div', {className: 'card'}, element('h4', {}, name), table,
                         element('div', {className: 'pictures'}, ...pictures));
    card.style.borderColor = series.color;
    return card;
  }

  function showPlots(title, text, plots, known) {
    const drawn = plots.filter(plot => plot !== null);
    if (drawn.length === 0) return;
    section(title, ...text ? [paragraph(text)] : [], element('p', {className: 'hint'},
      'Point at a mark to see what it stands for. Click a name in the legend to hide its curves; ' +
      'double-click it to show them alone. Drag to zoom into a box, Shift+drag to move, ' +
      'Ctrl+wheel to zoom, double-click to reset.'),
      ...drawn.map(plot => plotOf(plot, point => cardOf(known, point))));
  }

  function studyPlots() {
    const {points, foreign} = data;
    const timed = (name, title, x, clock) => {
      const plot = costPlot(points, name, title, `${x} [ms], median and quartiles`,
                            point => timeOf(point, clock));
      const curves = new Map();  // of other renderers, by the name before a space
      for (const point of foreign.filter(p => plot && p.time_ms > 0)) {
        const text = `${point.name.split(' ')[0]} (foreign, time as given)`;
        if (!curves.has(text)) {
          const color = foreignInks[curves.size % foreignInks.length];
          const entry = {text, color, shape: 'triangle', joined: true};
          plot.legend.push(entry);
          curves.set(text, {...entry, points: [], entries: [text]});
        }
        curves.get(text).points.push({x: point.time_ms, y: point.rms, name: shownName(point)});
      }
      plot?.series.unshift(...curves.values());
      return plot;
    };
    return [
      costPlot(points, 'error-step', 'Error by step', 'uniform step [voxels]',
               point => ({median: point.step ?? 0}), false),
      costPlot(points, 'error-samples', 'Error by look-ups', 'field look-ups per ray',
               point => ({median: point.samples_per_ray})),
      data.clock_note ? null : timed('error-time', "Error by the GPU's time",
                                     "time of the draws by the GPU's timer", 'gpu'),
      timed('error-cpu', 'Error by processor time', 'processor time of the march', 'cpu')];
  }

  function headOf() {
    const {scene, machine, reference, repeats} = data;
    const set = value => value !== 'none' && value !== '';
    const surface = scene.mode === 'isosurface';
    const vectorText = light => Array.isArray(light) || typeof light !== 'object' ? String(light) :
      Object.entries(light).map(([of, numbers]) => `${of}:${numbers}`).join();
    const lights = [...[scene.light].flat().filter(set).map(vectorText),
                    ...set(scene.sky) ? [`sky ${scene.sky}`] : [],
                    ...set(scene.environment) ? [`environment '${scene.environment}'`] : []].join('; ');
    const emission = scene['emission-grid'] && scene.mode === 'alpha' ?
      `${scene['emission-scale']} times '${scene['emission-grid']}' (${scene['emission-color']})` : 'none';
    const luminance = [
      String(scene.luminance),
      ...scene['luminance-grid'] ? [`${scene['luminance-scale']} of '${scene['luminance-grid']}'`] : [],
      ...scene['temperature-grid'] ? [`a black body's, of '${scene['temperature-grid']}'`] : [],
      ...set(scene.colormap) ? [`the colours of ${scene.colormap}`] : [],
      ...scene['transfer-function'] ? [`the colours of ${scene['transfer-function']}`] : []];
    return tableOf([
      ['study', ''], ['file', `${data.input.file}, SHA-256 ${data.input.sha256}`], ['date', data.date],
      ['light', !lights ? 'none' : surface ? `${lights}; it shades the surface` :
        `${lights}; scattered once. A ray in double from each voxel to each light, once for the ` +
        'reference and all pictures: its error is in no number below'],
      ['luminance', luminance.join(' times ')], ['emission', emission],
      ['reference', 'adaptive quadrature in double; its error is at most ' +
                    `${twoDigits(reference.error_bound)} at any pixel`],
      ['points', `${data.points.length}, each timed ${repeats === 1 ? 'once' : `${repeats} times`}`],
      ['psivox', versionText()], ['GL', data.renderer],
      ['machine', `${machine.processor}, ${machine.threads} threads, ${machine.system}`]], true);
  }
  const versionText = () => data.version + (data.git ? ` (${data.git})` : '');
  const conclusion = text => main.append(paragraph(text, {className: 'conclusion'}));

  function firstScreen() {
    const sizes = [...new Set(data.points.map(({resolution}) => resolution ?? ''))];
    const pictures = sizes.map(size => figureOf(
      size ? `reference_${size}.png` : 'reference.png', 'the picture, by the reference', 'the picture'));
    const links = files.links.map(href => element('p', {}, element('a', {href}, 'Turn the picture')));
    conclusion(data.conclusion.sentence);
    main.append(
      element('div', {className: 'first'}, element('div', {}, ...pictures, ...links),
        element('div', {}, paragraph('This command draws this picture; append a setting\'s options ' +
                                     'to draw it that way:'),
                element('pre', {className: 'command'}, ...inElements('span', data.command)), headOf())),
      paragraph('Within 8 bits: 99 % of the values of radiance and of alpha differ from the ' +
        'reference by at most 1/510. Of all settings, the one with the fewest look-ups counts; where ' +
        'others have at most 5 % more, the one with the least processor time; where that differs by ' +
        'at most 20 %, the one with the least RMS.'));
  }

  function cheapestRows() {
    const cheapest = (rms, costOf, unit) => {
      const good = data.points.filter(p => p.error.rms <= rms && costOf(p) > 0);
      const best = good.sort((a, b) => costOf(a) - costOf(b))[0];
      return best ? `${best.name}: ${costOf(best).toFixed(1)}${unit}` : none;
    };
    return [['RMS at most', 'fewest look-ups per ray', 'least processor time'],
            ...usualRms.map(rms => [powerText(rms), cheapest(rms, lookUps, ''),
                                    cheapest(rms, processorTime, ' ms')])];
  }

  /** Errors, and times over that of porter-duff under the same sampling. */
  function rulesRows() {
    const baseline = new Map(data.points.filter(({rule}) => rule === 'porter-duff')
                                        .map(p => [p.setting, processorTime(p)]));
    return rowsOf('rule', data.points.map(point => {
      const share = processorTime(point) / baseline.get(point.setting);
      return [point.rule, point.setting, twoDigits(point.error.rms) +
              (share > 0 && share < Infinity ? ` (${share.toFixed(2)})` : '')];
    }));
  }

  function needsRows() {
    return rowsOf('rule', [...curvesOf(data.points)].flatMap(([name, curve]) => usualRms.map(rms => {
      const need = needOf(curve, rms, lookUps), time = needOf(curve, rms, processorTime);
      return [name, `RMS ${powerText(rms)}`, need === null ? none :
        `${need.atMost ? '≤ ' : ''}${need.cost.toFixed(1)}` +
        (time.cost > 0 ? `, ${time.cost.toFixed(1)} ms` : '')];
    })));
  }

  function skippedRows() {
    const rows = new Map();
    for (const {rule, setting, reason} of data.skipped) {
      const row = `${rule}\n${reason}`;
      rows.set(row, [...rows.get(row) ?? [], setting]);
    }
    return [['skipped', 'why'], ...[...rows].map(([row, settings]) => {
      const [rule, reason] = row.split('\n');
      return [`${rule}: ${settings.join(', ')}`, reason];
    })];
  }

  function showStudy() {
    const {points, foreign} = data;
    const numbers = all => all.flatMap(([name, facts]) => facts.map(fact => [name, ...fact]));
    firstScreen();
    table('Cheapest ways to an error',
      'Error is the RMS over R G B A of the GPU\'s picture less the reference, in linear radiance. For ' +
      'each error the table names the measured variant that stays below it with the fewest field ' +
      'look-ups per ray, and the one with the least processor time.', cheapestRows(), true);
    showPlots('Plots', data.clock_note, studyPlots(), cards());
    table('Other renderers',
      'Pictures of other renderers, through the same camera, less the reference. A picture whose alpha ' +
      'is 1 everywhere is compared in R G B, over the scene\'s background or black; the others in R G ' +
      'B A, premultiplied. Times are as given: psivox did not measure them.',
      rowsOf('renderer', numbers(foreign.map(p => [shownName(p), foreignFacts(p)]))));
    table('Rules by samplings',
      'Each cell has the RMS over R G B A against the reference and, in parentheses, the processor time ' +
      'of the march over that of porter-duff in the same column.', rulesRows());
    section('Rules', ruleList(points));
    table('What an error takes',
      'Each cell has the field look-ups per ray and the processor time of the march at an RMS, ' +
      'interpolated between measured points linearly in the logarithms. ≤: the coarsest point already ' +
      'reaches the RMS; –: no point reaches it.', needsRows());
    table('All numbers',
      'Times are medians, with the quartiles in parentheses. The step error is the march in double less ' +
      'the reference; the arithmetic error is the GPU\'s picture less the march in double.',
      rowsOf('variant', numbers(points.map(p => [p.name + chosenText(p), factsOf(p)]))));
    table('Skipped', '', skippedRows(), true);
    const pairs = [...points.map(p => pairOf(fileOf(p.name), p.difference_scale, p.name)),
                   ...foreign.map(p => pairOf(fileOf(`foreign_${p.name}`), p.difference_scale,
                                              shownName(p)))];
    section('Pictures', element('div', {className: 'gallery'}, ...pairs.map(pair =>
      element('div', {className: 'pair'}, ...pair))));
    const file = data.input.file.split('/').at(-1);
    section('Data', element('p', {}, 'All numbers: ',
      element('a', {href: 'results.csv'}, 'results.csv'), ', ',
      element('a', {href: 'results.json'}, 'results.json'),
      `. Cite as: psivox ${versionText()}, study of ${file}, ${data.date}.`));
    section('Scene', element('pre', {}, JSON.stringify(data.scene, null, 1)));
  }

  // --- the precision suite -----------------------------------------------------------------------

  /** Look-ups by RMS: geometric means over the scenes, where all of them reach it. */
  function meanPlot(scenes, name, title) {
    const names = [...new Set(scenes.flatMap(({points}) => points.map(({curve}) => curve)))];
    const curves = names.map(curve => {
      const own = scenes.map(({points}) => curvesOf(points).get(curve) ?? []);
      const places = Array.from({length: 10}, (_, i) => 10 ** (-2 - i / 3)).flatMap(y => {
        const needs = own.map(points => needOf(points, y, lookUps));
        if (needs.includes(null)) return [];
        const mean = needs.reduce((sum, {cost}) => sum + Math.log(cost), 0) / needs.length;
        return [{x: Math.exp(mean), y, name: curve}];
      });
      return [own.flat()[0], places];
    }).filter(([, places]) => places.length > 0);
    return {...plotOfCurves(curves), name, x: 'field look-ups per ray, geometric mean',
            title: `${title}: geometric mean of ${scenes.length} scenes`};
  }

  function showSuite() {
    const {scenes, misses} = data;
    const mission = ['porter-duff', 'psi-weighted', 'psi-balanced', 'preintegrated'];
    const few = scenes.map(scene => ({...scene, points: scene.points.filter(({rule, sampling}) =>
      rule === 'cell-exact' || (sampling === 'uniform' && mission.includes(rule)))}));
    conclusion(data.conclusion);
    main.append(
      ...misses.map(miss => element('p', {}, element('b', {}, 'Not as expected: '), miss)),
      paragraph('A volume renderer integrates light along each pixel\'s ray: the radiance is ∫ L τ T ds, ' +
        'where τ is the attenuation, L the luminance of the medium and T the transmittance in front. ' +
        'Each rule is one way to do that from samples of the volume (look-ups): at uniform steps, or ' +
        'from voxel face to voxel face in so many segments a cell. In every scene here the truth is ' +
        'known: the reference integrates the trilinear data in double precision, by another algorithm, ' +
        'with a bound on its own error at each pixel. Errors are over R, G, B and A of linear radiance, in float32, as drawn by the GL ' +
        'driver named below. Times are processor times of one march; everything else is the same on ' +
        'every run.'),
      paragraph(`psivox ${versionText()}, ${data.renderer}`),
      element('div', {className: 'gallery'}, ...scenes.map(({name}) => figureOf(`${name}.png`, name))));
    showPlots('Error by look-ups', '', [
      meanPlot(few.filter(s => !s.function), 'suite-values', 'Values that glow'),
      meanPlot(few.filter(s => s.function === 'value'), 'suite-functions', 'Through transfer functions'),
      ...scenes.map(({name, points}) => costPlot(points, name, name, 'field look-ups per ray',
                                                 p => ({median: p.samples_per_ray})))], new Map());
    section('Rules', ruleList(scenes.flatMap(({points}) => points)));
    table('Scenes', '', [['scene', 'medium', 'reference\'s own bound'],
      ...scenes.map(s => [s.name, s.medium, twoDigits(s.reference_bound)])], true);
    table('Orders of convergence',
      'The error falls as a power of the step, which theory gives: the expected order. The measured one ' +
      'is the slope in logarithms over the finest four errors above four times float32\'s rounding. The ' +
      'field has kinks at faces of cells, and no rule between uniform samples keeps more than order 2.',
      [['scene', 'rule, sampling', 'expected', 'measured', 'verdict'],
       ...scenes.flatMap(({name, orders}) => orders.map(o => [
         name, o.way, o.expected > 0 ? String(o.expected) : 'none', o.order?.toFixed(2) ?? none,
         o.expected > 0 ? o.verdict : 'not held']))]);
    table('All pictures',
      'Marschner and Lobb\'s signal as Weiss and Westermann (2021) measure it: PSNR over R G B A with a ' +
      'peak of 1, and the share of the absolute differences above powers of ten.',
      rowsOf('picture', scenes.flatMap(({name, points}) => points.flatMap(p => [
        ['RMS', twoDigits(p.error.rms)], ['99.9 % below', twoDigits(p.p999)], ['largest', twoDigits(p.max)],
        ['PSNR [dB]', p.psnr?.toFixed(1) ?? none], ['look-ups a ray', p.samples_per_ray.toFixed(1)],
        ['time [ms]', processorTime(p).toFixed(1)],
        ...p.above.map((part, i) => [`> 1e-${i + 1} [%]`, twoDigits(100 * part)])
      ].map(fact => [`${name}: ${p.name}`, ...fact])))));
  }

  // --- a sequence --------------------------------------------------------------------------------

  function showFrames() {
    conclusion(data.conclusion);
    main.append(tableOf([
      ['rule, sampling', 'RMS, median', 'least', 'greatest', 'in frame', 'look-ups a ray, median',
       'greatest', 'processor time, median [ms]'],
      ...data.methods.map(m => [m.variant, ...[m.rms_median, m.rms_min, m.rms_max].map(twoDigits),
        String(m.worst_frame), m.samples_per_ray_median.toFixed(1), m.samples_per_ray_max.toFixed(1),
        m.cpu_ms_median.toFixed(1)])]));
    section('Frames', element('p', {}, ...data.frames.flatMap(({frame, folder}) =>
      [element('a', {href: `${encodeURIComponent(folder)}/index.html`}, String(frame)), ' '])));
  }

  document.body.append(tip);
  if (data.scenes) showSuite();
  else if (data.frames) showFrames();
  else showStudy();
})();
