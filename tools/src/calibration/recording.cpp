#include "calibration/recording.h"

#include <fmt/format.h>

#include <map>
#include <opencv2/imgcodecs.hpp>

#include "common/error.h"
#include "text_lines.h"

namespace rubble::calibration {

namespace {

using tools::Words;

double value(const std::map<std::string, double>& values, const std::string& key,
             const std::filesystem::path& path) {
  const auto found = values.find(key);
  if (found == values.end()) {
    throw common::Error(fmt::format("{}: says no `{}`", path.string(), key));
  }
  return found->second;
}

template <typename Value>
using ByIndex = std::map<int, Value>;

template <typename Value>
void insertOnce(ByIndex<Value>& values, int index, Value value) {
  if (!values.emplace(index, std::move(value)).second) {
    throw common::Error(fmt::format("index {} is there twice", index));
  }
}

ByIndex<std::string> readPictureNames(const std::filesystem::path& path) {
  ByIndex<std::string> names;
  tools::forEachLine(tools::readTextFile(path), [&](std::string_view line) {
    Words words(line, ", \t\r");
    const int index = words.any<int>("index");
    const std::string_view name = words.rest();
    if (name.empty()) {
      throw common::Error("the line ends before its file");
    }
    insertOnce(names, index, std::string(name));
  });
  return names;
}

ByIndex<Scan> readScans(const std::filesystem::path& path) {
  ByIndex<Scan> scans;
  tools::forEachLine(tools::readTextFile(path), [&](std::string_view line) {
    Words words(line, ", \t\r");
    const int index = words.any<int>("index");
    Scan scan;
    scan.angle_min = words.finite("first angle");
    scan.angle_step = words.finite("angle step");
    while (!words.rest().empty()) {
      scan.ranges.push_back(words.any<double>("range"));
    }
    if (scan.ranges.empty()) {
      throw common::Error("the line has no ranges");
    }
    insertOnce(scans, index, std::move(scan));
  });
  return scans;
}

}  // namespace

Calib readCalib(const std::filesystem::path& path) {
  std::map<std::string, double> values;
  std::string model = "pinhole";
  std::string corners;
  tools::forEachLine(tools::readTextFile(path), [&](std::string_view line) {
    Words words(line);
    const std::string key(words.word("key"));
    if (key == "model") {
      model = words.word("model");
      if (model != "pinhole" && model != "fisheye") {
        throw common::Error(fmt::format("model `{}`: pinhole or fisheye", model));
      }
    } else if (key == "board_inner_corners") {
      const int width = words.any<int>("number of corners in a row");
      corners = fmt::format("{}x{}", width, words.any<int>("number of rows"));
    } else {
      values[key] = words.finite(key.c_str());
    }
    words.expectEnd();
  });
  Calib calib;
  Lens& lens = calib.lens;
  const auto get = [&](const char* key) { return value(values, key, path); };
  lens.size = {static_cast<int>(get("width")), static_cast<int>(get("height"))};
  lens.is_fisheye = model == "fisheye";
  lens.K = {get("fx"), 0.0, get("cx"), 0.0, get("fy"), get("cy"), 0.0, 0.0, 1.0};
  if (lens.is_fisheye) {
    lens.distortion = {get("k1"), get("k2"), get("k3"), get("k4")};
  } else {
    lens.distortion = {get("k1"), get("k2"), get("p1"), get("p2"), values.contains("k3") ? get("k3") : 0.0};
  }
  if (!corners.empty()) {
    calib.board = parseBoard(corners, get("board_square_m"));
  }
  return calib;
}

Pairs readPairs(const std::filesystem::path& folder, const Lens& lens, const Board& board) {
  const ByIndex<std::string> pictures = readPictureNames(folder / "images.csv");
  const ByIndex<Scan> scans = readScans(folder / "scans.csv");
  Pairs pairs;
  for (const auto& [index, scan] : scans) {
    if (!pictures.contains(index)) {
      pairs.left_out.push_back({std::to_string(index), "images.csv has no picture for this scan"});
    }
  }
  for (const auto& [index, name] : pictures) {
    const auto scan = scans.find(index);
    if (scan == scans.end()) {
      pairs.left_out.push_back({name, "scans.csv has no scan for this picture"});
      continue;
    }
    const cv::Mat grey = cv::imread((folder / name).string(), cv::IMREAD_GRAYSCALE);
    if (grey.empty()) {
      pairs.left_out.push_back({name, "is no readable picture"});
      continue;
    }
    if (grey.size() != lens.size) {
      throw common::Error(fmt::format("{}: {} x {} pixels, but the camera's calibration is for {} x {}",
                                      (folder / name).string(), grey.cols, grey.rows, lens.size.width,
                                      lens.size.height));
    }
    const auto corners = findCorners(grey, board);
    if (!corners) {
      pairs.left_out.push_back({name, "does not show the whole board"});
      continue;
    }
    pairs.used.push_back({name, T_camera_board(board, lens, *corners), scan->second.points(),
                          straightRuns(scan->second), isFirstSquareBlack(grey, board, *corners)});
  }
  return pairs;
}

}  // namespace rubble::calibration
