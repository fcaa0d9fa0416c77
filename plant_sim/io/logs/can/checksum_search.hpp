// SPDX-License-Identifier: Apache-2.0
// By which rule the last byte of a frame checks the others, found from the frames themselves.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "io/logs/recorded_frame.hpp"

namespace voltlap::plant {

struct FoundChecksum {
  std::string rule;                  ///< in words
  std::size_t holds = 0;             ///< frames
  std::size_t breaks = 0;            ///< frames, those of another length among them
  std::size_t first_break_line = 0;  ///< 0: none
};

/// Takes the frames of one identifier. The rules it knows, of a frame of n bytes (2 to 8):
///   identifier + n + sum of bytes 0 to n-2 (Orion); 0x39 + n + sum (thermistor module of the Orion); bytes of the
///   identifier + sum (Nissan, Tesla); the sum alone; the sum and another constant; SAE J1850 over two bytes of the
///   identifier and the others (can_dbc/car.dbc).
/// One is found when it holds in 95 % of the frames, and in so many different contents that chance cannot be it.
class ChecksumSearch {
 public:
  void take(const RecordedFrame& frame);
  [[nodiscard]] std::optional<FoundChecksum> found() const;

 private:
  struct Content {
    std::array<std::uint8_t, 8> data;
    std::uint8_t constant;  ///< last byte less the sum of the others
    bool crc;               ///< whether that rule holds
  };
  [[nodiscard]] bool stands_out(std::size_t holding) const;
  [[nodiscard]] std::uint8_t most_frequent_constant() const;
  [[nodiscard]] bool is_no_chance(bool crc, std::uint8_t constant) const;
  [[nodiscard]] std::array<std::pair<std::uint8_t, const char*>, 4> fixed_constants() const;
  [[nodiscard]] std::string rule_of(std::uint8_t constant) const;
  void keep(const RecordedFrame& frame, std::uint8_t constant, bool crc);

  std::uint32_t id_ = 0;
  std::uint8_t length_ = 0;
  bool given_up_ = false;
  std::size_t frames_ = 0, crc_holds_ = 0;
  std::array<std::uint32_t, 256> constants_{};
  std::array<std::uint32_t, 256> first_line_{};  ///< of each constant
  std::size_t first_line_without_crc_ = 0, first_line_of_other_length_ = 0;
  std::vector<Content> contents_;  ///< the first different ones
};

}  // namespace voltlap::plant
