#include "eval_marks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numeric>

#include "common/files.h"
#include "small_arena.h"
#include "support/error_text.h"
#include "support/temp_dir.h"

namespace rubble::tools {
namespace {

using arena_sim::Sighting;
using test::errorOf;
using ::testing::DoubleEq;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

Sighting label(const std::string& object_class, double x, double size, std::size_t pictures = 10) {
  return {"id", object_class, "hazard", "", {x, 0.0, 0.0}, std::vector<double>(pictures, size)};
}

Mark labelMark(const std::string& object_class, double x) {
  return {object_class, "hazard", "", {x, 0.0, 0.0}};
}

TEST(ScoreMarksTest, EachIsMatchedOnceTheNearestFirst) {
  const std::vector<Sighting> objects = {label("poison", 0.0, 120.0), label("poison", 0.4, 120.0),
                                         label("poison", 5.0, 120.0), label("flammable", 9.0, 120.0)};
  // 0.3 belongs to 0.4, 0.35 then to 0.0; 5.2 is once too many; 9.0 is of the wrong class.
  const auto score =
      scoreMarks(objects,
                 {labelMark("poison", 0.35), labelMark("poison", 0.38), labelMark("poison", 5.1),
                  labelMark("poison", 5.2), labelMark("poison", 9.0)},
                 {})
          .at("hazard");
  EXPECT_EQ(score.objects, 4);
  EXPECT_EQ(score.seen, 4);
  EXPECT_EQ(score.confirmed, 3);
  EXPECT_EQ(score.seen_confirmed_once, 2);
  EXPECT_EQ(score.duplicates, 1);
  EXPECT_EQ(score.false_marks, 1);
  EXPECT_NEAR(std::accumulate(score.errors_m.begin(), score.errors_m.end(), 0.0), 0.35 + 0.02 + 0.1, 1e-12);
}

TEST(ScoreMarksTest, CodesAreToldApartByTheirText) {
  const std::vector<Sighting> objects = {{"qr_1", "qr", "qr", "a", {0, 0, 0}, {}},
                                         {"qr_2", "qr", "qr", "b", {0.1, 0, 0}, {}}};
  const auto scores = scoreMarks(objects, {{"qr", "qr", "b", {0, 0, 0}}, {"qr", "qr", "c", {0, 0, 0}}}, {});
  EXPECT_EQ(scores.at("qr").confirmed, 1);
  EXPECT_THAT(scores.at("qr").errors_m, ElementsAre(DoubleEq(0.1)));
  EXPECT_EQ(scores.at("qr").false_marks, 1);
  EXPECT_EQ(scores.at("qr").seen, 0);
}

TEST(ScoreMarksTest, SeenIsLargeForTenPictures) {
  Sighting victim{"victim_1", "victim", "victim", "", {3, 0, 0}, std::vector<double>(10, 115.0)};
  const std::vector<Sighting> objects = {label("poison", 0.0, 115.0), label("corrosive", 0.0, 115.0, 9),
                                         victim};
  const auto scores = scoreMarks(objects, {labelMark("poison", 0.0), labelMark("corrosive", 0.0)}, {});
  EXPECT_EQ(scores.at("hazard").seen, 1);
  EXPECT_EQ(scores.at("hazard").confirmed, 2);
  EXPECT_EQ(scores.at("victim").seen, 0);
  EXPECT_EQ(scores.at("all").recall[4].objects, 2);
  EXPECT_EQ(scores.at("all").recall[4].confirmed, 1);
  EXPECT_EQ(scoreMarks(objects, {}, {.pixels_victim = 100.0}).at("victim").seen, 1);
}

TEST(ReadMarksTest, OnlyConfirmedOnesCount) {
  const test::TempDir dir;
  const std::string header = "id,class,kind,text,state,x,y,z,views\n";
  const auto marks = readConfirmedMarks(dir.write(
      "o.csv", header + "1,qr,qr,\"a, b\",confirmed,1,2,3,5\n2,victim,victim,\"\",pending,1,2,3,1\n"));
  ASSERT_EQ(marks.size(), 1U);
  EXPECT_EQ(marks[0].text, "a, b");
  EXPECT_EQ(marks[0].p_world, Eigen::Vector3d(1, 2, 3));
  const auto errorFor = [&](const std::string& row) {
    return errorOf([&] { readConfirmedMarks(dir.write("o.csv", header + row)); });
  };
  EXPECT_THAT(errorFor("1,qr,qr,a,sure,1,2,3,5\n"), HasSubstr("o.csv:2: `sure` is no state"));
  EXPECT_THAT(errorFor("1,qr,qr,a,confirmed,1,,3,5\n"), HasSubstr("o.csv:2"));
}

TEST(SightingsTest, AMissionsWorldIsFoundAgain) {
  const test::TempDir dir;
  auto options = smallMission();
  options.seed = 3;
  arena_sim::writeMission(options, smallArena(), dir.path());
  const auto sightings = arena_sim::findSightings(dir.path(), std::nullopt);
  std::size_t seen = 0;
  for (const Sighting& sighting : sightings) {
    seen += sighting.sizes.empty() ? 0U : 1U;
    for (const double size : sighting.sizes) {
      EXPECT_GT(size, 1.0);
      EXPECT_LT(size, 160.0);
    }
  }
  EXPECT_GT(seen, 3U);
  EXPECT_LT(seen, sightings.size());
  EXPECT_THAT(errorOf([&] { arena_sim::findSightings(dir.path(), 4); }),
              HasSubstr("seed 4 gives other objects"));
  // What is marked where it is.
  std::vector<Mark> marks;
  for (const Sighting& object : sightings) {
    marks.push_back({object.object_class, object.kind, object.text, object.p_world});
  }
  const MarksScore score =
      scoreMarks(sightings, marks, {.pixels_planar = 5.0, .pixels_victim = 5.0}).at("all");
  EXPECT_EQ(score.seen_confirmed_once, score.seen);
  EXPECT_EQ(score.false_marks + score.duplicates, 0);
}

}  // namespace
}  // namespace rubble::tools
