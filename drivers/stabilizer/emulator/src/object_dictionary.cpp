#include "object_dictionary.h"

#include <algorithm>
#include <span>

#include "protocol/canopen.h"

namespace rubble::stabilizer {

namespace {

// Abort codes (CiA 301 table 22).
constexpr std::uint32_t kUnknownCommand = 0x05040001;
constexpr std::uint32_t kReadOnly = 0x06010002;
constexpr std::uint32_t kNoObject = 0x06020000;
constexpr std::uint32_t kNotMappable = 0x06040041;
constexpr std::uint32_t kPdoTooLong = 0x06040042;
constexpr std::uint32_t kWrongLength = 0x06070010;
constexpr std::uint32_t kNoSubindex = 0x06090011;
constexpr std::uint32_t kOutOfRange = 0x06090030;
constexpr std::uint32_t kNotNow = 0x08000022;

constexpr std::uint32_t kPdoOff = 0x80000000U;
constexpr std::uint8_t kMostMapped = 8;
constexpr std::uint16_t kMappingOffset = 0x200;

ObjectEntry objectOf(std::uint32_t mapped) {
  return {static_cast<std::uint16_t>(mapped >> 16), static_cast<std::uint8_t>(mapped >> 8)};
}

}  // namespace

ObjectDictionary::ObjectDictionary() { reset(); }

void ObjectDictionary::reset() {
  constexpr std::uint32_t kServoDrive = 0x00020192;    // CiA 402, servo.
  constexpr std::uint32_t kModes = 1U << 0 | 1U << 7;  // pp, csp
  objects_ = {{0x100000, {kServoDrive, 4, false}},
              {0x100100, {0, 1, false}},
              {0x101700, {0, 2}},
              {0x604000, {0, 2}},
              {0x604100, {0, 2, false}},
              {0x605A00, {2, 2}},
              {0x606000, {0, 1}},
              {0x606100, {0, 1, false}},
              {0x606400, {0, 4, false}},
              {0x606C00, {0, 4, false}},
              {0x607A00, {0, 4}},
              {0x608100, {0, 4}},
              {0x608300, {0, 4}},
              {0x608400, {0, 4}},
              {0x60C201, {10, 1}},
              {0x60C202, {0xFD, 1}},
              {0x650200, {kModes, 4, false}}};
  addPdo(0x1400);
  addPdo(0x1800);
}

void ObjectDictionary::addPdo(std::uint16_t parameter) {
  objects_[keyOf({parameter, 1})] = {kPdoOff, 4};
  objects_[keyOf({parameter, 2})] = {0xFF, 1};
  const auto mapping = static_cast<std::uint16_t>(parameter + kMappingOffset);
  objects_[keyOf({mapping, 0})] = {0, 1};
  for (std::uint8_t i = 1; i <= kMostMapped; ++i) {
    objects_[keyOf({mapping, i})] = {0, 4};
  }
}

CanFrame ObjectDictionary::serve(const CanFrame& request, int node) {
  const std::uint8_t command = request.data[0];
  const ObjectEntry entry{static_cast<std::uint16_t>(readLittleEndian(std::span(request.data).subspan(1, 2))),
                          request.data[3]};
  CanFrame answer{.id = cob::kSdoAnswer + static_cast<std::uint32_t>(node), .data = request.data, .size = 8};
  const auto respond = [&answer](std::uint8_t kind, std::uint32_t value) {
    answer.data[0] = kind;
    writeLittleEndian(value, std::span(answer.data).subspan(4));
    return answer;
  };
  const auto found = objects_.find(keyOf(entry));
  if (found == objects_.end()) {
    const auto sibling = objects_.lower_bound(keyOf({entry.index, 0}));
    const bool has_index = sibling != objects_.end() && sibling->first >> 8 == entry.index;
    return respond(0x80, has_index ? kNoSubindex : kNoObject);
  }
  if (command == 0x40) {
    return respond(static_cast<std::uint8_t>(0x43 | (4 - found->second.bytes) << 2), found->second.value);
  }
  if ((command & 0xE2) != 0x22) {
    return respond(0x80, kUnknownCommand);
  }
  const int bytes = (command & 1) != 0 ? 4 - (command >> 2 & 3) : found->second.bytes;
  const auto value = static_cast<std::uint32_t>(
      readLittleEndian(std::span(request.data).subspan(4, static_cast<std::size_t>(bytes))));
  if (const std::uint32_t abort = refusalOf(entry, value, bytes); abort != 0) {
    return respond(0x80, abort);
  }
  found->second.value = value;
  return respond(0x60, 0);
}

std::uint32_t ObjectDictionary::refusalOf(const ObjectEntry& entry, std::uint32_t value, int bytes) const {
  const Object& object = objects_.at(keyOf(entry));
  if (!object.writable) {
    return kReadOnly;
  }
  if (bytes != object.bytes) {
    return kWrongLength;
  }
  if (entry.index == 0x1600 || entry.index == 0x1A00) {
    return mappingRefusal(entry.index, entry.subindex, value);
  }
  if (entry.index == 0x6060 && value != 1 && value != 8) {
    return kOutOfRange;
  }
  return 0;
}

std::uint32_t ObjectDictionary::mappingRefusal(std::uint16_t mapping, std::uint8_t subindex,
                                               std::uint32_t value) const {
  const auto parameter = static_cast<std::uint16_t>(mapping - kMappingOffset);
  if (isPdoOn(parameter) || (subindex != 0 && get({mapping, 0}) != 0)) {
    return kNotNow;
  }
  if (subindex != 0) {
    const auto object = objects_.find(keyOf(objectOf(value)));
    const bool fits = object != objects_.end() && static_cast<int>(value & 0xFF) == 8 * object->second.bytes;
    return fits ? 0 : kNotMappable;
  }
  if (value > kMostMapped) {
    return kOutOfRange;
  }
  std::uint32_t bits = 0;
  for (std::uint8_t i = 1; i <= value; ++i) {
    const std::uint32_t mapped = get({mapping, i});
    if (mapped == 0) {
      return kNotMappable;
    }
    bits += mapped & 0xFF;
  }
  return bits > 64 ? kPdoTooLong : 0;
}

bool ObjectDictionary::isPdoOn(std::uint16_t parameter) const { return (get({parameter, 1}) & kPdoOff) == 0; }

CanFrame ObjectDictionary::packPdo(std::uint16_t parameter) const {
  CanFrame frame{.id = cobId(parameter)};
  const auto mapping = static_cast<std::uint16_t>(parameter + kMappingOffset);
  for (std::uint8_t i = 1; i <= get({mapping, 0}); ++i) {
    const std::uint32_t mapped = get({mapping, i});
    const auto bytes = static_cast<std::uint8_t>((mapped & 0xFF) / 8);
    writeLittleEndian(get(objectOf(mapped)), std::span(frame.data).subspan(frame.size, bytes));
    frame.size = static_cast<std::uint8_t>(frame.size + bytes);
  }
  return frame;
}

bool ObjectDictionary::unpackPdo(std::uint16_t parameter, const CanFrame& frame) {
  const auto mapping = static_cast<std::uint16_t>(parameter + kMappingOffset);
  std::size_t begin = 0;
  for (std::uint8_t i = 1; i <= get({mapping, 0}); ++i) {
    const std::uint32_t mapped = get({mapping, i});
    const std::size_t bytes = (mapped & 0xFF) / 8;
    if (begin + bytes > frame.size) {
      return false;
    }
    set(objectOf(mapped), static_cast<std::uint32_t>(readLittleEndian(frame.bytes().subspan(begin, bytes))));
    begin += bytes;
  }
  return true;
}

}  // namespace rubble::stabilizer
