#include "recognizer/recognizer_node.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <bot_core/image_t.hpp>
#include <cmath>
#include <cstring>
#include <deque>
#include <filesystem>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <rubble/command_t.hpp>
#include <rubble/detections_t.hpp>
#include <rubble/mono_features_t.hpp>
#include <rubble/object_notice_t.hpp>
#include <set>

#include "common/error.h"
#include "lcm_io/channels.h"
#include "lcm_io/picture_decoder.h"
#include "notice_picture.h"
#include "novelty.h"
#include "recognizer/code_reader.h"
#include "recognizer/recognizer.h"
#include "recognizer/vocabulary.h"
#include "recognizer_node_config.h"

namespace rubble::recognizer {

namespace {

using common::Utime;
using lcm_io::NodeStatus;

/// Pictures that wait for their features.
constexpr std::size_t kMostPictures = 8;
constexpr std::size_t kMostNoticeBytes = 100'000;
/// How long DEGRADED stays after pictures were left out.
constexpr Utime kLateSpan = 5 * common::kMicrosecondsPerSecond;

orb::Features featuresFromMessage(const rubble::mono_features_t& m) {
  const auto n = static_cast<std::size_t>(std::max(m.n, 0));
  if (m.n < 0 || m.octave.size() != n || m.descriptors.size() != n * sizeof(orb::Descriptor)) {
    throw common::Error(fmt::format("{} features with {} octaves and {} bytes of descriptors", m.n,
                                    m.octave.size(), m.descriptors.size()));
  }
  orb::Features features;
  features.width = m.width;
  features.height = m.height;
  features.x = m.x;
  features.y = m.y;
  features.angle = m.angle;
  features.octave = m.octave;
  features.descriptors.resize(n);
  if (n > 0) {
    std::memcpy(features.descriptors.data(), m.descriptors.data(), m.descriptors.size());
  }
  for (std::size_t i = 0; i < n; ++i) {
    if (!std::isfinite(features.x[i]) || !std::isfinite(features.y[i]) || !std::isfinite(features.angle[i])) {
      throw common::Error(fmt::format("feature {} is not finite", i));
    }
  }
  return features;
}

rubble::detection_t toMessage(const Detection& detection) {
  rubble::detection_t message;
  message.class_name = detection.class_name;
  message.kind = detection.kind;
  message.text = detection.text;
  message.score = detection.score;
  for (std::size_t i = 0; i < 4; ++i) {
    message.quad_x[i] = detection.quad[i].x;
    message.quad_y[i] = detection.quad[i].y;
  }
  message.width = detection.width;
  message.height = detection.height;
  return message;
}

Detection toDetection(const Code& code) {
  return {.class_name = code.kind, .kind = code.kind, .text = code.text, .score = 1.0F, .quad = code.quad};
}

class RecognizerNode : public lcm_io::Node {
 public:
  explicit RecognizerNode(const lcm_io::ProcessContext& context)
      : bus_(context.bus),
        times_(context.times),
        config_(context.config.read<NodeConfig>("recognizer")),
        code_reader_(config_.codes),
        novelty_(config_.notice_views, config_.notice_quiet) {
    cv::setNumThreads(0);
    const std::filesystem::path path = vocabularyPath(config_.vocabulary);
    if (path.empty()) {
      spdlog::warn("no vocabulary: only codes are read");
    } else {
      load(path);
    }
    bus_.subscribe<bot_core::image_t>(lcm_io::channel::kCamera, [this](const auto& m) { onPicture(m); });
    bus_.subscribe<rubble::mono_features_t>(lcm_io::channel::kMonoFeatures,
                                            [this](const auto& m) { onFeatures(m); });
    bus_.subscribe<rubble::command_t>(lcm_io::channel::kCommand, [this](const auto& m) { onCommand(m); });
  }

  NodeStatus status() const override {
    NodeStatus status;
    status.state = recognizer_ ? "watching" : "codes only";
    status.counters = {{"pictures", counters_.pictures},
                       {"pictures_left_out", counters_.left_out},
                       {"detections", counters_.detections},
                       {"notices", counters_.notices}};
    const auto say = [&](const char* what) {
      status.level = NodeStatus::Level::kDegraded;
      status.detail += (status.detail.empty() ? "" : "; ") + std::string(what);
    };
    if (!recognizer_) {
      say("no vocabulary: make one with `rubble train SAMPLES_DIR` and name it in recognizer.vocabulary");
    }
    if (counters_.pictures == 0) {
      status.state = "waiting";
      say("no picture with its MONO_FEATURES yet: are rubble-camera and rubble-slam-mono running?");
    }
    if (last_left_out_ > 0 && last_picture_ - last_left_out_ <= kLateSpan) {
      say("cannot keep up: pictures are left out");
    }
    return status;
  }

 private:
  struct Counters {
    std::int64_t pictures = 0, left_out = 0, detections = 0, notices = 0;
  };

  void load(const std::filesystem::path& path) {
    const auto vocabulary = std::make_shared<const Vocabulary>(Vocabulary::load(path));
    recognizer_.emplace(config_.recognizer, vocabulary);
    spdlog::info("vocabulary {}", path.string());
  }

  void onCommand(const rubble::command_t& command) {
    if (command.target != "recognizer") {
      return;
    }
    if (command.verb != "load") {
      throw common::Error(fmt::format("unknown command `{}`; known: load FILE", command.verb));
    }
    load(command.argument);
  }

  void onPicture(const bot_core::image_t& picture) {
    pictures_.push_back(picture);
    if (pictures_.size() > kMostPictures) {
      pictures_.pop_front();
    }
  }

  void onFeatures(const rubble::mono_features_t& message) {
    const auto picture = std::find_if(pictures_.begin(), pictures_.end(),
                                      [&](const bot_core::image_t& p) { return p.utime == message.utime; });
    noteLeftOut(message.utime);
    // Half a picture early is in time: pictures do not come at multiples of the period.
    if (picture == pictures_.end() ||
        message.utime + period_ / 2 - last_look_ < common::utimeFromSeconds(config_.period)) {
      return;
    }
    last_look_ = message.utime;
    const lcm_io::StageTimer total(times_, "total");
    pictures_.erase(pictures_.begin(), picture);
    const bot_core::image_t image = std::move(pictures_.front());
    pictures_.pop_front();
    recognise(lcm_io::decodeColour(image), featuresFromMessage(message), message.utime);
  }

  /// Features come for every picture: a gap in their times is what the bus had to drop.
  void noteLeftOut(Utime utime) {
    if (last_picture_ > 0 && period_ > 0) {
      const Utime missed = (utime - last_picture_ - period_ / 2) / period_;
      if (missed > 0) {
        counters_.left_out += missed;
        last_left_out_ = utime;
      }
    }
    if (last_picture_ > 0) {
      period_ = period_ > 0 ? std::min(period_, utime - last_picture_) : utime - last_picture_;
    }
    last_picture_ = utime;
  }

  void recognise(const cv::Mat& picture, const orb::Features& features, Utime utime) {
    std::vector<Detection> detections;
    if (recognizer_) {
      const lcm_io::StageTimer timer(times_, "recognise");
      detections = recognizer_->recognise(features, picture, counters_.pictures % config_.solid_every == 0);
    }
    {
      const lcm_io::StageTimer timer(times_, "codes");
      cv::cvtColor(picture, grey_, cv::COLOR_BGR2GRAY);
      for (const Code& code : code_reader_.read(grey_)) {
        detections.push_back(toDetection(code));
      }
    }
    rubble::detections_t message;
    message.utime = utime;
    message.width = picture.cols;
    message.height = picture.rows;
    for (const Detection& detection : detections) {
      message.detections.push_back(toMessage(detection));
    }
    message.n = static_cast<std::int32_t>(message.detections.size());
    bus_.publish(lcm_io::channel::kDetections, message);
    ++counters_.pictures;
    counters_.detections += message.n;
    notify(picture, detections, utime);
  }

  void notify(const cv::Mat& picture, const std::vector<Detection>& detections, Utime utime) {
    std::set<std::string> seen;
    for (const Detection& detection : detections) {
      const std::string name =
          detection.text.empty() ? detection.class_name : detection.class_name + ": " + detection.text;
      if (!seen.insert(name).second || !novelty_.see(name, utime)) {
        continue;
      }
      rubble::object_notice_t notice;
      notice.utime = utime;
      notice.detection = toMessage(detection);
      notice.jpeg = noticeJpeg(picture, detection.quad, name, kMostNoticeBytes);
      notice.njpeg = static_cast<std::int32_t>(notice.jpeg.size());
      bus_.publish(lcm_io::channel::kObjectNotice, notice);
      ++counters_.notices;
      spdlog::info("new: {}", name);
    }
  }

  lcm_io::Bus& bus_;
  lcm_io::StageTimes* times_;
  const NodeConfig config_;
  std::optional<Recognizer> recognizer_;
  CodeReader code_reader_;
  Novelty novelty_;
  std::deque<bot_core::image_t> pictures_;
  cv::Mat grey_;
  Utime last_picture_ = 0;
  Utime period_ = 0;  // The shortest one between two pictures.
  Utime last_look_ = 0;
  Utime last_left_out_ = 0;
  Counters counters_;
};

}  // namespace

std::unique_ptr<lcm_io::Node> makeNode(const lcm_io::ProcessContext& context) {
  return std::make_unique<RecognizerNode>(context);
}

std::string describeConfig(const common::Config& config) { return config.describe<NodeConfig>("recognizer"); }

}  // namespace rubble::recognizer
