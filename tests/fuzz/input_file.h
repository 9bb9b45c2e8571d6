#pragma once

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <span>
#include <string>

#include "common/error.h"

namespace rubble::fuzz {

/// The fuzzer's input as a file in memory, for code that takes a path.
class InputFile {
 public:
  InputFile(const std::uint8_t* data, std::size_t size) : fd_(::memfd_create("input", MFD_CLOEXEC)) {
    RUBBLE_CHECK(fd_ >= 0 && ::write(fd_, data, size) == static_cast<ssize_t>(size));
  }
  explicit InputFile(std::span<const std::uint8_t> bytes) : InputFile(bytes.data(), bytes.size()) {}
  ~InputFile() { ::close(fd_); }
  InputFile(const InputFile&) = delete;
  InputFile& operator=(const InputFile&) = delete;

  std::filesystem::path path() const { return "/proc/self/fd/" + std::to_string(fd_); }

 private:
  int fd_;
};

/// Several files, for code that takes a directory.
class InputDirectory {
 public:
  InputDirectory()
      : path_(std::filesystem::temp_directory_path() / ("rubble-fuzz-" + std::to_string(::getpid()))) {
    std::filesystem::create_directory(path_);
  }
  ~InputDirectory() { std::filesystem::remove_all(path_); }
  InputDirectory(const InputDirectory&) = delete;
  InputDirectory& operator=(const InputDirectory&) = delete;

  const std::filesystem::path& path() const { return path_; }
  void write(const std::string& name, std::span<const std::uint8_t> bytes) const {
    std::filesystem::create_directories((path_ / name).parent_path());
    std::ofstream stream(path_ / name, std::ios::binary);
    stream.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    RUBBLE_CHECK(stream.good());
  }

 private:
  std::filesystem::path path_;
};

/// The input cut at its first NUL bytes; the last piece holds the rest, the others are text.
template <std::size_t n>
std::array<std::span<const std::uint8_t>, n> cut(std::span<const std::uint8_t> input) {
  std::array<std::span<const std::uint8_t>, n> pieces;
  for (std::size_t i = 0; i + 1 < n; ++i) {
    const auto end = static_cast<std::size_t>(std::find(input.begin(), input.end(), 0) - input.begin());
    pieces[i] = input.first(end);
    input = input.subspan(std::min(end + 1, input.size()));
  }
  pieces[n - 1] = input;
  return pieces;
}

}  // namespace rubble::fuzz
