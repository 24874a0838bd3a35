#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "psivox/sequence.h"
#include "psivox/vdb.h"

// Where the files of a film are, as their headers tell.

namespace psivox {

/// The place of the scene's density, or of what `auto` takes for it.
GridPlace density_place(const Scene& scene, const VolumeFile& file);

/// Where the density of a file is.
struct FilePlace {
  std::string path;
  GridPlace place;
};

/// Those of the files that can be read.
std::vector<FilePlace> places_of(const Scene& scene, std::span<const std::string> files);

/// The domain of files whose voxels are the smaller, the more of them their domains have; unset:
/// they are not.
std::optional<AdaptiveDomain> adaptive_domain(const std::vector<FilePlace>& places);

/// The files that reach farthest along each axis, beyond all that are shown by more than a
/// hundredth of the width.
std::vector<std::string> far_files(const Scene& scene, const std::vector<FilePlace>& places,
                                   std::span<const std::string> shown,
                                   const std::optional<AdaptiveDomain>& adaptive);

/// Adds what one more frame shows.
void add_subject(const Subject& one, Subject& all);

}  // namespace psivox
