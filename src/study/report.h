#pragma once

#include <filesystem>
#include <string>

#include "study/results.h"

namespace psivox {

/// The folders of pictures in a study's folder. Each has a `file_name(variant)`.png for each point.
inline constexpr const char* pictures_folder = "pictures";
inline constexpr const char* differences_folder = "differences";

/// File name, without extension, of the reference for a variant. There is one reference per
/// resolution.
std::string reference_name(const Variant& variant);

/// Writes results.md, the plots and index.html of the points that `results` has. The pictures must
/// be in the folder.
void write_report(const StudyResults& results, const std::filesystem::path& folder);

}  // namespace psivox
