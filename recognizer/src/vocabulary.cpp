#include "recognizer/vocabulary.h"

#include "common/byte_stream.h"
#include "common/error.h"
#include "common/files.h"
#include "vocabulary_data.h"

namespace rubble::recognizer {

namespace {

constexpr common::Magic kMagic = {'R', 'B', 'V', 'O', 'C', '0', '0', '2'};

template <typename T>
void putList(const std::vector<T>& values, common::ByteWriter* writer) {
  writer->put<std::uint64_t>(values.size());
  writer->putAll(std::span<const T>(values));
}

template <typename T>
std::vector<T> getList(common::ByteReader* reader) {
  std::vector<T> values(reader->getCount(sizeof(T)));
  reader->getAll(std::span<T>(values));
  return values;
}

void putClass(const ObjectClass& object_class, common::ByteWriter* writer) {
  writer->putText(object_class.name);
  writer->putText(object_class.kind);
  writer->put(object_class.width);
  writer->put(object_class.height);
  writer->put<std::uint64_t>(object_class.aliases.size());
  for (const std::string& alias : object_class.aliases) {
    writer->putText(alias);
  }
}

ObjectClass getClass(common::ByteReader* reader) {
  ObjectClass object_class;
  object_class.name = reader->getText();
  object_class.kind = reader->getText();
  object_class.width = reader->get<double>();
  object_class.height = reader->get<double>();
  object_class.aliases.resize(reader->getCount(sizeof(std::uint64_t)));
  for (std::string& alias : object_class.aliases) {
    alias = reader->getText();
  }
  return object_class;
}

template <typename Matrix>
void putMatrix(const Matrix& matrix, common::ByteWriter* writer) {
  writer->putAll(std::span(matrix.data(), static_cast<std::size_t>(matrix.size())));
}

template <typename Matrix>
void getMatrix(common::ByteReader* reader, Matrix* matrix) {
  if (static_cast<std::size_t>(matrix->size()) * sizeof(float) > reader->left()) {
    reader->fail("truncated");
  }
  reader->getAll(std::span(matrix->data(), static_cast<std::size_t>(matrix->size())));
}

void putSolid(const SolidModel& model, common::ByteWriter* writer) {
  writer->put(model.object_class);
  writer->put(model.rows);
  writer->put(model.columns);
  writer->put(model.zero);
  writer->put(model.typical);
  putList(model.trees.trees, writer);
}

SolidModel getSolid(common::ByteReader* reader) {
  SolidModel model;
  model.object_class = reader->get<std::uint32_t>();
  model.rows = reader->get<std::int32_t>();
  model.columns = reader->get<std::int32_t>();
  model.zero = reader->get<float>();
  model.typical = reader->get<float>();
  model.trees.trees = getList<BoostedTrees::Tree>(reader);
  return model;
}

WordIndex getWords(common::ByteReader* reader) {
  auto descriptors = getList<orb::Descriptor>(reader);
  auto places = getList<WordPlace>(reader);
  auto centres = getList<orb::Descriptor>(reader);
  auto begins = getList<std::uint32_t>(reader);
  return {std::move(descriptors), std::move(places), std::move(centres), std::move(begins)};
}

bool isSound(const SolidModel& model) {
  constexpr std::int32_t kMost = 64;  // cells
  const auto fits = [](std::int32_t side) { return side > 2 * kWindowMargin && side <= kMost; };
  return fits(model.rows) && fits(model.columns) && model.typical > model.zero &&
         std::all_of(model.trees.trees.begin(), model.trees.trees.end(), [&](const BoostedTrees::Tree& tree) {
           return *std::max_element(tree.features.begin(), tree.features.end()) < model.width();
         });
}

/// A checksum tells damage, not sense: what indexes something must be within it.
bool isSound(const VocabularyData& data) {
  const WordIndex& words = data.words;
  const auto& begins = words.begins();
  const auto in = [](std::uint32_t index, std::size_t size) { return index < size; };
  return !data.classes.empty() && (!data.view_classes.empty() || !data.solids.empty()) &&
         std::all_of(data.solids.begin(), data.solids.end(),
                     [&](const SolidModel& model) {
                       return in(model.object_class, data.classes.size()) && isSound(model);
                     }) &&
         std::all_of(data.view_classes.begin(), data.view_classes.end(),
                     [&](std::uint32_t c) { return in(c, data.classes.size()); }) &&
         words.places().size() == words.size() && begins.size() == words.centres().size() + 1 &&
         begins.front() == 0 && begins.back() == words.size() &&
         std::is_sorted(begins.begin(), begins.end()) && words.centres().size() <= 0xFFFF &&
         std::all_of(words.places().begin(), words.places().end(), [&](const WordPlace& place) {
           return in(place.object_class, data.classes.size()) && in(place.view, data.view_classes.size());
         });
}

}  // namespace

Vocabulary::Vocabulary(VocabularyData data) : data_(std::make_shared<const VocabularyData>(std::move(data))) {
  RUBBLE_CHECK(isSound(*data_));
}

Vocabulary Vocabulary::load(const std::filesystem::path& path) {
  return parse(common::readFile(path), path.string());
}

Vocabulary Vocabulary::parse(std::span<const std::uint8_t> bytes, const std::string& thing) {
  try {
    common::ByteReader reader(bytes, thing);
    reader.openSealed(kMagic, "a vocabulary");
    VocabularyData data;
    data.classes.resize(reader.getCount(sizeof(std::uint64_t)));
    for (ObjectClass& object_class : data.classes) {
      object_class = getClass(&reader);
    }
    data.view_classes = getList<std::uint32_t>(&reader);
    data.words = getWords(&reader);
    const auto views = static_cast<Eigen::Index>(data.view_classes.size());
    data.appearance.clutter_mean.resize(kPatchDimensions);
    data.appearance.whitening.resize(kPatchDimensions, kPatchDimensions);
    data.appearance.views.resize(kPatchDimensions, views);
    data.appearance.clutter_score = reader.get<float>();
    getMatrix(&reader, &data.appearance.clutter_mean);
    getMatrix(&reader, &data.appearance.whitening);
    getMatrix(&reader, &data.appearance.views);
    data.solids.resize(reader.getCount(sizeof(std::uint64_t)));
    for (SolidModel& model : data.solids) {
      model = getSolid(&reader);
    }
    if (reader.left() != 0 || !isSound(data)) {
      reader.fail("its parts do not fit together");
    }
    return Vocabulary(std::move(data));
  } catch (const common::Error& e) {
    throw common::Error(std::string(e.what()) + "; make it anew with `rubble train`");
  }
}

std::vector<std::uint8_t> Vocabulary::serialised() const {
  common::ByteWriter writer;
  writer.put(kMagic);
  writer.put<std::uint64_t>(data_->classes.size());
  for (const ObjectClass& object_class : data_->classes) {
    putClass(object_class, &writer);
  }
  putList(data_->view_classes, &writer);
  putList(data_->words.descriptors(), &writer);
  putList(data_->words.places(), &writer);
  putList(data_->words.centres(), &writer);
  putList(data_->words.begins(), &writer);
  writer.put(data_->appearance.clutter_score);
  putMatrix(data_->appearance.clutter_mean, &writer);
  putMatrix(data_->appearance.whitening, &writer);
  putMatrix(data_->appearance.views, &writer);
  writer.put<std::uint64_t>(data_->solids.size());
  for (const SolidModel& model : data_->solids) {
    putSolid(model, &writer);
  }
  return std::move(writer).sealed();
}

const std::vector<ObjectClass>& Vocabulary::classes() const { return data_->classes; }
std::size_t Vocabulary::viewCount() const { return data_->view_classes.size(); }
std::size_t Vocabulary::wordCount() const { return data_->words.size(); }

}  // namespace rubble::recognizer
