#pragma once

#include <functional>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "text_lines.h"

namespace rubble::tools {

/// Comma separated values; one may stand in double quotes, a double quote in it twice. Throws Error for a
/// quote that is not closed.
std::vector<std::string> splitCsv(std::string_view line);

/// A table whose first line names its columns: hands the values of `columns`, in that order, of every row
/// to `handle`. Columns may lie in any order among others. Throws Error naming file and line; what `handle`
/// throws is rethrown so.
void forEachRow(const TextFile& file, std::initializer_list<const char*> columns,
                const std::function<void(const std::vector<std::string>&)>& handle);

}  // namespace rubble::tools
