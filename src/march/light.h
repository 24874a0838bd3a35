#pragma once

#include <functional>
#include <glm/vec3.hpp>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "march/voxel_luminance.h"
#include "psivox/error.h"
#include "psivox/medium.h"
#include "scene/transfer_function.h"

namespace psivox {

/// How optical depths towards a light are found.
struct LightMethod {
  /// Distance between the columns of a lattice [voxels], n or 1/n (light_lattice.h). 0: a ray from
  /// each voxel through the cells, which is exact.
  double spacing = 0;
  double termination = 0;  ///< transmittance at which rays and columns end; 0: never
  bool operator==(const LightMethod&) const = default;
};

/// "columns 0.5 voxels apart".
std::string light_method_text(const LightMethod& method);

/// Parallel light, with a camera's lights turned to the world.
struct Beam {
  glm::dvec3 direction{0};  ///< of travel, normalised [world]
  glm::dvec3 radiance{0};   ///< colour times albedo
  LightMethod method{};
};

/// Beams of the view's lights.
std::vector<Beam> light_beams(const View& view);
/// Beams of a uniform sky from `count` directions, spread over the sphere by spherical Fibonacci
/// points (Keinert et al. 2015, Spherical Fibonacci mapping); all of the same radiance.
std::vector<Beam> sky_beams(const glm::dvec3& radiance, int count);
/// Beams of the view's sky or environment, at most `count`; none if it has neither.
std::vector<Beam> sky_beams(const View& view, int count);

/// Directions of a sky whose light counts as exact, and the most that a tolerance gets.
inline constexpr int exact_sky_count = 512, most_sky_count = 1024;

/// Segments of a cell by which a function of the gradient, along which it is no cubic, counts as
/// integrated.
inline constexpr int gradient_segments = 32;

/// Blocks of 8^3 voxels whose depths are asked for, by their first voxels.
using LightBlocks = std::span<const glm::ivec3>;

/// Takes the optical depths of a block, by its number: 512, z fastest. Several threads may call it
/// at once, for different blocks.
using TakeDepths = std::function<void(std::size_t block, std::span<const double> depths)>;

/// Finds optical depths of a view's medium from voxels to where light of that direction comes in.
/// They are the depths of trilinear data, whatever the view's rule. Where the transfer function has
/// a gradient they follow the view's segments, except the reference's.
using BeamDepths = std::function<void(const Beam& beam, LightBlocks blocks, const TakeDepths& take,
                                      const Progress& progress)>;

/// Takes a block's depths towards one of several beams, by its number. Several threads may call it
/// at once, for different blocks.
using TakeLight =
    std::function<void(std::size_t beam, std::size_t block, std::span<const double> depths)>;

/// Finds the depths of several beams. For each block, they arrive in any order of the beams.
using LightDepths = std::function<void(std::span<const Beam> beams, LightBlocks blocks,
                                       const TakeLight& take, const Progress& progress)>;

/// The progress of a part of the work, which begins at `begin` and is `size` of the whole. It calls
/// `progress`, which must outlive it.
Progress part_of(const Progress& progress, double begin, double size);

/// Depths of several beams, found for one beam after another.
LightDepths one_by_one(BeamDepths depths);

/// Where the lattice of a light lies (light_lattice.h).
struct LatticeFrame;

/// A brick of it: the numbers of its first column and its first slice.
using LatticeBrick = glm::ivec3;

/// Optical depths along the columns of bricks, each from the slice before the brick's first: of
/// slices, which follow each other, at the brick's columns, axis_v fastest.
using LatticeColumns =
    std::function<void(std::span<const LatticeBrick> bricks, std::span<double> depths)>;

/// Channels of the luminance of a medium in the light of some beams: 1 or 3.
int luminance_channels(const Medium& medium, std::span<const Beam> beams);

/// The transmittance e^-depth behind which no more than `light` of a beam arrives, over all octaves
/// (see LitLuminance) of an isotropic medium. 0 if floats have none.
double transmittance_of(double light, int octaves);

/// Luminance at voxels of a view's medium in the light of some beams:
///   L = luminance + albedo * sum of radiance * scattered(depth) over the beams,
///   scattered(depth) = sum over i of a^i * phase(g a^i) * e^(-a^i depth), a = 1/2,
/// all of it times the colour where a transfer function gives colours to voxels; colours that it
/// gives along rays are the lit medium's `lit_colors`. One octave (i = 0) is light scattered once.
/// More approximate light scattered often (Wrenninge, Kulla and Lundqvist, "Oz: The Great and
/// Volumetric", 2013): each goes farther, dimmer and more evenly. A luminance of another grid is
/// interpolated at the density's voxels; a constant one is the lit medium's `ambient`.
class LitLuminance {
 public:
  LitLuminance(const View& view, std::vector<Beam> beams);
  LitLuminance(const LitLuminance&) = delete;
  LitLuminance& operator=(const LitLuminance&) = delete;

  const std::vector<Beam>& beams() const { return beams_; }
  /// L without its beams and without what is constant.
  glm::dvec3 own(const glm::ivec3& voxel) const;
  /// What a beam adds to L behind an optical depth.
  glm::dvec3 share(std::size_t beam, const glm::ivec3& voxel, double depth) const;
  /// Bound of L in any channel.
  double brightest() const;
  /// Channels of the lit medium's luminance.
  int channels() const { return common_ ? 1 : 3; }
  /// Whether the camera changes it: there are several phases, so each voxel has its own.
  bool sees_camera() const { return g_ != 0 && !by_ray_; }

  /// The medium with L as its luminance in these blocks.
  Medium medium(LightBlocks blocks, const LightDepths& depths, const Progress& progress = {}) const;

 private:
  double phase(const Beam& beam, const glm::ivec3& voxel, double cosine) const;
  /// The parts of a beam's light that arrive at voxels, times their phases: sums over the octaves.
  /// voxel(i) is the i-th one; Real is the precision of the exponentials.
  template <typename Real>
  void scattered(const Beam& beam, const auto& voxel, std::span<const Real> depths, Real* to) const;
  /// Adds a beam to a block's values, which the first that comes sets.
  void add(const Beam& beam, bool first, const glm::ivec3& origin, std::span<const double> depths,
           float* to) const;

  const Medium& medium_;
  Camera camera_;
  double g_;
  int octaves_;
  std::vector<Beam> beams_;
  OwnLuminance glow_;
  PointAlbedo albedo_;
  glm::dvec3 ambient_{0};             ///< the medium's luminance where it is constant
  glm::dvec3 own_color_{0};           ///< factor of `glow_` where it is not
  bool by_ray_ = false;               ///< the phase is one factor of each ray
  std::optional<glm::dvec3> common_;  ///< colour of all luminance: one channel will do
};

/// Calls `some` for the numbers of the blocks, some hundreds at a time, with progress between them.
void in_batches(LightBlocks blocks, const Progress& progress,
                const std::function<void(std::size_t first, std::size_t end)>& some);

/// An optical depth at a voxel. Several threads call it.
using VoxelDepth = std::function<double(const glm::ivec3& voxel)>;

/// Takes the depths of all voxels of the blocks, by all threads.
void take_blocks(LightBlocks blocks, const VoxelDepth& depth, const TakeDepths& take,
                 const Progress& progress);
/// The depths of some voxels, by all threads.
std::vector<double> depths_of(std::span<const glm::ivec3> voxels, const VoxelDepth& depth);

/// The view with one of its volumes in the first one's place, and the first one in its; 0: the
/// first.
View seen_from(const View& view, std::size_t volume);

/// The beams of the first volume as they light one of a view's volumes, which is the first of
/// `seen`: its albedo is its own.
std::vector<Beam> beams_on(const View& seen, std::size_t volume, std::span<const Beam> beams);

/// Whether one of a dark view's volumes is to be lit: one that attenuates nothing is not.
bool is_to_be_lit(const View& dark, std::size_t volume);

/// Depths through the whole medium from voxels of one of its volumes; 0: the first.
using DepthsAt = std::function<LightDepths(std::size_t volume)>;

/// The medium of a dark view in the light of beams: the first volume in some blocks, the further
/// ones everywhere.
Medium lit_medium(const View& dark, const std::vector<Beam>& beams, LightBlocks blocks,
                  const DepthsAt& depths_at, const Progress& progress);

/// Whether light is asked for in a block of the first volume.
using WantBlock = std::function<bool(const glm::ivec3& block)>;

/// The view in the light of its beams and, if it has a sky, of exact_sky_count directions, all
/// exact. `wanted`: where; unset: everywhere. The further volumes are lit everywhere.
View lit(View view, const DepthsAt& depths_at, const Progress& progress = {},
         const WantBlock& wanted = {});
/// That of a view with one volume.
View lit(View view, const LightDepths& depths, const Progress& progress = {});

/// The medium's transfer function without its colours, which are in the light's luminance.
std::shared_ptr<const TransferFunction> without_colors(const Medium& medium);

/// The view whose march gives exact depths through the first volume, in cells, up to a
/// transmittance.
View depth_march(const View& view, double termination);
/// The same, orthographic, looking towards the light.
View light_march(const View& view, const Beam& beam);

}  // namespace psivox
