#pragma once

#include "samples.h"
#include "word_index.h"

namespace rubble::recognizer {

/// ORB features of every sample, rendered at several sizes from several angles; features of one view that lie
/// at one place, turned alike, and differ little become one word, their majority. Those seen most often are
/// kept.
WordIndex trainWords(const Samples& samples);

}  // namespace rubble::recognizer
