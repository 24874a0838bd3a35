// A ray marcher as an expert would write it over NanoVDB in an afternoon: the HDDA finds leaves,
// the library's sampler interpolates trilinearly, homogeneous segments have their midpoints on one
// lattice per ray, TBB runs rays in parallel. compare_peers.py builds and runs it. It uses psivox
// only to write its picture.
//
//   nanovdb_march FILE.vdb OUT.exr step=1 size=512 extinction=20 from=r,g,b to=r,g,b
//                 position=x,y,z target=x,y,z fov=35 termination=1e-6
//
// Luminance is from + (to - from) * density, extinction is that of density 1 [1/world unit], the
// step is in voxels, the view is upright (+Y). It prints {"march_ms": .., "march_cpu_ms": ..}.

#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/OpenToNanoVDB.h>
#include <nanovdb/util/Ray.h>
#include <nanovdb/util/SampleFromVoxels.h>
#include <openvdb/openvdb.h>
#include <openvdb/tools/Morphology.h>
#include <tbb/blocked_range2d.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "base/stopwatch.h"
#include "psivox/image.h"

namespace {

using Vec = nanovdb::Vec3d;
using Ray = nanovdb::Ray<float>;
using Grid = nanovdb::NanoGrid<float>;

class Options {
 public:
  Options(int argc, char** argv) {
    for (int i = 3; i < argc; ++i) {
      const std::string word = argv[i];
      const std::size_t equals = word.find('=');
      values_[word.substr(0, equals)] = word.substr(equals + 1);
    }
  }
  double number(const char* name) const { return std::stod(values_.at(name)); }
  Vec triple(const char* name) const {
    double x = 0, y = 0, z = 0;
    std::sscanf(values_.at(name).c_str(), "%lf,%lf,%lf", &x, &y, &z);
    return {x, y, z};
  }

 private:
  std::map<std::string, std::string> values_;
};

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

struct Frame {
  Vec position, right, up, forward;
  double half;  ///< half size of the image plane, tan(fov / 2)
  int size;

  explicit Frame(const Options& options)
      : position(options.triple("position")),
        half(std::tan(options.number("fov") * M_PI / 360)),
        size(int(options.number("size"))) {
    forward = (options.triple("target") - position).normalize();
    right = forward.cross(Vec(0, 1, 0)).normalize();
    up = right.cross(forward);
  }
  Vec direction(int x, int y) const {
    const double u = (2 * (x + 0.5) / size - 1) * half, v = (1 - 2 * (y + 0.5) / size) * half;
    return (right * u + up * v + forward).normalize();
  }
};

struct Medium {
  nanovdb::Vec3f from, change;  ///< luminance at density 0, and its increase at density 1
  float depth;                  ///< optical depth of a segment of density 1
  float step, termination;
};

/// Radiance and opacity along a ray in index space, whose direction has length 1.
template <class Sampler, class Accessor>
void integrate(Ray ray, const Grid& grid, const Medium& medium, const Sampler& sampler,
               const Accessor& leaves, float* rgba) {
  float transmittance = 1;
  nanovdb::Vec3f sum(0);
  const auto width = [&](const nanovdb::Coord& at) {
    return std::max<int>(8, int(leaves.getDim(at, ray)));
  };
  if (ray.clip(grid.tree().bbox())) {
    nanovdb::HDDA<Ray> walk;
    const float start = ray.t0() + 1e-4f;
    walk.init(ray, start, ray.t1(), width(nanovdb::RoundDown<nanovdb::Coord>(ray(start))));
    bool dark = false;
    while (!dark) {
      if (leaves.probeLeaf(walk.voxel())) {
        float k = std::ceil(walk.time() / medium.step - 0.5f);
        for (float t; (t = (k + 0.5f) * medium.step) < walk.next(); k += 1) {
          const float density = sampler(ray(t));
          if (!(density > 0)) continue;
          const float passed = std::exp(-medium.depth * density);
          sum += (medium.from + medium.change * density) * (transmittance * (1 - passed));
          transmittance *= passed;
          if ((dark = transmittance < medium.termination)) break;
        }
      }
      if (dark || !walk.step()) break;
      walk.update(ray, width(nanovdb::RoundDown<nanovdb::Coord>(ray(walk.time() + 1e-3f))));
      if (walk.time() >= ray.t1()) break;
    }
  }
  for (int c = 0; c < 3; ++c) rgba[c] = sum[c];
  rgba[3] = 1 - transmittance;
}

void render(const Grid& grid, const Frame& frame, const Medium& medium, float* rgba) {
  const int size = frame.size;
  tbb::parallel_for(
      tbb::blocked_range2d<int>(0, size, 16, 0, size, 16),
      [&](const tbb::blocked_range2d<int>& tile) {
        const auto values = grid.tree().getAccessor(), leaves = grid.tree().getAccessor();
        const auto sampler = nanovdb::createSampler<1>(values);
        for (int y = tile.rows().begin(); y < tile.rows().end(); ++y)
          for (int x = tile.cols().begin(); x < tile.cols().end(); ++x) {
            const Vec direction = frame.direction(x, y);
            const Ray world(nanovdb::Vec3f(frame.position), nanovdb::Vec3f(direction));
            integrate(world.worldToIndexF(grid), grid, medium, sampler, leaves,
                      rgba + 4 * (std::size_t(y) * std::size_t(size) + std::size_t(x)));
          }
      });
}

}  // namespace

int main(int argc, char** argv) try {
  if (argc < 3) throw std::runtime_error("nanovdb_march FILE.vdb OUT.exr NAME=VALUE ...");
  const Options options(argc, argv);
  const auto handle = load(argv[1]);
  const Grid& grid = *handle.grid<float>();
  const Frame frame(options);
  const float step = float(options.number("step"));
  const Vec from = options.triple("from"), to = options.triple("to");
  const Medium medium{nanovdb::Vec3f(from), nanovdb::Vec3f(to - from),
                      float(options.number("extinction") * grid.voxelSize()[0]) * step, step,
                      float(options.number("termination"))};
  psivox::Image image{frame.size, frame.size, {{"", {"R", "G", "B", "A"}, {}}}, {}};
  image.layers[0].values.resize(4 * std::size_t(frame.size) * std::size_t(frame.size));

  const psivox::Stopwatch watch;
  render(grid, frame, medium, image.layers[0].values.data());
  std::printf("{\"march_ms\": %.3f, \"march_cpu_ms\": %.3f}\n", watch.ms(), watch.cpu_ms());
  psivox::write_image(image, argv[2]);
  return 0;
} catch (const std::exception& error) {
  std::fprintf(stderr, "nanovdb_march: %s\n", error.what());
  return 1;
}
