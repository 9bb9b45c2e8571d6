#include "lcm_io/codec.h"

#include <gmock/gmock.h>

#include <random>

#include "all_types.h"
#include "sample_messages.h"
#include "support/allocation_watch.h"
#include "support/error_text.h"

namespace rubble::lcm_io {
namespace {

using test::errorOf;
using test::largestAllocation;
using test::watchAllocations;

/// Elements of at most this size may be made for every byte of a message.
constexpr std::size_t kLargestElement = 288;

/// Decoding may refuse, but neither crash nor allocate more than the message's size justifies, and what it
/// takes can be encoded again.
template <typename Message>
void expectHarmless(ByteView bytes) {
  watchAllocations();
  try {
    const auto message = decode<Message>(bytes);
    EXPECT_LE(largestAllocation(), kLargestElement * bytes.size());
    EXPECT_EQ(encode(message).size(), bytes.size());
  } catch (const common::Error&) {
    EXPECT_LE(largestAllocation(), std::max<std::size_t>(1024, kLargestElement * bytes.size()));
  }
}

template <typename Message>
class CodecTest : public testing::Test {
 protected:
  const Bytes good_ = encode(sample<Message>());
};
TYPED_TEST_SUITE(CodecTest, AllTypes);

TYPED_TEST(CodecTest, TruncationAtEveryByteIsDamage) {
  for (std::size_t n = 0; n < this->good_.size(); ++n) {
    EXPECT_THROW(decode<TypeParam>(ByteView(this->good_).first(n)), common::Error) << n << " bytes";
  }
}

TYPED_TEST(CodecTest, BytesTooManyAreDamage) {
  Bytes bytes = this->good_;
  bytes.push_back(0);
  EXPECT_THROW(decode<TypeParam>(bytes), common::Error);
}

TYPED_TEST(CodecTest, AnyLengthAnywhereIsHarmless) {
  for (const std::uint32_t length :
       {0U, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFFFFU, 0x10000000U, 0x00100000U, 200U}) {
    for (std::size_t at = 8; at + 4 <= this->good_.size(); ++at) {
      Bytes bytes = this->good_;
      for (int i = 0; i < 4; ++i) {
        bytes[at + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
      }
      expectHarmless<TypeParam>(bytes);
    }
  }
}

TYPED_TEST(CodecTest, EveryBitFlipIsHarmless) {
  for (std::size_t bit = 0; bit < 8 * this->good_.size(); ++bit) {
    Bytes bytes = this->good_;
    bytes[bit / 8] ^= static_cast<std::uint8_t>(1U << bit % 8);
    expectHarmless<TypeParam>(bytes);
  }
}

TYPED_TEST(CodecTest, GarbageIsHarmless) {
  std::mt19937 random(11);
  for (int round = 0; round < 300; ++round) {
    Bytes bytes(this->good_.begin(), this->good_.begin() + 8);  // The fingerprint, so that it gets further.
    bytes.resize(8 + random() % 400);
    for (std::size_t i = 8; i < bytes.size(); ++i) {
      // Mostly small lengths, which lead deeper.
      bytes[i] = static_cast<std::uint8_t>(random() % 4 == 0 ? random() % 8 : round % 2 == 0 ? 0 : random());
    }
    expectHarmless<TypeParam>(bytes);
  }
}

TEST(Codec, AnotherTypeIsNamed) {
  const Bytes bytes = encode(sample<rubble::stabilizer_t>());
  EXPECT_EQ(
      errorOf([&] { decode<rubble::stabilizer_command_t>(bytes); }),
      "56 bytes that are no stabilizer_command_t (other fingerprint): another type or version is published");
  EXPECT_TRUE(hasFingerprint<rubble::stabilizer_t>(bytes));
  EXPECT_FALSE(hasFingerprint<rubble::stabilizer_command_t>(bytes));
  EXPECT_FALSE(hasFingerprint<rubble::stabilizer_t>(ByteView(bytes).first(7)));
}

TEST(Codec, DamageIsNamed) {
  const Bytes bytes = encode(sample<rubble::stabilizer_t>());
  EXPECT_EQ(errorOf([&] { decode<rubble::stabilizer_t>(ByteView(bytes).first(55)); }),
            "damaged stabilizer_t of 55 bytes: a length inside does not fit");
}

TEST(Codec, ATextWithAZeroInsideIsDamage) {
  rubble::counter_t counter;
  counter.name = "ab";
  counter.count = 1;
  Bytes bytes = encode(counter);
  ASSERT_EQ(bytes[13], 'b');
  bytes[13] = 0;
  EXPECT_THROW(decode<rubble::counter_t>(bytes), common::Error) << "it could not be encoded again";
  bytes[13] = 'b';
  bytes[14] = 'c';
  EXPECT_THROW(decode<rubble::counter_t>(bytes), common::Error) << "no zero at the end";
}

}  // namespace
}  // namespace rubble::lcm_io
