// Bricks in codes (CodeWidth in atlas.h). A texel is a word of 64 bits; with light beside the density it
// is two, and with coloured light two texels follow each other: the density and red, green and blue.

int code_texels() { return paired && luminance_source == SOURCE_VECTOR ? 2 : 1; }

// Where a coded brick has the codes of a cell.
struct CodedCell {
  int head;
  int rows;    // texel of the first of its four rows
  int next_y;  // texels to the next one along y
  int next_x;
  uint bit;    // where the codes begin in a word
  uint width;  // of a code [bits]
};

CodedCell find_codes(int payload, int3 cell) {
  int n = code_texels();
  int head = payload * CODE_WORDS * n;
  int wide = int(fetch_code(head).y & 3u);
  uint width = uint(7 + 5 * wide - (wide >> 1));
  int row = cell.x * BRICK_VALUES + cell.y;
  return CodedCell(head, head + (1 + ((row * BRICK_CELLS + cell.z) >> (3 - wide))) * n, n << wide,
                   (BRICK_VALUES << wide) * n, uint(cell.z & ((BRICK_CELLS >> wide) - 1)) * width, width);
}

// The codes at the two ends of a cell along z, in a row's word.
real2 codes_in(IN(CodedCell) c, uint low, uint high) {
  bool is_high = c.bit >= 32u;
  uint shift = c.bit & 31u;
  uint bits = ((is_high ? high : low) >> shift) | (((is_high ? 0u : high) << 1u) << (31u - shift));
  uint mask = (1u << c.width) - 1u;
  return real2(real(int(bits & mask)), real(int((bits >> c.width) & mask)));
}

Corners decoded(uint offset, uint step_bits, real2 p, real2 q, real2 r, real2 s) {
  real from = real_of_bits(offset);
  real scale = real_of_bits(step_bits);
  return Corners(real4(p.x, p.y, q.x, q.y) * scale + from, real4(r.x, r.y, s.x, s.y) * scale + from);
}

// Two channels of a coded brick.
struct TwoCorners {
  Corners a;
  Corners b;
};

TwoCorners decode_two(IN(CodedCell) c, int i) {
  uint4 head = fetch_code(c.head + i);
  uint4 p = fetch_code(c.rows + i);
  uint4 q = fetch_code(c.rows + i + c.next_y);
  uint4 r = fetch_code(c.rows + i + c.next_x);
  uint4 s = fetch_code(c.rows + i + c.next_x + c.next_y);
  return TwoCorners(decoded(head.x, head.y, codes_in(c, p.x, p.y), codes_in(c, q.x, q.y),
                            codes_in(c, r.x, r.y), codes_in(c, s.x, s.y)),
                    decoded(head.z, head.w, codes_in(c, p.z, p.w), codes_in(c, q.z, q.w),
                            codes_in(c, r.z, r.w), codes_in(c, s.z, s.w)));
}

// The density, and the channels of a luminance beside it.
struct CodedBrick {
  Corners v;
  Corners x;
  Corners y;
  Corners z;
};

CodedBrick decode_brick(Node brick, int3 cell) {
  CodedCell c = find_codes(brick.payload, cell);
  TwoCorners first = decode_two(c, 0);
  if (code_texels() == 1) return CodedBrick(first.a, first.b, first.b, first.b);
  TwoCorners second = decode_two(c, 1);
  return CodedBrick(first.a, first.b, second.a, second.b);
}
