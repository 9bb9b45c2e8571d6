#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <initializer_list>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rubble::common {

/// One mapping of the configuration while a typed struct is read from it. A config struct holds the
/// defaults; its `visit(ConfigSection&, Struct&)` names every field once, with unit, limits and
/// meaning. That visit reads the files, rejects what is misspelt or out of range, and documents.
class ConfigSection {
 public:
  void number(const char* key, double& value, const char* unit, double min, double max, const char* doc);
  void integer(const char* key, int& value, const char* unit, int min, int max, const char* doc);
  void flag(const char* key, bool& value, const char* doc);
  void text(const char* key, std::string& value, const char* doc);
  void choice(const char* key, std::string& value, std::initializer_list<const char*> choices,
              const char* doc);
  /// A fixed number of values on one line, e.g. a translation `[x, y, z]`.
  void numbers(const char* key, std::vector<double>& values, const char* unit, double min, double max,
               const char* doc);
  /// A nested mapping; valid as long as this section.
  ConfigSection& section(const char* key, const char* doc);
  /// A list of mappings, each read by visit(ConfigSection&, Item&). A later source replaces the whole list.
  template <typename Item>
  void sections(const char* key, std::vector<Item>& items, const char* doc) {
    if (const auto sources = readList(key)) {
      items.assign(sources->size(), Item());
      for (std::size_t i = 0; i < items.size(); ++i) {
        visit(addListItem(key, i, (*sources)[i]), items[i]);
      }
    } else {
      for (std::size_t i = 0; i < items.size(); ++i) {
        visit(addListItem(key, i, std::nullopt), items[i]);
      }
    }
    documentList(key, items.size(), doc);
  }

 private:
  friend class Config;

  struct Source {
    YAML::Node map;
    std::string origin;
  };

  ConfigSection(std::string path, int depth) : path_(std::move(path)), depth_(depth) {}

  [[noreturn]] void fail(const Source& source, const char* key, const std::string& what) const;
  template <typename T>
  T as(const Source& source, const YAML::Node& node, const char* key, const char* expected) const;
  template <typename Apply>
  void apply(const char* key, const Apply& apply);
  /// The mappings of the last source that gives the list.
  std::optional<std::vector<Source>> readList(const char* key);
  ConfigSection& addListItem(const char* key, std::size_t index, const std::optional<Source>& source);
  void documentList(const char* key, std::size_t items, const char* doc);
  void document(const char* key, const std::string& value, const std::string& comment);
  void rejectUnknownKeys() const;
  std::string description() const;

  std::string path_;
  int depth_ = 0;
  std::vector<Source> sources_;
  std::vector<std::string> known_;
  std::list<ConfigSection> children_;
  bool is_list_item_ = false;
  /// Lines of YAML with a comment, or an index into children_ where the text is empty.
  std::vector<std::string> lines_;
};

/// Configuration files and `--set` overrides, in the order given; later ones win key by key. Every
/// file holds top-level sections named after components (`slam_lidar:`, `robot:` ...).
class Config {
 public:
  /// Throws Error naming file and line for bad YAML or a section no component has.
  void addFile(const std::filesystem::path& path);

  /// `slam_lidar.map.cell_size=0.1`. Throws Error naming the argument.
  void addOverride(std::string_view assignment);

  /// `defaults` overlaid with section `name` of every source. Throws Error naming file, line and
  /// key for anything unknown, mistyped or out of range.
  template <typename T>
  T read(const char* name, T defaults = T()) const {
    T value = std::move(defaults);
    ConfigSection root = open(name);
    visit(root, value);
    root.rejectUnknownKeys();
    return value;
  }

  /// The effective section as commented YAML, one line per field: value, unit, limits, meaning.
  /// Throws as read() does.
  template <typename T>
  std::string describe(const char* name, T defaults = T()) const {
    T value = std::move(defaults);
    ConfigSection root = open(name);
    visit(root, value);
    root.rejectUnknownKeys();
    return std::string(name) + ":\n" + root.description();
  }

 private:
  ConfigSection open(const char* name) const;

  std::vector<ConfigSection::Source> sources_;
};

}  // namespace rubble::common
