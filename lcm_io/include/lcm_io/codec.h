#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "common/error.h"

namespace rubble::lcm_io {

using Bytes = std::vector<std::uint8_t>;
using ByteView = std::span<const std::uint8_t>;

/// The bytes of a generated LCM message, fingerprint first, into `bytes`, whose memory is used again.
template <typename Message>
void encodeInto(const Message& message, Bytes& bytes) {
  bytes.resize(static_cast<std::size_t>(message.getEncodedSize()));
  const int size = message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  RUBBLE_CHECK(size == static_cast<int>(bytes.size()));
}

template <typename Message>
Bytes encode(const Message& message) {
  Bytes bytes;
  encodeInto(message, bytes);
  return bytes;
}

/// True when the bytes start with the fingerprint of Message.
template <typename Message>
bool hasFingerprint(ByteView bytes) {
  const auto expected = static_cast<std::uint64_t>(Message::getHash());
  std::uint64_t found = 0;
  for (std::size_t i = 0; i < sizeof(found) && i < bytes.size(); ++i) {
    found = found << 8 | bytes[i];
  }
  return bytes.size() >= sizeof(found) && found == expected;
}

/// Decodes and throws Error saying whether the type is another one or the content is damaged.
template <typename Message>
Message decode(ByteView bytes) {
  if (!hasFingerprint<Message>(bytes)) {
    throw common::Error(
        fmt::format("{} bytes that are no {} (other fingerprint): another type or version is published",
                    bytes.size(), Message::getTypeName()));
  }
  Message message;
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) {
    throw common::Error(fmt::format("damaged {} of {} bytes: a length inside does not fit",
                                    Message::getTypeName(), bytes.size()));
  }
  return message;
}

}  // namespace rubble::lcm_io
