#include "bag_file.h"

#include <bzlib.h>
#include <fmt/format.h>
#include <lz4frame.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>
#include <string_view>
#include <tuple>

#include "common/error.h"

namespace rubble::tools {

namespace {

using common::Error;
using lcm_io::Bytes;
using lcm_io::ByteView;

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";
/// More is damage: chunks are of 768 kB, or of one message.
constexpr std::uint32_t kLargestChunk = 1U << 28U;

enum Op : std::uint8_t { kMessageData = 2, kBagHeader = 3, kIndexData = 4, kChunk = 5, kConnection = 7 };

ByteView take(ByteView& rest, std::size_t size) {
  if (size > rest.size()) {
    throw Error("damaged bag: a length inside does not fit");
  }
  const ByteView taken = rest.first(size);
  rest = rest.subspan(size);
  return taken;
}

template <typename T>
T numberOf(ByteView bytes) {
  T value{};
  if (bytes.size() != sizeof value) {
    throw Error("damaged bag: a number of another size");
  }
  std::memcpy(&value, bytes.data(), sizeof value);
  return value;
}

template <typename T>
T takeNumber(ByteView& rest) {
  return numberOf<T>(take(rest, sizeof(T)));
}

std::string textOf(ByteView bytes) { return {bytes.begin(), bytes.end()}; }

ByteView takeBlock(ByteView& rest) { return take(rest, takeNumber<std::uint32_t>(rest)); }

/// `name=value` fields, each with its length before it.
ByteView fieldOf(ByteView fields, std::string_view name) {
  while (!fields.empty()) {
    const ByteView field = takeBlock(fields);
    const auto equals = std::find(field.begin(), field.end(), '=');
    if (equals != field.end() && std::equal(field.begin(), equals, name.begin(), name.end())) {
      return {equals + 1, field.end()};
    }
  }
  throw Error(fmt::format("damaged bag: a record without its field `{}`", name));
}

std::uint8_t opOf(ByteView header) { return numberOf<std::uint8_t>(fieldOf(header, "op")); }

void unpackBzip2(Bytes& packed, Bytes& unpacked) {
  auto size = static_cast<unsigned int>(unpacked.size());
  if (::BZ2_bzBuffToBuffDecompress(reinterpret_cast<char*>(unpacked.data()), &size,
                                   reinterpret_cast<char*>(packed.data()),
                                   static_cast<unsigned int>(packed.size()), 0, 0) != BZ_OK ||
      size != unpacked.size()) {
    throw Error("damaged bag: a chunk of bz2 cannot be unpacked");
  }
}

void unpackLz4(const Bytes& packed, Bytes& unpacked) {
  LZ4F_dctx* context = nullptr;
  RUBBLE_CHECK(!LZ4F_isError(::LZ4F_createDecompressionContext(&context, LZ4F_VERSION)));
  const std::unique_ptr<LZ4F_dctx, decltype(&::LZ4F_freeDecompressionContext)> owner(
      context, ::LZ4F_freeDecompressionContext);
  std::size_t in = packed.size();
  std::size_t out = unpacked.size();
  const std::size_t left = ::LZ4F_decompress(context, unpacked.data(), &out, packed.data(), &in, nullptr);
  if (left != 0 || in != packed.size() || out != unpacked.size()) {
    throw Error("damaged bag: a chunk of lz4 cannot be unpacked");
  }
}

}  // namespace

BagFile::BagFile(const std::filesystem::path& path) : stream_(path, std::ios::binary | std::ios::ate) {
  if (!stream_) {
    throw Error(fmt::format("cannot be read ({})", std::strerror(errno)));
  }
  size_ = static_cast<std::uint64_t>(std::max<std::streamoff>(stream_.tellg(), 0));
  std::uint64_t at = 0;
  const Bytes magic = readBytes(at, std::min<std::uint64_t>(size_, kMagic.size()));
  if (textOf(magic) != kMagic) {
    throw Error("not a bag that can be read (it does not begin with `#ROSBAG V2.0`)");
  }
  readIndex();
  std::stable_sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.time_ns, a.chunk, a.offset) < std::tie(b.time_ns, b.chunk, b.offset);
  });
}

void BagFile::requireBytes(std::uint64_t at, std::uint64_t size) const {
  if (size > size_ - at) {
    throw Error(fmt::format("the bag is damaged or cut off after byte {}; fix: rosbag reindex", at));
  }
}

Bytes BagFile::readBytes(std::uint64_t& at, std::uint64_t size) {
  requireBytes(at, size);
  Bytes bytes(size);
  stream_.seekg(static_cast<std::streamoff>(at));
  if (!stream_.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) {
    throw Error(fmt::format("cannot be read at byte {}", at));
  }
  at += size;
  return bytes;
}

std::uint32_t BagFile::readLength(std::uint64_t& at) {
  return numberOf<std::uint32_t>(readBytes(at, sizeof(std::uint32_t)));
}

Bytes BagFile::readBlock(std::uint64_t& at) { return readBytes(at, readLength(at)); }

void BagFile::readIndex() {
  std::uint64_t chunk = 0;
  for (std::uint64_t at = kMagic.size(); at < size_;) {
    const std::uint64_t record = at;
    const Bytes header = readBlock(at);
    switch (opOf(header)) {
      case kBagHeader:
        if (numberOf<std::uint64_t>(fieldOf(header, "index_pos")) == 0) {
          throw Error("the bag has no index: its recording was cut off; fix: rosbag reindex");
        }
        break;
      case kChunk:
        chunk = record;
        break;
      case kConnection: {
        std::uint64_t data_at = at;
        connections_[numberOf<std::uint32_t>(fieldOf(header, "conn"))] = {
            textOf(fieldOf(header, "topic")), textOf(fieldOf(readBlock(data_at), "type"))};
        break;
      }
      case kIndexData: {
        std::uint64_t data_at = at;
        const Bytes data = readBlock(data_at);
        const auto connection = numberOf<std::uint32_t>(fieldOf(header, "conn"));
        for (ByteView rest = data; !rest.empty();) {
          const std::uint64_t seconds = takeNumber<std::uint32_t>(rest);
          const auto nanoseconds = takeNumber<std::uint32_t>(rest);
          entries_.push_back(
              {seconds * 1'000'000'000 + nanoseconds, chunk, takeNumber<std::uint32_t>(rest), connection});
        }
        break;
      }
      default:  // Chunk infos, which tell nothing new.
        break;
    }
    const std::uint32_t size = readLength(at);
    requireBytes(at, size);
    at += size;
  }
  for (const Entry& entry : entries_) {
    if (!connections_.contains(entry.connection) || entry.chunk == 0) {
      throw Error("damaged bag: its index is of other chunks or connections; fix: rosbag reindex");
    }
  }
}

void BagFile::unpackChunk(std::uint64_t at) {
  chunk_at_ = 0;
  const std::uint64_t record = at;
  const Bytes header = readBlock(at);
  const std::string compression = textOf(fieldOf(header, "compression"));
  const auto size = numberOf<std::uint32_t>(fieldOf(header, "size"));
  Bytes packed = readBlock(at);
  if (size > kLargestChunk) {
    throw Error(fmt::format("damaged bag: a chunk of {} bytes", size));
  }
  if (compression == "none") {
    chunk_ = std::move(packed);
  } else {
    chunk_.resize(size);
    if (compression == "bz2") {
      unpackBzip2(packed, chunk_);
    } else if (compression == "lz4") {
      unpackLz4(packed, chunk_);
    } else {
      throw Error(fmt::format("compression `{}` is not supported", compression));
    }
  }
  chunk_at_ = record;
}

ByteView BagFile::message(const Entry& entry) {
  if (chunk_at_ != entry.chunk) {
    unpackChunk(entry.chunk);
  }
  ByteView rest = chunk_;
  take(rest, entry.offset);
  const ByteView header = takeBlock(rest);
  if (opOf(header) != kMessageData || numberOf<std::uint32_t>(fieldOf(header, "conn")) != entry.connection) {
    throw Error("damaged bag: its index points at no message; fix: rosbag reindex");
  }
  return takeBlock(rest);
}

}  // namespace rubble::tools
