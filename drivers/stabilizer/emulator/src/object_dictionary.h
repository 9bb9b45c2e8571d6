#pragma once

#include <cstdint>
#include <map>

#include "protocol/can_frame.h"
#include "protocol/sdo.h"

namespace rubble::stabilizer {

/// The objects of an emulated drive and its SDO server (CiA 301 section 7.2.4.3, expedited transfers). What a
/// real one checks before it changes a PDO's mapping is checked.
class ObjectDictionary {
 public:
  ObjectDictionary();

  /// As after power-on and a reset of the communication.
  void reset();

  std::uint32_t get(const ObjectEntry& entry) const { return objects_.at(keyOf(entry)).value; }
  std::uint16_t get16(std::uint16_t index) const { return static_cast<std::uint16_t>(get({index, 0})); }
  std::int32_t get32(std::uint16_t index) const { return static_cast<std::int32_t>(get({index, 0})); }
  void set(const ObjectEntry& entry, std::uint32_t value) { objects_.at(keyOf(entry)).value = value; }

  /// Answers an SDO request.
  CanFrame serve(const CanFrame& request, int node);

  // PDOs as they are mapped; `parameter`: 0x1400 or 0x1800.
  bool isPdoOn(std::uint16_t parameter) const;
  std::uint32_t cobId(std::uint16_t parameter) const { return get({parameter, 1}) & 0x7FF; }
  CanFrame packPdo(std::uint16_t parameter) const;
  /// False when the frame is too short for what is mapped.
  bool unpackPdo(std::uint16_t parameter, const CanFrame& frame);

 private:
  struct Object {
    std::uint32_t value = 0;
    int bytes = 4;
    bool writable = true;
  };

  static std::uint32_t keyOf(const ObjectEntry& entry) {
    return static_cast<std::uint32_t>(entry.index) << 8 | entry.subindex;
  }
  void addPdo(std::uint16_t parameter);
  /// An abort code; 0: may be done.
  std::uint32_t refusalOf(const ObjectEntry& entry, std::uint32_t value, int bytes) const;
  std::uint32_t mappingRefusal(std::uint16_t mapping, std::uint8_t subindex, std::uint32_t value) const;

  std::map<std::uint32_t, Object> objects_;
};

}  // namespace rubble::stabilizer
