#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "common/error.h"
#include "common/files.h"

namespace rubble::common {

/// What a file begins with: kind and version.
using Magic = std::array<char, 8>;

/// Appends plain values to bytes, in the machine's (little-endian) order.
class ByteWriter {
 public:
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void put(const T& value) { putAll(std::span(&value, 1)); }
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void putAll(std::span<const T> values) {
    const std::size_t end = bytes_.size();
    bytes_.resize(end + values.size_bytes());
    if (!values.empty()) {
      std::memcpy(bytes_.data() + end, values.data(), values.size_bytes());
    }
  }
  /// Its length, then its characters.
  void putText(const std::string& text) {
    put(static_cast<std::uint64_t>(text.size()));
    putAll(std::span(text.data(), text.size()));
  }
  std::vector<std::uint8_t>& bytes() { return bytes_; }
  /// Ends what began with a Magic: all of it, then its CRC-32.
  std::vector<std::uint8_t> sealed() && {
    put(crc32(bytes_));
    return std::move(bytes_);
  }

 private:
  std::vector<std::uint8_t> bytes_;
};

/// Takes them out again. Throws Error, naming the thing, instead of reading beyond the end.
class ByteReader {
 public:
  /// `thing`: what the bytes are, for the Error's text.
  ByteReader(std::span<const std::uint8_t> bytes, std::string thing)
      : bytes_(bytes), thing_(std::move(thing)) {}

  template <typename T>
  requires std::is_trivially_copyable_v<T> T get() {
    T value;
    getAll(std::span(&value, 1));
    return value;
  }
  template <typename T>
  requires std::is_trivially_copyable_v<T>
  void getAll(std::span<T> values) {
    require(values.size_bytes());
    if (!values.empty()) {
      std::memcpy(values.data(), bytes_.data(), values.size_bytes());
    }
    bytes_ = bytes_.subspan(values.size_bytes());
  }
  /// Takes the magic from the front and the checksum from the end of what ByteWriter has sealed. `kind`: "a
  /// map".
  void openSealed(const Magic& magic, const std::string& kind) {
    const std::span<const std::uint8_t> all = bytes_;
    if (get<Magic>() != magic) {
      fail("not " + kind + ", or one of another version");
    }
    std::uint32_t crc = 0;
    if (bytes_.size() < sizeof crc) {
      fail("truncated");
    }
    const auto content = all.first(all.size() - sizeof crc);
    std::memcpy(&crc, all.data() + content.size(), sizeof crc);
    if (crc != crc32(content)) {
      fail("damaged, its checksum is wrong");
    }
    bytes_ = bytes_.first(bytes_.size() - sizeof crc);
  }
  /// Number of elements that follow, each at least `element_size` bytes long.
  std::size_t getCount(std::size_t element_size) {
    const auto count = get<std::uint64_t>();
    if (count > bytes_.size() / element_size) {
      fail("truncated");
    }
    return static_cast<std::size_t>(count);
  }
  std::string getText() {
    std::string text(getCount(1), '\0');
    getAll(std::span(text.data(), text.size()));
    return text;
  }
  std::size_t left() const { return bytes_.size(); }
  /// Throws Error: "<thing>: <what>".
  [[noreturn]] void fail(const std::string& what) const { throw Error(thing_ + ": " + what); }

 private:
  void require(std::size_t size) const {
    if (size > bytes_.size()) {
      fail("truncated");
    }
  }

  std::span<const std::uint8_t> bytes_;
  std::string thing_;
};

}  // namespace rubble::common
