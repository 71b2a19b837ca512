// The bending matrix as vector code multiplies by it.
#include "server/core/fem/element/bending_layout.h"

#include <algorithm>
#include <map>
#include <span>
#include <utility>

#include <gtest/gtest.h>

#include "tests/fem/integrator_cases.h"
#include "tests/support/random_cuts.h"

namespace kerf::fem {
namespace {

using Entries = std::map<std::pair<int, int>, double>;  // by row and column

Entries entries_of(const linear::RowStore<BendingEntry>& rows) {
  Entries entries;
  for (int v = 0; v < rows.num_rows(); ++v) {
    for (const BendingEntry& entry : rows.row(v)) {
      if (entry.column != v && entry.value != 0.0) entries[{v, entry.column}] = entry.value;
    }
  }
  return entries;
}

// Fails where an entry is kept twice.
Entries entries_of(const BendingLayout<double>& layout, int num_vertices) {
  Entries entries;
  const auto add = [&](int row, int column, double value) {
    if (value == 0.0) return;
    EXPECT_TRUE(entries.insert({{row, column}, value}).second) << row << ' ' << column;
  };
  const auto kLanesInBlock = static_cast<int>(linear::kBlockLanes);
  for (int v = 0; v < num_vertices; v += kLanesInBlock) {
    const auto block = static_cast<std::size_t>(v / kLanesInBlock);
    for (std::size_t k = 0; k < layout.offsets(block).size(); ++k) {
      for (std::size_t l = 0; l < linear::kBlockLanes; ++l) {
        const int row = v + static_cast<int>(l);
        add(row, row + layout.offsets(block)[k], layout.diagonals(block)[k].lane[l]);
      }
    }
  }
  for (int group = 0; group < layout.num_groups(); ++group) {
    for (const FourEntries<double>& entry : layout.rest(group)) {
      for (std::size_t r = 0; r < entry.value.size(); ++r) {
        add(4 * group + static_cast<int>(r), entry.place[r] / 4, entry.value[r]);
      }
    }
  }
  return entries;
}

BendingLayout<double> layout_of(const Model& model) {
  BendingLayout<double> layout;
  const int n = model.bending().rows().num_rows();
  layout.resize(n);
  for (std::size_t block = 0; block * linear::kBlockLanes < static_cast<std::size_t>(n); ++block) {
    layout.set_block(model.bending().rows(), block);
  }
  return layout;
}

TEST(BendingLayout, HasEachEntryOnce) {
  mesh::TriangleMesh mesh = square_grid(20);
  Model model(mesh, *find_preset("demo"));
  test::RandomCuts cuts(5, mesh, model);
  for (const std::size_t count : {0U, 3U, 30U}) {
    cuts.make(count);
    const BendingLayout<double> layout = layout_of(model);
    EXPECT_EQ(entries_of(layout, mesh.num_vertices()), entries_of(model.bending().rows())) << count;
  }
}

TEST(BendingLayout, KeepsOfAGridWhatMostRowsHaveAsDiagonals) {
  const mesh::TriangleMesh mesh = square_grid(20);
  const Model model(mesh, *find_preset("demo"));
  const BendingLayout<double> layout = layout_of(model);
  for (std::size_t block = 0; block * linear::kBlockLanes < 400; ++block) {
    const std::span<const std::int32_t> offsets = layout.offsets(block);
    EXPECT_TRUE(std::is_sorted(offsets.begin(), offsets.end()));
    EXPECT_GE(offsets.size(), 11U);
    EXPECT_LE(offsets.size(), 18U);  // of two rings
    for (const linear::Lanes16<double>& diagonal : layout.diagonals(block)) {
      const auto zeros = static_cast<std::size_t>(std::count(diagonal.lane.begin(), diagonal.lane.end(), 0.0));
      EXPECT_LE(zeros + BendingLayout<double>::kLeastInDiagonal, 16U);
    }
  }
}

TEST(BendingLayout, FollowsTheMatrixAlone) {
  mesh::TriangleMesh mesh = square_grid(20);
  Model model(mesh, *find_preset("demo"));
  const Entries uncut = entries_of(model.bending().rows());
  test::RandomCuts cuts(6, mesh, model);
  BendingLayout<double> layout = layout_of(model);
  const auto follow = [&] {
    const int n = model.bending().rows().num_rows();
    layout.resize(n);
    layout.set_block(model.bending().rows(), static_cast<std::size_t>(n - 1) / linear::kBlockLanes);
    for (const mesh::VertexId v : model.changed_rows()) {
      layout.set_block(model.bending().rows(), static_cast<std::size_t>(v) / linear::kBlockLanes);
    }
    const BendingLayout<double> fresh = layout_of(model);
    for (std::size_t block = 0; block * linear::kBlockLanes < static_cast<std::size_t>(n); ++block) {
      EXPECT_TRUE(std::ranges::equal(layout.offsets(block), fresh.offsets(block))) << block;
    }
    EXPECT_EQ(entries_of(layout, n), entries_of(model.bending().rows()));
  };
  for (int i = 0; i < 4; ++i) {
    cuts.make_one();
    follow();
  }
  for (int i = 0; i < 4; ++i) {
    cuts.undo_one();
    follow();
  }
  EXPECT_EQ(entries_of(layout, mesh.num_vertices()), uncut);
}

}  // namespace
}  // namespace kerf::fem
