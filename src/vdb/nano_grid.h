#pragma once

#include <functional>
#include <memory>
#include <string>

#include "file_grid.h"
#include "nano_file.h"
#include "nano_tree.h"

namespace psivox::vdb {

/// A grid of a .nvdb. All of its bytes are in memory.
class NanoGrid final : public FileGrid {
 public:
  NanoGrid(NanoFile& file, const GridEntry& entry, bool marked);

  std::string why_whole() const override { return "its file has it as one block"; }
  std::shared_ptr<StoredLeaves> stored_leaves(const LeafSurvey&, std::string, bool) override {
    return nullptr;
  }

 private:
  Topology read_topology(const TopologyWish& wish) override;
  void read_leaves(const TakeLeaf& take, const std::function<bool()>& enough) override;

  std::shared_ptr<const void> memory_;
  std::unique_ptr<NanoTree> tree_;
};

}  // namespace psivox::vdb
