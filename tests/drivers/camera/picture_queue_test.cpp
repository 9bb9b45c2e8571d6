#include "picture_queue.h"

#include <gtest/gtest.h>

namespace rubble::camera {
namespace {

TEST(PictureQueue, FullDropsTheOldestAndCountsIt) {
  PictureQueue queue(2);
  for (int i = 0; i < 5; ++i) {
    auto picture = queue.blank();
    picture->utime = i;
    queue.push(std::move(picture));
  }
  EXPECT_EQ(queue.dropped(), 3);
  EXPECT_EQ(queue.pop()->utime, 3);
  EXPECT_EQ(queue.pop()->utime, 4);
  EXPECT_EQ(queue.pop(), nullptr);
}

TEST(PictureQueue, PicturesGoRound) {
  PictureQueue queue(2);
  auto picture = queue.blank();
  const bot_core::image_t* first = picture.get();
  queue.push(std::move(picture));
  queue.giveBack(queue.pop());
  EXPECT_EQ(queue.blank().get(), first);
}

}  // namespace
}  // namespace rubble::camera
