#include "world/signs_placement.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "common/error.h"
#include "scene/signs.h"
#include "world/furniture.h"

namespace rubble::arena_sim {

namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double kGap = 0.002;  // Between wall and picture.
constexpr double kLowest = 0.15;
constexpr double kHighest = 1.1;
constexpr int kAttempts = 800;

/// A picture's frame at p (its centre) whose z is `out`, level, and y upwards.
common::Pose3 facing(const Vector2d& p, double z, const Vector2d& out) {
  common::Pose3 T = common::Pose3::Identity();
  const Vector3d normal(out.x(), out.y(), 0.0);
  T.linear().col(0) = Vector3d::UnitZ().cross(normal);
  T.linear().col(1) = Vector3d::UnitZ();
  T.linear().col(2) = normal;
  T.translation() = Vector3d(p.x(), p.y(), z);
  return T;
}

class SignHanger {
 public:
  SignHanger(Site& site, Random& random) : site_(site), random_(random) {}

  void hangAll(const std::vector<OpenBox>& boxes) {
    std::vector<common::Pose3> special;
    special.reserve(boxes.size());
    for (const OpenBox& box : boxes) {
      special.push_back(box.T_arena_back * common::Pose3(Eigen::Translation3d(0.0, 0.0, kGap)));
    }
    const std::size_t in_boxes = special.size();
    if (site_.plan.crossing) {
      addCrossingPlaces(special);
    }
    std::size_t used = 0;
    // The boxes' places take hazard labels; the crossing's go to the first of the rest.
    const auto next = [&](const Vector2d& size, bool hazard) {
      if (used < special.size() && (hazard || used >= in_boxes)) {
        hung_.push_back({special[used].translation(), size});
        return special[used++];
      }
      return findPlaceOrFail(size);
    };
    for (int i = 0; i < site_.config.hazard_labels; ++i) {
      // Every second label goes to a wall, so that the places at the crossing get codes, too.
      const Vector2d size = square(0.15, 0.25);
      addHazard(i, used < in_boxes || i % 2 == 0 ? next(size, true) : findPlaceOrFail(size), size);
    }
    for (int i = 0; i < site_.config.qr_codes; ++i) {
      const Vector2d size = square(0.12, 0.2);
      addQrCode(i, next(size, false), size);
    }
    for (int i = 0; i < site_.config.april_tags; ++i) {
      const Vector2d size = square(0.15, 0.25);
      addAprilTag(i, next(size, false), size);
    }
    addPosters();
  }

 private:
  struct Hung {
    Vector3d p;
    Vector2d size;
  };

  Vector2d square(double smallest, double largest) {
    const double side = random_.uniform(smallest, largest);
    return {side, side};
  }

  static int pixelsOf(double size) { return std::min(512, static_cast<int>(std::lround(4000.0 * size))); }

  bool overlaps(const Vector3d& p, const Vector2d& size) const {
    return std::any_of(hung_.begin(), hung_.end(), [&](const Hung& other) {
      return (other.p - p).norm() < 0.5 * (other.size.norm() + size.norm()) + 0.03;
    });
  }

  /// A room with 0.7 m of free ground lies in front of p.
  bool looksIntoRoom(const Vector2d& p, const Vector2d& out) const {
    for (const double distance : {0.1, 0.4, 0.7}) {
      const Vector2d q = p + distance * out;
      const auto room = roomAt(site_.plan, q);
      if (!room || std::any_of(site_.footprints.begin(), site_.footprints.end(),
                               [&](const Footprint& f) { return (f.p - q).norm() < f.radius + 0.12; })) {
        return false;
      }
    }
    return true;
  }

  /// On a random side of a random wall.
  std::optional<common::Pose3> findPlace(const Vector2d& size) {
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
      const auto& walls = site_.plan.walls;
      const WallPiece& wall =
          walls[static_cast<std::size_t>(random_.integer(0, static_cast<int>(walls.size()) - 1))];
      const Vector2d along = (wall.line.b - wall.line.a).normalized();
      const double length = (wall.line.b - wall.line.a).norm();
      const double margin = 0.5 * size.x() + 0.08;
      const double highest = std::min(kHighest, site_.config.wall_height - 0.04) - 0.5 * size.y();
      if (length < 2.0 * margin || highest < kLowest + 0.5 * size.y()) {
        continue;
      }
      const Vector2d out = random_.sign() * Vector2d(-along.y(), along.x());
      const Vector2d p = wall.line.a + random_.uniform(margin, length - margin) * along +
                         (0.5 * wall.thickness + kGap) * out;
      const double z = std::min(highest, random_.uniform(kLowest + 0.5 * size.y(), 0.9));
      const Vector3d centre(p.x(), p.y(), z);
      const bool crossed = std::any_of(walls.begin(), walls.end(), [&](const WallPiece& other) {
        return &other != &wall && distanceTo(other.line, p) < margin;
      });
      if (crossed || overlaps(centre, size) || !looksIntoRoom(p, out)) {
        continue;
      }
      hung_.push_back({centre, size});
      return facing(p, z, out);
    }
    return std::nullopt;
  }

  common::Pose3 findPlaceOrFail(const Vector2d& size) {
    if (const auto place = findPlace(size)) {
      return *place;
    }
    throw common::Error(
        fmt::format("the arena's walls have no place left for sign {}; lower arena_sim.world.hazard_labels, "
                    "arena_sim.world.qr_codes or arena_sim.world.april_tags, or enlarge "
                    "arena_sim.world.width and arena_sim.world.depth",
                    hung_.size() + 1));
  }

  /// At the platform's back, at the end of ramp and stairs, and beside the ramp.
  void addCrossingPlaces(std::vector<common::Pose3>& places) {
    const CrossingPlan& plan = *site_.plan.crossing;
    const common::Pose3 T_arena_block = common::pose3FromPose2(plan.T_arena_block);
    const double back = plan.length() - CrossingPlan::kBoard - kGap;
    for (const double y : {plan.rampY(), plan.stairsY()}) {
      places.push_back(T_arena_block * facing({back, y + random_.uniform(-0.2, 0.2)},
                                              plan.height + random_.uniform(0.25, 0.6), {-1.0, 0.0}));
    }
    const double x = plan.rise() - random_.uniform(0.3, 0.6) * plan.rampLength();
    const bool low = plan.ramp_at_low_y;
    const double y = low ? CrossingPlan::kBoard + kGap : plan.width() - CrossingPlan::kBoard - kGap;
    places.push_back(T_arena_block * facing({x, y}, plan.rampHeight(x) + 0.38, {0.0, low ? 1.0 : -1.0}));
  }

  void hang(const common::Pose3& T, const Vector2d& size, const cv::Mat& picture) {
    Appearance look;
    look.material = Material::kPaint;
    look.seed = random_.seed();
    look.picture = std::make_shared<const cv::Mat>(picture);
    site_.scene.surfaces.push_back(makePicture(T, size, look));
  }

  void addObject(const char* kind, int number, const std::string& object_class, const std::string& text,
                 const common::Pose3& T, const Vector2d& size) {
    const Vector3d corner(0.5 * size.x(), 0.5 * size.y(), 0.0);
    site_.objects.push_back({fmt::format("{}_{}", kind, number + 1), object_class, kind, text, T, size,
                             Eigen::AlignedBox3d(-corner, corner)});
  }

  void addHazard(int number, const common::Pose3& T, const Vector2d& size) {
    const auto classes = hazardClasses();
    if (hazards_.empty()) {
      for (std::size_t i = 0; i < classes.size(); ++i) {
        hazards_.push_back(i);
      }
      std::shuffle(hazards_.begin(), hazards_.end(), random_.engine());
    }
    const std::string_view hazard = classes[hazards_.back()];
    hazards_.pop_back();
    const cv::Scalar background =
        random_.chance(0.5) ? cv::Scalar(235.0, 238.0, 240.0) : cv::Scalar(110.0, 150.0, 185.0);
    hang(T, size, drawHazardLabel(hazard, pixelsOf(size.x()), background));
    addObject("hazard", number, std::string(hazard), "", T, size);
  }

  void addQrCode(int number, const common::Pose3& T, const Vector2d& size) {
    const char* words[] = {"fire exit", "gas valve", "stairs", "first aid", "no entry", "boiler room"};
    const std::string text = fmt::format("{}-{} {}", random_.pick({"victim", "room", "sector"}),
                                         random_.integer(1, 99), words[random_.integer(0, 5)]);
    hang(T, size, drawQrCode(text, pixelsOf(size.x())));
    addObject("qr", number, "qr", text, T, size);
  }

  void addAprilTag(int number, const common::Pose3& T, const Vector2d& size) {
    constexpr int kTags = 2115;  // Of the family Standard41h12.
    int id = random_.integer(0, kTags - 1);
    while (std::find(tags_.begin(), tags_.end(), id) != tags_.end()) {
      id = (id + 1) % kTags;
    }
    tags_.push_back(id);
    hang(T, size, drawAprilTag(id, pixelsOf(size.x())));
    addObject("apriltag", number, "apriltag", std::to_string(id), T, size);
  }

  void addPosters() {
    const int posters = random_.integer(5, 9);
    for (int i = 0; i < posters; ++i) {
      const double width = random_.uniform(0.3, 0.5);
      const Vector2d size(width, 1.4 * width);
      if (const auto place = findPlace(size)) {  // An arena full of signs needs none.
        hang(*place, size, drawPoster(random_.seed(), 240, 336));
      }
    }
  }

  Site& site_;
  Random& random_;
  std::vector<Hung> hung_;
  std::vector<std::size_t> hazards_;
  std::vector<int> tags_;
};

}  // namespace

void placeSigns(Site& site, const std::vector<OpenBox>& boxes, Random& random) {
  SignHanger(site, random).hangAll(boxes);
}

}  // namespace rubble::arena_sim
