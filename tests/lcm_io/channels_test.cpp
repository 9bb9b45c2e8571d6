#include "lcm_io/channels.h"

#include <gmock/gmock.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace rubble::lcm_io {
namespace {

using Row = std::map<std::string, std::string>;

const std::vector<std::string> kColumns = {"channel", "type", "class", "publisher", "queue", "logged"};

std::vector<std::string> cellsOf(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line.substr(1));
  for (std::string cell; std::getline(stream, cell, '|');) {
    const auto first = cell.find_first_not_of(" `");
    cells.push_back(first == std::string::npos ? ""
                                               : cell.substr(first, cell.find_last_not_of(" `") - first + 1));
  }
  return cells;
}

/// The rows of the first table whose header begins with `channel`.
std::vector<Row> documentedRows() {
  std::ifstream stream(RUBBLE_SOURCE_DIR "/docs/channels.md");
  std::vector<Row> rows;
  std::vector<std::string> header;
  for (std::string line; std::getline(stream, line);) {
    if (line.starts_with("|")) {
      const std::vector<std::string> cells = cellsOf(line);
      if (header.empty() && cells.front() == "channel") {
        header = cells;
      } else if (!header.empty() && !line.starts_with("|-")) {
        Row& row = rows.emplace_back();
        for (std::size_t i = 0; i < std::min(header.size(), cells.size()); ++i) {
          row[header[i]] = cells[i];
        }
      }
    } else if (!rows.empty()) {
      break;
    }
  }
  return rows;
}

Row rowOf(const ChannelInfo& info) {
  return {{"channel", std::string(info.name)},
          {"type", std::string(info.type)},
          {"class", std::string(toString(info.channel_class))},
          {"publisher", info.publisher.empty() ? "-" : std::string(info.publisher)},
          {"queue", std::to_string(info.queue_capacity)},
          {"logged", info.logged ? "yes" : "no"}};
}

TEST(Channels, TheDocumentShowsTheTable) {
  const std::vector<Row> documented = documentedRows();
  ASSERT_FALSE(documented.empty()) << "docs/channels.md has no table that begins with | channel |";
  std::set<std::string> names;
  for (const Row& row : documented) {
    const std::string name = row.at("channel");
    EXPECT_TRUE(names.insert(name).second) << name << " stands twice in docs/channels.md";
    const ChannelInfo* info = findChannel(name);
    ASSERT_NE(info, nullptr) << name << " is in docs/channels.md, not in lcm_io/src/channels.cpp";
    const Row expected = rowOf(*info);
    for (const std::string& column : kColumns) {
      ASSERT_TRUE(row.contains(column)) << "docs/channels.md has no column " << column;
      EXPECT_EQ(row.at(column), expected.at(column)) << name << ", column " << column;
    }
  }
  for (const ChannelInfo& info : channelTable()) {
    EXPECT_TRUE(names.contains(std::string(info.name))) << info.name << " is missing in docs/channels.md";
  }
}

TEST(Channels, FindsEveryRowAndNothingElse) {
  for (const ChannelInfo& info : channelTable()) {
    EXPECT_EQ(findChannel(info.name), &info);
    EXPECT_LE(info.name.size(), 63U) << "LCM takes no longer names";
    EXPECT_GT(info.queue_capacity, 0U);
  }
  EXPECT_EQ(findChannel("SCANS"), nullptr);
  EXPECT_EQ(findChannel(""), nullptr);
}

}  // namespace
}  // namespace rubble::lcm_io
