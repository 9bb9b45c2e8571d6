// A message of any type, as it is on the bus, and what makes values of it.
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "grid_image.h"
#include "lcm_io/codec.h"
#include "lcm_io/conversions.h"
#include "lcm_io/mono_map.h"
#include "lcm_io/picture_decoder.h"
#include "message_types.h"
#include "picture.h"
#include "picture_sequence.h"

namespace {

using namespace rubble;

constexpr std::size_t kTypes = std::tuple_size_v<MessageTypes>;
constexpr std::size_t kFingerprintSize = 8;
using Fingerprint = std::array<std::uint8_t, kFingerprintSize>;

template <typename Message>
Fingerprint fingerprintOf() {
  Fingerprint bytes{};
  auto hash = static_cast<std::uint64_t>(Message::getHash());
  for (std::size_t i = kFingerprintSize; i-- > 0; hash >>= 8) {
    bytes[i] = static_cast<std::uint8_t>(hash);
  }
  return bytes;
}

/// Whatever refuses a value does so by an Error.
template <typename Take>
void attempt(const Take& take) {
  try {
    take();
  } catch (const common::Error&) {
    // No value, and said so.
  }
}

template <typename Message>
void convert(const Message&) {}
void convert(const bot_core::image_t& message) {
  attempt([&] { lcm_io::decodeGrey(message); });
  attempt([&] { lcm_io::decodeColour(message); });
  attempt([&] { tools::pictureFileContent(message); });
}
void convert(const camera_info_t& message) {
  attempt([&] { lcm_io::intrinsicsFromMessage(message); });
  attempt([&] { tools::calibLine(message); });
}
void convert(const ground_truth_t& message) {
  attempt([&] { lcm_io::poseFromMessage(message.p_world_frame, message.q_world_frame); });
}
void convert(const odometry_t& message) {
  attempt([&] {
    const common::Pose3 T = lcm_io::poseFromMessage(message.p_odom_body, message.q_odom_body);
    RUBBLE_CHECK(T.matrix().allFinite() && std::abs(T.linear().determinant() - 1.0) < 1e-6);
  });
}
void convert(const mono_map_t& message) {
  attempt([&] {
    common::KeyframePoses keyframes;
    for (const common::AnchoredPose& picture : lcm_io::readMonoMap(message, keyframes)) {
      keyframes.locate(picture);
    }
  });
}
void convert(const grid_map_t& message) {
  attempt([&] { tools::GridAssembly().add(message); });
}

template <typename Message>
void decodeAs(lcm_io::ByteView bytes) {
  if (!lcm_io::hasFingerprint<Message>(bytes)) {
    return;
  }
  attempt([&] {
    const auto message = lcm_io::decode<Message>(bytes);
    RUBBLE_CHECK(std::ranges::equal(lcm_io::encode(message), bytes));
    convert(message);
  });
}

template <typename... Messages>
void decodeAsEach(lcm_io::ByteView bytes, const std::tuple<Messages...>*) {
  (decodeAs<Messages>(bytes), ...);
}

template <typename... Messages>
std::array<Fingerprint, kTypes> fingerprintsOf(const std::tuple<Messages...>*) {
  return {fingerprintOf<Messages>()...};
}

}  // namespace

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t max_size);

/// Most mutations leave the fingerprint, without which nothing is read; some make it another type's.
extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t max_size,
                                               unsigned int seed) {
  static const auto fingerprints = fingerprintsOf(static_cast<const MessageTypes*>(nullptr));
  std::minstd_rand random(seed);
  if (max_size <= kFingerprintSize || random() % 64 == 0) {
    return LLVMFuzzerMutate(data, size, max_size);
  }
  if (size < kFingerprintSize || random() % 16 == 0) {
    std::ranges::copy(fingerprints[random() % kTypes], data);
    size = std::max(size, kFingerprintSize);
  }
  return kFingerprintSize +
         LLVMFuzzerMutate(data + kFingerprintSize, size - kFingerprintSize, max_size - kFingerprintSize);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  decodeAsEach({data, size}, static_cast<const MessageTypes*>(nullptr));
  return 0;
}
