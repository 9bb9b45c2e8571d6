#pragma once

#include <Eigen/Core>
#include <array>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "arena_sim/sightings.h"

namespace rubble::tools {

/// A confirmed mark.
struct Mark {
  std::string object_class;
  std::string kind;
  std::string text;
  Eigen::Vector3d p_world;
};

/// The confirmed marks of an objects.csv as replay writes it: columns class, kind, text, state (pending,
/// confirmed or discarded), x, y, z among others. Throws Error naming file and line.
std::vector<Mark> readConfirmedMarks(const std::filesystem::path& path);

/// What counts as seen: this large (pixels) in at least kPictures pictures.
struct MarksOptions {
  static constexpr std::size_t kPictures = 10;
  double pixels_planar = 110.0;
  double pixels_victim = 120.0;
};

struct MarksScore {
  /// Objects by the largest size (pixels) reached in at least kPictures pictures; the last bin is open.
  static constexpr std::array kBinStarts = {30.0, 45.0, 60.0, 80.0, 110.0, 150.0};
  struct Bin {
    int objects = 0;
    int confirmed = 0;
  };

  int objects = 0;
  int seen = 0;
  int seen_confirmed_once = 0;   // Of these, with exactly one mark.
  int confirmed = 0;             // Of all objects, seen or not, with at least one.
  int duplicates = 0;            // Further marks of the same object.
  int false_marks = 0;           // Where no such object is near.
  std::vector<double> errors_m;  // Of each confirmed object's nearest mark.
  std::array<Bin, kBinStarts.size()> recall{};
};

/// By kind, and "all". A mark and an object match when their class (and a code's text) is the same and they
/// are at most 0.5 m apart; each is matched once, the nearest pair first.
std::map<std::string, MarksScore> scoreMarks(const std::vector<arena_sim::Sighting>& objects,
                                             const std::vector<Mark>& marks, const MarksOptions& options);

}  // namespace rubble::tools
