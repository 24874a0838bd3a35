// The march on a page: the shaders are its own, written for WebGL 2 (src/gl/webgl_march.h).

// --- textures, programs, targets ------------------------------------------------------------------
const row = 4096;  // entries of a texture's row, as in shaders/webgl.glsl
const gl = canvas.getContext("webgl2", {alpha: false, antialias: false, preserveDrawingBuffer: true});

function formats(name) {
  const uint = name.endsWith("UI");
  const channels = name.match(/^[RGBA]+/)[0].length;
  return {
    channels, internal: gl[name], type: uint ? gl.UNSIGNED_INT : gl.FLOAT,
    format: uint ? [gl.RED_INTEGER, gl.RG_INTEGER, , gl.RGBA_INTEGER][channels - 1] : [gl.RED, gl.RG, gl.RGB, gl.RGBA][channels - 1],
    array: uint ? Uint32Array : Float32Array,
  };
}

// The numbers of an element: their first bytes, their second ones, ..., deflated.
async function numbers(id, array) {
  const text = atob(element(id).textContent), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("deflate"));
  const planes = new Uint8Array(await new Response(stream).arrayBuffer());
  const size = array.BYTES_PER_ELEMENT, count = planes.length / size, result = new Uint8Array(planes.length);
  for (let k = 0; k < size; ++k)
    for (let i = 0; i < count; ++i) result[i * size + k] = planes[k * count + i];
  element(id).remove();
  return new array(result.buffer);
}

const code_bits = [7, 12, 16];  // by the width of CodeWidth in src/atlas/atlas.h

// The words of bricks in codes, as add_differences in src/page/packed_numbers.cpp takes them apart.
// Places count numbers of 32 bits; each word has two.
function words_of(heads, differences, channels) {
  const bricks = [], codes = new Int32Array(729), pair = 2 * channels;
  let end = 0, first = 0;
  for (let i = 0; i < heads.length; i += pair) {
    const wide = heads[i + 1] & 3;
    bricks.push({wide, place: end, head: heads.subarray(i, i + pair)});
    end += (82 << wide) * pair;
  }
  const words = new Uint32Array(end);
  for (const {place, head} of bricks) words.set(head, place);
  for (const wide of [0, 1, 2])
    for (let channel = 0; channel < channels; ++channel)
      for (const brick of bricks) {
        if (brick.wide !== wide) continue;
        for (let k = 0; k < 729; ++k) {
          const folded = differences[first + k] >> (16 - code_bits[wide]);
          codes[k] = folded & 1 ? ~(folded >> 1) : folded >> 1;
        }
        first += 729;
        for (const stride of [1, 9, 81])
          for (let k = stride; k < 729; ++k) if (Math.floor(k / stride) % 9) codes[k] += codes[k - stride];
        put_codes(codes, wide, words.subarray(brick.place + pair + 2 * channel), pair);
      }
  return words;
}

function put_codes(codes, wide, words, stride) {
  const cells = 8 >> wide, bits = code_bits[wide], mask = (1 << bits) - 1;
  for (let row = 0, at = 0; row < 81; ++row)
    for (let z = 0; z < 8; z += cells, at += stride)
      for (let k = 0; k <= cells; ++k) {  // no two codes have a bit in common
        const part = (codes[9 * row + z + k] & mask) * 2 ** (k * bits);
        words[at] += part % 2 ** 32;
        words[at + 1] += Math.floor(part / 2 ** 32);
      }
}

async function load_texture(texture, unit) {
  const {channels, internal, format, type, array} = formats(texture.format);
  const parts = [];
  const part = (i, of) => numbers(`${texture.name}-${i}`, of);
  if (texture.code_channels)
    parts.push(words_of(await part(0, array), await part(1, Uint16Array), texture.code_channels));
  else for (let i = 0; i < texture.channels.length; ++i) parts.push(await part(i, array));
  const entries = parts[0].length / texture.channels[0], rows = Math.max(1, Math.ceil(entries / row));
  if (rows > gl.getParameter(gl.MAX_TEXTURE_SIZE)) throw Error("This device's textures are too small.");
  const all = new array(rows * row * channels);
  let first = 0;
  parts.forEach((part, k) => {
    const own = texture.channels[k];
    for (let i = 0; i < entries; ++i)
      for (let c = 0; c < own; ++c) all[i * channels + first + c] = part[i * own + c];
    first += own;
  });
  new_texture(unit);
  gl.texStorage2D(gl.TEXTURE_2D, 1, internal, row, rows);
  gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, row, rows, format, type, all);
}

function new_texture(unit) {
  const texture = gl.createTexture();
  gl.activeTexture(gl.TEXTURE0 + unit);
  gl.bindTexture(gl.TEXTURE_2D, texture);
  for (const filter of [gl.TEXTURE_MIN_FILTER, gl.TEXTURE_MAG_FILTER])
    gl.texParameteri(gl.TEXTURE_2D, filter, gl.NEAREST);
  return texture;
}

function build(id) {
  const program = gl.createProgram();
  const vertex = `#version 300 es
    void main() { gl_Position = vec4(gl_VertexID == 1 ? 3 : -1, gl_VertexID == 2 ? 3 : -1, 0, 1); }`;
  for (const [type, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, element(id).textContent]]) {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS))
      throw Error(`The shader does not compile: ${gl.getShaderInfoLog(shader)}`);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS))
    throw Error(`The shader does not link: ${gl.getProgramInfoLog(program)}`);
  const places = {};
  return (name, kind, ...values) => {  // sets a uniform; those that the shader does not have are ignored
    gl.useProgram(program);
    places[name] ??= gl.getUniformLocation(program, name);
    gl[`uniform${kind}v`](places[name], values);
  };
}

class Target {  // a picture of radiance, top row first
  constructor(unit, size) {
    this.size = size;
    this.texture = new_texture(unit);
    gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA32F, ...size);
    this.buffer = gl.createFramebuffer();
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, gl.TEXTURE_2D, this.texture, 0);
  }
  bind(unit) {
    gl.activeTexture(gl.TEXTURE0 + unit);
    gl.bindTexture(gl.TEXTURE_2D, this.texture);
  }
  clear() {
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.buffer);
    gl.disable(gl.SCISSOR_TEST);
    gl.clearBufferfv(gl.COLOR, 0, [0, 0, 0, -1]);
  }
  delete() {
    gl.deleteFramebuffer(this.buffer);
    gl.deleteTexture(this.texture);
  }
}

// Until the commands so far are done [ms].
function done() {
  const sync = gl.fenceSync(gl.SYNC_GPU_COMMANDS_COMPLETE, 0), begun = performance.now();
  gl.flush();
  return new Promise((resolve, reject) => (function poll() {
    if (gl.isContextLost()) return reject(Error("The browser has lost its graphics; load the page again."));
    if (gl.getSyncParameter(sync, gl.SYNC_STATUS) !== gl.SIGNALED) return setTimeout(poll);
    gl.deleteSync(sync);
    resolve(performance.now() - begun);
  })());
}

// --- the march -----------------------------------------------------------------------------------
const march = scene.march, tables_unit = march.textures.findIndex(texture => texture.name === "tables");
const fine_unit = march.textures.length, coarse_unit = fine_unit + 1;
// what the medium's light is multiplied by before a bright background
const contrast = () => scene.contrast && background === 3 ? scene.contrast.factor : 1;
const background_choices = [scene.background ?? [0, 0, 0], [0, 0, 0], [0.2, 0.2, 0.2], [1, 1, 1]];
let set_march, set_display, fine, coarse;
let exposure = scene.exposure, background = 0, samples = march.samples;

async function load() {
  if (!gl) throw Error("This browser has no WebGL 2: the picture does not turn.");
  if (!gl.getExtension("EXT_color_buffer_float"))
    throw Error("This browser's WebGL draws no floats: the picture does not turn.");
  if (samples.length > 1 && !gl.getExtension("EXT_float_blend")) {
    samples = [[0.5, 0.5]];
    element("message").textContent = "This browser draws one sample a pixel.";
  }
  set_march = build_march("march");
  set_display = build("display");
  for (const [unit, texture] of march.textures.entries()) await load_texture(texture, unit);
  set_display("fine", "1i", fine_unit);
  set_display("coarse", "1i", coarse_unit);
  set_display("tone_map", "1i", scene.tone_map);
}

// A program of march.frag, with all uniforms that stay.
function build_march(id) {
  const set = build(id);
  for (const [name, kind, values] of march.uniforms) set(name, kind, ...values);
  for (const [unit, texture] of march.textures.entries()) set(texture.name, "1i", unit);
  return set;
}

// As place_clip in src/march/march_tables.cpp: distance and speed as functions of u and v, each with
// what float32 leaves of it.
function place_clip(c, distance) {
  const anchor = sum(c.position, times(distance, c.forward)), spread = first.orthographic ? 1 : distance;
  const entries = march.clip.flatMap(({normal, offset}) => {
    const across = [0, dot(normal, c.right) * c.half_width, dot(normal, c.up) * c.half_height];
    const at = sum([dot(normal, anchor) - offset, 0, 0], times(spread, across));
    const along = [dot(normal, c.forward), 0, 0];
    return [times(1 / march.unit, at), first.orthographic ? along : sum(along, across)];
  });
  gl.activeTexture(gl.TEXTURE0 + tables_unit);
  entries.flatMap(e => [e.map(Math.fround), e.map(v => v - Math.fround(v))]).forEach((entry, i) => {
    const at = march.clip_first + i;
    gl.texSubImage2D(gl.TEXTURE_2D, 0, at % row, Math.floor(at / row), 1, 1, gl.RGBA, gl.FLOAT,
                     new Float32Array([...entry, 0]));
  });
}

// As make_ray_bundle in src/scene/camera.cpp.
function place_camera(set_march) {
  const c = camera(), distance = Math.max(0, dot(minus(march.middle, c.position), c.forward));
  const right = times(c.half_width, c.right), up = times(c.half_height, c.up);
  const spread = first.orthographic ? 1 : distance, turn = first.orthographic ? 0 : 1;
  const world = {0: c.forward, u: times(turn, right), v: times(turn, up)};
  const anchor = sum(c.position, times(distance, c.forward));
  for (const grid of march.grids) {
    const turned = v => sum(sum(times(v[0], grid.columns[0]), times(v[1], grid.columns[1])),
                            times(v[2], grid.columns[2]));
    const set = (name, value) => set_march(`given.${grid.name}.${name}`, "3f", ...value);
    set("anchor_0", turned(minus(anchor, grid.origin)));
    set("anchor_u", turned(times(spread, right)));
    set("anchor_v", turned(times(spread, up)));
    for (const k in world) set(`direction_${k}`, times(march.unit, turned(world[k])));
  }
  for (const k in world) set_march(`given.world_${k}`, "3f", ...world[k]);
  set_march("given.camera_distance", "1f", distance / march.unit);
  if (march.clip.length) place_clip(c, distance);
  return c;
}

// One sample of each pixel of a rectangle, added to those before it.
function draw(set_march, target, size, [x, y, width, height], sample, add) {
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
  gl.viewport(0, 0, ...size);
  gl.enable(gl.SCISSOR_TEST);
  gl.scissor(x, y, width, height);
  set_march("given.image_size", "2f", ...size);
  set_march("given.sample_offset", "2f", ...sample);
  if (add) gl.enable(gl.BLEND);
  gl.blendFunc(gl.ONE, gl.ONE);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
  gl.disable(gl.BLEND);
}

let set_depth;

// The point [world] at which a pixel's ray meets what hides the rest; unset: there is none.
function pick(pixel) {
  if (!element("depth").textContent) return;
  set_depth ??= build_march("depth");
  const target = new Target(fine_unit, [1, 1]), layers = new Target(coarse_unit, [1, 1]);
  gl.bindFramebuffer(gl.FRAMEBUFFER, target.buffer);
  gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT1, gl.TEXTURE_2D, layers.texture, 0);
  gl.drawBuffers([gl.COLOR_ATTACHMENT0, gl.COLOR_ATTACHMENT1]);
  const c = place_camera(set_depth), found = new Float32Array(4);
  set_depth("tile_origin", "2i", ...pixel);
  draw(set_depth, target, size, [0, 0, 1, 1], [0.5, 0.5], false);
  gl.readBuffer(gl.COLOR_ATTACHMENT1);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.FLOAT, found);
  target.delete();
  layers.delete();
  for (const [unit, kept] of [[fine_unit, fine], [coarse_unit, coarse]]) kept.bind(unit);
  if (found[0] > 1e29) return;  // NEVER in shaders/ray.glsl
  const u = 2 * (pixel[0] + 0.5) / size[0] - 1, v = 1 - 2 * (pixel[1] + 0.5) / size[1];
  const across = sum(times(u * c.half_width, c.right), times(v * c.half_height, c.up));
  if (first.orthographic) return sum(sum(c.position, across), times(found[0], c.forward));
  const way = sum(c.forward, across);
  return sum(c.position, times(found[0] / length(way), way));
}

let coarse_size = [1, 1], size = scene.size;

function show() {
  gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  gl.disable(gl.SCISSOR_TEST);
  gl.viewport(0, 0, ...size);
  set_display("size", "2i", ...size);
  set_display("coarse_size", "2i", ...coarse_size);
  set_display("samples", "1f", samples.length);
  set_display("exposure", "1f", 2 ** exposure);
  set_display("contrast", "1f", contrast());
  set_display("background", "3f", ...background_choices[background]);
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}
