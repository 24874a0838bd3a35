#include <openvdb/openvdb.h>

#include "convert.h"

namespace psivox::vdb {
namespace {

constexpr Trees table = {openvdb::getLibraryVersionString, convert, place, rewritten};

}  // namespace
}  // namespace psivox::vdb

extern "C" const psivox::vdb::Trees* psivox_trees() {
  openvdb::initialize();
  return &psivox::vdb::table;
}
