// SPDX-License-Identifier: Apache-2.0
// CAN frames as lines of text on a serial line, as LAWICEL's CAN232 made them usual and `slcand` and python-can speak
// them ("CAN232 Manual", version 3, LAWICEL AB). This is the adapter's side; a line ends with a carriage return.
//
//   S6  500 kbit/s, the bus's own: any other is refused      O  opens the channel     L  opens it to listen only
//   C   closes it            V  version    N  serial number    F  errors since the last F    Z0  no time stamps
//   tiiildd..  frame of 11 bits: 3 digits identifier, 1 length, 2 for each byte      Tiiiiiiiildd..  of 29 bits
//
// The answer to a command is a carriage return, to a frame `z` or `Z` before it, to all that is refused a bell.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"

namespace voltlap::port {

class Slcan {
 public:
  /// The longest line: T, 8 digits, length, 16 digits, and the carriage return.
  static constexpr std::size_t kLineMax = 27;

  /// A byte that has come. True when it ends the line of a frame for the node, which is `frame` then.
  bool take(std::uint8_t byte, Frame& frame);
  /// What take() has to be answered with, to be sent before the next call; often empty. Ends with a zero.
  [[nodiscard]] const char* answer() const { return answer_; }

  [[nodiscard]] bool is_open() const { return open_; }
  /// Lines that were refused.
  [[nodiscard]] std::uint32_t refused() const { return refused_; }

  /// The line of a frame; returns its length.
  [[nodiscard]] static std::size_t encode(const Frame& frame, std::uint8_t (&line)[kLineMax]);

 private:
  bool obey(Frame& frame);
  bool obey_command();
  bool take_frame(Frame& frame) const;
  [[nodiscard]] bool number(std::size_t first, std::size_t digits, std::uint32_t& value) const;

  std::uint8_t line_[kLineMax] = {};
  std::size_t length_ = 0;
  bool overlong_ = false;               ///< the rest of this line is left out
  bool open_ = false, listens_ = false;
  bool lost_ = false;                   ///< a line was refused since the last F
  std::uint32_t refused_ = 0;
  const char* answer_ = "";
};

}  // namespace voltlap::port
