#pragma once

#include <vector>

namespace psivox::vdb {

/// The nodes of a tree by level, each level in the tree's order.
template <typename TreeT>
struct TreeNodes {
  using Root = typename TreeT::RootNodeType;
  using Upper = typename Root::ChildNodeType;
  using Lower = typename Upper::ChildNodeType;
  using Leaf = typename TreeT::LeafNodeType;

  explicit TreeNodes(TreeT& tree) : root(tree.root()) {
    for (auto it = root.beginChildOn(); it; ++it) uppers.push_back(&*it);
    for (Upper* node : uppers) append_children(*node, lowers);
    for (Lower* node : lowers) append_children(*node, leaves);
  }

  /// Calls op(node, width) for the root and each inner node, from the root down. Their tiles are
  /// `width` voxels wide.
  template <typename Op>
  void for_each_with_tiles(Op&& op) const {
    op(root, static_cast<int>(Upper::DIM));
    for (Upper* node : uppers) op(*node, static_cast<int>(Lower::DIM));
    for (Lower* node : lowers) op(*node, static_cast<int>(Leaf::DIM));
  }

  Root& root;
  std::vector<Upper*> uppers;
  std::vector<Lower*> lowers;
  std::vector<Leaf*> leaves;

 private:
  template <typename Node>
  static void append_children(Node& node, std::vector<typename Node::ChildNodeType*>& children) {
    for (auto it = node.beginChildOn(); it; ++it) children.push_back(&*it);
  }
};

}  // namespace psivox::vdb
