#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace rubble::recognizer {

/// What a detection says of the object it has found.
struct ObjectClass {
  std::string name;
  std::string kind = "hazard";
  double width = 0.0;   ///< m, of the sample's outline; 0: unknown
  double height = 0.0;  ///< m
  std::vector<std::string> aliases;
};

struct VocabularyData;

/// Everything the recogniser knows of its objects (Chen et al. 2017, section III-C), learnt by train() from
/// sample pictures: visual words and the look of every sample. Immutable; copies share it.
class Vocabulary {
 public:
  explicit Vocabulary(VocabularyData data);

  /// Throw common::Error naming the thing, what is wrong with it and the fix: not there, another version,
  /// truncated, damaged.
  static Vocabulary load(const std::filesystem::path& path);
  static Vocabulary parse(std::span<const std::uint8_t> bytes, const std::string& thing);
  std::vector<std::uint8_t> serialised() const;

  const std::vector<ObjectClass>& classes() const;
  std::size_t viewCount() const;
  std::size_t wordCount() const;
  const VocabularyData& data() const { return *data_; }

 private:
  std::shared_ptr<const VocabularyData> data_;
};

}  // namespace rubble::recognizer
