#pragma once

#include "world/site.h"

namespace rubble::arena_sim {

/// The hall around the arena: walls with windows, ceiling with trusses, columns, furniture along the walls,
/// the hall's lamps and the work lights on the arena's walls. Their light on the arena's floor sums up to
/// about 1.
void buildHall(Site& site, Random& random);

}  // namespace rubble::arena_sim
