#pragma once

#include <algorithm>
#include <cstddef>
#include <tuple>
#include <vector>

#include "fast_detector.h"

namespace rubble::orb {

/// Thins corners out so that they spread evenly over a picture: splits it into quarters, the fullest first,
/// until there are as many nodes as corners wanted, and keeps the strongest of every node. Keeps its buffers.
class CornerQuadtree {
 public:
  /// Leaves at most `wanted` corners, the strongest first.
  void thin(int width, int height, int wanted, std::vector<Corner>* corners) {
    plant(width, height, corners);
    while (grow(static_cast<std::size_t>(wanted), corners)) {
    }
    kept_.clear();
    for (const Node& node : nodes_) {
      kept_.push_back(
          *std::min_element(corners->begin() + node.begin, corners->begin() + node.end, isStronger));
    }
    std::sort(kept_.begin(), kept_.end(), isStronger);
    kept_.resize(std::min(kept_.size(), static_cast<std::size_t>(wanted)));
    std::swap(kept_, *corners);
  }

 private:
  /// corners[begin .. end) lie in x0 <= x < x1, y0 <= y < y1.
  struct Node {
    int x0, y0, x1, y1;
    std::ptrdiff_t begin, end;
  };

  static bool isStronger(const Corner& a, const Corner& b) {
    return std::tuple(-a.score, a.y, a.x) < std::tuple(-b.score, b.y, b.x);
  }

  void add(const Node& node, std::vector<Node>* nodes) {
    if (node.begin < node.end) {
      nodes->push_back(node);
    }
  }

  /// Roots side by side, about square.
  void plant(int width, int height, std::vector<Corner>* corners) {
    nodes_.clear();
    const int roots = std::max(1, (width + height / 2) / height);
    std::ptrdiff_t begin = 0;
    for (int i = 0; i < roots; ++i) {
      const int end_x = width * (i + 1) / roots;
      const auto end = std::partition(corners->begin() + begin, corners->end(),
                                      [&](const Corner& corner) { return corner.x < end_x; }) -
                       corners->begin();
      add({width * i / roots, 0, end_x, height, begin, end}, &nodes_);
      begin = end;
    }
  }

  /// Splits every node as long as fewer than `wanted` are known; false when nothing was left to do.
  bool grow(std::size_t wanted, std::vector<Corner>* corners) {
    std::sort(nodes_.begin(), nodes_.end(), [](const Node& a, const Node& b) {
      return std::tuple(a.begin - a.end, a.begin) < std::tuple(b.begin - b.end, b.begin);
    });
    next_.clear();
    bool has_split = false;
    for (std::size_t i = 0; i < nodes_.size(); ++i) {
      if (nodes_[i].end - nodes_[i].begin > 1 && next_.size() + nodes_.size() - i < wanted) {
        split(nodes_[i], corners);
        has_split = true;
      } else {
        next_.push_back(nodes_[i]);
      }
    }
    std::swap(nodes_, next_);
    return has_split;
  }

  void split(const Node& node, std::vector<Corner>* corners) {
    const int x = (node.x0 + node.x1) / 2;
    const int y = (node.y0 + node.y1) / 2;
    const auto isLeft = [x](const Corner& corner) { return corner.x < x; };
    const auto isAbove = [y](const Corner& corner) { return corner.y < y; };
    const auto first = corners->begin();
    const auto middle = std::partition(first + node.begin, first + node.end, isAbove) - first;
    const auto upper = std::partition(first + node.begin, first + middle, isLeft) - first;
    const auto lower = std::partition(first + middle, first + node.end, isLeft) - first;
    add({node.x0, node.y0, x, y, node.begin, upper}, &next_);
    add({x, node.y0, node.x1, y, upper, middle}, &next_);
    add({node.x0, y, x, node.y1, middle, lower}, &next_);
    add({x, y, node.x1, node.y1, lower, node.end}, &next_);
  }

  std::vector<Node> nodes_;
  std::vector<Node> next_;
  std::vector<Corner> kept_;
};

}  // namespace rubble::orb
