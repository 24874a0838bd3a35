// Bricks in codes (CodeWidth in atlas.h). A texel is a word of 64 bits; with light beside the density it
// is two, and with coloured light two texels follow each other: the density and red, green and blue.

int code_texels() { return paired && luminance_source == SOURCE_VECTOR ? 2 : 1; }

// Where a coded brick has the codes of a cell.
struct CodedCell {
  uint4 head;  // offset and step of the density's code, and of the luminance's, as bits of floats
  int rows;    // texel of the first of its four rows
  int next_y;  // texels to the next one along y
  int next_x;
  uint bit;    // where the codes begin in a word
  uint width;  // of a code [bits]
};

CodedCell find_codes(int payload, int3 cell) {
  int n = code_texels();
  int first = payload * CODE_WORDS * n;
  uint4 head = fetch_code(first);
  int wide = one_width;
  if (one_width < 0) wide = int(head.y & 3u);
  uint width = uint(7 + 5 * wide - (wide >> 1));
  int row = cell.x * BRICK_VALUES + cell.y;
  return CodedCell(head, first + (1 + ((row * BRICK_CELLS + cell.z) >> (3 - wide))) * n,
                   (1 << wide) * n, (BRICK_VALUES << wide) * n,
                   uint(cell.z & ((BRICK_CELLS >> wide) - 1)) * width, width);
}

// The codes at the two ends of a cell along z, in a row's word; where `nearest` the first one twice.
// If both lie in `high`, `bits` repeats a part of it above them. The masks leave that out, because a
// word has at most 63 bits.
real2 codes_in(IN(CodedCell) c, uint low, uint high) {
  bool is_high = c.bit >= 32u;
  uint shift = c.bit & 31u;
  uint bits = ((is_high ? high : low) >> shift) | ((high << 1u) << (31u - shift));
  uint mask = (1u << c.width) - 1u;
  real first = real(int(bits & mask));
  return real2(first, nearest ? first : real(int((bits >> c.width) & mask)));
}

// A channel's corners, by its code: two numbers of a head.
Corners code_corners(uint offset, uint step_bits, real2 p, real2 q, real2 r, real2 s) {
  return Corners(real4(p.x, p.y, q.x, q.y), real4(r.x, r.y, s.x, s.y),
                 real_of_bits(step_bits & ~uint(CODE_WIDTH_BITS)), real_of_bits(offset));
}

// Two channels of a coded brick.
struct TwoCorners {
  Corners a;
  Corners b;
};

// Of texel i of each word; `codes` has the offset and the step of one channel and of the other.
TwoCorners decode_two(IN(CodedCell) c, int i, uint4 codes) {
  uint4 p = fetch_code(c.rows + i);
  uint4 q = p;
  uint4 r = p;
  uint4 s = p;
  if (!nearest) {
    q = fetch_code(c.rows + i + c.next_y);
    r = fetch_code(c.rows + i + c.next_x);
    s = fetch_code(c.rows + i + c.next_x + c.next_y);
  }
  return TwoCorners(code_corners(codes.x, codes.y, codes_in(c, p.x, p.y), codes_in(c, q.x, q.y),
                                 codes_in(c, r.x, r.y), codes_in(c, s.x, s.y)),
                    code_corners(codes.z, codes.w, codes_in(c, p.z, p.w), codes_in(c, q.z, q.w),
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
  TwoCorners first = decode_two(c, 0, c.head);
  if (code_texels() == 1) return CodedBrick(first.a, first.b, first.b, first.b);
  TwoCorners second = decode_two(c, 1, uint4(c.head.z, c.head.w, c.head.z, c.head.w));
  return CodedBrick(first.a, first.b, second.a, second.b);
}
