#pragma once

#include <cstdint>
#include <optional>

namespace rubble::camera {

/// Counts what is missing in the numbers that a device gives its pictures.
class SequenceCounter {
 public:
  /// Pictures between the last number and this one; none where the count stands still or begins anew. Numbers
  /// wrap at 2^32.
  std::uint32_t missing(std::uint32_t sequence) {
    const std::uint32_t step = last_ ? sequence - *last_ : 1;
    last_ = sequence;
    return step == 0 || step > kLargestGap ? 0 : step - 1;
  }

 private:
  static constexpr std::uint32_t kLargestGap = 10'000;

  std::optional<std::uint32_t> last_;
};

}  // namespace rubble::camera
