#pragma once
// How many nodes a tree has, what they hold in memory, and what a file stores of them: for estimates.
#include "vdbcloud/core/fwd.h"

namespace vdbcloud {

/// Numbers of nodes: leaves of 8^3 voxels stand in nodes of 128^3, which stand in tops of 4096^3. The tables of nodes
/// and tops have a fixed size, whatever stands in them.
struct TreeSize {
    double leaves = 0, nodes = 0, tops = 0;

    /// Memory of a tree whose values have `value_bytes`, 4 or 12.
    double memory(double value_bytes) const { return leaf_memory(value_bytes) + table_memory(value_bytes); }
    double leaf_memory(double value_bytes) const { return leaves * (96 + 512 * value_bytes); }
    /// Of nodes and tops alone: each entry is a value or a pointer.
    double table_memory(double value_bytes) const;
    /// The values that reading and writing go through [bytes]: an entry of a table costs what a voxel's value does.
    double values(double value_bytes) const { return value_bytes * (512 * leaves + 4096 * nodes + 32768 * tops); }
};

TreeSize tree_size(const GridBase&);

}  // namespace vdbcloud
