#include <gtest/gtest.h>
#include <lcm/eventlog.h>

#include <memory>

#include "lcm_io/log_file.h"
#include "support/temp_dir.h"

namespace rubble::lcm_io {
namespace {

struct Destroy {
  void operator()(lcm_eventlog_t* log) const { lcm_eventlog_destroy(log); }
  void operator()(lcm_eventlog_event_t* event) const { lcm_eventlog_free_event(event); }
};

TEST(LogInterop, LcmReadsOurLogs) {
  const test::TempDir dir;
  const std::string path = dir.path() / "ours.lcm";
  LogWriter writer(path);
  for (int i = 0; i < 20; ++i) {
    writer.write(1000 * i, "CHANNEL_" + std::to_string(i), Bytes(static_cast<std::size_t>(i), 7));
  }
  writer.close();

  const std::unique_ptr<lcm_eventlog_t, Destroy> log(lcm_eventlog_create(path.c_str(), "r"));
  ASSERT_TRUE(log);
  for (int i = 0; i < 20; ++i) {
    const std::unique_ptr<lcm_eventlog_event_t, Destroy> event(lcm_eventlog_read_next_event(log.get()));
    ASSERT_TRUE(event) << i;
    EXPECT_EQ(event->eventnum, i);
    EXPECT_EQ(event->timestamp, 1000 * i);
    EXPECT_EQ(std::string(event->channel), "CHANNEL_" + std::to_string(i));
    EXPECT_EQ(event->datalen, i);
  }
  EXPECT_EQ(lcm_eventlog_read_next_event(log.get()), nullptr);
}

TEST(LogInterop, WeReadLcmsLogs) {
  const test::TempDir dir;
  const std::string path = dir.path() / "theirs.lcm";
  {
    const std::unique_ptr<lcm_eventlog_t, Destroy> log(lcm_eventlog_create(path.c_str(), "w"));
    ASSERT_TRUE(log);
    for (int i = 0; i < 20; ++i) {
      std::string channel = "CHANNEL_" + std::to_string(i);
      Bytes data(static_cast<std::size_t>(i) + 1, 9);
      lcm_eventlog_event_t event{};
      event.timestamp = 1'700'000'000'000'000 + i;
      event.channellen = static_cast<int32_t>(channel.size());
      event.channel = channel.data();
      event.datalen = static_cast<int32_t>(data.size());
      event.data = data.data();
      ASSERT_EQ(lcm_eventlog_write_event(log.get(), &event), 0);
    }
  }
  LogReader reader(path);
  for (int i = 0; i < 20; ++i) {
    const auto event = reader.next();
    ASSERT_TRUE(event) << i;
    EXPECT_EQ(event->number, i);
    EXPECT_EQ(event->utime, 1'700'000'000'000'000 + i);
    EXPECT_EQ(event->channel, "CHANNEL_" + std::to_string(i));
    EXPECT_EQ(event->data, Bytes(static_cast<std::size_t>(i) + 1, 9));
  }
  EXPECT_FALSE(reader.next());
  EXPECT_FALSE(reader.truncated());
}

}  // namespace
}  // namespace rubble::lcm_io
