#include "scene/materials.h"

#include <algorithm>
#include <cmath>

#include "common/error.h"
#include "scene/noise.h"
#include "scene/painters.h"

namespace rubble::arena_sim {

namespace {

void paint(Material material, Canvas& canvas) {
  switch (material) {
    case Material::kOsb:
      return paintOsb(canvas);
    case Material::kPlywood:
      return paintPlywood(canvas);
    case Material::kPlanks:
      return paintPlanks(canvas);
    case Material::kConcrete:
      return paintConcrete(canvas);
    case Material::kPaint:
      return paintBoardPaint(canvas);
    case Material::kCardboard:
      return paintCardboard(canvas);
    case Material::kMetal:
      return paintMetal(canvas);
    case Material::kRubber:
      return paintRubber(canvas);
    case Material::kCloth:
      return paintCloth(canvas);
    case Material::kSkin:
      return paintSkin(canvas);
    case Material::kCarpet:
      return paintCarpet(canvas);
    case Material::kBricks:
      return paintBricks(canvas);
  }
  RUBBLE_CHECK(false && "a material without a painter");
}

}  // namespace

cv::Mat paintMaterial(Material material, std::uint64_t seed, const cv::Size2f& size, float pixel) {
  RUBBLE_CHECK(size.width > 0.0F && size.height > 0.0F && pixel > 0.0F);
  const auto texels = [&](float length) {
    return std::max(1, static_cast<int>(std::lround(length / pixel)));
  };
  Canvas canvas{cv::Mat(texels(size.height), texels(size.width), CV_8UC3), pixel,
                derivedSeed(seed, static_cast<std::uint64_t>(material))};
  paint(material, canvas);
  return canvas.picture;
}

// Wood, paper and pale cloth are bright in the near infrared whatever their colour; rubber, soot-black
// pigments and bare metal (which throws light elsewhere) are not.
double reflectivityAt905nm(Material material) {
  switch (material) {
    case Material::kOsb:
      return 0.65;
    case Material::kPlywood:
      return 0.72;
    case Material::kPlanks:
      return 0.60;
    case Material::kConcrete:
      return 0.38;
    case Material::kPaint:
      return 0.75;
    case Material::kCardboard:
      return 0.62;
    case Material::kMetal:
      return 0.35;
    case Material::kRubber:
      return 0.06;
    case Material::kCloth:
      return 0.55;
    case Material::kSkin:
      return 0.60;
    case Material::kCarpet:
      return 0.25;
    case Material::kBricks:
      return 0.40;
  }
  RUBBLE_CHECK(false && "a material without a reflectivity");
  return 0.0;
}

}  // namespace rubble::arena_sim
