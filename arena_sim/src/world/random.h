#pragma once

#include <cstdint>
#include <initializer_list>
#include <random>

namespace rubble::arena_sim {

/// Random draws for builders.
class Random {
 public:
  explicit Random(std::mt19937_64 engine) : engine_(engine) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  /// low .. high, both included.
  int integer(int low, int high) { return std::uniform_int_distribution<int>(low, high)(engine_); }
  bool chance(double share) { return uniform(0.0, 1.0) < share; }
  double sign() { return chance(0.5) ? 1.0 : -1.0; }
  std::uint64_t seed() { return engine_(); }
  template <typename T>
  T pick(std::initializer_list<T> choices) {
    return choices.begin()[integer(0, static_cast<int>(choices.size()) - 1)];
  }
  std::mt19937_64& engine() { return engine_; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace rubble::arena_sim
