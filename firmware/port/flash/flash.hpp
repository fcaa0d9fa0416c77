// SPDX-License-Identifier: Apache-2.0
// What flash_nvm.hpp stands on: two areas of flash that are erased apart, programmed in units, each unit once.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port {

inline constexpr std::size_t kFlashAreas = 2;
inline constexpr std::size_t kFlashUnitMost = 8;
inline constexpr std::uint8_t kFlashBlank = 0xFF;

class Flash {
 public:
  /// Bytes that are programmed at once: 4 or 8.
  [[nodiscard]] virtual std::size_t unit() const = 0;
  /// Bytes of an area.
  [[nodiscard]] virtual std::size_t area_bytes() const = 0;
  /// All of the area becomes blank; up to seconds, in which code in the same bank stands still.
  virtual bool erase(std::size_t area) = 0;
  /// `offset` is a multiple of unit(), and the unit is blank. False when the flash reports an error or reads back
  /// something else.
  virtual bool program(std::size_t area, std::size_t offset, const std::uint8_t* unit_bytes) = 0;
  /// False when some of it cannot be read (an error that ECC does not mend); those bytes are then meaningless.
  virtual bool read(std::size_t area, std::size_t offset, std::uint8_t* bytes, std::size_t count) = 0;

 protected:
  ~Flash() = default;
};

}  // namespace voltlap::port
