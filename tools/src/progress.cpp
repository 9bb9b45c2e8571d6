#include "progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <utility>

namespace rubble::tools {

namespace {

using std::chrono::steady_clock;

constexpr int kBarWidth = 40;
constexpr std::chrono::milliseconds kRedraw{100};
constexpr std::chrono::seconds kQuiet{2};

}  // namespace

Progress::Progress(std::string label, std::int64_t total)
    : label_(std::move(label)),
      total_(total),
      terminal_(::isatty(STDERR_FILENO) == 1),
      next_(steady_clock::now() +
            (terminal_ ? steady_clock::duration(kRedraw) : steady_clock::duration(kQuiet))) {}

Progress::~Progress() {
  if (drawn_ && terminal_) {
    fmt::print(stderr, "\n");
  }
}

void Progress::update(std::int64_t done) {
  if (total_ <= 0) {
    return;
  }
  const auto percent = static_cast<int>(std::clamp<std::int64_t>(done, 0, total_) * 100 / total_);
  const int step = terminal_ ? 1 : 10;
  if (percent / step == shown_percent_ / step) {
    return;
  }
  const auto now = steady_clock::now();
  if (now < next_ && !(drawn_ && percent == 100)) {
    return;
  }
  draw(percent);
  shown_percent_ = percent;
  drawn_ = true;
  if (terminal_) {
    next_ = now + kRedraw;
  }
}

void Progress::draw(int percent) const {
  if (terminal_) {
    const int filled = percent * kBarWidth / 100;
    fmt::print(stderr, "\r{} [{:=<{}}{:{}}] {:3d} %", label_, "", filled, "", kBarWidth - filled, percent);
    std::fflush(stderr);
  } else {
    fmt::print(stderr, "{}: {} %\n", label_, percent / 10 * 10);
  }
}

}  // namespace rubble::tools
