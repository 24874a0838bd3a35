#include "psivox/value_survey.h"

#include <algorithm>
#include <glm/common.hpp>
#include <sstream>
#include <vector>

#include "psivox/error.h"
#include "psivox/vdb.h"
#include "vdb/sanitise.h"

namespace psivox {

BadValues operator+(BadValues a, const BadValues& b) {
  a.nan += b.nan;
  a.positive_infinite += b.positive_infinite;
  a.negative_infinite += b.negative_infinite;
  a.negative += b.negative;
  a.least = std::min(a.least, b.least);
  return a;
}

std::string BadValues::describe() const {
  std::vector<std::string> zeroed;
  if (nan > 0) zeroed.push_back(std::to_string(nan) + " NaN");
  if (negative_infinite > 0) zeroed.push_back(std::to_string(negative_infinite) + " -Inf");
  if (negative > 0) zeroed.push_back(std::to_string(negative) + " negative");
  std::ostringstream text;
  for (std::size_t i = 0; i < zeroed.size(); ++i) text << (i ? ", " : "") << zeroed[i];
  const bool one = nan + negative_infinite + negative == 1;
  if (!zeroed.empty()) text << (one ? " value" : " values") << " taken as 0";
  if (positive_infinite > 0) {
    text << (zeroed.empty() ? "" : "; ") << positive_infinite << " +Inf taken as " << largest;
  }
  return text.str();
}

float take_survey(Field& field, const ValueSurvey& of_leaves, const ReadOptions& options,
                  const std::string& subject) {
  ValueSurvey all = of_leaves + *field.survey;
  all.bad.largest = all.largest > 0 ? all.largest : 1;
  if (all.bad.any()) {
    if (options.strict)
      throw Error(ExitCode::input, subject + "is refused by strict reading: " + all.bad.describe());
    field.notices.push_back("grid '" + field.name + "': " + all.bad.describe());
    field.replaced = all.bad;
  }
  const float largest = all.bad.largest;
  for (Tile& tile : field.tiles) tile.value = glm::min(tile.value, glm::vec3(largest));
  all.all.add(0);
  field.stored_range = all.all.range(largest);
  field.active_range = (options.role == GridRole::data ? all.active : all.in_box).range(largest);
  field.survey.reset();
  return largest;
}

}  // namespace psivox
