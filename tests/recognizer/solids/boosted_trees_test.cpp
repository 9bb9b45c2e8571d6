#include "solids/boosted_trees.h"

#include <gtest/gtest.h>

#include <random>

namespace rubble::recognizer {
namespace {

/// Noise; of objects, two values differ by at least 60: no single one tells.
WindowTable makeWindows(int count, bool is_object, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> any(0, 150);
  WindowTable table{40, {}};
  for (int i = 0; i < count; ++i) {
    for (std::size_t f = 0; f < table.width; ++f) {
      table.values.push_back(static_cast<std::uint8_t>(any(random)));
    }
    std::uint8_t* row = &table.values[table.values.size() - table.width];
    const int low = is_object ? any(random) / 2 : row[7];
    row[7] = static_cast<std::uint8_t>(low);
    row[21] = static_cast<std::uint8_t>(is_object ? low + 60 + any(random) / 5 : row[21]);
  }
  return table;
}

double shareAbove(const BoostedTrees& trees, const WindowTable& table, float sum) {
  int above = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    above += sumOf(trees, table.row(i)) > sum ? 1 : 0;
  }
  return above / static_cast<double>(table.rows());
}

TEST(BoostedTrees, TellWhatTheyHaveNotSeen) {
  const BoostedTrees trees = boostTrees(makeWindows(800, true, 1), makeWindows(1600, false, 2), 120);
  EXPECT_EQ(trees.trees.size(), 120U);
  EXPECT_GT(shareAbove(trees, makeWindows(400, true, 3), 0.0F), 0.8);
  EXPECT_LT(shareAbove(trees, makeWindows(400, false, 4), 0.0F), 0.3);
}

TEST(BoostedTrees, TheCascadeKeepsTheShareOfObjects) {
  BoostedTrees trees = boostTrees(makeWindows(500, true, 1), makeWindows(900, false, 2), 60);
  const WindowTable objects = makeWindows(500, true, 5);
  setCascade(objects, 0.05, &trees);
  int kept = 0;
  for (std::size_t i = 0; i < objects.rows(); ++i) {
    BoostedTrees begin;
    bool passes = true;
    for (const BoostedTrees::Tree& tree : trees.trees) {
      begin.trees.push_back(tree);
      passes = passes && sumOf(begin, objects.row(i)) >= tree.least - 1e-4F;
    }
    kept += passes ? 1 : 0;
  }
  EXPECT_GE(kept, 475);
  EXPECT_LT(kept, 500);
}

}  // namespace
}  // namespace rubble::recognizer
