#pragma once

#include <filesystem>
#include <string>

#include "study/results.h"

namespace psivox {

/// The folders of a study's pictures, in its own; each has one `file_name(variant)`.png a point.
inline constexpr const char* pictures_folder = "pictures";
inline constexpr const char* differences_folder = "differences";

/// The reference's picture that a variant is compared with, without extension: one a resolution.
std::string reference_name(const Variant& variant);

/// Writes results.md, the plots and index.html of what `results` has so far. The pictures are in
/// the folder already.
void write_report(const StudyResults& results, const std::filesystem::path& folder);

}  // namespace psivox
