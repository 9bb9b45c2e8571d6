#pragma once

#include <filesystem>

namespace rubble::arena_sim {

/// Pictures of what is hidden in arenas, to train a recogniser with. Into the folder `out`, created when
/// missing, go one folder per class of hazard label with its print, a folder `victim` with dolls (none of
/// them in a mission) as a robot sees them, and samples.yaml (for each folder: kind, width and height in m
/// where all are the same, else 0, aliases). PNGs, transparent where the object is not, and of a plain grey
/// there for who looks at the colour alone. The same version writes the same bytes. Throws common::Error.
void writeSamples(const std::filesystem::path& out);

}  // namespace rubble::arena_sim
