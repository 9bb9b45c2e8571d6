#include "common/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "common/error.h"
#include "common/files.h"

namespace rubble::common {

namespace {

constexpr std::array kSections = {"robot",  "slam_lidar", "slam_mono",  "fusion",      "recognizer",
                                  "camera", "lidar",      "stabilizer", "ops_console", "arena_sim"};

std::size_t editDistance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({row[j] + 1, row[j - 1] + 1, substituted}));
    }
  }
  return row.back();
}

template <typename Names>
std::string suggestion(const std::string& key, const Names& names) {
  const auto closer = [&](const auto& a, const auto& b) {
    return editDistance(key, a) < editDistance(key, b);
  };
  const auto best = std::min_element(names.begin(), names.end(), closer);
  if (best != names.end() && editDistance(key, *best) <= 1 + key.size() / 3) {
    return fmt::format("; did you mean `{}`?", *best);
  }
  return fmt::format("; known here: {}", fmt::join(names, ", "));
}

constexpr std::string_view kOverride = "--set ";

/// File and line; an override is its own place.
std::string placeOf(const std::string& origin, const YAML::Node& node) {
  const YAML::Mark mark = node.Mark();
  return mark.is_null() || origin.starts_with(kOverride) ? origin
                                                         : fmt::format("{}:{}", origin, mark.line + 1);
}

/// Keys unknown or given twice are errors that name the place.
template <typename Names>
void checkKeys(const YAML::Node& map, const std::string& origin, const std::string& path,
               const Names& names) {
  std::vector<std::string> seen;
  for (const auto& entry : map) {
    const std::string key = entry.first.Scalar();
    const std::string place = placeOf(origin, entry.first);
    if (std::find(names.begin(), names.end(), key) == names.end()) {
      throw Error(fmt::format("{}: unknown key `{}`{}{}", place, key,
                              path.empty() ? "" : fmt::format(" in `{}`", path), suggestion(key, names)));
    }
    if (std::find(seen.begin(), seen.end(), key) != seen.end()) {
      throw Error(fmt::format("{}: key `{}` is given twice", place, key));
    }
    seen.push_back(key);
  }
}

}  // namespace

void ConfigSection::fail(const Source& source, const char* key, const std::string& what) const {
  // The key's place: a missing value has none, a long one ends lines below.
  std::string place = source.origin;
  for (const auto& entry : source.map) {
    if (entry.first.Scalar() == key) {
      place = placeOf(source.origin, entry.first);
      break;
    }
  }
  throw Error(fmt::format("{}: `{}.{}` {}", place, path_, key, what));
}

template <typename T>
T ConfigSection::as(const Source& source, const YAML::Node& node, const char* key,
                    const char* expected) const {
  if (node.IsNull()) {
    fail(source, key, fmt::format("must be {}, found nothing", expected));
  }
  try {
    return node.as<T>();
  } catch (const YAML::Exception&) {
    fail(source, key,
         fmt::format("must be {}, found {}", expected,
                     node.IsScalar() ? fmt::format("`{}`", node.Scalar()) : "a list or mapping"));
  }
}

template <typename Apply>
void ConfigSection::apply(const char* key, const Apply& apply) {
  known_.emplace_back(key);
  for (const Source& source : sources_) {
    if (const YAML::Node node = source.map[key]) {
      apply(source, node);
    }
  }
}

void ConfigSection::document(const char* key, const std::string& value, const std::string& comment) {
  const std::string line = fmt::format("{:{}}{}: {}", "", 2 * depth_, key, value);
  lines_.push_back(fmt::format("{:<40} # {}\n", line, comment));
}

void ConfigSection::number(const char* key, double& value, const char* unit, double min, double max,
                           const char* doc) {
  apply(key, [&](const Source& source, const YAML::Node& node) {
    value = as<double>(source, node, key, "a number");
    if (!(value >= min && value <= max)) {
      fail(source, key, fmt::format("= {} is outside {} .. {} {}", value, min, max, unit));
    }
  });
  document(key, fmt::format("{}", value), fmt::format("{} [{} .. {}]: {}", unit, min, max, doc));
}

void ConfigSection::integer(const char* key, int& value, const char* unit, int min, int max,
                            const char* doc) {
  apply(key, [&](const Source& source, const YAML::Node& node) {
    value = as<int>(source, node, key, "a whole number");
    if (value < min || value > max) {
      fail(source, key, fmt::format("= {} is outside {} .. {} {}", value, min, max, unit));
    }
  });
  document(key, fmt::format("{}", value), fmt::format("{} [{} .. {}]: {}", unit, min, max, doc));
}

void ConfigSection::flag(const char* key, bool& value, const char* doc) {
  apply(key, [&](const Source& source, const YAML::Node& node) {
    value = as<bool>(source, node, key, "true or false");
  });
  document(key, value ? "true" : "false", doc);
}

void ConfigSection::text(const char* key, std::string& value, const char* doc) {
  apply(key, [&](const Source& source, const YAML::Node& node) {
    value = as<std::string>(source, node, key, "a text");
  });
  YAML::Emitter quoted;
  quoted << YAML::DoubleQuoted << value;
  document(key, quoted.c_str(), doc);
}

void ConfigSection::choice(const char* key, std::string& value, std::initializer_list<const char*> choices,
                           const char* doc) {
  apply(key, [&](const Source& source, const YAML::Node& node) {
    value = as<std::string>(source, node, key, "a text");
    if (std::find(choices.begin(), choices.end(), value) == choices.end()) {
      fail(source, key, fmt::format("= `{}`; choose one of: {}", value, fmt::join(choices, ", ")));
    }
  });
  document(key, value, fmt::format("{}: {}", fmt::join(choices, " | "), doc));
}

void ConfigSection::numbers(const char* key, std::vector<double>& values, const char* unit, double min,
                            double max, const char* doc) {
  apply(key, [&](const Source& source, const YAML::Node& node) {
    auto read = as<std::vector<double>>(source, node, key, "a list of numbers");
    if (read.size() != values.size()) {
      fail(source, key, fmt::format("must hold {} numbers, found {}", values.size(), read.size()));
    }
    for (const double v : read) {
      if (!(v >= min && v <= max)) {
        fail(source, key, fmt::format("holds {}, outside {} .. {} {}", v, min, max, unit));
      }
    }
    values = std::move(read);
  });
  document(key, fmt::format("[{}]", fmt::join(values, ", ")),
           fmt::format("{} [{} .. {}]: {}", unit, min, max, doc));
}

ConfigSection& ConfigSection::section(const char* key, const char* doc) {
  ConfigSection child(path_ + "." + key, depth_ + 1);
  apply(key, [&](const Source& source, const YAML::Node& node) {
    if (node.IsNull()) {
      return;
    }
    if (!node.IsMap()) {
      fail(source, key, "must be a mapping of keys to values");
    }
    child.sources_.push_back({node, source.origin});
  });
  const std::string line = fmt::format("{:{}}{}:", "", 2 * depth_, key);
  lines_.push_back(fmt::format("{:<40} # {}\n", line, doc));
  lines_.emplace_back();
  return children_.emplace_back(std::move(child));
}

std::optional<std::vector<ConfigSection::Source>> ConfigSection::readList(const char* key) {
  std::optional<std::vector<Source>> mappings;
  apply(key, [&](const Source& source, const YAML::Node& node) {
    const bool is_list = node.IsSequence() &&
                         std::all_of(node.begin(), node.end(), [](const auto& item) { return item.IsMap(); });
    if (!is_list) {
      fail(source, key, "must be a list of mappings");
    }
    mappings.emplace();
    for (const YAML::Node& item : node) {
      mappings->push_back({item, source.origin});
    }
  });
  return mappings;
}

ConfigSection& ConfigSection::addListItem(const char* key, std::size_t index,
                                          const std::optional<Source>& source) {
  ConfigSection item(fmt::format("{}.{}[{}]", path_, key, index), depth_ + 2);
  item.is_list_item_ = true;
  if (source) {
    item.sources_.push_back(*source);
  }
  return children_.emplace_back(std::move(item));
}

void ConfigSection::documentList(const char* key, std::size_t items, const char* doc) {
  const std::string line = fmt::format("{:{}}{}:{}", "", 2 * depth_, key, items == 0 ? " []" : "");
  lines_.push_back(fmt::format("{:<40} # {}\n", line, doc));
  lines_.resize(lines_.size() + items);
}

void ConfigSection::rejectUnknownKeys() const {
  for (const Source& source : sources_) {
    checkKeys(source.map, source.origin, path_, known_);
  }
  for (const ConfigSection& child : children_) {
    child.rejectUnknownKeys();
  }
}

std::string ConfigSection::description() const {
  std::string text;
  auto child = children_.begin();
  for (const std::string& line : lines_) {
    text += line.empty() ? (child++)->description() : line;
  }
  if (is_list_item_ && !text.empty()) {
    text[2 * static_cast<std::size_t>(depth_) - 2] = '-';
  }
  return text;
}

void Config::addFile(const std::filesystem::path& path) {
  const std::vector<std::uint8_t> bytes = readFile(path);
  const std::string text(bytes.begin(), bytes.end());
  YAML::Node root;
  bool several = false;
  try {
    root = YAML::Load(text);
    // Not with YAML::LoadAll, which never returns on some bad input.
    const auto marker = text.find("\n---");
    several = marker != std::string::npos && !YAML::Load(text.substr(0, marker)).IsNull();
  } catch (const YAML::Exception& e) {
    throw Error(fmt::format("{}:{}: not valid YAML: {}", path.string(), e.mark.line + 1, e.msg));
  }
  if (several) {
    throw Error(fmt::format("{}: holds several YAML documents, expected one", path.string()));
  }
  if (root.IsNull()) {
    return;
  }
  if (!root.IsMap()) {
    throw Error(fmt::format("{}:1: expected sections such as `slam_lidar:`", path.string()));
  }
  checkKeys(root, path.string(), "", kSections);
  sources_.push_back({root, path.string()});
}

void Config::addOverride(std::string_view assignment) {
  const std::string origin = fmt::format("{}{}", kOverride, assignment);
  const auto equals = assignment.find('=');
  const auto dot = assignment.find('.');
  if (equals == std::string_view::npos || dot == std::string_view::npos || dot > equals) {
    throw Error(fmt::format("{}: expected component.key=value, e.g. slam_lidar.map.cell_size=0.1", origin));
  }
  YAML::Node value;
  try {
    value = YAML::Load(std::string(assignment.substr(equals + 1)));
  } catch (const YAML::Exception& e) {
    throw Error(fmt::format("{}: the value is not valid YAML: {}", origin, e.msg));
  }
  std::string_view keys = assignment.substr(0, equals);
  while (true) {
    const auto last = keys.rfind('.');
    YAML::Node map;
    map[std::string(keys.substr(last == std::string_view::npos ? 0 : last + 1))] = value;
    value = map;
    if (last == std::string_view::npos) {
      break;
    }
    keys = keys.substr(0, last);
  }
  checkKeys(value, origin, "", kSections);
  sources_.push_back({value, origin});
}

ConfigSection Config::open(const char* name) const {
  RUBBLE_CHECK(std::find(kSections.begin(), kSections.end(), std::string_view(name)) != kSections.end());
  ConfigSection root(name, 1);
  for (const ConfigSection::Source& source : sources_) {
    const YAML::Node node = source.map[name];
    if (!node || node.IsNull()) {
      continue;
    }
    if (!node.IsMap()) {
      throw Error(
          fmt::format("{}: `{}` must be a mapping of keys to values", placeOf(source.origin, node), name));
    }
    root.sources_.push_back({node, source.origin});
  }
  return root;
}

}  // namespace rubble::common
