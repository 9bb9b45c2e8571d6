#pragma once

#include <cstdint>
#include <vector>

#include "common/byte_stream.h"
#include "marks/object_marks.h"

namespace rubble::fusion {

/// Marks as a part of fusion's checkpoint.
void putMarks(common::ByteWriter& out, const std::vector<Mark>& marks, std::int32_t next_id);
/// Throws common::Error for what cannot be a mark.
void getMarks(common::ByteReader& in, std::vector<Mark>& marks, std::int32_t& next_id);

}  // namespace rubble::fusion
