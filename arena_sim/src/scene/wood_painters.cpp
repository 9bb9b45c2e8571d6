#include <algorithm>
#include <array>
#include <cmath>

#include "scene/painters.h"
#include "scene/wood_grain.h"

namespace rubble::arena_sim {

namespace {

constexpr int kFibres = 16;

/// One wood strand of an OSB board, in texels.
struct Strand {
  cv::Point2f centre;
  cv::Point2f along;  // Unit.
  float half_length = 0.0F;
  float half_width = 0.0F;
  float taper = 0.0F;                     // Share of the width lost from one end to the other.
  std::array<cv::Vec3b, kFibres> fibres;  // Colours from one edge to the other.
  std::array<float, kFibres> ragged{};    // By which fibres stand out at the ends.
};

cv::Vec3f strandColour(const cv::Vec3f& board, Dice& dice) {
  float tone = dice.normal(12.0F);
  if (dice.chance(0.08)) {
    tone -= dice.uniform(20.0F, 55.0F);
  }
  const float hue = dice.normal(5.0F);
  return board + cv::Vec3f(tone * 1.15F - hue, tone, tone * 0.85F + 0.6F * hue);
}

Strand throwStrand(const cv::Point2f& centre, float pixel, float size, const cv::Vec3f& board, Dice& dice) {
  Strand strand;
  strand.centre = centre;
  const float angle =
      dice.chance(0.25) ? dice.uniform(-1.57F, 1.57F) : std::clamp(dice.normal(0.45F), -1.5F, 1.5F);
  strand.along = {std::cos(angle), std::sin(angle)};
  strand.half_length = 0.5F * size * dice.uniform(0.03F, 0.125F) / pixel;
  const float slim = dice.uniform(0.0F, 1.0F);
  strand.half_width = std::max(0.7F, 0.5F * size * (0.008F + 0.032F * slim * slim) / pixel);
  strand.taper = dice.uniform(-0.5F, 0.5F);
  const cv::Vec3f colour = strandColour(board, dice);
  const float lean = dice.normal(7.0F) / kFibres;  // Strands do not lie flat.
  const auto grain = static_cast<std::uint64_t>(dice.below(1 << 30));
  float walk = 0.0F;
  for (int i = 0; i < kFibres; ++i) {
    walk = 0.65F * walk + 4.0F * hashSigned(grain, i, 0);
    const float tone = walk + lean * (static_cast<float>(i) - 0.5F * kFibres);
    // The lower edge lies in its own shade.
    writeRow({&tone, 1}, {colour - cv::Vec3f::all(i == kFibres - 1 ? 14.0F : 0.0F), {1.1F, 1.0F, 0.85F}},
             &strand.fibres[i]);
    strand.ragged[i] = 0.03F * walk * strand.half_length;
  }
  return strand;
}

/// Cuts [low, high] to where |offset + x / inverse_slope| <= reach.
void cutTo(float offset, float inverse_slope, float reach, float& low, float& high) {
  const float middle = -offset * inverse_slope;
  const float half = reach * std::abs(inverse_slope);
  low = std::max(low, middle - half);
  high = std::min(high, middle + half);
}

void layStrand(cv::Mat& picture, const Strand& strand) {
  const float c = strand.along.x;
  const float s = strand.along.y;
  const float narrowing = 0.5F * strand.taper * strand.half_width / strand.half_length;
  const float per_texel = 0.5F * kFibres / strand.half_width;
  const float reach_along =
      strand.half_length + *std::max_element(strand.ragged.begin(), strand.ragged.end()) + 0.5F;
  // No slope is so small that its inverse would not do.
  const float inverse_c = 1.0F / std::max(c, 1e-6F);
  const float inverse_s = 1.0F / std::copysign(std::max(std::abs(s), 1e-6F), s);
  const float reach_across = strand.half_width * (1.0F + 0.5F * std::abs(strand.taper)) + 0.5F;
  const float rise = std::abs(s) * reach_along + std::abs(c) * reach_across;
  const int first = std::max(0, cvCeil(strand.centre.y - rise));
  const int last = std::min(picture.rows - 1, cvFloor(strand.centre.y + rise));
  for (int y = first; y <= last; ++y) {
    const float dy = static_cast<float>(y) - strand.centre.y;
    float low = -1e6F;
    float high = 1e6F;
    cutTo(dy * s, inverse_c, reach_along, low, high);
    cutTo(dy * c, -inverse_s, reach_across, low, high);
    const int begin = std::max(0, cvCeil(strand.centre.x + low));
    const int end = std::min(picture.cols - 1, cvFloor(strand.centre.x + high));
    auto* row = picture.ptr<cv::Vec3b>(y);
    for (int x = begin; x <= end; ++x) {
      const float dx = static_cast<float>(x) - strand.centre.x;
      const float along = dx * c + dy * s;
      const float across = dy * c - dx * s;
      const float half = strand.half_width + narrowing * along;
      const auto fibre = static_cast<std::size_t>(
          std::clamp(static_cast<int>(per_texel * (across + strand.half_width)), 0, kFibres - 1));
      const float weight =
          std::min(half - std::abs(across), strand.half_length + strand.ragged[fibre] - std::abs(along)) +
          0.5F;
      if (weight >= 1.0F) {
        row[x] = strand.fibres[fibre];
      } else if (weight > 0.0F) {
        const auto share = static_cast<int>(256.0F * weight);
        for (int k = 0; k < 3; ++k) {
          row[x][k] =
              static_cast<std::uint8_t>(row[x][k] + ((strand.fibres[fibre][k] - row[x][k]) * share >> 8));
        }
      }
    }
  }
}

/// Strands all over the board, one near every point of a grid, so that nothing stays bare for long.
void layStrands(Canvas& canvas, float size, float spacing, const cv::Vec3f& board, Dice& dice) {
  const float cell_u = 1.7F * spacing / canvas.pixel;
  const float cell_v = spacing / canvas.pixel;
  for (float y = -cell_v; y < static_cast<float>(canvas.picture.rows) + cell_v; y += cell_v) {
    for (float x = -cell_u; x < static_cast<float>(canvas.picture.cols) + cell_u; x += cell_u) {
      const cv::Point2f centre(x + dice.uniform(-0.3F, 1.3F) * cell_u,
                               y + dice.uniform(-0.3F, 1.3F) * cell_v);
      layStrand(canvas.picture, throwStrand(centre, canvas.pixel, size, board, dice));
    }
  }
}

/// A boat-shaped patch where a knot was cut out of the veneer.
void addFootball(Canvas& canvas, Dice& dice) {
  const cv::Point2f p(dice.uniform(0.0F, canvas.width()), dice.uniform(0.0F, canvas.height()));
  const float length = dice.uniform(0.035F, 0.06F);
  const float width = dice.uniform(0.3F, 0.45F) * length;
  std::vector<cv::Point2f> outline;
  for (int i = 0; i <= 24; ++i) {
    const float t = static_cast<float>(i % 12) / 6.0F - 1.0F;
    const float side = i < 12 ? 1.0F : -1.0F;
    outline.push_back(p + cv::Point2f(side * t * length, side * width * (1.0F - t * t)));
  }
  const float tone = dice.uniform(0.75F, 1.1F);
  const cv::Vec3f wood = tone * reflecting(0.60F, 0.46F, 0.30F);
  for (int i = -5; i <= 5; ++i) {
    const float v = static_cast<float>(i) / 5.5F;
    const float reach = length * std::sqrt(1.0F - std::abs(v));
    const cv::Point2f left = p + cv::Point2f(-reach, v * width);
    drawLine(canvas, std::array{left, left + cv::Point2f(2.0F * reach, 0.0F)},
             {0.25F * width, (1.0F + dice.normal(0.03F)) * wood, 0.9F});
  }
  drawLine(canvas, outline, {0.0012F, reflecting(0.16F, 0.10F, 0.06F), 0.7F});
}

/// Short dark pores along the grain.
void addFlecks(Canvas& canvas, float per_area, Dice& dice) {
  for (int i = cvRound(per_area * canvas.width() * canvas.height()); i > 0; --i) {
    const int y = dice.below(canvas.picture.rows);
    const int begin = dice.below(canvas.picture.cols);
    const int end = std::min(canvas.picture.cols,
                             begin + 1 + static_cast<int>(dice.uniform(0.001F, 0.014F) / canvas.pixel));
    const float light =
        1.0F - std::min(1.0F, 0.0025F / canvas.pixel) * std::pow(dice.uniform(0.0F, 1.0F), 2.0F) * 0.3F;
    auto* row = canvas.picture.ptr<cv::Vec3b>(y);
    for (int x = begin; x < end; ++x) {
      row[x] *= light;
    }
  }
}

struct Board {
  float end = 0.0F;  // m, where the next begins.
  float offset = 0.0F;
  float tone = 0.0F;
  std::vector<Knot> knots;
};

/// A row of boards on top of each other, each of several pieces along u.
struct Course {
  float top = 0.0F;  // m
  std::vector<Board> boards;
};

std::vector<Course> sawBoards(const Canvas& canvas, Dice& dice) {
  std::vector<Course> courses;
  const float width = dice.uniform(0.09F, 0.14F);
  for (float v = 0.0F; v < canvas.height();) {
    Course course;
    const float bottom = v;
    course.top = v += width;
    for (float u = -dice.uniform(0.0F, 1.5F); u < canvas.width();) {
      Board board;
      const float begin = u;
      board.end = u += dice.uniform(1.2F, 2.6F);
      board.offset = dice.uniform(0.0F, 200.0F);
      board.tone = dice.normal(11.0F);
      for (int i = dice.below(5); i > 0; --i) {
        board.knots.push_back({{dice.uniform(begin, u), dice.uniform(bottom + 0.015F, v - 0.015F)},
                               dice.uniform(0.004F, 0.014F)});
      }
      course.boards.push_back(std::move(board));
    }
    courses.push_back(std::move(course));
  }
  return courses;
}

void addNails(Canvas& canvas, const std::vector<Course>& courses, Dice& dice) {
  float bottom = 0.0F;
  for (const Course& course : courses) {
    for (const Board& board : course.boards) {
      for (const float u : {board.end - 0.02F, board.end + 0.02F}) {
        for (const float share : {0.25F, 0.75F}) {
          const cv::Point2f p(u + dice.normal(0.003F),
                              bottom + share * (course.top - bottom) + dice.normal(0.004F));
          drawBlot(canvas, p, dice.uniform(0.003F, 0.005F), 0.5F,
                   {0.0F, reflecting(0.05F, 0.04F, 0.04F), 0.8F}, dice);
        }
      }
    }
    bottom = course.top;
  }
}

}  // namespace

void paintOsb(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const cv::Vec3f board = reflecting(0.52F, 0.39F, 0.225F) * dice.uniform(0.93F, 1.05F);
  canvas.picture.setTo(0.68F * board);
  layStrands(canvas, 1.0F, 0.0255F, board, dice);
  layStrands(canvas, 0.9F, 0.0265F, board, dice);
  layStrands(canvas, 0.5F, 0.036F, board, dice);
  weather(canvas, 0.8F);
  addStains(canvas, 0.7F, reflecting(0.12F, 0.08F, 0.05F));
  addScrews(canvas);
  addHandMarks(canvas);
}

void paintPlywood(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  WoodGrain grain(derivedSeed(canvas.seed, 2), canvas.pixel,
                  {dice.uniform(0.014F, 0.03F), dice.uniform(2.5F, 4.5F), dice.uniform(0.7F, 1.3F),
                   dice.uniform(7.0F, 13.0F), dice.uniform(3.5F, 6.0F)});
  std::vector<Knot> knots;
  for (int i = static_cast<int>(canvas.width() * canvas.height() * dice.uniform(1.0F, 7.0F)); i > 0; --i) {
    knots.push_back({{dice.uniform(0.0F, canvas.width()), dice.uniform(0.0F, canvas.height())},
                     dice.uniform(0.004F, 0.015F)});
  }
  const Tint tint{reflecting(0.58F, 0.44F, 0.285F) * dice.uniform(0.93F, 1.07F), {1.15F, 1.0F, 0.85F}};
  const auto columns = static_cast<std::size_t>(canvas.picture.cols);
  std::vector<float> tones(columns);
  for (int y = 0; y < canvas.picture.rows; ++y) {
    std::fill(tones.begin(), tones.end(), 0.0F);
    grain.startRow(y, columns);
    grain.piece(0, columns, static_cast<float>(canvas.picture.rows - y) * canvas.pixel, 0.0F, knots, tones);
    writeRow(tones, tint, canvas.picture.ptr<cv::Vec3b>(y));
  }
  addFlecks(canvas, 1800.0F, dice);
  for (int i = cvRound(canvas.width() * canvas.height() * dice.uniform(0.0F, 3.0F)); i > 0; --i) {
    addFootball(canvas, dice);
  }
  weather(canvas, 1.0F);
  addStains(canvas, 1.5F, reflecting(0.14F, 0.10F, 0.07F));
  addScrews(canvas);
  addHandMarks(canvas);
}

void paintPlanks(Canvas& canvas) {
  Dice dice(canvas.seed, 1);
  const std::vector<Course> courses = sawBoards(canvas, dice);
  WoodGrain grain(derivedSeed(canvas.seed, 2), canvas.pixel, {0.011F, 2.2F, 0.8F, 11.0F, 6.0F});
  const bool is_grey = dice.chance(0.35);  // Weathered.
  const cv::Vec3f wood = is_grey ? reflecting(0.30F, 0.27F, 0.23F) : reflecting(0.47F, 0.33F, 0.20F);
  const Tint tint{wood * dice.uniform(0.92F, 1.08F), {1.1F, 1.0F, 0.9F}};
  const auto columns = static_cast<std::size_t>(canvas.picture.cols);
  std::vector<float> tones(columns);
  constexpr float kGap = 0.003F;
  std::size_t course = courses.size() - 1;
  for (int y = 0; y < canvas.picture.rows; ++y) {
    const float v = (static_cast<float>(canvas.picture.rows - y) - 0.5F) * canvas.pixel;
    while (course > 0 && v < courses[course - 1].top) {
      --course;
    }
    std::fill(tones.begin(), tones.end(), 0.0F);
    grain.startRow(y, columns);
    std::size_t begin = 0;
    for (const Board& board : courses[course].boards) {
      const auto end = std::min(columns, static_cast<std::size_t>(std::max(0.0F, board.end / canvas.pixel)));
      const float gap_shade =
          -70.0F *
          std::clamp((kGap + 0.5F * canvas.pixel - (courses[course].top - v)) / canvas.pixel, 0.0F, 1.0F);
      if (begin < end) {
        std::fill(tones.begin() + static_cast<long>(begin), tones.begin() + static_cast<long>(end),
                  board.tone + gap_shade);
        grain.piece(begin, end, v, board.offset, board.knots, tones);
        tones[begin] -= 60.0F;
      }
      begin = std::max(begin, end);
    }
    writeRow(tones, tint, canvas.picture.ptr<cv::Vec3b>(y));
  }
  addFlecks(canvas, 900.0F, dice);
  addNails(canvas, courses, dice);
  weather(canvas, 1.0F);
  addStains(canvas, 1.5F, reflecting(0.08F, 0.06F, 0.05F));
  addHandMarks(canvas);
}

}  // namespace rubble::arena_sim
