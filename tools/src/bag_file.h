#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

#include "lcm_io/codec.h"

namespace rubble::tools {

/// A bag of ROS 1, format 2.0 (plain, bz2 or lz4), by its index. ROS's own library reads and writes beyond
/// its buffers when a length or offset in the bag is wrong. All functions throw Error for a damaged bag.
class BagFile {
 public:
  struct Connection {
    std::string topic;
    std::string type;
  };
  struct Entry {
    std::uint64_t time_ns = 0;  ///< of recording
    std::uint64_t chunk = 0;    ///< byte in the file
    std::uint32_t offset = 0;   ///< of the message in the unpacked chunk
    std::uint32_t connection = 0;
  };

  explicit BagFile(const std::filesystem::path& path);

  const std::map<std::uint32_t, Connection>& connections() const { return connections_; }
  /// Of every message, in order of time.
  const std::vector<Entry>& entries() const { return entries_; }
  const Connection& connectionOf(const Entry& entry) const { return connections_.at(entry.connection); }
  /// Valid until the next call.
  lcm_io::ByteView message(const Entry& entry);

 private:
  void requireBytes(std::uint64_t at, std::uint64_t size) const;
  lcm_io::Bytes readBlock(std::uint64_t& at);
  lcm_io::Bytes readBytes(std::uint64_t& at, std::uint64_t size);
  std::uint32_t readLength(std::uint64_t& at);
  void readIndex();
  void unpackChunk(std::uint64_t at);

  std::ifstream stream_;
  std::uint64_t size_ = 0;
  std::map<std::uint32_t, Connection> connections_;
  std::vector<Entry> entries_;
  std::uint64_t chunk_at_ = 0;  // 0: none is unpacked
  lcm_io::Bytes chunk_;
};

}  // namespace rubble::tools
