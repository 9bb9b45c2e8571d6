#pragma once

namespace rubble::common {

/// Lowers the calling thread's priority by `steps` of nice (1 .. 19); threads that it starts inherit it. For
/// work that the pose must not wait for when the cores are busy. A hint: where a sandbox forbids it, all
/// stays as it is.
void lowerPriority(int steps);

}  // namespace rubble::common
