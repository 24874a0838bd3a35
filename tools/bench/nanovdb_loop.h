// The march of nanovdb_march.cpp and nanovdb_march.cu, as an expert would write it over NanoVDB in
// an afternoon: the HDDA finds leaves, the library's sampler interpolates trilinearly, homogeneous
// segments have their midpoints on one lattice per ray.
#pragma once

#include <nanovdb/util/HDDA.h>
#include <nanovdb/util/Ray.h>
#include <nanovdb/util/SampleFromVoxels.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <string>

#include "psivox/image.h"

namespace nanovdb_loop {

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

inline psivox::Image picture_of(int size) {
  psivox::Image image{size, size, {{"", {"R", "G", "B", "A"}, {}}}, {}};
  image.layers[0].values.resize(4 * std::size_t(size) * std::size_t(size));
  return image;
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
  __hostdev__ Vec direction(int x, int y) const {
    const double u = (2 * (x + 0.5) / size - 1) * half, v = (1 - 2 * (y + 0.5) / size) * half;
    return (right * u + up * v + forward).normalize();
  }
};

struct Medium {
  nanovdb::Vec3f from, change;  ///< luminance at density 0, and its increase at density 1
  float depth;                  ///< optical depth of a segment of density 1
  float step, termination;

  Medium(const Options& options, double voxel)
      : from(options.triple("from")),
        change(options.triple("to") - options.triple("from")),
        step(float(options.number("step"))),
        termination(float(options.number("termination"))) {
    depth = float(options.number("extinction") * voxel) * step;
  }
};

/// Radiance and opacity along a ray in index space, whose direction has length 1.
template <class Sampler, class Accessor>
__hostdev__ void integrate(Ray ray, const Grid& grid, const Medium& medium, const Sampler& sampler,
                           const Accessor& leaves, float* rgba) {
  float transmittance = 1;
  nanovdb::Vec3f sum(0);
  const auto width = [&](const nanovdb::Coord& at) {
    return nanovdb::Max(8, int(leaves.getDim(at, ray)));
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

/// Radiance and opacity of a pixel of an upright picture.
__hostdev__ inline void draw_pixel(const Frame& frame, int x, int y, const Grid& grid,
                                   const Medium& medium, const Grid::AccessorType& values,
                                   const Grid::AccessorType& leaves, float* rgba) {
  const Ray world(nanovdb::Vec3f(frame.position), nanovdb::Vec3f(frame.direction(x, y)));
  integrate(world.worldToIndexF(grid), grid, medium, nanovdb::createSampler<1>(values), leaves,
            rgba + 4 * (std::size_t(y) * std::size_t(frame.size) + std::size_t(x)));
}

}  // namespace nanovdb_loop
