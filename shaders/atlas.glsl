// Brick atlas: from a cell to the node of the page table that covers it, and to its texels.
//
// Each language supplies the ids of the grids (density_grid and so on), the constants of
// src/march/glsl_subset.h, and the functions fetch_page(grid, i), fetch_constant(grid, i),
// fetch_constant3, fetch_texel(grid, i), fetch_texel3, filtered_texel(grid, slot, local),
// filtered_texel3, fetch_table(i), fetch_interval(i); fetch_pair(i): the density's texel and, where
// `paired`, the luminance's beside it, whose bricks have the same slots.

// A cube of cells of one kind: of an entry, of the empty entries around one, or an octant of a brick.
struct Node {
  int kind;
  int payload;  // of a brick: its slot
  int3 lo;      // first cell
  int side;     // cells along each axis
};

Node empty_node(int3 lo, int side) { return Node(NODE_EMPTY, 0, lo, side); }

// What a cell with an absent corner is: vacuum, of no value.
const int ABSENT = -1;
Node absent_node(int3 lo, int side) { return Node(NODE_EMPTY, ABSENT, lo, side); }
bool is_absent(Node node) {
  return absent_voxels && node.kind == NODE_EMPTY && node.payload == ABSENT;
}
Node no_node() { return empty_node(int3(0), 0); }

// In the cube: a negative difference is a large one without its sign.
bool inside(Node node, int3 cell) {
  int3 d = cell - node.lo;
  return max(max(uint(d.x), uint(d.y)), uint(d.z)) < uint(node.side);
}

bool inside_box(int3 lo, int3 hi, int3 cell) {
  return cell.x >= lo.x && cell.y >= lo.y && cell.z >= lo.z && cell.x < hi.x && cell.y < hi.y &&
         cell.z < hi.z;
}

IN(Grid) grid_of(int grid) {
#define GRID(id, name) if (grid == id) return name;
#include "grids.glsl"
#undef GRID
  return density;
}

int levels_of(int grid) {
  return
#define GRID(id, name) grid == id ? name##_levels :
#include "grids.glsl"
#undef GRID
      0;
}

// First cell of the brick that a node is, or is an octant of. Bricks lie at multiples of their cells.
int3 first_cell(Node brick) { return brick.lo & ~(BRICK_CELLS - 1); }

// Whether two cells lie in one cube of `side` cells, a power of two, at a multiple of them.
bool in_one_cube(int side, int3 a, int3 b) {
  int3 parts = (a ^ b) & -side;
  return (parts.x | parts.y | parts.z) == 0;
}

// Where a cell lies in its brick.
int3 in_brick(int3 cell) { return cell & (BRICK_CELLS - 1); }

// The octant of a brick that holds a cell; the brick itself if none of its octants hides. An octant
// whose bit is set above the slot is empty. Both lie at multiples of their cells.
Node octant_of(Node brick, int3 cell) {
  int hidden = brick.payload >> SLOT_BITS;
  int octant = (cell.x & 4) | ((cell.y & 4) >> 1) | ((cell.z & 4) >> 2);
  int side = hidden == 0 ? BRICK_CELLS : 4;
  return Node(((hidden >> octant) & 1) != 0 ? NODE_EMPTY : NODE_BRICK, brick.payload & SLOT_MASK,
              cell & -side, side);
}

// The node of a table's entry that spans 2^shift voxels and holds a cell, which is `at` in the table.
Node node_of(uint entry, int3 cell, int3 at, int shift) {
  int kind = int(entry >> PAYLOAD_BITS);
  int payload = int(entry) & PAYLOAD_MASK;
  int3 lo = cell - (at & ((1 << shift) - 1));
  int grow = kind == NODE_EMPTY ? (payload - 1) << shift : 0;
  return Node(kind, payload, lo - grow, (1 << shift) + 2 * grow);
}

// The entry that covers a cell of the domain.
Node find_entry(int grid, int3 cell) {
  int3 at = cell - grid_of(grid).table_min;
  int3 size = grid_of(grid).table_size;
  int shift = 3 * levels_of(grid);
  int3 q = at >> shift;
  uint entry = fetch_page(grid, (q.x * size.y + q.y) * size.z + q.z);
  if (levels_of(grid) > 1) {
    while (int(entry >> PAYLOAD_BITS) == NODE_CHILD) {
      shift -= 3;
      q = (at >> shift) & 7;
      entry = fetch_page(grid, (int(entry) & PAYLOAD_MASK) + ((q.x * 8 + q.y) * 8 + q.z));
    }
  }
  return node_of(entry, cell, at, shift);
}

// The node without the octants' bits, for look-ups that need values which octants hide.
Node find_stored(int grid, int3 cell) {
  Node node = find_entry(grid, cell);
  if (octants && grid == density_grid && node.kind == NODE_BRICK)
    node.payload = node.payload & SLOT_MASK;
  return node;
}

// The node that covers a cell of the domain.
Node find_node(int grid, int3 cell) {
  Node node = find_entry(grid, cell);
  if (octants && grid == density_grid && node.kind == NODE_BRICK) node = octant_of(node, cell);
  return node;
}

// A brick's value at a voxel, given from the brick's first one: its place among the texels.
int texel_index(int slot, int3 voxel) {
  return slot * BRICK_TEXELS + (voxel.x * BRICK_VALUES + voxel.y) * BRICK_VALUES + voxel.z;
}
