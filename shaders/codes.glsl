// Bricks in codes (CodeWidth in atlas.h): a record for the density and for each channel beside it.

// Where a record of a coded brick has the codes of a cell.
struct CodedCell {
  int word;    // of the first of its four rows
  int next_y;  // words to the next one along y
  int next_x;
  int behind;  // first word of the next record
  uint bit;    // where the codes begin in a word
  uint width;  // of a code [bits]
  real offset;
  real scale;
};

CodedCell find_codes(int first, int3 cell) {
  uint2 head = fetch_code(first);
  int wide = int(head.y & 3u);
  uint width = uint(7 + 5 * wide - (wide >> 1));
  int row = cell.x * BRICK_VALUES + cell.y;
  return CodedCell(first + 1 + ((row * BRICK_CELLS + cell.z) >> (3 - wide)), 1 << wide,
                   BRICK_VALUES << wide, first + (CODE_WORDS << wide), uint(cell.z & ((BRICK_CELLS >> wide) - 1)) * width,
                   width, real_of_bits(head.x), real_of_bits(head.y));
}

// The codes at the two ends of a cell along z, in a row's word.
real2 codes_at(IN(CodedCell) c, int i) {
  uint2 word = fetch_code(i);
  bool high = c.bit >= 32u;
  uint shift = c.bit & 31u;
  uint low = ((high ? word.y : word.x) >> shift) | (((high ? 0u : word.y) << 1u) << (31u - shift));
  uint mask = (1u << c.width) - 1u;
  return real2(real(int(low & mask)), real(int((low >> c.width) & mask)));
}

real4 decoded(IN(CodedCell) c, int i) {
  real2 a = codes_at(c, i);
  real2 b = codes_at(c, i + c.next_y);
  return real4(a.x, a.y, b.x, b.y) * c.scale + c.offset;
}

Corners decoded(IN(CodedCell) c) { return Corners(decoded(c, c.word), decoded(c, c.word + c.next_x)); }

// The records of a coded brick: the density, then each channel of a luminance beside it.
struct CodedBrick {
  Corners v;
  Corners x;
  Corners y;
  Corners z;
};

CodedBrick decode_brick(Node brick, int3 cell) {
  CodedCell c = find_codes(brick.payload * CODE_WORDS, cell);
  Corners v = decoded(c);
  c = find_codes(c.behind, cell);
  Corners x = decoded(c);
  if (luminance_source != SOURCE_VECTOR) return CodedBrick(v, x, x, x);
  c = find_codes(c.behind, cell);
  Corners y = decoded(c);
  return CodedBrick(v, x, y, decoded(find_codes(c.behind, cell)));
}
