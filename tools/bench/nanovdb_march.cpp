// A ray marcher as an expert would write it over NanoVDB in an afternoon: nanovdb_loop.h, whose
// rays TBB runs in parallel. compare_peers.py builds and runs it. It uses psivox only to write its
// picture.
//
//   nanovdb_march FILE.vdb OUT.exr step=1 size=512 extinction=20 from=r,g,b to=r,g,b
//                 position=x,y,z target=x,y,z fov=35 termination=1e-6
//   nanovdb_march FILE.vdb OUT.nvdb    writes the grid that it marches, for nanovdb_march.cu
//
// Luminance is from + (to - from) * density, extinction is that of density 1 [1/world unit], the
// step is in voxels, the view is upright (+Y). It prints {"march_ms": .., "march_cpu_ms": ..}.

#include "nanovdb_loop.h"

#include <nanovdb/util/IO.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Morphology.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include "base/stopwatch.h"

namespace {

using namespace nanovdb_loop;

nanovdb::GridHandle<> load(const char* file) {
  openvdb::initialize();
  openvdb::io::File input(file);
  input.open();
  const auto grid = openvdb::gridPtrCast<openvdb::FloatGrid>(input.readGrid("density"));
  // The march stops at leaves. The dilation also makes leaves of neighbours that a leaf's cells
  // reach into, and tiles of constant leaves; tiles then become leaves.
  openvdb::tools::dilateActiveValues(grid->tree(), 1, openvdb::tools::NN_FACE_EDGE_VERTEX);
  grid->tree().voxelizeActiveTiles();
  return nanovdb::openToNanoVDB(*grid);
}

void render(const Grid& grid, const Frame& frame, const Medium& medium, float* rgba) {
  const int size = frame.size;
  tbb::parallel_for(tbb::blocked_range2d<int>(0, size, 16, 0, size, 16),
                    [&](const tbb::blocked_range2d<int>& tile) {
                      const auto values = grid.tree().getAccessor(),
                                 leaves = grid.tree().getAccessor();
                      for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
                        for (int x = tile.cols().begin(); x < tile.cols().end(); ++x)
                          draw_pixel(frame, x, y, grid, medium, values, leaves, rgba);
                    });
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) throw std::runtime_error("nanovdb_march FILE.vdb OUT.exr NAME=VALUE ...");
  const auto handle = load(argv[1]);
  if (const std::string out = argv[2]; out.ends_with(".nvdb")) {
    nanovdb::io::writeGrid(out, handle);
    return 0;
  }
  const Options options(argc, argv);
  const Grid& grid = *handle.grid<float>();
  const Frame frame(options);
  const Medium medium(options, grid.voxelSize()[0]);
  psivox::Image image = picture_of(frame.size);

  const psivox::Stopwatch watch;
  render(grid, frame, medium, image.layers[0].values.data());
  std::printf("{\"march_ms\": %.3f, \"march_cpu_ms\": %.3f}\n", watch.ms(), watch.cpu_ms());
  psivox::write_image(image, argv[2]);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "nanovdb_march: %s\n", error.what());
  return 1;
}
