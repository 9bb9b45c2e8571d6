// Recordings as `rubble import` reads them, and the ROS messages in a bag by themselves: a bag's index is
// hard to keep whole. The input's first byte chooses the format; where a recording is a folder, NUL bytes
// part its files, the last of which is its picture.
#include <array>
#include <filesystem>
#include <vector>

#include "common/files.h"
#include "import_carmen.h"
#include "import_rosbag.h"
#include "input_file.h"
#include "picture_sequence.h"
#include "ros_messages.h"

namespace {

using namespace rubble;
using namespace rubble::tools;
using Bytes = std::span<const std::uint8_t>;

/// A PNG with the right checksums behind its chunks; anything else as it is.
std::vector<std::uint8_t> withChecksums(Bytes picture) {
  std::vector<std::uint8_t> bytes(picture.begin(), picture.end());
  if (bytes.size() < 8 || bytes[1] != 'P') {
    return bytes;
  }
  for (std::size_t at = 8; bytes.size() - at >= 12;) {
    const std::size_t length = std::uint32_t{bytes[at]} << 24U | std::uint32_t{bytes[at + 1]} << 16U |
                               std::uint32_t{bytes[at + 2]} << 8U | bytes[at + 3];
    if (length > bytes.size() - at - 12) {
      break;
    }
    const std::uint32_t crc = common::crc32(std::span(bytes).subspan(at + 4, length + 4));
    at += 8 + length;
    for (const unsigned int shift : {24U, 16U, 8U, 0U}) {
      bytes[at++] = static_cast<std::uint8_t>(crc >> shift);
    }
  }
  return bytes;
}

/// Three text files and a picture.
using Files = std::array<const char*, 4>;

void importFolder(Bytes input, const fuzz::InputDirectory& directory, const Files& files,
                  PictureSequence (*read)(const std::filesystem::path&)) {
  const auto pieces = fuzz::cut<4>(input);
  for (std::size_t i = 0; i < 3; ++i) {
    directory.write(files[i], pieces[i]);
  }
  directory.write(files[3], withChecksums(pieces[3]));
  writeSequence(read(directory.path()), directory.path() / "log");
}

void import(std::uint8_t format, Bytes input) {
  const fuzz::InputDirectory directory;
  switch (format % 10) {
    case 0:
      importCarmen(fuzz::InputFile(input).path(), directory.path() / "log", true);
      break;
    case 1:
      importFolder(input, directory, {"rgb.txt", "calib.txt", "groundtruth.txt", "a.png"}, readTumSequence);
      break;
    case 2:
      importFolder(input, directory, {"times.txt", "calib.txt", "poses.txt", "image_0/000000.png"},
                   readKittiSequence);
      break;
    case 3:
      importFolder(
          input, directory,
          {"cam0/data.csv", "cam0/sensor.yaml", "state_groundtruth_estimate0/data.csv", "cam0/data/a.png"},
          readEurocSequence);
      break;
    case 4:
      importRosbag(fuzz::InputFile(input).path(), directory.path() / "log", {});
      break;
    case 5:
      scanFromRos(input);
      break;
    case 6:
      imageFromRos(input);
      break;
    case 7:
      compressedImageFromRos(input);
      break;
    case 8:
      cameraInfoFromRos(input, 30.0);
      break;
    default:
      odometryFromRos(input);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size > 0) {
    try {
      import(data[0], {data + 1, size - 1});
    } catch (const common::Error&) {
      // No such recording, or damaged, and said so.
    }
  }
  return 0;
}
