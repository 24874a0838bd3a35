#pragma once

#include <openvdb/openvdb.h>

#include <string>

#include "grid_check.h"
#include "psivox/field.h"
#include "psivox/vdb.h"

namespace psivox::vdb {

/// Converts a grid to a Field. Takes the grid over and may change it.
///
/// `subject` begins error messages (`FILE: grid 'NAME' `), `name` becomes Field::name.
/// Throws Error(input) by the rules of problem_of, and under options.strict.
Field field_from_grid(openvdb::GridBase::Ptr grid, const std::string& name,
                      const std::string& subject, const ReadOptions& options);

/// What a field has of its grid without values, which is of a supported type and linear transform.
/// Notices tell of odd classes.
Field field_of_head(const openvdb::GridBase& grid, const std::string& name,
                    const GridSummary& summary);

}  // namespace psivox::vdb
