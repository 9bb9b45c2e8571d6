#include "async_writer.h"

#include <gtest/gtest.h>

#include <future>

#include "common/error.h"
#include "log_content.h"

namespace rubble::ops_console {
namespace {

constexpr std::size_t kRoomy = 64'000'000;

/// What a scripted sink has seen, shared with the test.
struct Tape {
  std::mutex mutex;
  std::condition_variable changed;
  std::vector<std::uint32_t> numbers;
  bool stalled = false;
  int refusals_left = 0;
  int calls = 0;
  int syncs = 0;

  template <typename Condition>
  bool waitFor(Condition condition) {
    std::unique_lock lock(mutex);
    return changed.wait_for(lock, std::chrono::seconds(10), condition);
  }
  void stall(bool on) {
    const std::lock_guard lock(mutex);
    stalled = on;
    changed.notify_all();
  }
};

class TapeSink : public LogSink {
 public:
  explicit TapeSink(std::shared_ptr<Tape> tape) : tape_(std::move(tape)) {}

  void write(const std::vector<lcm_io::RawMessage>& batch) override {
    std::unique_lock lock(tape_->mutex);
    tape_->calls += batch.empty() ? 0 : 1;
    tape_->changed.notify_all();
    tape_->changed.wait(lock, [&] { return !tape_->stalled; });
    if (!batch.empty() && tape_->refusals_left > 0) {
      --tape_->refusals_left;
      throw common::Error("refused");
    }
    for (const lcm_io::RawMessage& message : batch) {
      tape_->numbers.push_back(numberOf(message.data));
    }
    tape_->changed.notify_all();
  }

  void sync() override {
    const std::lock_guard lock(tape_->mutex);
    ++tape_->syncs;
    tape_->changed.notify_all();
  }

 private:
  std::shared_ptr<Tape> tape_;
};

class AsyncWriterTest : public testing::Test {
 protected:
  std::unique_ptr<LogSink> sink() const { return std::make_unique<TapeSink>(tape_); }
  std::shared_ptr<Tape> tape_ = std::make_shared<Tape>();
};

TEST_F(AsyncWriterTest, WritesAllInOrderAndSyncsWithoutBeingAsked) {
  AsyncWriter writer(sink(), kRoomy);
  for (std::uint32_t i = 0; i < 20'000; ++i) {
    writer.push(numbered("TEST", i, 500, 0));
  }
  EXPECT_TRUE(tape_->waitFor([&] { return tape_->numbers.size() == 20'000 && tape_->syncs > 0; }));
  writer.finish();
  EXPECT_EQ(tape_->numbers, countFrom(0, 20'000));
  EXPECT_EQ(writer.status().written, 20'000);
  EXPECT_EQ(writer.status().written_bytes, 20'000 * 500);
  EXPECT_EQ(writer.status().dropped, 0);
  EXPECT_EQ(writer.status().queued_bytes, 0U);
}

TEST_F(AsyncWriterTest, FinishWritesAndSyncsWhatWaits) {
  AsyncWriter writer(sink(), kRoomy);
  for (std::uint32_t i = 0; i < 5000; ++i) {
    writer.push(numbered("TEST", i, 1000, 0));
  }
  writer.finish();
  EXPECT_EQ(tape_->numbers, countFrom(0, 5000));
  EXPECT_GE(tape_->syncs, 1);
}

TEST_F(AsyncWriterTest, StalledDiskBlocksNobodyAndCostsTheOldest) {
  constexpr std::size_t kCapacity = 3'000'000;
  tape_->stall(true);
  AsyncWriter writer(sink(), kCapacity);
  writer.push(numbered("TEST", 0, 1000, 0));
  ASSERT_TRUE(tape_->waitFor([&] { return tape_->calls == 1; }));
  for (std::uint32_t i = 1; i < 10'000; ++i) {
    writer.push(numbered("TEST", i, 1000, 0));  // Would never return if it waited for the sink.
    ASSERT_LE(writer.status().queued_bytes, kCapacity);
  }
  const AsyncWriter::Status stalled = writer.status();
  EXPECT_GT(stalled.busy.count(), 0);
  EXPECT_GT(stalled.dropped, 6000);
  EXPECT_EQ(stalled.written, 0);

  tape_->stall(false);
  writer.finish();
  const auto kept = tape_->numbers.size();
  EXPECT_EQ(kept + static_cast<std::size_t>(stalled.dropped), 10'000U);
  EXPECT_EQ(tape_->numbers.front(), 0U);
  const std::vector<std::uint32_t> after(tape_->numbers.begin() + 1, tape_->numbers.end());
  EXPECT_EQ(after, countFrom(static_cast<std::uint32_t>(10'000 - after.size()), after.size()));
}

TEST_F(AsyncWriterTest, NothingIsLostOverADiskThatRefusesForAWhile) {
  tape_->refusals_left = 2;
  AsyncWriter writer(sink(), kRoomy);
  for (std::uint32_t i = 0; i < 100; ++i) {
    writer.push(numbered("TEST", i, 1000, 0));
  }
  ASSERT_TRUE(tape_->waitFor([&] { return tape_->calls == 2; }));
  EXPECT_EQ(writer.status().error, "refused");
  for (std::uint32_t i = 100; i < 200; ++i) {
    writer.push(numbered("TEST", i, 1000, 0));
  }
  ASSERT_TRUE(tape_->waitFor([&] { return tape_->numbers.size() == 200; }));
  writer.finish();
  EXPECT_EQ(tape_->numbers, countFrom(0, 200));
  EXPECT_EQ(writer.status().error, "");
  EXPECT_EQ(writer.status().dropped, 0);
}

TEST_F(AsyncWriterTest, FinishDoesNotWaitForADiskThatRefuses) {
  tape_->refusals_left = 1'000'000;
  AsyncWriter writer(sink(), kRoomy);
  for (std::uint32_t i = 0; i < 100; ++i) {
    writer.push(numbered("TEST", i, 1000, 0));
  }
  writer.finish();
  EXPECT_EQ(writer.status().written, 0);
  EXPECT_EQ(writer.status().dropped, 100);
  EXPECT_EQ(writer.status().error, "refused");
}

}  // namespace
}  // namespace rubble::ops_console
