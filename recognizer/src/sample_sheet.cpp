#include "sample_sheet.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <cmath>

#include "common/error.h"

namespace rubble::recognizer {

namespace {

[[noreturn]] void fail(const std::string& file, const YAML::Mark& mark, const std::string& what) {
  throw common::Error(fmt::format("{}:{}: {}", file, mark.line + 1, what));
}

double readLength(const std::string& file, const std::string& key, const YAML::Node& node) {
  double value = 0.0;
  if (!YAML::convert<double>::decode(node, value) || !std::isfinite(value) || value < 0.0) {
    fail(file, node.Mark(), fmt::format("{} is a length in metres, 0 for unknown", key));
  }
  return value;
}

std::string readText(const std::string& file, const std::string& key, const YAML::Node& node) {
  if (!node.IsScalar() || node.Scalar().empty()) {
    fail(file, node.Mark(), fmt::format("{} is a word", key));
  }
  return node.Scalar();
}

void applyEntry(const std::string& file, const YAML::Node& entry, ObjectClass* object_class) {
  if (!entry.IsMap()) {
    fail(file, entry.Mark(), "a class is a map of name, kind, width, height, aliases");
  }
  for (const auto& field : entry) {
    const std::string& key = field.first.Scalar();
    const YAML::Node& value = field.second;
    if (key == "name") {
      object_class->name = readText(file, key, value);
    } else if (key == "kind") {
      object_class->kind = readText(file, key, value);
    } else if (key == "width") {
      object_class->width = readLength(file, key, value);
    } else if (key == "height") {
      object_class->height = readLength(file, key, value);
    } else if (key == "aliases") {
      if (!value.IsSequence()) {
        fail(file, value.Mark(), "aliases is a list of words");
      }
      object_class->aliases.clear();
      for (const auto& alias : value) {
        object_class->aliases.push_back(readText(file, key, alias));
      }
    } else {
      fail(file, field.first.Mark(),
           fmt::format("unknown key '{}'; there are name, kind, width, height, aliases", key));
    }
  }
}

}  // namespace

void applySampleSheet(const std::filesystem::path& path, const std::map<std::string, std::uint32_t>& index,
                      std::vector<ObjectClass>* classes) {
  const std::string file = path.string();
  YAML::Node sheet;
  try {
    sheet = YAML::LoadFile(file);
  } catch (const YAML::Exception& e) {
    fail(file, e.mark, e.msg);
  }
  if (sheet.IsNull()) {
    return;
  }
  if (!sheet.IsMap()) {
    fail(file, sheet.Mark(),
         "a sheet of samples is a map from class to {name, kind, width, height, aliases}");
  }
  for (const auto& entry : sheet) {
    const auto found = index.find(entry.first.Scalar());
    if (found == index.end()) {
      fail(file, entry.first.Mark(),
           fmt::format("no picture and no folder is called '{}'", entry.first.Scalar()));
    }
    applyEntry(file, entry.second, &(*classes)[found->second]);
  }
}

}  // namespace rubble::recognizer
