#include "csv_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/error_text.h"

namespace rubble::tools {
namespace {

using test::errorOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

TEST(CsvTableTest, ValuesMayBeQuoted) {
  EXPECT_THAT(splitCsv(R"(a,,"b, ""c""",d)"), ElementsAre("a", "", R"(b, "c")", "d"));
  EXPECT_THAT(splitCsv(""), ElementsAre(""));
  EXPECT_THAT(errorOf([] { splitCsv(R"(a,"b)"); }), HasSubstr("not closed"));
}

TEST(CsvTableTest, ColumnsAreFoundByName) {
  std::vector<std::vector<std::string>> rows;
  const auto read = [&](const std::string& text) {
    forEachRow({"t.csv", text}, {"y", "x"}, [&](const auto& row) { rows.push_back(row); });
  };
  read("x,z,y\r\n1,2,3\r\n4,5,6\r\n");
  EXPECT_THAT(rows, ElementsAre(ElementsAre("3", "1"), ElementsAre("6", "4")));
  EXPECT_THAT(errorOf([&] { read("x,z\n1,2\n"); }), HasSubstr("t.csv:1: the first line names no column `y`"));
  EXPECT_THAT(errorOf([&] { read("x,y\n1\n"); }), HasSubstr("t.csv:2: 1 values for 2 columns"));
  EXPECT_THAT(errorOf([&] { read(""); }), HasSubstr("t.csv: is empty"));
}

}  // namespace
}  // namespace rubble::tools
