#include "bzip2_file.h"

#include <bzlib.h>
#include <fmt/format.h>

#include <array>
#include <utility>

#include "common/error.h"
#include "report.h"

namespace rubble::tools {

namespace {

/// One decompression at a time; bzip2's files may hold several streams one after the other.
class Stream {
 public:
  Stream() { RUBBLE_CHECK(BZ2_bzDecompressInit(&stream_, 0, 0) == BZ_OK); }
  ~Stream() { BZ2_bzDecompressEnd(&stream_); }
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Appends what one stream at the front of `input` unpacks to, and takes it from `input`. Returns
  /// bzip2's status: BZ_STREAM_END, BZ_OK when the input ended first, or an error.
  int unpack(std::string_view& input, std::string& output) {
    std::array<char, 1 << 16> buffer;
    // bzip2's interface is not const-correct; it only reads from next_in.
    stream_.next_in = const_cast<char*>(input.data());
    stream_.avail_in = static_cast<unsigned int>(input.size());
    int status = BZ_OK;
    do {
      stream_.next_out = buffer.data();
      stream_.avail_out = static_cast<unsigned int>(buffer.size());
      status = BZ2_bzDecompress(&stream_);
      output.append(buffer.data(), buffer.size() - stream_.avail_out);
    } while (status == BZ_OK && (stream_.avail_in > 0 || stream_.avail_out == 0));
    input.remove_prefix(input.size() - stream_.avail_in);
    return status;
  }

 private:
  bz_stream stream_{};
};

}  // namespace

TextFile readPlainOrBzip2(const std::filesystem::path& path) {
  constexpr std::size_t kLargestInput = 0xffffffff;  // bzip2 counts in 32 bits.
  TextFile file = readTextFile(path);
  if (!file.text.starts_with("BZh")) {
    return file;
  }
  const std::string compressed = std::exchange(file.text, {});
  if (compressed.size() > kLargestInput) {
    throw common::Error(fmt::format("{}: more than 4 GB of bzip2; unpack it with bunzip2 first", file.name));
  }
  std::string_view input = compressed;
  while (!input.empty()) {
    const int status = Stream().unpack(input, file.text);
    const std::size_t byte = compressed.size() - input.size();
    if (status == BZ_OK) {
      warn(fmt::format("{}: the compressed data is cut off at byte {}; what is whole before it counts",
                       file.name, byte));
    } else if (status != BZ_STREAM_END) {
      throw common::Error(fmt::format("{}: the bzip2 data is damaged before byte {}", file.name, byte));
    }
  }
  return file;
}

}  // namespace rubble::tools
