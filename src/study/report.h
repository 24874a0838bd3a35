#pragma once

#include <filesystem>
#include <string>

#include "study/page.h"
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

/// A header and one line per point, with all digits of each number.
std::string results_csv(const StudyResults& results);

/// A table with a row per rule and a column per sampling.
TextTable rules_table(const StudyResults& results);
inline constexpr const char* rules_note =
    "Each cell has the RMS over R G B A against the reference and, in parentheses, the processor "
    "time of the march over that of porter-duff in the same column.";

/// needs_of() as a readable table: a row for each rule and sampling, a column for each RMS.
TextTable needs_table(const StudyResults& results);
inline constexpr const char* needs_note =
    "Each cell has the field look-ups per ray and the processor time of the march at an RMS, "
    "interpolated between measured points linearly in the logarithms. ≤: the coarsest point "
    "already reaches the RMS; –: no point reaches it.";

/// A row for each picture of another renderer.
TextTable foreign_table(const StudyResults& results);
inline constexpr const char* foreign_note =
    "Pictures of other renderers, through the same camera, less the reference. A picture whose "
    "alpha is 1 everywhere is compared in R G B, over the scene's background or black; the others "
    "in R G B A, premultiplied. Times are as given: psivox did not measure them.";

/// Markdown: the tables, and the list of skipped variants.
std::string results_markdown(const StudyResults& results);

}  // namespace psivox
