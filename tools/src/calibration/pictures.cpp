#include "calibration/pictures.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <opencv2/imgcodecs.hpp>

#include "common/error.h"

namespace rubble::calibration {

namespace {

constexpr std::array kSuffixes{".jpg", ".jpeg", ".png", ".JPG", ".JPEG", ".PNG"};

std::vector<std::filesystem::path> pictureFiles(const std::filesystem::path& folder) {
  std::error_code error;
  std::vector<std::filesystem::path> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder, error)) {
    if (std::find(kSuffixes.begin(), kSuffixes.end(), entry.path().extension().string()) != kSuffixes.end()) {
      files.push_back(entry.path());
    }
  }
  if (error) {
    throw common::Error(fmt::format("{}: {}", folder.string(), error.message()));
  }
  if (files.empty()) {
    throw common::Error(fmt::format("{}: has no jpg or png pictures", folder.string()));
  }
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

void printLeftOut(const std::vector<LeftOut>& left_out) {
  for (const LeftOut& picture : left_out) {
    fmt::print(stderr, "left out: {}: {}\n", picture.name, picture.why);
  }
}

Pictures readPictures(const std::filesystem::path& folder, const Board& board) {
  Pictures pictures;
  for (const std::filesystem::path& file : pictureFiles(folder)) {
    const std::string name = file.filename().string();
    const cv::Mat grey = cv::imread(file.string(), cv::IMREAD_GRAYSCALE | cv::IMREAD_IGNORE_ORIENTATION);
    if (grey.empty()) {
      pictures.left_out.push_back({name, "is no readable picture"});
      continue;
    }
    if (pictures.size.empty()) {
      pictures.size = grey.size();
    }
    if (grey.size() != pictures.size) {
      pictures.left_out.push_back(
          {name, fmt::format("has {} x {} pixels, not {} x {} as the first", grey.cols, grey.rows,
                             pictures.size.width, pictures.size.height)});
    } else if (auto corners = findCorners(grey, board)) {
      pictures.with_board.push_back({name, std::move(*corners)});
    } else {
      pictures.left_out.push_back({name, "does not show the whole board"});
    }
  }
  return pictures;
}

}  // namespace rubble::calibration
